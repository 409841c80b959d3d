"""Motions of what is held as inputs, constraint forces as outputs, sensors and actuators, in second-order form."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx
from scipy.spatial.transform import Rotation

import flexmb as fm
from flexmb import planar, spatial

STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0)
FORCE = np.array([20.0, 3.0, 0.5])
COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")


def shaken_mass(stiffness=90.0, damping=1.2, mass=0.4, length=0.3, own=0.0):
    """A mass on a damped spring, which may have a mass of its own, on a wall."""
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("mass", (length, 0))
    section, lossy = fm.Rigidity(EA=stiffness * length, mass=own / length), fm.Damping(EA=damping * length)
    b.add(planar.truss, "wall", "mass", name="s", section=section, damping=lossy)
    b.fix("wall")
    b.fix("mass", "y")
    b.dof("mass", "x")
    b.mass("mass", mass)
    return b


def test_every_kind_of_signal_of_a_mass_on_a_wall_that_shakes():
    """m x'' = c (p' - x') + k (p - x) + F - S: the wall carries the stress k (x - p) + c (x' - p') + S."""
    k, c, m, w = 90.0, 1.2, 0.4, 0.25
    b = shaken_mass(k, c, m)
    b.input("wall", "x", "velocity")
    b.actuator("push", {"mass.x": 2.0, "s.1": w})
    b.output("mass", "x", "acceleration")
    b.output("wall", "x", "reaction")
    b.output("s", 1, "stress")
    b.sensor("gap", {"mass.x": w, "velocity wall.x": -2.0, "reaction wall.x": 1.0})
    found = fm.control.second_order(fm.linearize(b.build()))
    expected = {
        "M": [[m]],
        "C": [[c]],
        "K": [[k]],
        "B0": [[k, 2 - w]],
        "B1": [[c, 0]],
        "B2": [[0, 0]],
        "C0": [[0], [-k], [k], [w - k]],
        "C1": [[0], [-c], [c], [-c]],
        "C2": [[1], [0], [0], [0]],
        "D0": [[0, 0], [k, -w], [-k, w], [k, -w]],
        "D1": [[0, 0], [c, 0], [-c, 0], [c - 2, 0]],
        "D2": np.zeros((4, 2)),
        "orders": [1, 0],
        "moves": [True, False],
    }
    for name, value in expected.items():
        np.testing.assert_allclose(getattr(found, name), value, rtol=1e-12, atol=1e-14, err_msg=name)


def bent_leaf():
    """A leaf spring that cannot stretch, well away from where it was under the force and moment at its end c."""
    b = fm.Builder()
    b.node("a", (0, 0, 0))
    b.node("c", (0.1, 0, 0))
    leaf = fm.Rectangle(0.018, 0.5e-3, STEEL)
    b.add(spatial.beam, "a", "c", name="leaf", section=leaf, y=(0, 1, 0), released=(2, 3, 4, 5, 6))
    b.dof("leaf", 2, 3, 4, 5, 6)
    b.force("c", FORCE)
    b.moment("c", (0.2, 0.05, 0.0))
    return b


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::flexmb.BeamTheoryWarning")
def test_a_loaded_leaf_spring_on_a_floor_that_moves():
    """At rest: against nonlinear equilibria with the floor moved, and the moments in balance about it."""
    b = bent_leaf()
    b.fix("a")
    for component in COMPONENTS:
        b.input("a", component, "displacement")
        b.output("c", component)
    b.input("c", "y")
    b.input("c", "rx")
    b.input("leaf", 1, "displacement")
    for component in COMPONENTS:
        b.output("a", component, "reaction")
    b.output("leaf", 1, "stress")
    model = b.build()
    lin = fm.linearize(model)
    found = fm.control.second_order(lin)
    gain = np.asarray(found.D0 + found.C0 @ np.linalg.solve(found.K, found.B0))
    # A unit of base motion x, y, z, rx, ry, rz, of force y and moment rx at c, and of elongation.
    arm = np.asarray(lin.position("c") - lin.position("a"))
    turning = -np.cross((gain[:3] - np.eye(3, 9)).T, FORCE).T
    turning[:, 6] -= np.cross(arm, [0, 1, 0])
    turning[:, 7] -= [1, 0, 0]
    pushed = np.zeros((3, 9))
    pushed[1, 6] = -1
    # Round-off of 1 N and of 2 N m by the condition number of the stiffness, 6e3.
    np.testing.assert_allclose(gain[6:9], pushed, atol=1e-11)
    np.testing.assert_allclose(gain[9:12], turning, atol=1e-11)
    step = 1e-4
    for column, axis in ((3, 0), (5, 2)):
        ends = []
        for sign in (1, -1):
            b = bent_leaf()
            b.fix("a", "position")
            b.prescribe("a", "rotation", sign * step, axis=np.eye(3)[axis], tilt="fixed")
            ends.append(fm.equilibrium(b.build()))
        turned = [Rotation.from_quat(np.asarray(end.at("c.rotation")), scalar_first=True) for end in ends]
        moved = (ends[0].position("c") - ends[1].position("c")) / (2 * step)
        stress = (ends[0].stress_resultant("leaf", 1) - ends[1].stress_resultant("leaf", 1)) / (2 * step)
        # Truncation of the difference, the square of its step.
        np.testing.assert_allclose(gain[:3, column], moved, atol=1e-7)
        np.testing.assert_allclose(gain[3:6, column], (turned[0] * turned[1].inv()).as_rotvec() / (2 * step), atol=1e-7)
        assert gain[12, column] == approx(float(stress), rel=1e-7)


@pytest.mark.slow
def test_weight_counts_once_whichever_loads_it_belongs_to():
    """A body beside a leaf spring, whose clamp turns, under gravity of the constant or of the incremental loads."""
    found = []
    for increment in (False, True):
        b = fm.Builder()
        b.node("a", (0, 0))
        b.node("c", (0.1, 0))
        b.add(planar.beam, "a", "c", name="leaf", section=fm.Rectangle(0.018, 0.5e-3, STEEL), released=(2, 3))
        b.dof("leaf", 2, 3)
        b.add(planar.body, "c", name="body", mass=0.02, center=(0.12, 0.01), inertia=1e-5)
        b.fix("a")
        b.gravity((0.6, -9.81), increment=increment)
        b.input("a", "phi", "displacement")
        b.output("a", "phi", "reaction")
        b.output("c", "y")
        found.append(fm.control.second_order(fm.linearize(b.build(), increment=1.0 if increment else None)))
    assert abs(found[0].B0[0, 0]) > 0
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(other, one, rtol=1e-12, atol=1e-14)


# -- state spaces ---------------------------------------------------------------------------------------------------


def response(found, s):
    a, b, c, d = (np.asarray(of) for of in found)
    return c @ np.linalg.solve(s * np.eye(len(a)) - a, b) + d


@pytest.mark.slow
def test_state_spaces_of_a_wall_that_shakes():
    """(c s + k)/(m s^2 + c s + k) of its displacement, velocity and acceleration, with no state too many."""
    k, c, m = 90.0, 1.2, 0.4
    s = 1j * np.sqrt(k / m) * 0.8
    transmitted = (c * s + k) / (m * s**2 + c * s + k)
    expected = {"position": transmitted, "velocity": s * transmitted, "acceleration": s**2 * transmitted}
    expected["reaction"] = (c * s + k) * (1 - transmitted)
    cases = (
        ("displacement", ("position", "velocity"), ["mass.x", "d mass.x shifted"]),
        ("velocity", expected, ["mass.x", "moved by floor", "d mass.x"]),
        ("acceleration", expected, ["mass.x", "moved by floor", "d mass.x", "d moved by floor"]),
    )
    for order, (quantity, measured, names) in enumerate(cases):
        b = shaken_mass(k, c, m)
        b.input("wall", "x", quantity, name="floor")
        for wanted in measured:
            b.output("wall" if wanted == "reaction" else "mass", "x", wanted)
        found, states = fm.control.state_matrices(b.build())
        assert states == names
        rows = np.array([expected[wanted] for wanted in measured]) / s**order
        np.testing.assert_allclose(response(found, s)[:, 0], rows, rtol=1e-12)
    b = shaken_mass(k, c, m)
    b.input("wall", "x", "displacement", name="floor")
    b.output("wall", "x", "reaction", name="force on the floor")
    with pytest.raises(
        fm.ModelError, match="'force on the floor' needs the velocity of the coordinate that the input 'floor' moves"
    ):
        fm.to_statespace(b.build())


def test_a_wall_that_shakes_a_damped_spring_with_mass():
    """(-m_s s^2/6 + c s + k)/((m + m_s/3) s^2 + c s + k), the spring's mass m_s following its ends linearly."""
    k, c, m, own = 90.0, 1.2, 0.4, 0.3
    s = 1j * np.sqrt(k / m) * 0.8
    b = shaken_mass(k, c, m, own=own)
    b.input("wall", "x", "displacement", name="floor")
    b.output("mass", "x")
    found, states = fm.control.state_matrices(b.build())
    assert states == ["mass.x shifted", "d mass.x shifted"]
    moved = (-own / 6 * s**2 + c * s + k) / ((m + own / 3) * s**2 + c * s + k)
    np.testing.assert_allclose(response(found, s), [[moved]], rtol=1e-12)


def guide(floor, thickness=0.5e-3, length=0.1, weight=0.0):
    """The tutorial's guide on a floor: two leaf springs under a bar of 0.206 kg."""
    b = fm.Builder()
    leaf = fm.Rectangle(0.018, thickness, STEEL)
    for side, x in (("left", 0.0), ("right", 0.1)):
        b.node(f"{side} foot", (x, 0.0))
        b.node(f"{side} top", (x, length))
        b.add(planar.beam, f"{side} foot", f"{side} top", name=side, section=leaf, released=(2, 3))
        b.mass(f"{side} top", 0.103)
        if floor != "pushed":
            b.force(f"{side} top", (0.0, -weight))
    b.add(planar.beam, "left top", "right top", name="bar")
    if floor == "pushed":
        b.add(planar.beam, "left foot", "right foot", name="floor", released=(2, 3))
        b.mass("left foot", 1e6)
        for node in ("left foot", "right foot"):
            b.fix(node, "y", "phi")
        b.dof("left foot", "x")
        b.actuator("floor", {"left foot.x": 1e6})
    else:
        b.fix("left foot")
        b.fix("right foot")
        b.actuator("floor", {f"{floor} left foot.x": 1.0, f"{floor} right foot.x": 1.0})
    b.release("right", 1)
    b.dof("left", 2)
    b.dof("right", 1)
    b.output("left top", "x")
    return b


@pytest.mark.slow
def test_a_guide_on_a_floor_that_shakes_is_one_on_a_heavy_support_that_is_pushed():
    shaken, names = fm.control.state_matrices(guide("acceleration").build())
    assert names == ["left.e2", "right.e1", "moved by floor", "d left.e2", "d right.e1", "d moved by floor"]
    pushed, _ = fm.control.state_matrices(guide("pushed").build())
    for hertz in (0.5, 2.0, 40.0, 200.0):
        s = 2j * np.pi * hertz
        # The guide has 2e-7 of the support's mass.
        np.testing.assert_allclose(response(shaken, s), response(pushed, s), rtol=1e-6)


@pytest.mark.slow
def test_derivatives_of_a_pendulum_whose_pivot_shakes():
    """A to D by length, mass and gravity, which is aslant, against central differences; the rod cannot stretch."""

    def numbers(size):
        length, mass, gravity = size * jnp.array([0.7, 0.3, 9.81])
        b = fm.Builder()
        b.node("pivot", (0, 0))
        b.node("bob", (0.6 * length, -0.8 * length))
        b.add(planar.truss, "pivot", "bob", name="rod", released=())
        b.fix("pivot")
        b.mass("bob", mass)
        b.gravity((0.6 * gravity, -0.8 * gravity))
        b.dof("bob", "x")
        b.actuator("shaken", {"acceleration pivot.x": 1.0, "acceleration pivot.y": length})
        b.output("pivot", "y", "reaction")
        b.output("rod", 1, "stress")
        b.sensor("both", {"bob.x": 1 / length, "acceleration bob.y": mass})
        found, _ = fm.control.state_matrices(b.build())
        # Each entry counts alike, whatever its size.
        return sum(jnp.sum(jnp.cos(jnp.arange(of.size)) * jnp.arcsinh(of).ravel()) for of in found)

    at, along, step = jnp.ones(3), jnp.array([1.0, -0.3, 0.5]), 1e-5
    value = fm.jit(numbers)
    forward = jax.jvp(value, (at,), (along,))[1]
    reverse = jax.grad(value)(at) @ along
    central = (value(at + step * along) - value(at - step * along)) / (2 * step)
    # Truncation of the difference, 1e-10, and round-off over its step.
    np.testing.assert_allclose([forward, reverse], [central] * 2, rtol=1e-6)


@pytest.mark.slow
def test_what_cannot_be_a_signal_is_refused_by_name():
    b = shaken_mass()
    with pytest.raises(fm.ModelError, match=r"Sensor 'yaw' needs a dictionary"):
        b.sensor("yaw", {})
    with pytest.raises(fm.ModelError, match=r"Actuator 'push' has parts of several kinds, displacement, force"):
        b.actuator("push", {"mass.x": 1.0, "displacement wall.x": 1.0})
    for side, quantity in (("input", "displacement"), ("output", "reaction")):
        other = b.copy()
        getattr(other, side)("mass", "x", quantity)
        with pytest.raises(fm.ModelError, match=f"'{quantity} mass.x' is the {quantity} of a coordinate that is dof"):
            other.build()
    b.output("mass", "x")
    b.input("wall", "y", "displacement", name="across")
    model = b.build()
    with pytest.raises(fm.ModelError, match=r"Input 'across' \(a displacement\) moves nothing"):
        fm.control.state_matrices(model)
    with pytest.raises(fm.ModelError, match=r"input 'across' is the displacement of wall\.y, which is FIXED"):
        fm.simulate(model, [0, 0.1], control=lambda t, y: y)
