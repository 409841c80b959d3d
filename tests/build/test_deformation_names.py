"""Deformations by name: what a name means, where it is taken, and that no number means a closure by accident."""

import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial

STEEL = fm.Material(E=210e9, G=80e9, rho=7850)
STRIP = fm.Rectangle(0.01, 0.5e-3, STEEL)
WIRE = fm.Rigidity(EA=1e5, EIy=0.02, EIz=0.02, GIt=0.01, mass=0.04, Jx=1e-9)
LENGTH, PULL = 0.1, 50.0
SPECTRAL = planar.spectral_beam(3)


def beam(element=SPECTRAL, section=WIRE, **options):
    """One element from A along x to B."""
    b = fm.Builder()
    far = (LENGTH, 0) if next(iter(element.nodes.values())).dimension == 2 else (LENGTH, 0, 0)
    b.node("A", np.zeros(len(far)))
    b.node("B", far)
    b.add(element, "A", "B", name="l", section=section, **options)
    return b


def clamped(*args, **options):
    """Held at both ends."""
    b = beam(*args, **options)
    b.fix("A")
    b.fix("B")
    return b


@pytest.mark.slow
@pytest.mark.parametrize("element", [planar.spectral_beam, spatial.spectral_beam])
def test_a_tension_by_name_tunes_a_wire(element):
    """Pinned in the plane: f = pi/(2 L^2) sqrt(EI/m) sqrt(1 + T L^2/(pi^2 EI)); six coefficients give five digits."""
    b = beam(element(order=6))
    for node in "AB":
        b.fix(node, "position")
    if b.dimension == 3:
        b.fix("A", "l1")
    b.prestress("l", elongation=PULL)
    model = b.build()
    exact = np.pi / 2 / LENGTH**2 * np.sqrt(WIRE.EIy / WIRE.mass * (1 + PULL * LENGTH**2 / np.pi**2 / WIRE.EIy))
    assert fm.frequencies(model)[0] == approx(exact, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(("element", "flat"), [(SPECTRAL, (0.0, 0.0)), (planar.leaf_spring, (0.14, 0.27))])
def test_a_tension_by_name_pulls_at_the_end(element, flat):
    """Between fixed ends the closure passes on what is given, with no other force or moment.

    Clamps make a leaf spring stiffer by 1 - nu^2 over 0.14 of its width and 0.27 of its thickness each (THEORY.md
    (2.58)), so that it pulls more.
    """
    b = clamped(element, STRIP)
    b.prestress("l", elongation=PULL)
    found = fm.equilibrium(b.build())
    reach = flat[0] * STRIP.width + flat[1] * STRIP.thickness
    mean = 1 - 2 * reach / LENGTH * (STEEL.E / 2 / STEEL.shear_modulus() - 1) ** 2
    assert found.stress_resultant("l", "closure_x") == approx(PULL / mean)
    np.testing.assert_allclose([found.stress_resultant("l", f"closure_{of}") for of in ("y", "tilt")], 0, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("room", [planar, spatial])
def test_what_is_called_elongation_is_what_warmth_gives(room):
    """A free one grows by alpha times temperature times length, and does nothing else, whatever its numbers are."""
    section = fm.Rectangle(0.01, 0.5e-3, fm.Material(E=210e9, G=80e9, rho=7850, alpha=1e-5))
    for name in ("truss", "beam", "warping_beam", "spectral_beam"):
        if not hasattr(room, name):
            continue
        b = beam(getattr(room, name), section)
        (member,) = b.members.values()
        element = member.element
        ref = element.reference([np.asarray(b.nodes[node].start, float) for node in member.nodes])
        gradient = [np.zeros(1 if room is planar else 2)] * (name != "truss")
        own = element.arguments(element.thermal, member.properties)
        found = np.asarray(element.thermal(np.full(2, 30.0), *gradient, ref=ref, **own))
        assert len(found) == len(element.deformation_names)
        at = [*element.deformation_names.values()].index("elongation")
        assert found[at] == approx(3e-4 * LENGTH)
        np.testing.assert_allclose(np.delete(found, at), 0, atol=1e-15)


MEANT = r"its closure.*Its strains are 4 to 6 elongation, 7 to 9 curvature"
REFUSED = {
    "prestress": (
        lambda: beam().prestress("l", PULL),
        r"Prestress of element 'l': deformation 1 \(closure_x\).*" + MEANT,
    ),
    "prestress by name": (lambda: beam().prestress("l", closure_x=1.0), r"deformation 1 \(closure_x\).*has no effect"),
    "strain": (lambda: beam().strain("l", 0, 1e-3), r"Strain of element 'l': deformation 2 \(closure_y\).*" + MEANT),
    "released": (lambda: beam(released=(1, 2, 3)), r"deformation 1 \(closure_x\) is part of " + MEANT),
    "release": (lambda: beam().release("l", 3), r'deformation 3 .*give its name "closure_tilt"'),
    "dof": (lambda: beam().dof("l", 1), MEANT),
    "dofs": (lambda: beam().build(dofs=["l.e1"]), MEANT),
    "prescribe": (lambda: beam().prescribe("l", "1", 1e-3), MEANT),
    "unknown": (
        lambda: beam(planar.beam).prestress("l", elongatoin=1.0),
        r"'l' has deformations 1 to 3, not 'elongatoin': 1 elongation, 2 bending_p, 3 bending_q\.",
    ),
    "unknown among the released": (
        lambda: beam(released=("bending",)),
        r"deformations 1 to 9, not 'bending': 1 closure",
    ),
    "twice": (
        lambda: beam(planar.beam).strain("l", 1e-3, elongation=1e-3),
        r"deformation 1 \(elongation\) is given tw",
    ),
    "not a number": (lambda: beam().prestress("l", elongation="50 N"), r"Prestress of element 'l' must be a number"),
    "of a body": (lambda: bodied().prestress("load", 1.0), r"Element 'load' has no deformations, not 1"),
}


def bodied():
    b = beam()
    b.add(planar.follower_force, "B", name="load", force=(1.0, 0.0))
    return b


@pytest.mark.parametrize("case", REFUSED)
def test_what_would_do_nothing_or_cut_a_beam_is_refused(case):
    act, message = REFUSED[case]
    with pytest.raises(fm.ModelError, match=message):
        act()


def test_a_traced_number_is_no_zero():
    import jax

    with pytest.raises(fm.ModelError, match="closure_x"):
        jax.grad(lambda pull: beam().prestress("l", pull) or pull)(PULL)


def roles(**options):
    return [role.value for role in beam(**options).members["l"].roles]


def test_a_field_is_released_as_a_whole():
    assert roles(released=("curvature",)) == roles(released=SPECTRAL.fields[1]) == ["fixed"] * 6 + ["dependent"] * 3
    assert roles(released="curvature") == roles(released=("curvature",))
    assert roles(released="all") == roles() == ["fixed"] * 3 + ["dependent"] * 6
    assert roles(released=("curvature_2", 4)) == ["fixed"] * 3 + ["dependent"] + ["fixed"] * 3 + ["dependent", "fixed"]


@pytest.mark.slow
def test_a_closure_is_cut_by_its_name():
    """A slot at the end: B goes along the beam as the spring beside it has it, across as 3 EI/L^3 has it."""
    b = beam(released=("closure_x", "elongation", "curvature"))
    b.node("wall", (2 * LENGTH, 0))
    b.add(planar.truss, "B", "wall", name="spring", section=fm.Rigidity(EA=1e3 * LENGTH))
    b.fix("A")
    b.fix("wall")
    found = np.asarray(fm.compliance(fm.linearize(b.build()), "B"))
    assert found[0, 0] == approx(1e-3)
    assert found[1, 1] == approx(LENGTH**3 / 3 / WIRE.EIy)


def hinged():
    """A pendulum with a spring in its hinge."""
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (LENGTH, 0))
    b.rotation("arm")
    b.add(planar.rigid_beam, "A", "arm", "B", name="bar")
    b.rotation("ground")
    b.add(planar.hinge, "ground", "arm", name="hinge", stiffness=2.0)
    b.fix("A")
    b.fix("ground")
    b.mass("B", 0.3)
    return b


@pytest.mark.slow
def test_names_stand_for_numbers_everywhere():
    first = None
    for angle, bar in ((1, 1), ("angle", "offset_x"), ("e1", "e1")):
        b = hinged()
        b.dof("hinge", angle)
        b.start("hinge", angle, 0.1, 0.2)
        b.input("hinge", angle, name="motor")
        b.output("hinge", angle, name="measured")
        b.output("bar", bar, "stress", name="felt")
        b.sensor("twice", {f"hinge.{angle}": 2.0})
        model = b.build()
        first = first or model
        assert model.labels.inputs == first.labels.inputs
        assert [[one.index for one in signal.terms] for signal in model.labels.outputs] == [[2], [0], [2]]
        assert model.q_labels == ["hinge.e1"]
        np.testing.assert_array_equal(model.parameters.start, [[0.1], [0.2]])
    named = hinged().build(dofs=["hinge.angle"])
    assert named.q_labels == ["hinge.e1"]
    b = hinged()
    b.prescribe("hinge", "angle", 0.3)
    assert fm.equilibrium(b.build()).rotation("arm") == approx(0.3)
    # Free at its rest, driven by a moment that is constant from the start: J a'' = M - k a, from 0.
    ts = np.linspace(0, 0.02, 5)
    motion = fm.simulate(named, ts, loads={"hinge.angle": lambda t: 0.05})
    omega = np.sqrt(2.0 / (0.3 * LENGTH**2))
    expected = 0.05 / 2.0 * (1 - np.cos(omega * ts))
    for name in ("angle", 1, "e1"):
        np.testing.assert_allclose(np.abs(motion.deformation("hinge", name)), expected, atol=1e-6)
    np.testing.assert_allclose(motion.along("deformation hinge.angle").values, motion.deformation("hinge", 1))
    with pytest.raises(KeyError, match="element 'hinge' has deformations 1 to 1, not 'angel': 1 angle"):
        motion.deformation("hinge", "angel")


@pytest.mark.slow
def test_a_stroke_and_a_trajectory_by_name():
    b = hinged()
    b.input("hinge", "angle")
    model = b.build(dofs=["hinge.angle"])
    ts = np.linspace(0, 0.1, 5)
    by = [fm.trajectory.inverse_dynamics(model, {name: lambda t: t**2}, ts) for name in ("hinge.angle", "hinge.e1")]
    np.testing.assert_array_equal(by[0].u0, by[1].u0)
    # The motor's stress acts against its deformation: -(J a'' + k a) with a = t^2.
    np.testing.assert_allclose(np.ravel(by[0].u0), -(2 * 0.3 * LENGTH**2 + 2.0 * ts**2), rtol=1e-9)


def test_what_is_held_or_loose_is_warned_of_by_name():
    b = beam(planar.beam, released=("bending_p", "bending_q"))
    b.fix("A")
    b.prestress("l", 1.0, 1e-3)
    with pytest.warns(fm.errors.IdleWarning, match=r"Prestress of element 'l': deformation 1 \(elongation\) is fixed"):
        b.build()
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (LENGTH, 0))
    b.add(planar.gear, "A", "B", name="mesh", ratio=1.0, stiffness=5.0)
    b.strain("mesh", turn=0.1)
    b.fix("A", "position")
    b.fix("B", "position")
    b.fix("A", "rotation")
    with pytest.warns(fm.errors.IdleWarning, match=r"nothing resists deformation 2 \(turn\).*Give it a stiffness"):
        b.build(check=True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "message"),
    [
        (("stretch", "bend"), "must name 1 deformations, but names 2"),
        (("e2",), "calls deformation 1 'e2'"),
        (("increment",), "calls deformation 1 'increment'"),
        (("a b",), "calls deformation 1 'a b'"),
    ],
)
def test_names_of_an_own_element(names, message):
    def distance(p: fm.Point2, q: fm.Point2, *, ref):
        return planar.truss.deformation(p, q, ref=ref)

    own = fm.Element(distance, stiffness=lambda *, ref, k: np.ones((1, 1)) * k, names=("stretch",))
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (LENGTH, 0))
    b.add(own, "A", "B", name="spring", k=3.0)
    b.strain("spring", stretch=1e-3)
    b.fix("A")
    b.fix("B", "y")
    assert fm.equilibrium(b.build()).deformation("spring", "stretch") == approx(1e-3)
    with pytest.raises(fm.ModelError, match=message):
        b.add(fm.Element(distance, names=names), "A", "B")
