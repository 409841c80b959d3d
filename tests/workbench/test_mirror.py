"""Mirrored mechanisms have the frequencies of their originals."""

import numpy as np
import pytest
from cases import documents
from cases.tolerances import approx

import flexmb as fm
from flexmb.workbench.building import build
from flexmb.workbench.document import Document, EditError, apply


def mirrored(document, axis, at="0.03"):
    op = {"op": "mirror", "ids": [t["id"] for t in document.things], "axis": axis, "at": at, "keep": False}
    return apply(document, [op])[0]


def skew_arm_in_the_plane() -> Document:
    """A bent arm with all that has a sign: loads, prestress, strain, temperature, a joint, an eccentric body."""
    beam = {"section": "leaf"}
    return documents.drawn(
        2,
        {"t": "1e-3", "h": "0.07"},
        [
            ("Material", "steel", documents.STEEL | {"alpha": "12e-6"}),
            ("Rectangle", "leaf", documents.leaf_args()),
            ("node", "A", {"position": ["0", "0.01"]}),
            ("node", "B", {"position": ["h", "2*h/3"]}),
            ("node", "C", {"position": ["0.15", "0.02"]}),
            ("rotation", "rocker", {"start": ["0.3"]}),
            ("planar.beam", "first", {"nodes": ["A", "B"], **beam}),
            ("planar.spectral_beam", "second", {"nodes": ["B", "C"], **beam, "curvature": "3", "order": "3"}),
            ("planar.hinge", "joint", {"nodes": ["C", "rocker"], "stiffness": "0.7"}),
            ("inertia", None, {"node": "rocker", "inertia": ["1e-5"]}),
            ("body", None, {"node": "C", "mass": "0.05", "center": ["0.01", "0.02"], "inertia": ["2e-5"]}),
            ("prescribe", None, {"of": "A", "component": "x", "value": "2e-3"}),
            ("prescribe", None, {"of": "A", "component": "2", "value": "1e-3"}),
            ("prescribe", None, {"of": "A", "component": "phi", "value": "0.05"}),
            ("force", None, {"node": "C", "force": ["3", "1"]}),
            ("force", None, {"node": "B", "force": ["-1", "2"], "follower": "true"}),
            ("moment", None, {"node": "C", "moment": ["0.2"]}),
            ("gravity", None, {"acceleration": ["1", "-9.81"]}),
            ("prestress", None, {"element": "first", "values": ["2", "3", "-1"]}),
            ("strain", None, {"element": "second", "values": ["0", "0", "0", "1e-4", "0", "0", "0.05", "0.02"]}),
            ("temperature", None, {"element": "first", "change": ["10", "20"], "gradient": ["3e4"]}),
            ("strain", None, {"element": "joint", "values": ["0.1"]}),
        ],
    )


def skew_arm_in_space() -> Document:
    """The same in space, with elements whose y is the default and with such whose y is given."""
    return documents.drawn(
        3,
        {"t": "1e-3", "h": "0.07"},
        [
            ("Material", "steel", documents.STEEL | {"alpha": "12e-6"}),
            ("Rectangle", "leaf", documents.leaf_args()),
            (
                "Rigidity",
                "bent",
                {"EA": "1e6", "EIy": "2", "EIz": "5", "GIt": "1", "mass": "0.1"}
                | {"Jx": "3e-6", "Jy": "2e-6", "Jz": "1e-6", "Jyz": "8e-7"},
            ),
            ("node", "A", {"position": ["0", "0.01", "0"]}),
            ("node", "B", {"position": ["h", "0.02", "0.05"]}),
            ("node", "C", {"position": ["0.15", "0.1", "0.04"]}),
            ("node", "D", {"position": ["0.17", "0.1", "0.09"]}),
            ("rotation", "rocker", {"start": ["0.8", "0.36", "0.48", "0"]}),
            ("spatial.beam", "first", {"nodes": ["A", "B"], "section": "leaf"}),
            ("spatial.beam", "second", {"nodes": ["B", "C"], "section": "bent", "y": ["0.2", "1", "0.3"]}),
            (
                "spatial.spectral_beam",
                "third",
                {"nodes": ["C", "D"], "section": "leaf", "curvature": ["0", "2", "3"], "order": "3"},
            ),
            ("spatial.hinge", "joint", {"nodes": ["D", "rocker"], "axis": ["1", "2", "3"], "stiffness": "0.7"}),
            ("inertia", None, {"node": "rocker", "inertia": ["3e-5", "1e-6", "2e-6", "4e-5", "3e-6", "5e-5"]}),
            (
                "body",
                None,
                {"node": "C", "mass": "0.05", "center": ["0.01", "0.02", "-0.01"]}
                | {"inertia": ["3e-5", "1e-6", "2e-6", "4e-5", "3e-6", "5e-5"]},
            ),
            ("prescribe", None, {"of": "A", "component": "x", "value": "2e-3"}),
            ("prescribe", None, {"of": "A", "component": "y", "value": "1e-3"}),
            ("prescribe", None, {"of": "A", "component": "3", "value": "-1e-3"}),
            (
                "prescribe",
                None,
                {"of": "A", "component": "rotation", "value": "0.05", "axis": ["1", "2", "-1"], "tilt": "fixed"},
            ),
            ("force", None, {"node": "C", "force": ["3", "1", "2"]}),
            ("force", None, {"node": "B", "force": ["-1", "2", "3"], "follower": "true"}),
            ("moment", None, {"node": "C", "moment": ["0.2", "0.1", "0.3"]}),
            ("moment", None, {"node": "D", "moment": ["0.1", "0.3", "-0.2"], "follower": "true"}),
            ("gravity", None, {"acceleration": ["1", "-9.81", "3"]}),
            ("prestress", None, {"element": "first", "values": ["2", "3", "-1", "4", "2", "5"]}),
            ("strain", None, {"element": "second", "values": ["0", "1e-3", "2e-3", "1e-3", "3e-4", "2e-4"]}),
            (
                "strain",
                None,
                {
                    "element": "third",
                    "values": ["0"] * 6
                    + ["1e-5", "0", "0", "0.02", "0.01", "0.0"]
                    + ["0.03", "0.01", "0", "0.02", "0.01", "0.01"],
                },
            ),
            ("temperature", None, {"element": "first", "change": ["10", "20"], "gradient": ["3e4", "2e4"]}),
            ("strain", None, {"element": "joint", "values": ["0.1"]}),
        ],
    )


def coupled_arm() -> Document:
    """A beam whose strains are coupled, with a centre of mass beside its axis."""
    stiffness = "1e4 30 20 40 3 0.2 -0.3 2 0.4 5".split()
    mass = {"mass": "0.5", "center_y": "0.01", "center_z": "-0.02", "Jx": "3e-4", "Jy": "2e-4", "Jz": "1e-4"}
    return documents.drawn(
        3,
        {},
        [
            ("General", "box", {"stiffness": stiffness, **mass, "Jyz": "5e-5"}),
            ("node", "A", {"position": ["0", "0.01", "0"]}),
            ("node", "C", {"position": ["0.2", "0.05", "0.1"]}),
            (
                "spatial.spectral_beam",
                "arm",
                {"nodes": ["A", "C"], "section": "box", "order": "2", "y": ["0", "1", "0"]},
            ),
            ("fix", None, {"node": "A"}),
            ("force", None, {"node": "C", "force": ["3", "1", "2"]}),
            ("gravity", None, {"acceleration": ["1", "-9.81", "3"]}),
        ],
    )


def test_the_image_of_a_stiffness_has_other_signs():
    """Of a beam whose local z is reversed: twist and curvature about y change sign."""
    document = coupled_arm()
    before, after = (
        {t["name"]: t["args"] for t in one.things if t["call"] == "General"}
        for one in (document, mirrored(document, "y"))
    )
    signs = np.array([1.0, -1, -1, 1])
    wanted = np.outer(signs, signs)[np.triu_indices(4)] * np.array(before["box"]["stiffness"], float)
    own = after["box mirrored"]
    np.testing.assert_array_equal(np.array(own["stiffness"], float), wanted)
    assert [float(own[name]) for name in ("center_y", "center_z", "Jyz")] == [0.01, 0.02, -5e-5]
    assert after["box"] == before["box"]


def loaded(document):
    """Frequencies about the equilibrium under loads, which feel every sign, and where node C is there."""
    built = build(document)
    assert (built.problems, built.skipped) == ([], [])
    model = built.model()
    found = np.sort(np.abs(np.imag(np.asarray(fm.poles(model)))))
    return found[found > 1][:12], np.array(fm.equilibrium(model).position("C"))


# Across y the default y of two beams in space is turned round, across x it is not; each axis compiles anew.
@pytest.mark.slow
@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize("arm", [skew_arm_in_the_plane, skew_arm_in_space, coupled_arm])
def test_a_mirrored_arm_has_the_same_frequencies(arm, axis):
    document = arm()
    here, place = loaded(document)
    there, image = loaded(mirrored(document, axis))
    assert there == approx(here, rel=1e-7)
    place["xyz".index(axis)] = 0.06 - place["xyz".index(axis)]
    assert image == approx(place, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("axis", ["x", "z"])
@pytest.mark.parametrize("y", [[], ["0", "1", "0.2"]])
def test_a_mirrored_leaf_spring_with_skew_and_elastic_ends_has_the_same_frequencies(axis, y):
    leaf = {"nodes": ["A", "B"], "section": "leaf", "skew": ["0.5", "0.2"], "order": "2"}
    leaf |= {"clamp": ["1e7", "1e6", "2e6", "300", "40", "3000"], "clamped": "both"} | ({"y": y} if y else {})
    document = documents.drawn(
        3,
        {"t": "1e-3"},
        [
            ("Material", "steel", documents.STEEL),
            ("Rectangle", "leaf", documents.leaf_args()),
            ("node", "A", {"position": ["0", "0.01", "0"]}),
            ("node", "B", {"position": ["0.1", "0.02", "0.05"]}),
            ("fix", None, {"node": "A"}),
            ("spatial.leaf_spring", "leaf spring", leaf),
            ("body", None, {"node": "B", "mass": "0.1", "center": ["0.02", "0.01", "0.03"]}),
        ],
    )
    assert frequencies(mirrored(document, axis)) == approx(frequencies(document), rel=1e-7)


BLOCKS = {
    "parallel_guide": {"length": "0.1", "spacing": "0.05", "section": "leaf"},
    "double_parallel_guide": {"length": "0.1", "spacing": "0.05", "inner": "0.03", "section": "leaf"},
    "cross_pivot": {"length": "0.1", "section": "leaf", "ratio": "0.3", "half_angle": "0.6"},
    "butterfly_pivot": {"length": "0.1", "radius": "0.02", "section": "leaf"},
    "cartwheel": {"length": "0.1", "section": "leaf"},
    "folded_leaf_spring": {"length": "0.1", "section": "leaf", "second": "0.06"},
    "notch_hinge": {"width": "0.01", "height": "0.01", "neck": "0.001", "radius": "0.005", "material": "steel"},
    "wire_flexure": {"length": "0.1", "section": "leaf"},
}


def with_block(dimension, name, **more) -> Document:
    """A building block that carries an eccentric body, with a mass beside its stage."""
    zeros, point = ["0"] * (dimension - 2), ["0.02", "0.01", "0.03"][:dimension]
    own = {"base": "base", "stage": "S", **BLOCKS[name], "along": ["0.2", "1", "0.1"][:dimension], **more}
    inertia = ["1e-5"] if dimension == 2 else ["3e-5", "1e-6", "2e-6", "4e-5", "3e-6", "5e-5"]
    return documents.drawn(
        dimension,
        {"t": "1e-3"},
        [
            ("Material", "steel", documents.STEEL),
            ("Rectangle", "leaf", documents.leaf_args()),
            ("node", "base", {"position": ["0.01", "0.02", *zeros]}),
            ("fix", None, {"node": "base"}),
            (f"blocks.{name}", "block", own),
            ("body", None, {"node": "S", "mass": "0.1", "center": point, "inertia": inertia}),
        ],
    )


def frequencies(document):
    built = build(document)
    assert (built.problems, built.skipped) == ([], [])
    return np.asarray(fm.frequencies(built.model()))[:6]


@pytest.mark.slow
@pytest.mark.parametrize("name", BLOCKS)
def test_a_mirrored_block_in_the_plane_has_the_same_frequencies(name):
    document = with_block(2, name)
    assert frequencies(mirrored(document, "x")) == approx(frequencies(document), rel=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "more"), [("cross_pivot", {"apart": "0.02"}), ("folded_leaf_spring", {})])
@pytest.mark.parametrize("axis", "xz")
def test_a_mirrored_block_in_space_has_the_same_frequencies(name, more, axis):
    document = with_block(3, name, **more)
    assert frequencies(mirrored(document, axis)) == approx(frequencies(document), rel=1e-7)


@pytest.mark.slow
def test_a_block_whose_leaves_change_places_is_exploded_first_where_they_are_named():
    document = with_block(2, "cross_pivot")
    ids = [thing["id"] for thing in document.things]
    named = {"call": "prestress", "args": {"element": "block leaf 1", "values": ["0", "0", "0", "1"]}}
    document, _ = apply(document, [{"op": "add", "thing": named}])
    assert build(document).problems == []
    op = {"op": "mirror", "ids": ids, "axis": "x", "at": "0"}
    with pytest.raises(EditError, match="Explode it first"):
        apply(document, [op])
    parts, _ = apply(document, [{"op": "explode", "id": "5"}])
    there = mirrored(parts, "x")
    assert build(there).problems == []
    assert frequencies(there) == approx(frequencies(parts), rel=1e-7)


@pytest.mark.slow
def test_what_has_no_mirror_image_is_told():
    document = documents.drawn(
        3,
        {},
        [
            ("node", "A", {"position": ["0", "0", "0"]}),
            ("body", None, {"node": "A", "step": "part.step", "material": ""}),
        ],
    )
    with pytest.raises(EditError, match="STEP file") as fault:
        mirrored(document, "x")
    assert fault.value.address == "2/step"
