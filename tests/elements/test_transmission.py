"""Joints and transmissions against geometry and closed forms."""

import numpy as np
import pytest
from cases.tolerances import approx
from scipy.optimize import root

import flexmb as fm
from flexmb import planar, spatial

# -- belts --------------------------------------------------------------------------------------------------------

# Radii of both pulleys, signed by the side: open, crossed, to a point.
BELTS = {
    "open": (0.3, 0.3),
    "unequal": (0.2, 0.45),
    "right": (-0.3, -0.1),
    "crossed": (0.3, -0.2),
    "point": (0.25, 0.0),
}
P0, Q0 = np.array([0.1, -0.2]), np.array([1.5, 0.6])


def length_between_marks(p, q, way, turn_p, turn_q, radii):
    """Length of belt between marks on both pulleys, by finding where the belt leaves the one and reaches the other.

    On the left of the way from p to q a belt runs clockwise, on the right counter-clockwise.
    """

    def straight(angles):
        start, end = (
            c + abs(r) * np.array([np.cos(a), np.sin(a)]) for c, r, a in zip((p, q), radii, angles, strict=True)
        )
        return end - start

    def slopes(angles):
        """Of the length by the two angles: zero where the straight part is tangent."""
        along = straight(angles) / np.linalg.norm(straight(angles))
        tangents = [abs(r) * np.array([-np.sin(a), np.cos(a)]) for r, a in zip(radii, angles, strict=True)]
        return [tangents[0] @ along + radii[0], tangents[1] @ along + radii[1] if radii[1] else angles[1] - way]

    found = root(slopes, [way + np.pi / 2 * (1 if r > 0 else -1) for r in radii], tol=1e-10)
    assert np.max(np.abs(found.fun)) < 1e-9
    at_p, at_q = angles = found.x
    return radii[0] * (turn_p - at_p) + np.linalg.norm(straight(angles)) + radii[1] * (at_q - turn_q)


@pytest.mark.parametrize("case", BELTS)
def test_belt_is_as_long_as_the_way_it_takes(case):
    radii = BELTS[case]
    element, n = (planar.belt_to_point, 3) if case == "point" else (planar.belt, 4)
    properties = dict(zip(("radius_p", "radius_q"), radii[: n - 2], strict=False))
    ref = element.reference([P0, np.zeros(1), Q0, np.zeros(1)][:n])
    call = fm.jit(lambda x, near: element.deformation(*x, ref=ref, near=near, **properties))
    way = np.arctan2(*(Q0 - P0)[::-1])
    begin = length_between_marks(P0, Q0, way, 0, 0, radii)
    near = np.zeros(n - 1)
    for s in np.linspace(0, 1, 31):
        # Centre q goes around p by more than a turn and away from it, both pulleys turn, p by more than a turn.
        around, turn_p, turn_q = 7.0 * s, -9.0 * s, 4.0 * s
        p = P0 + s * np.array([0.3, 0.5])
        q = p + (1 + 0.4 * s) * np.array([[np.cos(around), -np.sin(around)], [np.sin(around), np.cos(around)]]) @ (
            Q0 - P0
        )
        near = np.asarray(call([p, np.array([turn_p]), q, np.array([turn_q])][:n], near))
        now = length_between_marks(p, q, way + around, turn_p, turn_q, radii)
        # Root finding leaves 1e-9 of an angle, to first order nothing of the length.
        assert near[0] == approx(now - begin, abs=1e-12)


def lift(turn=0.0, free=False):
    """Mass on a belt below a pulley that has turned; positive turns wind the belt up."""
    b = fm.Builder()
    b.node("pulley", (0, 0))
    b.node("mass", (RADIUS, -LENGTH))
    section, damping = fm.Rigidity(EA=EA), fm.Damping(EA=EDA)
    # On the way down the centre lies to the right: the belt runs to its left, and winds up counter-clockwise.
    b.add(planar.belt_to_point, "pulley", "mass", name="belt", radius_p=RADIUS, section=section, damping=damping)
    b.fix("pulley", "position")
    b.fix("mass", "x")
    b.mass("mass", MASS)
    if free:
        b.inertia("pulley", INERTIA)
        b.dof("pulley", "phi")
    else:
        b.prescribe("pulley", "phi", turn)
    b.dof("belt", 1)
    return b


RADIUS, LENGTH, MASS, INERTIA, EA, EDA = 0.2, 1.5, 3.0, 0.05, 900.0, 7.0


@pytest.mark.slow
@pytest.mark.parametrize("turn", [0.0, 1.0, -7.0])
def test_frequency_and_damping_of_a_mass_on_a_belt(turn):
    free = LENGTH - RADIUS * turn
    model = lift(turn).build()
    lin = fm.linearize(model)
    np.testing.assert_allclose(lin.x[3], -free, rtol=1e-12)
    np.testing.assert_allclose(lin.D0, [[EDA / free]], rtol=1e-12)
    np.testing.assert_allclose(fm.frequencies(model), [np.sqrt(EA / free / MASS) / (2 * np.pi)], rtol=1e-12)


@pytest.mark.slow
def test_belt_carries_a_weight_and_pulls_at_its_pulley():
    b = lift(1.0)
    b.gravity((0, -9.81))
    found = fm.equilibrium(b.build())
    free, weight = LENGTH - RADIUS, MASS * 9.81
    strain = weight / EA
    np.testing.assert_allclose(found.e[0], strain * free, rtol=1e-10)
    np.testing.assert_allclose(found.reactions[1], weight, rtol=1e-10)
    # The support turns the pulley against the belt. What belt stores beyond that is released as it is wound up.
    np.testing.assert_allclose(found.reactions[4], weight * RADIUS * (1 + strain / 2), rtol=1e-10)


@pytest.mark.slow
def test_frequencies_of_a_mass_and_a_free_pulley():
    found = fm.frequencies(lift(free=True).build())
    expected = np.sqrt(EA / LENGTH * (1 / MASS + RADIUS**2 / INERTIA)) / (2 * np.pi)
    # The pulley is free to turn: round-off of zero, to half the digits.
    assert abs(found[0]) < 1e-6
    np.testing.assert_allclose(found[1], expected, rtol=1e-10)


@pytest.mark.slow
def test_belt_without_a_section_does_not_stretch():
    b = fm.Builder()
    b.node("driver", (0, 0))
    b.node("driven", (2, 0))
    b.add(planar.belt, "driver", "driven", name="belt", radius_p=0.2, radius_q=-0.5)
    b.fix("driver", "position")
    b.fix("driven", "position")
    b.dof("driver", "phi")
    model = b.build()
    # Crossed: they turn in opposite senses, by more than a turn, one belt of the two being tight.
    found = fm.configuration(model, [10.0], [3.0])
    np.testing.assert_allclose(found.x[5], -10.0 * 0.2 / 0.5, rtol=1e-12)
    np.testing.assert_allclose(found.xd[5], -3.0 * 0.2 / 0.5, rtol=1e-12)
    np.testing.assert_allclose(found.e, [0, 10.0, -4.0], atol=1e-12)
    # So many steps away that they would never end.
    for far in (1e8, 1e99):
        with pytest.raises(fm.AnalysisError, match="exceed 20 000 radians"):
            fm.configuration(model, [far], [3.0])


BAD_BELTS = {
    "pulleys that overlap": {"radius_p": 1.0, "radius_q": -1.0},
    "a section with mass": {"radius_p": 0.1, "radius_q": 0.1, "section": fm.Rigidity(EA=1.0, mass=0.2)},
    "needs the property 'radius_q'": {"radius_p": 0.1},
}


@pytest.mark.parametrize("message", BAD_BELTS)
def test_belts_that_are_refused(message):
    b = fm.Builder()
    b.node("p", (0, 0))
    b.node("q", (2, 0))
    with pytest.raises(fm.ModelError, match=message):
        b.add(planar.belt, "p", "q", **BAD_BELTS[message])


# -- gears --------------------------------------------------------------------------------------------------------


@pytest.mark.slow("0.5-small")
@pytest.mark.parametrize("ratio", [0.4, 3.0, -1.03], ids=["small", "large", "inside a ring of nearly its size"])
@pytest.mark.parametrize("turn", [0.5, -11.0])
def test_planet_on_a_turning_arm(ratio, turn):
    """The sun turns by s, the arm by a: relative to the arm the planet turns by -(s - a)/ratio."""
    sun = 0.3 * turn
    b = fm.Builder()
    b.node("centre", (0, 0))
    b.node("planet", (0.3, 0.1))
    b.rotation("sun")
    b.add(planar.rigid_beam, "centre", "planet")
    b.add(planar.gear, "centre", "sun", "planet", "planet", name="mesh", ratio=ratio)
    b.fix("centre", "position")
    b.dof("centre", "phi")
    b.prescribe("sun", "phi", sun)
    model = b.build()
    found = fm.configuration(model, [turn], [2.0])
    np.testing.assert_allclose(found.at("planet.rotation"), [turn - (sun - turn) / ratio], rtol=1e-11)
    np.testing.assert_allclose(found.xd[model.labels.known("planet.rotation")], [2.0 * (1 + 1 / ratio)], rtol=1e-11)


@pytest.mark.slow
def test_tooth_force_on_the_arm():
    """A moment on gear p is carried by force F = M/r_p at the teeth, which gear q and both centres feel."""
    radius_p, radius_q, moment = 0.1, 0.25, 2.0
    b = fm.Builder()
    b.node("p", (0, 0))
    b.node("q", (radius_p + radius_q, 0))
    b.add(planar.gear, "p", "q", name="mesh", ratio=radius_q / radius_p, stiffness=50.0)
    b.fix("p", "position")
    b.fix("q")
    b.moment("p", moment)
    found = fm.equilibrium(b.build())
    force = moment / radius_p
    labels = found.labels
    np.testing.assert_allclose(found.e[0], moment / 50.0, rtol=1e-12)
    # The moment turns p counter-clockwise; its tooth pushes q upwards and is pushed down.
    np.testing.assert_allclose(found.reactions[labels.known("q")], [0, -force], atol=1e-10)
    np.testing.assert_allclose(found.reactions[labels.known("p")], [0, force], atol=1e-10)
    np.testing.assert_allclose(found.reactions[labels.known("q.rotation")], [force * radius_q], rtol=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("turn", [0.7, 9.0])
def test_bevel_gears(turn):
    b = fm.Builder()
    b.node("box", (0, 0, 0))
    for name in ("box.rotation", "in", "out"):
        b.rotation(name)
    axes = {"axis_p": (1.0, 0, 0), "axis_q": (0, 0.6, 0.8)}
    b.add(spatial.hinge, "box.rotation", "in", name="first", axis=axes["axis_p"])
    b.add(spatial.hinge, "box.rotation", "out", name="second", axis=axes["axis_q"])
    b.add(spatial.gear, "box.rotation", "in", "out", name="mesh", ratio=2.5, **axes)
    b.fix("box")
    b.dof("first", 1)
    found = fm.configuration(b.build(), [turn])
    half = -turn / 2.5 / 2
    lam = np.r_[np.cos(half), np.sin(half) * np.array(axes["axis_q"])]
    np.testing.assert_allclose(found.at("out"), lam, atol=1e-12)


# -- screws -------------------------------------------------------------------------------------------------------

AXIS, PITCH = np.array([1.0, 2.0, -2.0]) / 3, 0.004


@pytest.mark.slow("0.4")
@pytest.mark.parametrize("turn", [0.4, 20.0])
def test_screw_moves_by_its_pitch(turn):
    b = fm.Builder()
    b.node("nut", (0, 0, 0))
    b.node("screw", (0.1, 0, 0.2))
    b.add(spatial.screw, "nut", "screw", name="thread", axis=AXIS, pitch=PITCH)
    b.fix("nut")
    b.dof("thread", 2)
    found = fm.configuration(b.build(), [turn])
    np.testing.assert_allclose(found.at("screw"), np.array([0.1, 0, 0.2]) + PITCH * turn * AXIS, atol=1e-12)
    lam = np.r_[np.cos(turn / 2), np.sin(turn / 2) * AXIS]
    np.testing.assert_allclose(found.at("screw.rotation"), lam, atol=1e-12)


@pytest.mark.slow
def test_screw_that_bends_a_beam():
    """A nut drives the end of a cantilever across: 3 EI d/l^3, and the moment that turns the screw does its work."""
    length, ei, turn = 0.5, 2.0, 4.0
    b = fm.Builder()
    b.node("clamp", (length, 0, 0))
    b.node("base", (0, 0, 0))
    b.node("nut", (0, 0, 0.1))
    b.node("tip", (0, 0, 0))
    section = fm.Rigidity(EA=1.0, EIy=ei, EIz=ei, GIt=1.0)
    b.add(spatial.beam, "clamp", "tip", name="leaf", section=section, y=(0, 1, 0), second_order=False)
    b.add(spatial.screw, "base", "nut", name="thread", axis=(0, 0, 1), pitch=PITCH)
    # The tip is pinned to the nut and can turn.
    b.add(spatial.truss, "nut", "tip", name="rod")
    b.fix("clamp")
    b.fix("base")
    b.fix("tip", "x", "y")
    b.prescribe("thread", 2, turn)
    found = fm.equilibrium(b.build())
    thread = [i for i, entry in enumerate(found.labels.e) if entry.of == "thread"]
    travel = PITCH * turn
    # The rod is upright; the beam's elongation goes with the square of the travel, 1e-3 here and soft.
    np.testing.assert_allclose(found.at("tip")[2], travel, rtol=1e-12)
    force = 3 * ei * travel / length**3
    np.testing.assert_allclose(found.sigma[thread[0]], -force, rtol=2e-3)
    np.testing.assert_allclose(found.sigma[thread[1]], PITCH * found.sigma[thread[0]], rtol=1e-10)


# -- sliders ------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("space", [False, True], ids=["plane", "space"])
@pytest.mark.parametrize("body", [False, True], ids=["point", "body"])
def test_point_on_a_turning_line(space, body):
    """A slot turns about the origin by an angle; the pin in it stays on x = a: it is at height a tan(angle)."""
    a, angle = 0.6, 0.7
    room, far = (spatial, (0.0,)) if space else (planar, ())
    b = fm.Builder()
    b.node("slot", (0, 0, *far))
    b.node("pin", (a, 0, *far))
    element = room.prismatic if body else room.slider
    b.add(element, "slot", "pin", name="slide", axis=(2.0, 0, *far))
    b.fix("slot", "position")
    b.fix("pin", "x")
    if space:
        b.prescribe("slot", "rotation", angle, axis=(0, 0, 1), tilt="fixed")
    else:
        b.prescribe("slot", "phi", angle)
    found = fm.equilibrium(b.build())
    np.testing.assert_allclose(found.at("pin")[:2], [a, a * np.tan(angle)], rtol=1e-10)
    first = next(i for i, entry in enumerate(found.labels.e) if entry.of == "slide")
    np.testing.assert_allclose(found.e[first], a / np.cos(angle) - a, rtol=1e-10)
    if body:
        np.testing.assert_allclose(found.at("pin.rotation"), found.at("slot.rotation"), atol=1e-10)


@pytest.mark.slow("2-beam", "3-rigid_body", "3-beam")
@pytest.mark.parametrize("kind", ["rigid_body", "beam"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_rigid_body_is_clamped_at_both_ends(dimension, kind):
    """Two beams in line bend as one with a stiff part, where that hands on the moment.

    It does so as a beam without a section, which nothing frees.
    """
    module, section = (planar, spatial)[dimension - 2], fm.Rigidity(EA=1e5, EIy=1.0, EIz=1.0, GIt=1.0, mass=0.1)

    b = fm.Builder()
    for i, x in enumerate((0.0, 0.1, 0.15, 0.25)):
        b.node(f"n{i}", (x, *(0.0,) * (dimension - 1)))
    b.add(module.beam, "n0", "n1", section=section)
    b.add(getattr(module, kind), "n1", "n2", name="body")
    b.add(module.beam, "n2", "n3", section=section)
    b.fix("n0")
    b.force("n3", (0, 1e-4, 0)[:dimension])
    # Both beams and the stiff part between them, by hand: a cantilever bends where it can, by M = F (l - x).
    expected = 1e-4 * ((0.25**3 - 0.15**3) + 0.1**3) / 3
    # The slope to the second power.
    assert fm.equilibrium(b.build()).at("n3")[1] == approx(expected, rel=1e-6)


@pytest.mark.slow
def test_pin_body_is_a_rigid_beam():
    assert planar.pin_body is planar.rigid_beam
    assert spatial.pin_body is spatial.rigid_beam
