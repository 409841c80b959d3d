"""Bodies on a node: pendulums, kinetic energy and weight against closed forms, and what is no body."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.optimize
from cases import mechanisms
from cases.tolerances import approx
from scipy.spatial.transform import Rotation

import flexmb as fm
from flexmb import planar, spatial
from flexmb.mechanics.inertia import mass_matrix

G, MASS = 9.81, 2.0
# Of a box of 0.3, 0.2 and 0.1 m, turned: a tensor without zeros.
TURN = Rotation.from_rotvec([0.4, -0.7, 0.3]).as_matrix()
INERTIA = TURN @ np.diag(MASS / 12 * np.array([0.2**2 + 0.1**2, 0.3**2 + 0.1**2, 0.3**2 + 0.2**2])) @ TURN.T
SIX = INERTIA[np.triu_indices(3)]


def pendulum(center, inertia, axis=None, stiffness=None):
    """A body on a hinge through its node."""
    dimension = len(center)
    b = fm.Builder()
    b.node("pivot", (0.0,) * dimension)
    b.fix("pivot", "position")
    b.rotation("frame")
    b.fix("frame")
    turn = {} if axis is None else {"axis": axis}
    b.body("pivot", MASS, center=center, inertia=inertia)
    b.add(
        (planar if axis is None else spatial).hinge,
        "frame",
        "pivot.rotation",
        name="hinge",
        stiffness=stiffness,
        **turn,
    )
    b.dof("hinge", 1)
    b.gravity((*(0.0,) * (dimension - 1), -G))
    return b


def frequency(center, inertia, axis=None):
    return fm.frequencies(pendulum(center, inertia, axis).build(dofs="named"))[0]


@pytest.mark.slow
def test_compound_pendulum_in_the_plane():
    depth, own = 0.35, 0.07

    def expected(center, inertia):
        return jnp.sqrt(MASS * G * -center[1] / (inertia + MASS * center @ center)) / (2 * jnp.pi)

    center = np.array([0.0, -depth])
    assert frequency(center, own) == approx(float(expected(center, own)), rel=1e-12)
    found, right = (jax.grad(f, (0, 1))(center, own) for f in (frequency, expected))
    # Sideways the equilibrium turns, and the distance changes in second order alone.
    np.testing.assert_allclose(found[0], [0.0, right[0][1]], rtol=1e-9, atol=1e-9)
    assert found[1] == approx(float(right[1]), rel=1e-9)


@pytest.mark.slow
def test_compound_pendulum_in_space():
    """About an axis that is none of the body's: n J n + m d^2 about it, whatever lies along it."""
    axis, depth, aside = np.array([0.6, 0.8, 0.0]), 0.25, 0.4

    def expected(depth, inertia):
        tensor = inertia[jnp.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])]
        return jnp.sqrt(MASS * G * depth / (axis @ tensor @ axis + MASS * depth**2)) / (2 * jnp.pi)

    def found(depth, inertia):
        center = jnp.array([aside * axis[0], aside * axis[1], 0.0]) - depth * jnp.array([0.0, 0.0, 1.0])
        return frequency(center, inertia, axis)

    assert found(depth, SIX) == approx(float(expected(depth, SIX)), rel=1e-12)
    for got, right in zip(*(jax.grad(f, (0, 1))(depth, SIX) for f in (found, expected)), strict=True):
        np.testing.assert_allclose(got, right, rtol=1e-9, atol=1e-12)


def test_weight_turns_a_body_about_its_node():
    # k phi + m g (x cos phi - y sin phi) = 0, and its derivative over the inertia about the node.
    x, y, k, own = 0.3, -0.1, 25.0, 0.05

    def balance(phi):
        return k * phi + MASS * G * (x * np.cos(phi) - y * np.sin(phi))

    phi = scipy.optimize.brentq(balance, -2, 2, xtol=1e-14)
    slope = k - MASS * G * (x * np.sin(phi) + y * np.cos(phi))
    lin = fm.linearize(pendulum((x, y), own, stiffness=k).build())
    assert lin.x[lin.labels.coordinates("pivot.rotation")[0]] == approx(phi, rel=1e-9)
    assert fm.frequencies(lin)[0] == approx(np.sqrt(slope / (own + MASS * (x**2 + y**2))) / 2 / np.pi, rel=1e-9)


def test_kinetic_energy_is_that_of_newton_and_euler():
    """1/2 m |v + w x R c|^2 + 1/2 w R J R' w of a body that has turned, two of which add up."""
    center = np.array([0.1, -0.2, 0.3])
    b = fm.Builder()
    b.node("p", (1.0, 2.0, 3.0))
    b.body("p", MASS, center=center, inertia=INERTIA)
    b.body("p", 0.5, center=-2 * center, inertia=SIX)
    model = b.build(check=False)
    assert float(fm.mass(model)) == approx(MASS + 0.5, rel=1e-14)
    rotation = Rotation.from_rotvec([0.5, 0.2, -0.9])
    vector = rotation.as_quat(scalar_first=True)
    matrix = np.asarray(mass_matrix(model.topology, model.parameters, np.r_[0.0, 0, 0, vector]))
    rng = np.random.default_rng(1)
    for v, w in rng.standard_normal((3, 2, 3)):
        # Rate of Euler parameters of a body that turns with w, about global axes.
        turning = np.r_[-w @ vector[1:], w * vector[0] + np.cross(w, vector[1:])] / 2
        rates = np.r_[v, turning]
        expected = 0.0
        for mass, arm in ((MASS, center), (0.5, -2 * center)):
            speed = v + np.cross(w, rotation.apply(arm))
            spin = rotation.inv().apply(w)
            expected += mass * speed @ speed / 2 + spin @ INERTIA @ spin / 2
        assert rates @ matrix @ rates / 2 == approx(expected, rel=1e-12)


@pytest.mark.parametrize("element", [planar.rigid_beam, planar.rigid_body])
def test_a_rigid_plate_in_the_plane_has_the_inertia_of_a_plate(element):
    """About its end: m (l^2/3 + t^2/12)."""
    length, width, thick = 0.1, 0.02, 0.05
    b = fm.Builder()
    b.node("pin", (0, 0))
    b.node("end", (0.6 * length, 0.8 * length))
    b.rotation("ground")
    section = fm.Rectangle(width, thick, fm.Material(E=1.0, G=1.0, rho=7800.0))
    ends = ("pin", "pin.rotation", "end") if element is planar.rigid_beam else ("pin", "end")
    b.add(element, *ends, section=section)
    b.add(planar.hinge, "ground", "pin.rotation", stiffness=100.0)
    b.fix("ground")
    b.fix("pin", "x", "y")
    inertia = 7800.0 * width * thick * length * (length**2 / 3 + thick**2 / 12)
    assert float(fm.frequencies(b.build())[0]) == approx(np.sqrt(100.0 / inertia) / (2 * np.pi), rel=1e-9)


@pytest.mark.parametrize("element", [spatial.rigid_beam, spatial.rigid_body])
def test_a_rigid_plate_has_the_inertia_of_a_plate(element):
    """Kinetic energy of turns about each local axis of a plate 200 mm wide and 50 mm thick, about its end."""
    length, wide, thick = 0.1, 0.2, 0.05
    turned = Rotation.from_rotvec([0.4, -1.1, 0.7])
    x, y, _ = axes = turned.as_matrix().T
    b = fm.Builder()
    b.node("p", (0, 0, 0))
    b.node("q", length * x)
    section = fm.Rectangle(wide, thick, fm.Material(E=1.0, G=1.0, rho=7800.0))
    b.add(element, "p", "q", section=section, y=y)
    model = b.build(check=False)
    matrix = np.asarray(mass_matrix(model.topology, model.parameters, model.parameters.reference))
    mass = 7800.0 * wide * thick * length
    inertia = mass / 12 * np.array([wide**2 + thick**2, thick**2 + 4 * length**2, wide**2 + 4 * length**2])
    for axis, expected in zip(axes, inertia, strict=True):
        rates = np.zeros(model.topology.n_x)
        rates[model.labels.coordinates("p.rotation")] = np.r_[0.0, axis / 2]
        rates[model.labels.coordinates("q")] = np.cross(axis, length * x)
        assert rates @ matrix @ rates == approx(expected, rel=1e-12)


def test_a_rigid_body_whose_ends_lie_in_one_place_has_finite_derivatives():
    """By the place of its end: its mass is zero there."""

    def mass(q):
        ref = spatial.rigid_body.reference([jnp.zeros(3), jnp.eye(4)[0], q, jnp.eye(4)[0]])
        return spatial.rigid_body.inertia(*ref, ref=ref, section=fm.Rigidity(mass=1.0, Jx=2.0))

    assert all(np.all(np.isfinite(slopes)) for slopes in jax.jacfwd(mass)(jnp.zeros(3)))


@pytest.mark.slow
def test_a_body_is_a_mass_at_the_end_of_a_rigid_beam():
    """On a leaf spring under its weight: modes about the state, which is far from the undeformed one."""
    center = np.array([0.02, 0.03, -0.05])

    def loaded(body):
        b = fm.Builder()
        b.node("foot", (0, 0, 0))
        b.node("top", (0, 0, 0.1))
        b.add(spatial.beam, "foot", "top", section=mechanisms.leaf(), y=(0, 1, 0), name="leaf")
        b.fix("foot")
        if body:
            b.body("top", 0.2, center=center, inertia=1e-3 * INERTIA)
        else:
            b.node("centre", np.array([0, 0, 0.1]) + center)
            b.add(spatial.rigid_beam, "top", "centre")
            b.mass("centre", 0.2)
            b.inertia("top", 1e-3 * INERTIA)
        b.gravity((1.0, -2.0, -G))
        b.dof("leaf", *range(1, 7))
        return fm.linearize(b.build())

    one, other = loaded(True), loaded(False)
    # Newton's tolerance of 1e-9, in two systems of equations.
    tops = (np.asarray(lin.x)[lin.labels.coordinates("top")] for lin in (one, other))
    np.testing.assert_allclose(*tops, rtol=1e-8, atol=1e-12)
    np.testing.assert_allclose(fm.frequencies(one), fm.frequencies(other), rtol=1e-7)


@pytest.mark.slow
def test_steady_precession_of_a_heavy_top():
    """m g d = C w3 W - (A + m d^2) W^2 cos(tilt): its axis goes round the vertical at W."""
    mass, depth, a, c, tilt, rate = 1.0, 0.1, 4e-3, 2e-3, 0.7, 8.0
    spin = (mass * G * depth + (a + mass * depth**2) * rate**2 * np.cos(tilt)) / (c * rate)
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    b = fm.Builder()
    b.node("pivot", (0, 0, 0))
    b.fix("pivot", "position")
    b.body("pivot", mass, center=depth * axis, inertia=a * np.eye(3) + (c - a) * np.outer(axis, axis))
    b.gravity((0, 0, -G))
    b.dof("pivot.rotation", 2, 3, 4)
    turning = rate * np.array([0, 0, 1.0]) + (spin - rate * np.cos(tilt)) * axis
    for i in range(3):
        b.start("pivot.rotation", i + 2, 0.0, turning[i] / 2)
    model, times = b.build(), np.linspace(0, 0.05, 3)
    motion = fm.simulate(model, times, rtol=1e-9, atol=1e-11)
    turned = Rotation.from_quat(np.asarray(motion.x)[:, model.labels.coordinates("pivot.rotation")], scalar_first=True)
    round_ = Rotation.from_rotvec(np.outer(rate * times, [0, 0, 1]))
    # Ten times the tolerance.
    np.testing.assert_allclose(turned.apply(axis), round_.apply(axis), rtol=0, atol=1e-8)


WRONG = {
    "no mass": ({}, "needs a mass .*, or a STEP file"),
    "no weight": ({"mass": 0.0}, "has a mass of 0.0, but it must be positive"),
    "center of three": ({"mass": 1.0, "center": (0, 0, 1)}, r"its center must have shape \(2,\), but has shape \(3,\)"),
    "negative": ({"mass": 1.0, "inertia": -1.0}, "has an inertia of -1.0, but it cannot be negative"),
    "material": ({"mass": 1.0, "material": 7800.0}, "material needs a STEP file"),
    "both": ({"mass": 1.0, "step": "part.step"}, "a STEP file determines its mass; leave out one"),
    "no material": ({"step": "part.step"}, "a STEP file contains only volumes. Give material="),
    "no density": ({"step": "part.step", "material": fm.Material(1.0, 1.0)}, "density of its material is 0.0"),
    "no file": ({"step": "part.step", "material": 7800.0}, "there is no STEP file 'part.step'"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_no_body(case):
    given, message = WRONG[case]
    b = fm.Builder()
    b.node("A", (0, 0))
    with pytest.raises(fm.ModelError, match=f"The body on node 'A'.*{message}"):
        b.body("A", **given)
    assert not b.members


@pytest.mark.parametrize("inertia", [(1, 0, 0, 1, 0, 2.1), (1, 0, 0, -1e-3, 0, 1), (1, 0, 2, 1, 0, 1)])
def test_inertia_that_no_body_has(inertia):
    b = fm.Builder()
    b.node("A", (0, 0, 0))
    with pytest.raises(
        fm.ModelError, match=r"body on node 'A' has the principal moments of inertia .*, which no body has"
    ):
        b.body("A", 1.0, inertia=inertia)
    # A needle and a plate are the limits.
    b.body("A", 1.0, inertia=(0, 0, 0, 1, 0, 1))
    b.body("A", 1.0, inertia=(1, 0, 0, 1, 0, 2))


def test_a_spacar_file_takes_no_body(tmp_path):
    b = pendulum((0.0, -1.0), 0.1)
    with pytest.raises(fm.ModelError, match="body on node 'pivot' cannot be expressed in a SPACAR file"):
        fm.write_spacar(b, tmp_path / "pendulum.dat")
