"""Where a driven motion starts: what is driven is where its law says, and degrees of freedom are where they were."""

import re

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx
from scipy.spatial.transform import Rotation

import flexmb as fm
from flexmb import planar, spatial
from flexmb.motion.coordinates_form import coordinates_form
from flexmb.motion.drives_by_name import Drives, driven_by
from flexmb.motion.start import Start, begins_still, driven_start

LEVER = np.array([0.3, 0.2, 0.1])
INERTIA = np.diag([0.1, 0.2, 0.25])


def hub(element) -> fm.Model:
    """A blade of 0.3 m on a hub that is driven."""
    material = fm.Material(E=2e9, G=8e8, rho=2000.0, damping=1e-3)
    b = fm.Builder()
    b.node("o", (0, 0))
    b.node("k", (0.3, 0))
    b.add(element, "o", "k", name="blade", section=fm.Rectangle(0.02, 0.004, material))
    b.fix("o", "position")
    b.mass("k", 0.05)
    b.prescribe("o", "rotation")
    for number in range(1, 4):
        b.dof("blade", number)
    return b.build()


@pytest.mark.slow
def test_a_blade_begins_at_the_speed_of_its_hub():
    """Its degrees of freedom, which are deformations, begin at rest: it turns as a whole, at 10 rad/s."""
    found = fm.simulate(hub(planar.beam), [0.0, 0.01], motion={"o.rotation": lambda t: 10 * t})
    np.testing.assert_allclose(found.velocity("k")[0], (0, 3.0), atol=1e-12)
    np.testing.assert_allclose(found.velocity("k.rotation")[0], 10.0, rtol=1e-12)


def gyroscope(turned: np.ndarray, tilt: str) -> fm.Model:
    """A body whose rotation about an axis is driven, in another frame."""
    b = fm.Builder()
    b.node("o", (0, 0, 0))
    b.node("m", turned @ LEVER)
    b.add(spatial.rigid_body, "o", "m")
    b.fix("o", "position")
    b.mass("m", 2.0)
    b.inertia("o", turned @ INERTIA @ turned.T)
    b.gravity(turned @ [0, 0, -9.81])
    b.prescribe("o", "rotation", axis=turned @ [0, 0, 1.0], tilt=tilt)
    return b.build()


TIMES = np.linspace(0.0, 0.3, 4)


def shaken(*dof: str | int) -> fm.Model:
    """A mass on a spring whose foot is driven, with a degree of freedom that is named or found."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("mass", (0.1, 0))
    b.add(planar.truss, "foot", "mass", name="spring", section=fm.Rigidity(EA=90.0, alpha=1e-3))
    b.temperature("spring", 0.0)
    b.prescribe("foot", "x", 0.0)
    b.fix("foot", "y")
    b.fix("mass", "y")
    b.mass("mass", 0.4)
    if dof:
        b.dof(*dof)
    return b.build()


@pytest.mark.slow
def test_what_hangs_on_degrees_of_freedom_that_were_found_is_told():
    """x'' = -(k/m) (x - foot): the spring begins without strain, and the mass at the speed of the foot or at rest."""
    w, p, size = np.sqrt(90.0 / 0.1 / 0.4), 25.0, 1e-3
    driven = {"motion": {"foot.x": lambda t: size * jnp.sin(p * t)}, "rtol": 1e-9}
    with pytest.warns(fm.FlexmbWarning, match=r"chose these degrees of freedom: spring\.e1\..*dof\(\)"):
        found = fm.simulate(shaken(), TIMES, **driven)
    named, at_rest = (fm.simulate(shaken(*dof), TIMES, **driven) for dof in (("spring", 1), ("mass", "x")))
    np.testing.assert_array_equal(found.x, named.x)
    for motion, begins in ((named, size * p), (at_rest, 0.0)):
        steady = size * w**2 / (w**2 - p**2)
        exact = steady * np.sin(p * TIMES) + (begins - steady * p) / w * np.sin(w * TIMES)
        # Ten times the tolerance of a step.
        np.testing.assert_allclose(motion.at("mass")[:, 0] - 0.1, exact, atol=1e-8)
    # Whatever is found, what begins where it is begins alike: at rest, where a motion under the same law has ended, and
    # where a spring is warm that nothing holds.
    fm.simulate(shaken(), TIMES, motion={"foot.x": lambda t: size * (1 - jnp.cos(p * t))})
    fm.simulate(shaken(), TIMES + TIMES[-1], initial=found, **driven)
    fm.simulate(shaken(), TIMES, loads={"spring.temperature": lambda t: 30.0 + t})


@pytest.mark.slow
def test_a_motion_without_a_velocity_is_named():
    """The root of time is finite and its rate is not, at the start."""
    with pytest.raises(fm.AnalysisError, match=r"Motion 'foot\.x' has a velocity .* not finite at t = 0 s.* smooth"):
        fm.simulate(shaken("mass", "x"), TIMES, motion={"foot.x": lambda t: 1e-3 * jnp.sqrt(t)})


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Driven coordinates move")
def test_how_it_begins_is_the_same_in_every_frame():
    found = []
    for turned in (np.eye(3), Rotation.from_rotvec([1, 2, -0.5]).as_matrix()):
        motion = fm.simulate(gyroscope(turned, "free"), [0.0, 0.3], motion={"o.rotation": lambda t: 2 * t}, rtol=1e-9)
        np.testing.assert_allclose(motion.angular_velocity("o")[0] @ turned, (0, 0, 2), atol=1e-12)
        found.append(np.array(motion.at("m")[-1]) @ turned)
    # Ten times the tolerance of either integration.
    np.testing.assert_allclose(*found, atol=1e-8)


def test_a_law_may_begin_turned_far():
    """A turn and more: where the body is, and its velocity, w x r."""
    model = gyroscope(np.eye(3), "fixed")
    driven = driven_by(model, Drives(motion={"o.rotation": lambda t: 7.5 + 2 * t}))
    given = Start(model.parameters.reference, jnp.zeros(model.topology.n_x))

    @jax.jit
    def begins(t):
        return driven_start(coordinates_form(model.topology, model.parameters, driven), t, given)

    begin, there = begins(0.0)
    assert bool(there)
    place, m = Rotation.from_rotvec([0, 0, 7.5]).as_matrix() @ LEVER, np.asarray(model.labels.coordinates("m"))
    np.testing.assert_allclose(begin.x[m], place, atol=1e-12)
    np.testing.assert_allclose(begin.xd[m], np.cross([0, 0, 2.0], place), atol=1e-12)


def pendulum() -> fm.Builder:
    """A rigid pendulum of a degree of freedom below a point that is driven sideways."""
    b = fm.Builder()
    b.node("o", (0, 0.0))
    b.node("m", (0.3, -0.4))
    b.rotation("r")
    b.add(planar.rigid_beam, "o", "r", "m")
    b.mass("m", 2.0)
    b.inertia("r", 0.05)
    b.fix("o", "y")
    b.prescribe("o", "x")
    b.gravity((0, -9.81))
    b.start("r", "phi", 0.1, velocity=-0.2)
    return b


@pytest.mark.slow
def test_start_values_are_kept_whatever_is_driven():
    model = pendulum().build()
    for law in (lambda t: 0.3 * t, lambda t: 0.3 + 0 * t):
        found = fm.simulate(model, [0.0, 0.1], motion={"o.x": law})
        np.testing.assert_allclose(found.rotation("r")[0], 0.1, atol=1e-14)
        np.testing.assert_allclose(found.velocity("r", "phi")[0], -0.2, atol=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("derivative", [jax.jacfwd, jax.jacrev])
def test_derivatives_by_where_a_law_begins(derivative):
    """All of a rigid pendulum that does not turn goes along with its point: by as much, and twice as fast."""
    model = pendulum().build()
    top, at = model.topology, jnp.array(0.0)
    given = fm.configuration(model)
    m = np.asarray(model.labels.coordinates("m"))

    def begin(amount):
        driven = driven_by(model, Drives(motion={"o.x": lambda t: amount * (1 + 2 * t + t**2)}))
        start, _ = driven_start(coordinates_form(top, model.parameters, driven), at, Start(given.x, given.xd))
        return start.x[m], start.xd[m]

    position, velocity = derivative(begin)(0.2)
    np.testing.assert_allclose(position, (1, 0), atol=1e-12)
    np.testing.assert_allclose(velocity, (2, 0), atol=1e-12)


@pytest.mark.parametrize(
    ("law", "still"), [(lambda t: t**2, True), (lambda t: 0.1 * t, False), (lambda t: 0.1 + t**2, False)]
)
def test_what_begins_at_rest_is_left_alone(law, still):
    """Nothing is compiled for a law that begins where the mechanism is."""
    model = pendulum().build()
    assert begins_still(model.parameters, driven_by(model, Drives(motion={"o.x": law})), 0.0) is still
    assert begins_still(model.parameters, driven_by(model, Drives(loads={"m.x": law})), 0.0)


@pytest.mark.slow
def test_heat_at_the_start_moves_what_it_pushes():
    """A rigid body that is 50 K warm pushes a spring, the degree of freedom, which begins as it was."""
    b = fm.Builder()
    for name, x in {"a": 0.0, "b": 1.0, "c": 2.0}.items():
        b.node(name, (x, 0))
    b.add(planar.truss, "b", "c", name="spring", section=fm.Rigidity(EA=10.0))
    b.add(planar.truss, "a", "b", name="hot", section=fm.Rigidity(EA=1e3, alpha=1e-3), released=())
    b.fix("a", "y")
    b.fix("b", "y")
    b.fix("c")
    b.mass("b", 1.0)
    b.mass("a", 1.0)
    b.temperature("hot", 0.0)
    b.dof("spring", 1)
    found = fm.simulate(b.build(), [0.0, 0.1], loads={"hot.temperature": lambda t: 50 + 300 * t})
    np.testing.assert_allclose((found.at("a")[0, 0], found.at("b")[0, 0]), (-0.05, 1.0), atol=1e-12)
    np.testing.assert_allclose((found.velocity("a")[0, 0], found.velocity("b")[0, 0]), (-0.3, 0.0), atol=1e-12)


@pytest.mark.slow
def test_where_it_cannot_be_assembled():
    """A slider that pulls a crank further than both are long."""
    b = fm.Builder()
    b.node("o", (0, 0))
    b.node("p", (0.3, 0.4))
    b.node("q", (0.6, 0))
    b.add(planar.truss, "o", "p", released=())
    b.add(planar.truss, "p", "q", released=())
    b.fix("o")
    b.fix("q", "y")
    b.prescribe("q", "x")
    b.mass("p", 1.0)
    with pytest.raises(fm.AnalysisError, match="cannot be assembled there"):
        fm.simulate(b.build(), [0.0, 0.1], motion={"q.x": lambda t: 0.5 + t})


@pytest.mark.slow
@pytest.mark.parametrize("angle", [3.0, -4.0, 9.7])
def test_an_arm_on_a_hub_that_is_held_turned_far(angle):
    """It lies along its hub, without a load; beyond some 3 rad its bending is zero at the opposite side too."""
    b = fm.Builder()
    b.node("o", (0, 0))
    b.node("k", (0.1, 0))
    b.add(planar.beam, "o", "k", section=fm.Rigidity(EA=1e5, EIy=0.05, mass=0.1))
    b.fix("o", "position")
    b.mass("k", 0.05, inertia=1e-6)
    b.prescribe("o", "rotation", angle)
    model = b.build()
    wanted = 0.1 * np.array([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(fm.configuration(model).at("k"), wanted, atol=1e-12)
    np.testing.assert_allclose(fm.simulate(model, [0.0, 1e-3]).at("k")[0], wanted, atol=1e-12)


# Degrees of freedom of a guide that leave but one coefficient of curvature to follow from the motion of its stage.
STRETCHING = [f"left.e{i}" for i in (4, 5, 6, 7, 8, 10, 11, 12, 13)] + [f"right.e{i}" for i in (5, 6, 7, 8, 11, 12, 13)]
# Elastic energy of the guide: stiffness 24 EI/L^3, 1 mm.
BENT = 0.5 * 24 * 210e9 * 0.02 * 0.4e-3**3 / 12 / 0.1**3 * 1e-6


def spectral_guide(prescribed=False, dof=False, element=planar.spectral_beam, dofs=()):
    """Two leaf springs by spectral beams, a stage that is 1 mm aside."""
    leaf = fm.Rectangle(0.02, 0.4e-3, fm.Material(E=210e9, G=80e9, rho=7850.0))
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, 0.1), "C": (0.08, 0.1), "D": (0.08, 0)}.items():
        b.node(name, place)
    b.add(element, "A", "B", name="left", section=leaf)
    b.add(element, "D", "C", name="right", section=leaf)
    b.add(planar.rigid_body, "B", "C")
    for name in "AD":
        b.fix(name)
    for name in "BC":
        b.mass(name, 0.15)
    if prescribed:
        b.prescribe("B", "x", 1e-3)
    elif dof:
        b.dof("B", "x")
        b.input("B", "x")
    else:
        b.start("B", "x", 1e-3)
    return b.build(dofs=["B.x", *dofs] if dofs else "auto")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("element", "tolerance"),
    # Strips are stiffer than beams near their clamps, by 1 / (1 - nu^2) at most.
    [(planar.spectral_beam, 1e-3), (planar.leaf_spring, 0.11)],
)
def test_leaf_springs_bend_where_their_stage_is_put(element, tolerance):
    """Found beside the stage's coordinate are degrees of freedom that may stay zero: stretches, and higher orders."""
    model = spectral_guide(element=element)
    assert float(fm.simulate(model, [0.0, 1e-5]).observe().energy[0]) == approx(BENT, rel=tolerance)
    assert model.q_labels == spectral_guide(element=element, dof=True).q_labels


@pytest.mark.slow
def test_leaf_springs_that_stretch_at_the_start_are_told():
    """Where the degrees of freedom are named so that a single coefficient of curvature is left to follow."""
    model = spectral_guide(dofs=STRETCHING)
    with pytest.warns(
        fm.FlexmbWarning, match=r"At the start elements store 21\.\d+ J, but (\S+) J would suffice"
    ) as heard:
        fm.simulate(model, [0.0, 1e-5])
    least = float(re.search(r"but (\S+) J", str(heard[0].message))[1])
    # The estimate is one of small deformations, x/L = 0.01.
    assert least == approx(BENT, rel=1e-3)
    # What the message says to do.
    found = fm.simulate(model, [0.0, 1e-5], initial=fm.equilibrium(spectral_guide(prescribed=True)))
    assert float(found.observe().energy[0]) == approx(BENT, rel=1e-3)


@pytest.mark.slow
def test_leaf_springs_that_stretch_along_a_trajectory_are_told():
    law = fm.trajectory.septic(0.0, 1e-3, 0.1)
    with pytest.warns(fm.FlexmbWarning, match="At t = 0.1 s elements store 21.* use cubic beams"):
        fm.trajectory.inverse_dynamics(spectral_guide(dof=True, dofs=STRETCHING), {"B.x": law}, np.linspace(0, 0.1, 5))


@pytest.mark.slow
def test_leaf_springs_bend_along_a_trajectory():
    """The drive's force is the stiffness by hand times the way, where the stage rests at its end; x/L = 0.01."""
    law = fm.trajectory.septic(0.0, 1e-3, 0.1)
    found = fm.trajectory.inverse_dynamics(spectral_guide(dof=True), {"B.x": law}, np.linspace(0, 0.1, 5))
    np.testing.assert_allclose(found.u0[-1], 2 * BENT / 1e-3, rtol=1e-3)


@pytest.mark.slow
def test_a_loop_that_is_turned_as_a_whole_holds_no_strain():
    """Nothing but round-off is in its beams, one of which is found from the others."""
    material = fm.Material(E=210e9, G=80e9, rho=7850.0)
    b = fm.Builder()
    for name, place in {"O": (0, 0), "K": (0.313, 0.017), "S": (0.333, 0.291), "T": (0.011, 0.307)}.items():
        b.node(name, place)
    for name, ends in {"a": "OK", "c": "KS", "d": "ST", "g": "TO"}.items():
        b.add(planar.beam, *ends, name=name, section=fm.Rectangle(0.02, 0.02 if name == "g" else 2e-4, material))
    b.fix("O", "position")
    b.dof("O", "phi")
    for name in "acd":
        b.dof(name, 1, 2, 3)
    b.input("O", "phi")
    law = fm.trajectory.septic(0.0, -1.1, 0.1)
    plan = fm.trajectory.inverse_dynamics(b.build(), {"O.phi": law}, np.linspace(0, 0.1, 5))
    assert float(plan.motion.at("K")[-1][0]) == approx(0.313 * np.cos(1.1) + 0.017 * np.sin(1.1), rel=1e-9)


@pytest.mark.slow
def test_a_mass_without_any_element_follows_a_trajectory():
    b = fm.Builder()
    b.node("m", (0, 0))
    b.fix("m", "y")
    b.mass("m", 2.0)
    b.dof("m", "x")
    b.input("m", "x")
    law = fm.trajectory.septic(0.0, 1e-3, 0.1)
    plan = fm.trajectory.inverse_dynamics(b.build(), {"m.x": law}, np.linspace(0, 0.1, 5))
    # Its largest acceleration but for the ends is antisymmetric about the middle.
    np.testing.assert_allclose(plan.u0[1], -plan.u0[3], rtol=1e-9)
