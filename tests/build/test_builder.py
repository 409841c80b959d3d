"""A wrong description is answered by one message that names the culprit and says what is right."""

import copy
import pickle
from decimal import Decimal
from fractions import Fraction

import jax
import numpy as np
import pytest
from cases import mechanisms
from cases.tolerances import approx
from scipy.spatial.transform import Rotation

import flexmb as fm
from flexmb import planar, spatial
from flexmb.mechanics import deformation

LEAF = mechanisms.leaf()


def two_nodes(dimension=2):
    b = fm.Builder()
    b.node("A", (0.0,) * dimension)
    b.node("B", (0.1, *(0.0,) * (dimension - 1)))
    return b


def beam(b, **properties):
    return b.add(planar.beam, "A", "B", name="leaf", **{"section": LEAF, **properties})


WRONG = {
    "unknown node": (lambda b: b.add(planar.truss, "A", "C", name="bar"), r"No node 'C' \(element 'bar', q\)"),
    "misspelt node": (lambda b: (b.node("middle", (1, 1)), b.fix("midle")), r"Did you mean 'middle'"),
    "node twice": (lambda b: b.node("A", (1, 1)), r"Node 'A' is defined twice"),
    "element twice": (lambda b: (beam(b), beam(b)), r"Element 'leaf' is defined twice"),
    "three coordinates in the plane": (lambda b: b.node("C", (0, 0, 0)), r"'C' has 3 coordinates, but .* planar"),
    "one coordinate": (lambda b: b.node("C", (0,)), r"'C' must have 2 or 3 coordinates, but has 1"),
    "not a number": (lambda b: b.node("C", (float("nan"), 0)), r"Node 'C' has a value that is not a finite number"),
    "property not a number": (
        lambda b: beam(b, section=fm.Rectangle(0.018, float("inf"), mechanisms.steel())),
        r"Property 'section' of element 'leaf'",
    ),
    "spatial element in the plane": (lambda b: b.add(spatial.truss, "A", "B", name="s"), r"'s' \(truss\) is spatial"),
    "wrong number of nodes": (lambda b: b.add(planar.beam, "A", name="one"), r"'one' \(beam\) joins 4 nodes: p \(pos"),
    "unknown property": (lambda b: beam(b, sections=LEAF), r"'leaf' \(beam\) has no property 'sections'. It takes"),
    "needed property": (
        lambda b: (b.rotation("r"), b.rotation("s"), b.add(needy, "r", "s", name="gear")),
        r"'gear' \(needy\) needs the property 'ratio'",
    ),
    "zero length": (lambda b: (b.node("C", (0, 0)), b.add(planar.truss, "A", "C", name="z")), r"'z' has zero length"),
    "zero length to round-off": (
        lambda b: (b.node("C", (0.15, 0)), b.node("D", (3 * 0.05, 0)), b.add(planar.beam, "C", "D", name="z")),
        r"'z' has zero length",
    ),
    "deformation out of range": (lambda b: beam(b, released=(1, 4)), r"'leaf' has deformations 1 to 3, not 4"),
    "two roles": (lambda b: (beam(b), b.fix("A"), b.dof("A", "x")), r"'A' is fixed already and cannot be dof too"),
    "degree of freedom twice": (lambda b: (beam(b), b.dof("B", "x"), b.dof("B", "x")), r"B.x.* twice"),
    "label of nothing": (
        lambda b: (beam(b), b.build(dofs=["B.x", "leaf"])),
        r"'leaf' is no degree of freedom. Name it as",
    ),
    "label unknown": (lambda b: (beam(b), b.build(dofs=["B.q"])), r"Node 'B' has no coordinate 'q'"),
    "label twice": (lambda b: (beam(b), b.build(dofs=["B.x", "B.x"])), r"`dofs` has 'B.x' twice"),
    "label as a word": (
        lambda b: (beam(b), b.build(dofs=("B", 1))),
        r"`dofs` must be 'auto', 'named' or a list of names",
    ),
    "labels without one that is named": (
        lambda b: (beam(b), b.dof("B", "y"), b.build(dofs=["B.x"])),
        r"`dofs` leaves out 'B 2', which dof\(\) names",
    ),
    "unknown coordinate": (lambda b: b.dof("A", "z"), r"no coordinate 'z'. It has: phi|has no coordinate 'z'"),
    "unknown element": (lambda b: (beam(b), b.release("leav", 1)), r"No element 'leav'. Did you mean 'leaf'"),
    "force too long": (lambda b: b.force("B", (1, 2, 3)), r"Force on node 'B' has 3 components, but the node has 2"),
    "gravity too long": (lambda b: b.gravity((0, 0, -9.81)), r"Gravity must have 2 components"),
    "wrong output": (lambda b: b.output("A", "x", "stress"), r"must be one of position, velocity, acceleration"),
    "released a word": (lambda b: beam(b, released="none"), r"`released` of element 'leaf' must be \"all\" or numbers"),
    "released a number": (lambda b: beam(b, released=2), r"`released` of element 'leaf' must be \"all\" or numbers"),
    "released a fraction": (lambda b: beam(b, released=(1.5,)), r"`released` of element 'leaf' must be"),
    "released nothing": (lambda b: (beam(b), b.release("leaf")), r"Release of 'leaf' is empty"),
    "released half": (lambda b: (beam(b), b.release("leaf", 1.5)), r"'leaf' has deformations 1 to 3, not 1.5"),
    "a fraction of a coordinate": (lambda b: b.dof("B", 1.7), r"Node 'B' has coordinates 1 to 2, not 1.7"),
    "a truth as coordinate": (lambda b: b.dof("B", True), r"Node 'B' has coordinates 1 to 2, not True"),
    "nothing as coordinate": (lambda b: b.fix("B", None), r"Node 'B' has coordinates 1 to 2, not None"),
    "a power as coordinate": (lambda b: b.fix("B", "²"), r"has no coordinate '²'"),
    "no degree of freedom": (lambda b: b.dof("B"), r"Dof of 'B' is empty"),
    "scalar force": (lambda b: b.force("B", 3.0), r"Force on node 'B' must be a sequence of numbers, not 3.0"),
    "force a word": (lambda b: b.force("B", "12"), r"Force on node 'B' must be a sequence of numbers, not '12'"),
    "force of words": (lambda b: b.force("B", ("1", "2")), r"Force on node 'B' must be a number, not '1'"),
    "force too short": (lambda b: b.force("B", (1.0,)), r"Force on node 'B' has 1 components, but the node has 2"),
    "force without end": (lambda b: b.force("B", (1.0, float("nan"))), r"Force on node 'B' has a value that is not a"),
    "a flag that is a word": (
        lambda b: b.force("B", (1.0, 0.0), increment="no"),
        r"Argument `increment` must be True or False, not 'no'",
    ),
    "moment of two": (lambda b: b.moment("B", (1.0, 2.0)), r"Moment on node 'B' must be one number in the plane"),
    "moment a word": (lambda b: b.moment("B", "1"), r"Moment on node 'B' must be numbers, not '1'"),
    "scalar gravity": (lambda b: b.gravity(-9.81), r"Gravity must be a sequence of numbers, not -9.81"),
    "position a number": (lambda b: b.node("C", 1.0), r"Node 'C' must be a sequence of numbers, not 1.0"),
    "position of words": (lambda b: b.node("C", ("1", "2")), r"Node 'C' must be a number, not '1'"),
    "arguments exchanged": (lambda b: b.node((0, 0), "C"), r"A node is named by a string.*not by \(0, 0\)"),
    "a node without a name": (lambda b: b.node("", (0, 0)), r"A node needs a name"),
    "a name that is a rotation's": (
        lambda b: b.node("A.rotation", (0, 0)),
        r"'A.rotation' has a name that is reserved for the rot",
    ),
    "mass on a rotation": (lambda b: (beam(b), b.mass("A.rotation", 1.0)), r"'A.rotation' has no position"),
    "mass a word": (lambda b: b.mass("A", "heavy"), r"The mass on node 'A' must be a number, not 'heavy'"),
    "mass of two": (lambda b: b.mass("A", [1.0, 2.0]), r"The mass on node 'A' must be one number, but has shape"),
    "prestress of nothing": (lambda b: (beam(b), b.prestress("leaf")), r"Prestress of 'leaf' is empty"),
    "strain not a number": (
        lambda b: (beam(b), b.strain("leaf", float("nan"))),
        r"Strain of element 'leaf' has a value that is not a finite number: nan",
    ),
    "strain beyond reason": (
        lambda b: (beam(b), b.strain("leaf", 1e308)),
        r"Strain of element 'leaf' has a value that is too large to compute with",
    ),
    "strain of what has no stiffness": (
        lambda b: (beam(b, section=None), b.strain("leaf", 1e-3)),
        r"Strain of element 'leaf': it has no stiffness",
    ),
    "strain of a closure": (
        lambda b: (b.add(planar.spectral_beam(2), "A", "B", name="s", section=LEAF), b.strain("s", 0, 0, 1e-3)),
        r"Strain of element 's': deformation 3 \(closure_tilt\) is part of its closure.* 4 to 5 elongation",
    ),
    "temperature without alpha": (
        lambda b: (beam(b), b.temperature("leaf", 10.0)),
        r"Temperature of element 'leaf': its coefficient of thermal expansion is not stated.* Material\(.., alpha=",
    ),
    "temperature of a rigid beam without alpha": (
        lambda b: (b.add(planar.rigid_beam, "A", "B", name="arm"), b.temperature("arm", 10.0)),
        r"Temperature of element 'arm': its coefficient of thermal expansion is not stated",
    ),
    "temperature of a hinge": (
        lambda b: (b.rotation("A2"), b.add(planar.hinge, "A.rotation", "A2", name="h"), b.temperature("h", 10.0)),
        r"Temperature of element 'h': temperature does not deform an element of type hinge",
    ),
    "temperature of no element": (
        lambda b: (warm(b), b.temperature("laef", 1)),
        r"No element 'laef'. Did you mean 'le",
    ),
    "temperature a word": (lambda b: (warm(b), b.temperature("leaf", "hot")), r"'leaf' must be numbers, not 'hot'"),
    "temperature without end": (
        lambda b: (warm(b), b.temperature("leaf", float("nan"))),
        r"Temperature of element 'leaf' has a value that is not a finite number: nan",
    ),
    "temperature of three": (
        lambda b: (warm(b), b.temperature("leaf", (1, 2, 3))),
        r"Temperature of element 'leaf' must be one number, or two for its ends, not \(1, 2, 3\)",
    ),
    "gradient of two in the plane": (
        lambda b: (warm(b), b.temperature("leaf", 1, gradient=(1, 2))),
        r"Gradient of the temperature of element 'leaf' must be one number in the plane",
    ),
    "gradient across a truss": (
        lambda b: (warm(b, planar.truss), b.temperature("leaf", 1, gradient=3)),
        r"Temperature of element 'leaf': an element of type truss does not bend",
    ),
    "prescribed a word": (lambda b: b.prescribe("B", "x", "5 mm"), r"Prescribed value of 'B' must be a number, not '5"),
    "prescribed in two": (lambda b: b.prescribe("B", "x", [0, 1]), r"Prescribed value of 'B' must be one number"),
    "start a word": (lambda b: b.start("B", "x", "1"), r"Start value of 'B' must be a number, not '1'"),
}


def warm(b, element=planar.beam):
    b.add(element, "A", "B", name="leaf", section=fm.Rigidity(EA=1e6, EIy=1.0, alpha=1e-5))


def needy(a: fm.Angle, b: fm.Angle, *, ref, ratio: float):
    return a - ref.a + ratio * (b - ref.b)


@pytest.mark.parametrize("case", WRONG)
def test_wrong_description(case):
    act, message = WRONG[case]
    with pytest.raises(fm.ModelError, match=message):
        act(two_nodes())


def test_names_that_are_not_given_are_new():
    b = two_nodes()
    b.node("beam 2", (1, 1))
    b.add(planar.beam, "A", "B", name="beam 1")
    assert b.add(planar.beam, "A", "beam 2") == "beam 3"
    assert b.add(planar.beam, "B", "beam 2", name="beam 4") == "beam 4"
    assert [b.add(planar.truss, "A", "B", section=LEAF), b.add(planar.beam, "A", "B")] == ["truss 4", "beam 5"]


def test_parallel_y_vector():
    b = two_nodes(3)
    with pytest.raises(fm.ModelError, match="'leaf' has a local y vector that is zero or parallel"):
        b.add(spatial.beam, "A", "B", name="leaf", section=LEAF, y=(2.0, 0, 0))


def test_empty_model():
    with pytest.raises(fm.ModelError, match="no elements"):
        fm.Builder().build()


@pytest.mark.parametrize("many", [600, 0])
def test_degree_of_freedom_that_cannot_move(many, monkeypatch):
    monkeypatch.setattr(deformation, "MANY", many)
    b = mechanisms.planar_guide(dofs=False)
    b.dof("left1", "y")
    with pytest.raises(fm.MechanismError, match=r"left1.y cannot move"):
        b.build()


@pytest.mark.parametrize("many", [600, 0])
def test_degrees_of_freedom_that_repeat_each_other(many, monkeypatch):
    monkeypatch.setattr(deformation, "MANY", many)
    b = mechanisms.planar_guide(elongation=True, dofs=False)
    b.dof("left1", "x")
    b.dof("right1", "x", "y")
    with pytest.raises(fm.MechanismError, match=r"do not determine the rest"):
        b.build()


@pytest.mark.parametrize("many", [600, 0])
def test_too_few_and_too_many_degrees_of_freedom(many, monkeypatch):
    monkeypatch.setattr(deformation, "MANY", many)
    few = mechanisms.planar_guide(elongation=True, dofs=False)
    few.dof("left1", "x")
    with pytest.raises(fm.MechanismError, match="NDOF = 3, but 1 degrees of freedom are named"):
        few.build()
    many = mechanisms.planar_guide(dofs=False)
    many.dof("left1", "x")
    many.dof("left 1", 2)
    with pytest.raises(fm.MechanismError, match="NDOF = 1, but 2 degrees of freedom are named"):
        many.build()


@pytest.mark.parametrize("ask", [lambda model: fm.Builder(), fm.equilibrium, lambda model: fm.frequencies(model, at=0)])
def test_double_precision_is_asked_for(ask):
    model = mechanisms.planar_guide().build()
    with jax.enable_x64(False), pytest.raises(RuntimeError, match=r"flexmb\.enable_x64\(\)"):
        ask(model)


def test_found_degrees_of_freedom_are_said_and_can_be_named():
    found = mechanisms.planar_guide(elongation=True, dofs=False).build()
    assert len(found.q_labels) == 3
    assert all(name.split(".")[1][0] == "e" for name in found.q_labels)  # deformations of the leaf springs
    named = mechanisms.planar_guide(elongation=True).build()
    # Another choice of coordinates, the same mechanism.
    np.testing.assert_allclose(fm.frequencies(found), fm.frequencies(named), rtol=1e-9)
    # The labels are names again, in their order, of deformations and of coordinates, with names that have points.
    b = mechanisms.planar_guide(elongation=True, dofs=False)
    assert b.build(dofs=found.q_labels[::-1]).q_labels == found.q_labels[::-1]
    assert b.build(dofs=["left1.x", *found.q_labels[1:]]).q_labels == ["left1.x", *found.q_labels[1:]]
    assert b.dofs == []
    bent = fm.Builder()
    bent.node("a.b", (0, 0, 0))
    bent.node("e1", (0.1, 0, 0))
    bent.add(spatial.beam, "a.b", "e1", name="e1.e2", section=LEAF)
    bent.fix("a.b")
    labels = ["e1.y", "e1.rotation.l1", *(f"e1.e2.e{i}" for i in (1, 3, 4, 6))]
    model = bent.build(dofs=labels)
    assert model.q_labels == labels
    bent.dof("e1", "y")
    assert bent.build(dofs=model.q_labels).q_labels == labels


def test_traced_geometry_needs_named_degrees_of_freedom():
    def frequency(height):
        b = fm.Builder()
        b.node("A", (0, 0))
        b.node("B", (0, height))
        b.add(planar.beam, "A", "B", section=LEAF)
        b.fix("A")
        return fm.frequencies(b.build())[0]

    with pytest.raises(fm.ModelError, match="Name them with dof"):
        jax.grad(frequency)(0.1)


def spectral_guide(height=0.1, held=True):
    b = fm.Builder()
    leaf = fm.Rectangle(0.018, 5e-4, STEEL)
    for name, place in {"A": (0, 0), "B": (0, height), "C": (0.1, height), "D": (0.1, 0)}.items():
        b.node(name, place)
    b.add(planar.spectral_beam(4), "A", "B", name="left", section=leaf)
    b.add(planar.spectral_beam(4), "D", "C", name="right", section=leaf)
    b.add(planar.beam, "B", "C", name="stage")
    b.fix("A")
    b.fix("D", *(() if held else ("position",)))
    b.mass("C", 0.2)
    return b


@pytest.mark.slow
def test_coefficients_of_spectral_beams_make_up_the_degrees_of_freedom():
    b = spectral_guide()
    expected = fm.frequencies(b.build())
    b.dof("B", "x")
    model = b.build()
    assert model.q_labels[0] == "B.x"
    assert len(model.q_labels) == 13
    assert all(label.startswith(("left.e", "right.e")) for label in model.q_labels[1:])
    np.testing.assert_allclose(fm.frequencies(model), expected, rtol=1e-8)
    # A foot that turns freely has a stiffness too, that of its leaf spring: it needs no name.
    assert len(spectral_guide(held=False).build(dofs="named").q_labels) == 14
    # What has none does: nothing holds the mechanism as a whole.
    b = fm.Builder()
    for name, x in (("A", 0), ("B", 1)):
        b.node(name, (x, 0))
    b.add(planar.spectral_beam(4), "A", "B", name="leaf", section=fm.Rigidity(EA=1.0, EIy=1.0, mass=1.0))
    with pytest.raises(fm.MechanismError, match="NDOF = 11, but 0 degrees of freedom are named") as info:
        b.build(dofs="named")
    assert info.value.code == "underconstrained"


def test_a_traced_build_without_checks_needs_no_degrees_of_freedom():
    def length(place):
        b = fm.Builder()
        b.node("p", (0, 0))
        b.node("q", (place, 0))
        b.add(planar.beam, "p", "q", name="leaf", section=fm.Rigidity(EA=1.0, EIy=1.0))
        b.fix("p")
        model = b.build(check=False)
        return model.parameters.reference[model.labels.known("q")[0]]

    assert float(jax.jit(length)(0.25)) == 0.25


@pytest.mark.slow
def test_a_traced_build_has_all_degrees_of_freedom_named():
    def tip(height, dofs="auto"):
        b = spectral_guide(height)
        b.dof("B", "x")
        return fm.frequencies(b.build(dofs=dofs))[0]

    with pytest.raises(fm.ModelError, match="NDOF = 13, but 1 degrees of freedom are named, and the rest"):
        jax.grad(tip)(0.1)
    b = spectral_guide()
    b.dof("B", "x")
    labels = b.build().q_labels
    found = jax.grad(lambda h: tip(h, labels))(0.1)
    # Central difference: truncation 1e-8.
    assert found == approx((float(tip(0.1 + 1e-5)) - float(tip(0.1 - 1e-5))) / 2e-5, rel=1e-6)


def test_own_element_from_a_notebook():
    """A gear pair on a turning arm: the wheel turns by -1/ratio of the pinion."""

    def gear(p: fm.Point2, a: fm.Angle, q: fm.Point2, b: fm.Angle, *, ref, ratio: float):
        def direction(v):
            return jax.numpy.arctan2(v[1], v[0])

        arm = direction(q - p) - direction(ref.q - ref.p)
        return (a - ref.a - arm) + ratio * (b - ref.b - arm)

    b = two_nodes()
    b.add(gear, "A", "B", name="gears", ratio=3.0)
    b.fix("A", "position")
    b.fix("B", "position")
    b.inertia("A", 0.2)
    b.inertia("B", 0.3)
    b.dof("A", "phi")
    model = b.build()
    # Kinetic energy of both wheels seen at the first: 0.2 + 0.3/9.
    assert fm.linearize(model).M0[0, 0] == approx(0.2 + 0.3 / 9, rel=1e-12)


def test_overview_lists_every_entry():
    text = mechanisms.planar_guide().build().overview()
    assert "NDOF = NX - NXO - NEO = 12 - 6 - 5 = 1" in text
    assert "left1           x dof, y dependent" in text
    assert "left 1          e1 fixed, e2 dependent, e3 dependent" in text


def test_overview_joins_what_is_alike_within_a_leaf_spring():
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (0.1, 0))
    b.add(planar.leaf_spring(order=6), "foot", "tip", name="leaf", section=mechanisms.leaf())
    b.fix("foot")
    lines = b.build().overview().splitlines()
    (inner,) = [line for line in lines if line.startswith("leaf.internal")]
    assert inner.split(maxsplit=1)[1].startswith("c1 to c")
    assert all(len(line) < 120 for line in lines)


def test_overview_keeps_a_long_name_off_its_components():
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("carriage of mirror", (1, 0))
    b.add(planar.truss, "foot", "carriage of mirror", name="rod")
    b.fix("foot")
    b.fix("carriage of mirror")
    text = b.build(check=False).overview().splitlines()
    assert "carriage of mirror x fixed, y fixed" in text
    assert "node               components" in text


STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0)


@pytest.mark.parametrize(
    ("section", "fault"),
    [
        (fm.Rectangle(0.018, -5e-4, STEEL), "thickness = -0.0005, but it must be positive"),
        (fm.Rectangle(0.0, 5e-4, STEEL), "width = 0.0, but it must be positive"),
        (fm.Rectangle(0.018, 5e-4, fm.Material(E=-1.0, G=80e9)), "E = -1.0"),
        (fm.Rectangle(0.018, 5e-4, fm.Material(E=1.0, G=80e9, rho=-1.0)), "rho = -1.0, but it cannot be negative"),
        (fm.Circle(1e-3, fm.Material(1e9, 4e8, nu=0.5)), "nu = 0.5, but it must be above -1 and below 0.5"),
        (fm.Circle(1e-3, fm.Material(210e9, 60e9)), "nu = 0.75 by E and G, but it must be below 0.5: G is"),
        (fm.Circle(1e-3, fm.Material(1e9, 4e8, strength=0.0)), "strength = 0.0, but it must be positive"),
        (fm.Circle(1e-3, fm.Material(1e9, 4e8, damping=-1e-6)), "damping = -1e-06, but it cannot be negative"),
        (fm.Circle(1e-3, fm.Material(1e9, 4e8, strength=1e6, fatigue=2e6)), "fatigue = 2000000.0, but it cannot be ab"),
        (fm.HollowRectangle(0.02, 0.01, 0.002, 0.005, STEEL), "wall_z = 0.005, which leaves no hole"),
        (fm.Tube(0.01, 0.005, STEEL), "wall = 0.005, which leaves no hole"),
        (fm.Rigidity(EIy=-1.0), "EIy = -1.0, but it cannot be negative"),
    ],
)
def test_sections_that_cannot_be(section, fault):
    b = two_nodes()
    with pytest.raises(fm.ModelError, match=f"The section of element 'leaf' has {fault}"):
        b.add(planar.beam, "A", "B", name="leaf", section=section)


def test_a_mass_is_not_negative_but_inertia_may_be():
    b = two_nodes()
    with pytest.raises(fm.ModelError, match="mass on node 'A' is -1"):
        b.mass("A", -1.0)
    b.mass("A", 1.0, inertia=-1e-3)


@pytest.mark.slow
def test_sections_of_several_kinds_in_one_block():
    """A leaf spring, a given rigidity and an element without section are as three blocks of their own would be."""

    def chain(*sections):
        b = fm.Builder()
        for i in range(len(sections) + 1):
            b.node(f"{i}", (0.1 * i, 0))
        for i, section in enumerate(sections):
            b.add(
                planar.beam,
                f"{i}",
                f"{i + 1}",
                name=f"b{i}",
                section=section,
                released=() if section is None else "all",
            )
        b.fix("0")
        b.mass(f"{len(sections)}", 1.0, inertia=1e-3)
        return fm.frequencies(b.build())

    leaf = fm.Rectangle(0.018, 5e-4, STEEL)
    found = chain(None, leaf, leaf.rigidity(), fm.Circle(1e-3, STEEL))
    alike = chain(None, leaf.rigidity(), leaf.rigidity(), fm.Circle(1e-3, STEEL).rigidity())
    np.testing.assert_allclose(found, alike, rtol=1e-9)


def test_inertia_is_six_numbers_or_their_matrix():
    def wheel(inertia):
        b = fm.Builder()
        b.node("hub", (0, 0, 0))
        b.mass("hub", 1.0, inertia=inertia)
        return b.build(check=False).parameters.properties

    six = [1.0, 0.1, 0.2, 2.0, 0.3, 3.0]
    matrix = [[1.0, 0.1, 0.2], [0.1, 2.0, 0.3], [0.2, 0.3, 3.0]]
    for one, other in zip(jax.tree.leaves(wheel(six)), jax.tree.leaves(wheel(np.array(matrix))), strict=True):
        np.testing.assert_array_equal(one, other)
    with pytest.raises(fm.ModelError, match=r"inertia of node 'hub' must be .* not of shape \(3,\)"):
        wheel([1.0, 2.0, 3.0])
    # Turned to and fro it is symmetric but for round-off.
    turn = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix()
    wheel(turn @ np.diag([1e-5, 1e-5, 1e-5]) @ turn.T + 1e-20 * np.eye(3, k=1))
    with pytest.raises(fm.ModelError, match="inertia of node 'hub' must be a symmetric matrix"):
        wheel(np.triu(matrix))


def test_inertia_in_the_plane_is_one_number():
    b = fm.Builder()
    b.node("hub", (0, 0))
    with pytest.raises(fm.ModelError, match="inertia of node 'hub' must be one number"):
        b.mass("hub", 1.0, inertia=np.eye(3))


def test_options_of_build_that_do_not_exist():
    b = mechanisms.planar_guide()
    for options, message in (
        ({"dofs": "none"}, "`dofs` must be 'auto' or 'named', but is 'none'"),
        ({"release": "all"}, "`release` must be 'auto' or 'none', but is 'all'"),
        ({"release": True}, "`release` must be 'auto' or 'none', but is True"),
        ({"check": "no"}, "`check` must be True or False, not 'no'"),
    ):
        with pytest.raises(ValueError, match=message):
            b.build(**options)


def test_gravity_is_of_the_dimension_of_the_nodes_whatever_comes_first():
    b = fm.Builder()
    b.gravity((0, 0, -9.81))
    b.node("A", (0, 0))
    b.node("B", (0.1, 0))
    beam(b)
    b.fix("A")
    with pytest.raises(fm.ModelError, match="Gravity must have 2 components, but has 3"):
        b.build()


def test_an_element_that_is_refused_leaves_nothing_behind():
    b = two_nodes()
    with pytest.raises(fm.ModelError, match="No node 'C'"):
        b.add(planar.beam, "A", "C", name="leaf")
    b.node("C", (0.0, 0.0))
    with pytest.raises(fm.ModelError, match="zero length"):
        b.add(planar.beam, "A", "C", name="leaf")
    assert list(b.nodes) == ["A", "B", "C"]
    assert not b.members


def test_names_that_the_builder_gives_are_free():
    """Neither a default name nor that of a mass takes another element's."""
    b = two_nodes()
    b.add(planar.beam, "A", "B", name="beam 3")
    b.add(planar.beam, "A", "B", name="mass A 4")
    assert b.add(planar.beam, "A", "B") == "beam 4"
    b.mass("A", 1.0)
    assert len(b.members) == 4
    assert b.members["mass A 4"].element is planar.beam


@pytest.mark.parametrize("what", ["prestress", "strain"])
def test_what_acts_on_fixed_deformations_is_warned_of(what):
    b = two_nodes()
    beam(b, released=(2, 3))
    b.fix("A")
    getattr(b, what)("leaf", 1e-3, 0.0)
    with pytest.warns(
        fm.FlexmbWarning, match=rf"{what.capitalize()} of element 'leaf': deformation 1 \(elongation\) is fixed"
    ):
        b.build()
    b.release("leaf", 1)
    b.build()


def test_arrays_that_are_written_into_afterwards_leave_a_model_as_it_is():
    def numbers(write):
        every = [np.array(v) for v in (5e-4, [0.01, 0.0], 1e-5, 0.1, 0.3, 2.0)]
        thickness, center, inertia, place, pull, factor = every
        b = fm.Builder()
        b.node("a", (0.0, 0.0))
        b.node("c", (0.1, 0.0))
        b.add(planar.beam, "a", "c", name="leaf", section=fm.Rectangle(0.018, thickness, LEAF.material))
        b.fix("a")
        b.body("c", 0.1, center=center, inertia=inertia)
        b.prestress("leaf", pull)
        b.start("c", "y", place, place)
        b.gravity((0.0, factor))
        b.actuator("pair", {"c.x": factor, "c.y": 1.0})
        for given in every if write else ():
            given[...] = 7.0
        return jax.tree.leaves(b.build().parameters)

    assert all(map(np.array_equal, numbers(False), numbers(True)))


def pickled(b):
    return pickle.loads(pickle.dumps(b))


@pytest.mark.slow
@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, fm.Builder.copy, pickled])
def test_a_copy_of_a_builder_has_contents_of_its_own(copied):
    b = two_nodes()
    beam(b)
    b.fix("A")
    b.input("B", "y")
    before = fm.frequencies(b.build())
    twin = copied(b)
    assert type(twin) is fm.Builder
    twin.node("C", (0.2, 0))
    twin.add(planar.beam, "B", "C", name="more", section=LEAF)
    twin.mass("B", 1.0)
    twin.force("B", (1.0, 0))
    twin.output("B", "y")
    twin.dof("leaf", 2)
    twin.release("leaf", 1)
    twin.start("leaf", 2, 0.1)
    twin.fix("B", "x")
    assert (list(b.nodes), list(b.members)) == (["A", "B", "A.rotation", "B.rotation"], ["leaf"])
    assert [b.dofs, b.starts, b.signals["output"], b.loads["initial"].get("force")] == [[], {}, [], None]
    np.testing.assert_array_equal(fm.frequencies(b.build()), before)


@pytest.mark.slow
def test_a_body_on_a_second_rotation_of_a_node_is_an_element():
    """Two arms on one pin: what the message says is right, by the frequencies of the arm on springs."""

    def arms(on_second):
        b = fm.Builder()
        b.node("pin", (0, 0))
        b.fix("pin", "position")
        b.rotation("ground")
        b.fix("ground")
        b.add(planar.hinge, "ground", "pin", stiffness=3.0)
        b.body("pin", 1.0, center=(0.1, 0), inertia=0.02)
        b.rotation("second")
        b.add(planar.hinge, "ground", "second", stiffness=12.0)
        on_second(b)
        return b.build()

    way = r"'second' has no position.* add\(planar.body, 'position', 'second', mass=.., center=.., inertia=..\)"
    with pytest.raises(fm.ModelError, match=way):
        arms(lambda b: b.body("second", 1.0, inertia=0.02))
    model = arms(lambda b: b.add(planar.body, "pin", "second", mass=1.0, center=(0.1, 0), inertia=0.02))
    expected = np.sqrt(np.array([3.0, 12.0]) / (0.02 + 1.0 * 0.1**2)) / (2 * np.pi)
    np.testing.assert_allclose(fm.frequencies(model), expected, rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [Fraction, Decimal])
def test_fractions_and_decimals_are_numbers(kind):
    def model(n):
        b = fm.Builder()
        b.node("A", (0, 0))
        b.node("B", (n("0.1"), n(0)))
        steel = fm.Material(n("210e9"), n("80e9"), n(7850))
        b.add(planar.beam, "A", "B", name="leaf", section=fm.Rectangle(n("0.018"), n("0.0005"), steel))
        b.fix("A")
        b.body("B", n("0.1"), center=(n("0.01"), 0), inertia=n("1e-4"))
        b.force("B", (n(1), n("0.25")))
        b.force("B", (n(1), 0))
        b.gravity((0, n("-9.81")))
        b.prestress("leaf", n(2))
        b.prescribe("B", "y", n("1e-3"))
        return b.build()

    assert all(map(np.array_equal, *(jax.tree.leaves(model(n).parameters) for n in (kind, float))))
    fm.simulate(model(kind), [kind(0), kind("1e-4")], rtol=kind("1e-4"))
    with pytest.raises(fm.ModelError, match="Node 'A' has a value that is too large"):
        fm.Builder().node("A", (kind("1e200"), 0))
    with pytest.raises(fm.ModelError, match="Node 'A' must be a number, not"):
        fm.Builder().node("A", (kind, 0))
