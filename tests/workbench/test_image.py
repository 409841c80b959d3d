"""Every element type has a mirror image, of which the signs are those that geometry says."""

import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.workbench.fields import calls
from flexmb.workbench.image import mirror_signs

STEEL = fm.materials.stainless_301
LEAF = fm.Rectangle(0.02, 5e-4, STEEL)
PLACES = {2: [(0.01, 0.02), (0.05, 0.07)], 3: [(0.01, 0.02, 0.0), (0.05, 0.07, 0.03)]}
PROPERTIES = {
    "axis": (1.0, 2.0, 3.0),
    "axis_p": (1.0, 2.0, 3.0),
    "axis_q": (0.0, 2.0, -1.0),
    "ratio": 2.0,
    "pitch": 0.01,
    "radius_p": 0.004,
    "radius_q": 0.003,
    "mass": 0.1,
}
ELEMENTS = [name for name, call in calls().items() if call.kind == "element" and call.entry["group"] == "element"]


def member_of(name, **more):
    """An element at a place that no symmetry has, and its nodes."""
    element = calls()[name].function
    d = calls()[name].entry["dimension"]
    b = fm.Builder()
    nodes = []
    for k, end in enumerate(calls()[name].entry["fields"][0]["doc"].removeprefix("Nodes: ").rstrip(".").split(", ")):
        if k < 2:
            b.node(end, PLACES[d][k])
        else:
            b.rotation(end)
        nodes.append(end)
    own = {key: value[:d] if key.startswith("axis") else value for key, value in PROPERTIES.items()}
    own = {key: value for key, value in own.items() if key in element.properties}
    section = fm.Rigidity(EA=1e4) if "belt" in name else LEAF
    own |= {"section": section} if "section" in element.properties else {}
    b.add(element, *nodes, name="it", **own, **more)
    member = b.members["it"]
    kinds = [b.nodes[node].kind for node in member.nodes]
    return member, [np.asarray(b.nodes[node].start, float) for node in member.nodes], kinds


@pytest.mark.slow
@pytest.mark.parametrize("name", ELEMENTS)
def test_every_element_has_an_image_across_every_axis(name):
    member, references, kinds = member_of(name)
    for axis in range(kinds[0].dimension):
        found = mirror_signs(member, references, kinds, axis, False)
        assert found is not None
        assert found[1].shape == (len(member.roles),)
        assert set(np.abs(found[1])) == {1}


@pytest.mark.parametrize(
    ("name", "axis", "flips", "signs"),
    [
        ("planar.truss", 0, {}, [1]),
        ("planar.beam", 0, {}, [1, -1, -1]),
        ("planar.hinge", 1, {}, [-1]),
        ("planar.rigid_beam", 0, {}, [-1, 1]),
        ("planar.rigid_beam", 1, {}, [1, -1]),
        ("planar.rigid_body", 1, {}, [1, -1, -1]),
        ("planar.slider", 0, {}, [1, -1]),
        ("planar.gear", 0, {}, None),
        # A belt to the left of the line between its pulleys is to the right of it in the mirror.
        ("planar.belt_to_point", 0, {"radius_p": -1}, None),
        ("spatial.beam", 2, {}, [1, -1, -1, -1, 1, 1]),
        ("spatial.hinge", 0, {}, None),
        # A right-handed screw is a left-handed one in the mirror.
        ("spatial.screw", 1, {"pitch": -1}, None),
        ("spatial.rigid_beam", 1, {}, [1, -1, 1]),
        ("spatial.rigid_body", 1, {}, [1, -1, 1, -1, 1, -1]),
    ],
)
def test_signs_are_those_of_geometry(name, axis, flips, signs):
    found = mirror_signs(*member_of(name), axis, False)
    assert found is not None
    assert {key: int(value) for key, value in found[0].items() if np.all(value == -1)} == flips
    if signs is not None:
        assert found[1].tolist() == signs


@pytest.mark.slow(
    "False-spectral_beam-flexmb.elements.spatial-3",
    "False-leaf_spring-flexmb.elements.planar-2",
    "False-leaf_spring-flexmb.elements.spatial-3",
    "True-spectral_beam-flexmb.elements.planar-2",
    "True-spectral_beam-flexmb.elements.spatial-3",
    "True-leaf_spring-flexmb.elements.planar-2",
    "True-leaf_spring-flexmb.elements.spatial-3",
)
@pytest.mark.parametrize(("room", "d"), [(planar, 2), (spatial, 3)])
@pytest.mark.parametrize("kind", ["spectral_beam", "leaf_spring"])
@pytest.mark.parametrize("y_turns", [False, True])
def test_signs_of_series_are_those_of_their_function(room, d, kind, y_turns):
    if d == 2 and y_turns:
        pytest.skip("there is no y in the plane")
    place = room.__name__.rpartition(".")[2]
    own = {"y": (0.3, 0.1, 1.0)} if d == 3 else {}
    member, references, kinds = member_of(f"{place}.{kind}", order=2, **own)
    element = member.element
    _, signs = mirror_signs(member, references, kinds, 1, y_turns) or ({}, np.zeros(0))
    random = np.random.default_rng(3)
    state = [r + 0.05 * random.normal(size=r.shape) for r in references]
    mirror = np.where(np.arange(d) == 1, -1.0, 1.0)

    def image(x, kind):
        if kind.part == "position":
            return mirror * x
        if kind.part == "internal":
            # Coefficients are deformations themselves, the last ones.
            return signs[-len(x) :] * x
        return np.append(x[:1], -mirror * x[1:]) if d == 3 and kind.part == "rotation" else -x

    def deformation(nodes, ref, **properties):
        properties = {**element.of_deformation(member.properties), **properties}
        reference, options = element.reference(ref), element.alone().options
        return np.asarray(element.deformation(*nodes, ref=reference, **options, **properties))

    there = {"y": (-1.0 if y_turns else 1.0) * mirror * np.array([0.3, 0.1, 1.0])} if d == 3 else {}
    clamps = "clamped" in element.of_deformation(member.properties)
    given = {"clamped": np.array([1.0, 1.0])} if clamps else {}
    ours = deformation(state, references, **given)
    images = [[image(x, k) for x, k in zip(nodes, kinds, strict=True)] for nodes in (state, references)]
    theirs = deformation(*images, **there, **given)
    assert theirs == approx(signs * ours, abs=1e-9 * np.max(np.abs(ours)))
