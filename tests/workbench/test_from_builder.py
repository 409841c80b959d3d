"""Builders, models, files and functions as documents: what is built of a document is what was there."""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import flexmb as fm
from flexmb import materials, planar, spatial
from flexmb.mechanisms import mechanism_path
from flexmb.workbench.building import build
from flexmb.workbench.from_builder import document_of

from ..cases import mechanisms

SHIPPED = sorted(path.stem for path in Path(mechanism_path("pf2d")).parent.glob("*.dat"))


def rebuilt(document) -> fm.Builder:
    found = build(document)
    assert found.problems == []
    assert found.skipped == []
    return found.builder


def check_same(builder, other, release="none") -> None:
    """Counts, frequencies, the steady state and, where there are signals, the response at 10 rad/s."""
    one, two = builder.build(release=release), other.build(release=release)
    assert two.counts() == one.counts()
    # Coordinates stand in another order. Found is flexibility, 1 / omega^2: its round-off is that of the largest one.
    found, expected = (np.asarray(fm.frequencies(model)) for model in (two, one))
    moves = np.isfinite(expected)
    assert np.array_equal(np.isfinite(found), moves)
    round_off = 1e-12 + np.finfo(float).eps * (expected[moves] / expected[0]) ** 2
    assert np.all(np.abs(found[moves] / expected[moves] - 1) <= round_off)
    lines = [fm.linearize(model) for model in (one, two)]
    np.testing.assert_allclose(fm.frequencies(two)[0], fm.frequencies(one)[0], rtol=1e-12)
    if one.labels.inputs and one.labels.outputs:
        systems = [fm.to_statespace(line) for line in lines]
        assert systems[1].input_labels == systems[0].input_labels
        found = [system(10j) for system in systems]
        np.testing.assert_allclose(found[1], found[0], rtol=1e-9, atol=1e-12 * np.max(np.abs(found[0])))


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_mechanism(name):
    read = fm.read_spacar(mechanism_path(name))
    document, left_out = document_of(read)
    assert document.data["title"] == name
    # Beside the mechanism alone: what an analysis takes.
    assert all("analysis or a drawing" in one for one in left_out)
    assert bool(left_out) is (name in ("elevator", "manipulator"))
    check_same(read.builder, rebuilt(document), release="auto")


def test_rotations_of_a_file_belong_to_positions():
    document, _ = document_of(fm.read_spacar(mechanism_path("pf2d")))
    named = [thing["name"] for thing in document.things if thing["call"] == "node"]
    assert named == ["1", "3", "5", "7"]
    assert next(t["args"]["nodes"] for t in document.things if t["call"] == "planar.beam") == ["1", "3"]
    # A second rotation at a hinge stays by itself.
    elevator, _ = document_of(fm.read_spacar(mechanism_path("elevator")))
    assert sum(thing["call"] == "rotation" for thing in elevator.things) == 1


@pytest.mark.slow
@pytest.mark.parametrize("built", ["planar_guide", "spatial_guide", "truss_guide"])
def test_tutorial_systems(built):
    builder = getattr(mechanisms, built)()
    document, left_out = document_of(builder)
    assert left_out == []
    check_same(builder, rebuilt(document), release="auto")
    # A model says which degrees of freedom and releases were found.
    again, left_out = document_of(builder.build(release="auto"))
    assert left_out == []
    check_same(builder, rebuilt(again), release="auto")


def check_same_contents(actual, expected) -> None:
    """All that a Builder holds, to the last bit."""
    assert set(actual.members) == set(expected.members)
    assert set(actual.nodes) == set(expected.nodes)
    for name, member in expected.members.items():
        own = actual.members[name]
        assert (own.element, own.nodes, own.roles, own.hidden) == (
            member.element,
            member.nodes,
            member.roles,
            member.hidden,
        )
        values, structure = jax.tree.flatten(member.properties)
        own_values, own_structure = jax.tree.flatten(own.properties)
        assert own_structure == structure
        for value, other in zip(values, own_values, strict=True):
            np.testing.assert_array_equal(other, value)
    for name, node in expected.nodes.items():
        assert (actual.nodes[name].kind, actual.nodes[name].roles) == (node.kind, node.roles)
        np.testing.assert_array_equal(actual.nodes[name].start, node.start)
    assert actual.loads == expected.loads
    assert actual.signals == expected.signals
    assert (actual.dofs, actual.starts) == (expected.dofs, expected.starts)


def everything(b: fm.Builder) -> fm.Builder:
    """Each call of a Builder in space."""
    steel = fm.Material(210e9, 80e9, 7850.0, alpha=12e-6, damping=1e-5)
    leaf = fm.Rectangle(0.02, 0.5e-3, steel, torsion="approximate")
    wire = fm.Circle(1e-3, materials.stainless_301)
    for name, place in (("A", (0, 0, 0)), ("B", (0.1, 0, 0)), ("C", (0.1, 0.1, 0)), ("D", (0.1, 0.1, 0.1))):
        b.node(name, place)
    b.node("E", (0, 0.2, 0))
    b.rotation("hub", (np.cos(0.1), 0, 0, np.sin(0.1)))
    b.add(spatial.beam, "A", "B", name="first", section=leaf, y=(0, 0, 1), released=(2, 3, 4, 5, 6))
    b.add(spatial.leaf_spring, "B", "C", name="B", section=leaf, y=(0, 0, 1), clamped=(True, False), order=4)
    b.add(spatial.warping_beam, "C", "D", name="warps", section=leaf, y=(0, 1, 0))
    b.add(spatial.hinge, "C", "hub", axis=(0, 0, 1), stiffness=(1.0, 2.0, 3.0), name="joint", released="all")
    b.add(spatial.truss, "A", "E", section=fm.Rigidity(EA=1e3, mass=0.1), damping=fm.Damping(EA=1.0), name="rod")
    b.add(spatial.rigid_beam, "B", "E", name="arm")
    b.node("F", (0, 0.3, 0))
    b.add(spatial.beam, "F", "D", name="wire", section=wire)
    b.fix("A")
    b.fix("D", "x", "y")
    b.mass("C", 0.5, inertia=(1e-3, 0, 1e-4, 2e-3, 0, 3e-3))
    b.body("B", 0.2, center=(0.01, 0, 0), inertia=(1e-4, 0, 0, 1e-4, 0, 1e-4))
    b.inertia("hub", (1e-3, 0, 0, 1e-3, 0, 1e-3))
    b.force("C", (1.0, 0, 2.0))
    b.force("C", (0, 0.5, 0), increment=True)
    b.force("B", (0, 0.1, 0), follower=True)
    b.moment("B", (0.01, 0, 0))
    b.moment("B", (0, 0.01, 0), increment=True)
    b.moment("C", (0, 0, 0.01), follower=True)
    b.gravity((0, 0, -9.81))
    b.prestress("rod", 0.1)
    b.strain("rod", 1e-6)
    b.temperature("first", 10.0)
    b.temperature("first", (1.0, 2.0), gradient=(0.0, 100.0), increment=True)
    b.prescribe("D", "z", 1e-4)
    b.prescribe("D", "z", 1e-3, increment=True)
    b.input("C", "y")
    b.input("C", "rz", local=True)
    b.input("A", "x", "acceleration", name="floor")
    b.output("B", "x", "velocity", kind="node")
    b.output("first", 2, "stress")
    b.output("A", "y", "reaction")
    b.sensor("lean", {"D.rx": 2.0, "velocity C.x": 0.5})
    b.actuator("both", {"C.x": 1.0, "E.y": -1.0})
    return b


def test_every_feature_in_space():
    builder = everything(fm.Builder())
    document, left_out = document_of(builder)
    assert left_out == []
    other = rebuilt(document)
    check_same_contents(other, builder)
    # The document of what is built of a document is that document.
    again, _ = document_of(other)
    assert again.things == document.things


def test_a_general_section_is_its_triangle():
    b = fm.Builder()
    b.node("A", (0, 0, 0))
    b.node("B", (0.1, 0, 0))
    section = fm.sections.General(np.diag([4.0, 3, 2, 1]) + 0.1, mass=0.5, center_y=0.01, damping=1e-4)
    b.add(spatial.spectral_beam, "A", "B", name="box", section=section)
    document, left_out = document_of(b)
    assert left_out == []
    given = next(thing["args"] for thing in document.things if thing["call"] == "General")
    assert given["stiffness"] == ["4.1", "0.1", "0.1", "0.1", "3.1", "0.1", "0.1", "2.1", "0.1", "1.1"]
    check_same_contents(rebuilt(document), b)


@pytest.mark.slow
def test_rotation_prescribed_in_space():
    b = fm.Builder()
    b.node("A", (0, 0, 0))
    b.node("B", (0.1, 0, 0))
    b.add(
        spatial.leaf_spring, "A", "B", section=fm.Rectangle(0.02, 0.5e-3, fm.Material(210e9, 80e9, 7850.0)), y=(0, 0, 1)
    )
    b.fix("A")
    b.prescribe("B", "rotation", 0.1, axis=(0, 0, 1), tilt="free")
    b.mass("B", 0.1)
    document, left_out = document_of(b)
    assert left_out == []
    assert not any("turn of" in str(thing.get("name")) for thing in document.things)
    check_same(b, rebuilt(document))


@pytest.mark.slow
def test_what_a_document_cannot_hold_is_told():
    def own(p: fm.Point2, q: fm.Point2, *, ref):
        return jnp.stack([p[0] - q[0] - ref.p[0] + ref.q[0]])

    b = mechanisms.planar_guide()
    names = [name for name, node in b.nodes.items() if node.kind.part == "position"]
    b.add(own, names[0], names[1], name="mine", released="all")
    tapered = fm.sections.taper(mechanisms.leaf(), mechanisms.leaf(thickness=1e-3))
    b.node("far", (1.0, 1.0))
    b.add(planar.spectral_beam, names[0], "far", name="tapered", section=tapered)
    document, left_out = document_of(b)
    assert [one.partition(":")[0] for one in left_out] == ["element 'mine'", "element 'tapered'"]
    assert "mine" not in {thing.get("name") for thing in document.things}


def guide(t=0.5e-3, w=0.018, length=0.1, leaves=2):
    b = fm.Builder()
    steel = fm.Material(210e9, 80e9, 7850.0)
    for i in range(leaves):
        b.node(f"foot {i}", (0.1 * i, 0))
        b.node(f"top {i}", (0.1 * i, length))
        b.add(planar.leaf_spring, f"foot {i}", f"top {i}", section=fm.Rectangle(2 * w, t, steel), name=f"leaf {i}")
        b.fix(f"foot {i}")
    b.add(planar.rigid_body, "top 0", "top 1", name="stage")
    b.mass("top 0", 0.1 + t)
    b.sensor("pace", {"velocity top 0.x": 1 / w})
    return b.build()


@pytest.mark.slow
def test_names_of_a_function_are_kept_with_its_arithmetic():
    given = {"t": (0.5e-3, 0.1e-3, 2e-3), "w": 0.018, "length": 0.1, "leaves": 2}
    document, left_out = document_of(guide, given)
    assert left_out == ["argument leaves = 2 stays as it is: names are numbers with a decimal point"]
    assert document.names["t"] == {"value": "0.0005", "low": "0.0001", "high": "0.002"}
    texts = {str(thing.get("name") or thing["call"]): thing["args"] for thing in document.things}
    assert texts["section"]["width"] == "2*w"
    assert texts["top 1"]["position"] == ["0.1", "length"]
    assert texts["mass"]["mass"] == "0.1+t"
    assert texts["pace"]["weights"] == [["velocity top 0.x", "1/w"]]
    assert not any(thing["call"] == "dof" for thing in document.things)
    # Other values of the names build what the function does.
    data = {**document.data, "names": {n: {**own} for n, own in document.names.items()}}
    data["names"]["t"]["value"] = "0.8e-3"
    data["names"]["length"]["value"] = "0.12"
    built = build(type(document).from_data(data)).builder.build()
    np.testing.assert_allclose(fm.frequencies(built), fm.frequencies(guide(t=0.8e-3, length=0.12)), rtol=1e-12)


def test_arithmetic_that_fields_do_not_know_is_told():
    def turned(angle=0.3, length=0.1):
        b = fm.Builder()
        b.node("A", (0, 0))
        b.node("B", (length * jnp.cos(angle), length))
        b.add(planar.truss, "A", "B", section=fm.Rigidity(EA=1e3, mass=1.0))
        b.fix("A")
        b.fix("B", "x")
        return b

    document, left_out = document_of(turned, {"angle": 0.3, "length": 0.1})
    assert left_out == ["how position of node 'B' follows from angle, length: it is more than + - * / **"]
    assert document.things[1]["args"]["position"][1] == "length"
    assert float(document.things[1]["args"]["position"][0]) == 0.1 * np.cos(0.3)


@pytest.mark.slow
def test_a_function_that_asks_for_values_is_told():
    def thick(t=1e-3):
        return guide(t if t > 0.5e-3 else 0.5e-3)

    document, left_out = document_of(thick, {"t": 1e-3})
    assert len(left_out) == 1
    assert left_out[0].startswith("how numbers follow from t: the function needs to know their values")
    assert next(t for t in document.things if t["call"] == "Rectangle")["args"]["thickness"] == "0.001"


@pytest.mark.slow
def test_wrong_sources_are_refused():
    with pytest.raises(TypeError, match=r"is no mechanism\. Give a Builder"):
        document_of("guide.dat")
    with pytest.raises(TypeError, match="need a function"):
        document_of(mechanisms.planar_guide(), {"t": 1.0})


@pytest.mark.parametrize("what", ["prescribed", "increment", "held", "named", "started", "tilt"])
def test_angles_about_global_axes(what):
    b = fm.Builder()
    b.node("A", (0, 0, 0))
    b.node("B", (0.1, 0, 0))
    leaf = fm.Rectangle(0.02, 0.5e-3, fm.Material(210e9, 80e9, 7850.0))
    b.add(spatial.leaf_spring, "A", "B", name="B", section=leaf, y=(0, 0, 1))
    b.fix("A")
    b.mass("B", 0.1)
    calls = {
        "prescribed": lambda: (b.prescribe("B", "rz", 0.1, kind="node"), b.fix("B", "ry")),
        "increment": lambda: b.prescribe("B", "rz", 0.1, increment=True, kind="node"),
        "held": lambda: b.fix("B", "rx", "ry"),
        "named": lambda: b.dof("B", "rz", "y", kind="node"),
        "started": lambda: b.start("B", "rz", 0.01, kind="node"),
        "tilt": lambda: b.prescribe("B", "rotation", 0.1, axis=(0, 0, 1), tilt="fixed"),
    }
    calls[what]()
    document, left_out = document_of(b)
    assert left_out == []
    assert not any("turn of" in str(thing) for thing in document.things)
    check_same_contents(rebuilt(document), b)
    model = b.build()
    again, left_out = document_of(model)
    assert left_out == []
    assert not any("turn of" in str(thing) for thing in again.things)
    names = [{str(own.labels.e[i]) for i in own.topology.e.fixed} for own in (model, rebuilt(again).build())]
    assert names[0] == names[1]


@pytest.mark.slow
@pytest.mark.parametrize("case", ["fold", "fold beside a statement", "statement that is shared", "thick", "thicker"])
def test_clamps_of_a_model_are_found_again_or_stated(case):
    leaf = fm.Rectangle(0.05, 0.5e-3, fm.Material(210e9, 80e9, 7850.0))
    b = fm.Builder()
    last = (0.1, 0, 0.1) if case.startswith("fold") else (0.2, 0, 0)
    thickness = {"thick": 2e-3, "thicker": 1e-3}.get(case)
    other = fm.Rectangle(0.05, thickness, leaf.material) if thickness else leaf
    for name, place in {"A": (0, 0, 0), "B": (0.1, 0, 0), "C": last}.items():
        b.node(name, place)
    stated = {"fold beside a statement": (True, False), "statement that is shared": (True, True)}.get(case)
    b.add(spatial.leaf_spring, "A", "B", name="one", section=leaf, y=(0, 1, 0), clamped=stated)
    b.add(spatial.leaf_spring, "B", "C", name="two", section=other, y=(0, 1, 0))
    b.fix("A")
    b.mass("C", 0.1)
    model = b.build()
    document, left_out = document_of(model)
    assert not left_out
    again = rebuilt(document).build()
    assert again.counts() == model.counts()
    ends, found = (
        [np.asarray(own["clamped"]).tolist() for own in one.parameters.properties if "clamped" in own]
        for one in (model, again)
    )
    assert found == ends
    stiffness = (fm.linear.directional_compliance(one)["C"] for one in (again, model))
    np.testing.assert_allclose(*stiffness, rtol=1e-9)
