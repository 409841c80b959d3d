"""The references of motion are right: printed numbers, closed forms, what is kept, two formulations, two meshes."""

from math import inf

import numpy as np
import pytest
from cases.tolerances import approx
from references import motion_references as motion
from references import motion_rod_cases, shooting
from references.motion_integrators import gauss, runge_kutta
from references.motion_rod_cases import PROBLEMS
from references.motion_rod_references import REFERENCE
from references.motion_rods import PlanarRod, SpatialRod, at_rest
from references.rods import Cantilever
from references.rods import SpatialRod as ShotRod
from scipy.linalg import eigh
from scipy.optimize import fsolve

# Printed numbers are good to half a unit in the last digit.
# C3-rotating: eta; flap 1, 2, 3, first lead-lag.
ROTATING = [
    (0, 3.5160153, 22.0344916, 61.6972144, 3.5160153),
    (1, 3.6816468, 22.1810111, 61.8417626, 3.5432363),
    (2, 4.1373196, 22.6149220, 62.2731841, 3.6217970),
    (3, 4.7972785, 23.3202637, 62.9849675, 3.7435119),
    (4, 5.5850014, 24.2733494, 63.9667605, 3.8977225),
    (5, 6.4495447, 25.4460803, 65.2050405, 4.0738959),
    (6, 7.3603730, 26.8090817, 66.6839144, 4.2632254),
]
# C4-shaft: half waves, speed; forward, backward.
SHAFT = [
    (1, 0, 637.6024350, 637.6024350),
    (1, 500, 638.3727754, 636.8330242),
    (1, 1000, 639.1440454, 636.0645430),
    (1, 5000, 645.3476688, 629.9501568),
    (2, 0, 2544.5395746, 2544.5395746),
    (2, 5000, 2575.3776329, 2514.0707769),
]
# D5-fourbar: loops; theta, rate, joint at t = 10, energy.
FOURBAR = [
    (1, -30.343944970939, -1.966934719, (0.4783850578, 0.8781501788), 20.4533333333),
    (2, -30.179800860189, -1.506642181, (0.3284581115, 0.9445185382), 35.835),
]


def slope(function, t, step=1e-5):
    """Derivative of an answer by time, fourth order."""
    near, far = ((function(t + k * step) - function(t - k * step)) / (2 * k * step) for k in (1, 2))
    return (4 * near - far) / 3


def test_pendulum():
    found = motion.pendulum([10.0])
    np.testing.assert_allclose(found["period"], 2.3678419476, atol=5e-11)
    np.testing.assert_allclose(found["position"][0], (-0.2750874626, -0.9614192051), atol=5e-11)
    times = np.linspace(0.0, 4.0, 9)
    found, g = motion.pendulum(times, 0.7, 2.5), motion.GRAVITY
    states = runge_kutta(lambda t, y: np.array([y[1], -g / 0.7 * np.sin(y[0])]), (2.5, 0.0), times)
    np.testing.assert_allclose(np.stack([found["theta"], found["rate"]], 1), states, atol=1e-10)
    # From the horizontal the tension is three times the weight along the rod.
    found = motion.pendulum(times)
    np.testing.assert_allclose(found["tension"], 3 * g * np.cos(found["theta"]), atol=1e-11)


@pytest.mark.parametrize(("loops", "theta", "rate", "joint", "energy"), FOURBAR)
def test_fourbar(loops, theta, rate, joint, energy):
    found = motion.fourbar([5.0, 10.0], loops)
    np.testing.assert_allclose(found["theta"][-1], theta, atol=2e-11)
    np.testing.assert_allclose(found["rate"][-1], rate, atol=5e-10)
    np.testing.assert_allclose(found["joint"][-1], joint, atol=5e-11)
    np.testing.assert_allclose(found["energy"], energy, atol=5e-11)


def test_dzhanibekov():
    period = float(motion.dzhanibekov([0.0])["period"])
    # The printed tenth digit is 6e-10 too low: closed form and integration agree on 57.46284887496.
    np.testing.assert_allclose(period, 57.4628488744, atol=1e-9)
    found = motion.dzhanibekov(np.array([0.25, 0.5, 0.75, 1.0]) * period)
    # Every turn over the unstable axis multiplies rounding by some 1e4.
    np.testing.assert_allclose(found["rates"][:2, 1], [0.0, -1.0], atol=1e-11)
    np.testing.assert_allclose(found["rates"][2:, 1], [0.0, 1.0], atol=5e-9)
    np.testing.assert_allclose(found["energy"], 1.0000005, rtol=1e-12)
    np.testing.assert_allclose(found["momentum"], np.tile([1e-3, 2.0, 0.0], (4, 1)), atol=1e-9)


def test_heavy_top():
    found = motion.heavy_top([0.5, 1.0])
    centres = (-0.7024683, -0.0211652, -0.7114003), (0.1733440, 0.6400886, -0.7484908)
    rates = (-0.4710531, 150.0, 5.9010831), (-0.8220781, 150.0, -5.9232914)
    np.testing.assert_allclose(found["centre"], centres, atol=5.1e-8)
    np.testing.assert_allclose(found["rates"], rates, atol=5.1e-8)
    np.testing.assert_allclose(found["energy"], 5435.69679086, atol=1e-8)


def test_turning_body_under_torque():
    """Fixed in space, the torque adds to the momentum; about the body's axis of symmetry, the rates are known."""
    times, push = np.linspace(0.0, 5.0, 6), np.array([0.3, -0.2, 0.5])
    found = motion.turning_body(times, (1.0, 2.0, 2.5), (0.5, -1.0, 2.0), lambda t, R: R.T @ push)
    expected = np.array([0.5, -2.0, 5.0]) + times[:, None] * push
    np.testing.assert_allclose(found["momentum"], expected, atol=1e-10)
    found = motion.turning_body(times, (2.0, 2.0, 0.5), (0.4, 0.0, 3.0), lambda t, R: (0.0, 0.0, 0.25))
    nutation = 0.4 * np.exp(1j * (0.5 - 2.0) / 2.0 * (3 * times + times**2 / 4))
    np.testing.assert_allclose(
        found["rates"], np.stack([nutation.real, nutation.imag, 3 + times / 2], axis=1), atol=1e-11
    )


def test_double_pendulum():
    """As two points on the plane whose rods pull as their lengths ask."""
    (m1, m2), (l1, l2), g = (1.3, 0.6), (0.8, 1.1), motion.GRAVITY
    times = np.linspace(0.0, 2.0, 5)
    found = motion.double_pendulum(times, (m1, m2), (l1, l2), (1.5, -0.8), (0.3, -0.5))
    np.testing.assert_allclose(found["energy"], found["energy"][0], rtol=1e-12)

    def rate(t, y):
        r, v = y.reshape(2, 2, 2)
        rods, speeds = np.diff(r, axis=0, prepend=0.0), np.diff(v, axis=0, prepend=0.0)
        # a1 = g + (rod2 T2 - rod1 T1)/m1, a2 = g - rod2 T2/m2, rod . relative acceleration = -speed^2.
        weight = np.array([0.0, -g])
        inner = rods @ rods.T
        matrix = np.array(
            [
                [-inner[0, 0] / m1, inner[0, 1] / m1],
                [inner[0, 1] / m1, -inner[1, 1] * (1 / m1 + 1 / m2)],
            ]
        )
        right = -(speeds**2).sum(1) - np.array([rods[0] @ weight, 0.0])
        pulls = np.linalg.solve(matrix, right)[:, None] * rods
        a = weight + np.array([(pulls[1] - pulls[0]) / m1, -pulls[1] / m2])
        return np.concatenate([v, a]).ravel()

    first = l1 * np.array([np.sin(1.5), -np.cos(1.5)])
    speed = 0.3 * l1 * np.array([np.cos(1.5), np.sin(1.5)])
    second = first + l2 * np.array([np.sin(-0.8), -np.cos(-0.8)])
    after = speed - 0.5 * l2 * np.array([np.cos(-0.8), np.sin(-0.8)])
    states = runge_kutta(rate, np.concatenate([first, second, speed, after]), times, 1e-12)
    np.testing.assert_allclose(found["positions"], states[:, :4].reshape(-1, 2, 2), atol=1e-9)


def test_rigid_slider_crank():
    """Its torque is the growth of its energy, its guide's force that of its angular momentum; the loop stays closed."""
    crank, rod, speed, masses, g = 0.15, 0.3, 20.0, (0.05, 0.0666, 0.033), 9.81
    times = np.linspace(0.003, 0.3, 8)

    def state(t):
        found = motion.slider_crank(t, speed, crank, rod, masses, g)
        p, x = found["rod_angle"], found["slider"]
        pin = crank * np.stack([np.cos(speed * t), np.sin(speed * t)])
        return found, p, x, pin, (pin + np.stack([x, 0 * x])) / 2

    def energy_and_momentum(t):
        *_, pin, middle = state(t)
        pd, xd, md = (slope(lambda s, i=i: state(s)[i], t) for i in (1, 2, 4))
        still, moved = masses[1] * rod**2 / 12, masses[1]
        kinetic = masses[0] * (crank * speed) ** 2 / 6 + moved * (md**2).sum(0) / 2 + still * pd**2 / 2
        spin = masses[0] * crank**2 * speed / 3 + moved * (middle[0] * md[1] - middle[1] * md[0]) + still * pd
        potential = g * (masses[0] * pin[1] / 2 + masses[1] * middle[1])
        return np.stack([kinetic + masses[2] * xd**2 / 2 + potential, spin])

    found, p, x, pin, middle = state(times)
    np.testing.assert_allclose(pin + rod * np.stack([np.cos(p), np.sin(p)]), np.stack([x, 0 * x]), atol=1e-15)
    np.testing.assert_allclose(found["slider_velocity"], slope(lambda t: state(t)[2], times), atol=1e-9)
    np.testing.assert_allclose(
        found["slider_acceleration"], slope(lambda t: state(t)[0]["slider_velocity"], times), atol=1e-8
    )
    power, moment = slope(energy_and_momentum, times, 1e-4)
    np.testing.assert_allclose(found["torque"], power / speed, atol=1e-7)
    weights = g * (masses[0] * pin[0] / 2 + masses[1] * middle[0] + masses[2] * x)
    np.testing.assert_allclose(found["torque"] + found["guide"] * x - weights, moment, atol=1e-7)


@pytest.mark.parametrize(("wave", "speed", "forward", "backward"), SHAFT)
def test_shaft(wave, speed, forward, backward):
    np.testing.assert_allclose(motion.shaft(speed, wave), (forward, backward), atol=5.1e-8)


@pytest.mark.parametrize(("eta", "first", "second", "third", "lead_lag"), ROTATING)
def test_rotating_beam(eta, first, second, third, lead_lag):
    found = motion.rotating_beam(eta)
    np.testing.assert_allclose(found["flap"], (first, second, third), atol=6e-8)
    np.testing.assert_allclose(found["lead_lag"][0], lead_lag, atol=6e-8)
    np.testing.assert_allclose(motion.rotating_beam(eta, terms=14)["flap"], found["flap"], rtol=1e-12)


def test_rod_frequencies():
    """Clamped-free: C1-beam-modes, and C2-timoshenko with shear and rotary inertia, all terms of M as printed there."""
    rod = PlanarRod(1.0, 1.0, 1.0, terms=10)
    M, *_ = rod.equations(np.zeros(3 + rod.n_q), np.zeros(3 + rod.n_q))
    squares = eigh(np.diag(rod.stiffness), M[3:, 3:], eigvals_only=True)[:3]
    np.testing.assert_allclose(squares**0.25, (1.8751040687, 4.6940911330, 7.8547574382), rtol=1e-9)
    E, nu, rho, h = 210e9, 0.3, 7850.0, 0.1
    G, area, second = E / 2 / (1 + nu), h**2, h**4 / 12
    rod = PlanarRod(1.0, E * second, rho * area, GA=5 / 6 * G * area, rotary=rho * second, terms=12)
    M, *_ = rod.equations(np.zeros(3 + rod.n_q), np.zeros(3 + rod.n_q))
    squares = eigh(np.diag(rod.stiffness), M[3:, 3:], eigvals_only=True)[:3]
    np.testing.assert_allclose(np.sqrt(squares), (520.84064174, 3121.57776540, 8210.22613309), rtol=1e-8)


def test_planar_rod_is_a_spatial_one():
    """Same points, mass matrix and forces in a motion with all its strains; velocities are the points' rates."""
    rng = np.random.default_rng(0)
    flat = PlanarRod(2.0, 1.3, 0.7, EA=50.0, GA=30.0, rotary=0.02, terms=5)
    deep = SpatialRod(2.0, (1.0, 2.0, 1.3), (50.0, 30.0, 20.0), 0.7, (0.05, 0.03, 0.02), terms=5, stations=(0.5, 1.0))
    z, zd = rng.normal(size=(2, 3 + flat.n_q)) * np.array([[0.1], [1.0]])
    z[:3] = zd[:3] = 0.0
    own = np.concatenate([np.arange(10, 25)])

    def spread(v):
        q = np.zeros(deep.n_q)
        q[own] = v[3:]
        return q

    positions, frames = deep.field(*at_rest(np.zeros(3), np.eye(3), deep.n_q), spread(z), spread(zd), 0)
    M, force = deep.inertia(positions, frames)
    flat_M, flat_force, flat_positions, _ = flat.equations(z, zd)
    np.testing.assert_allclose(positions.r[:, :2], flat_positions.r, atol=1e-12)
    np.testing.assert_allclose(M[np.ix_(own, own)], flat_M[3:, 3:], atol=1e-11)
    np.testing.assert_allclose((force - deep.stiffness * spread(z))[own], flat_force[3:], atol=1e-10)


def test_spatial_rod_in_motion():
    """Velocities and accelerations at z'' = 0 are derivatives of places and frames."""
    rng = np.random.default_rng(1)
    rod = SpatialRod(2.0, (1.0,) * 3, (50.0,) * 3, 0.7, (0.05, 0.03, 0.02), terms=4)
    q, qd = rng.normal(size=(2, rod.n_q)) * np.array([[0.1], [1.0]])
    base = at_rest((1.0, 2.0, 3.0), np.eye(3), rod.n_q)
    positions, frames = rod.field(*base, q, qd, 0)
    np.testing.assert_allclose(
        slope(lambda t: rod.field(*base, q + t * qd, qd, 0)[0].r, 0.0, 1e-3), positions.v, atol=1e-9
    )
    np.testing.assert_allclose(
        slope(lambda t: rod.field(*base, q + t * qd, qd, 0)[0].v, 0.0, 1e-3), positions.a, atol=1e-8
    )
    np.testing.assert_allclose(
        slope(lambda t: rod.field(*base, q + t * qd, qd, 0)[1].w, 0.0, 1e-3), frames.a, atol=1e-8
    )
    turning = slope(lambda t: rod.field(*base, q + t * qd, qd, 0)[1].R, 0.0, 1e-3) @ frames.R.transpose(0, 2, 1)
    np.testing.assert_allclose(turning[:, [2, 0, 1], [1, 2, 0]], frames.w, atol=1e-8)
    np.testing.assert_allclose(frames.J @ qd, frames.w, atol=1e-12)
    np.testing.assert_allclose(positions.J @ qd, positions.v, atol=1e-12)


def test_spatial_rod_in_equilibrium():
    """Under a dead force out of its planes: against shooting."""
    bending, stretching, force = (0.7, 2.0, 1.0), (200.0, 90.0, 80.0), np.array([0.5, 0.8, -1.2])
    rod = SpatialRod(1.0, bending, stretching, 1.0, (0.0, 0.0, 0.0), terms=8)
    base, still = at_rest(np.zeros(3), np.eye(3), rod.n_q), np.zeros(rod.n_q)
    q = fsolve(lambda q: rod.field(*base, q, still, 0)[0].J[-1].T @ force - rod.stiffness * q, still, xtol=1e-13)
    tip = rod.field(*base, q, still, 0)[0].r[-1]
    problem = Cantilever(ShotRod(1.0, *bending, *stretching), (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), tuple(force))
    np.testing.assert_allclose(tip, problem.tip(shooting.solve(problem))[:3], atol=1e-8)


def test_gauss_keeps_its_order_and_leaves_fast_motion_alone():
    """q'' = load - squares q from rest: the slow one to order six with three stages, the stiff one stays bounded."""
    squares, load = np.array([4.0, 1e10]), np.array([1.0, 0.0])
    errors = []
    for step in (0.2, 0.1):
        states = gauss(lambda t, q, qd: (np.eye(2), load - squares * q), squares, [2.0], step, stages=3)
        errors.append(np.abs(states[0, 0] - [(1 - np.cos(4.0)) / 4, 0.0]).max())
    assert 50 < errors[0] / errors[1] < 80


@pytest.mark.slow
def test_spin_up_by_another_integrator():
    """Runge-Kutta where nothing is stiff; and what the beam does in the end, stretched by its own weight."""
    rod = PlanarRod(10.0, 1.4e4, 1.2, terms=2)

    def rate(t, y):
        turn, speed, acceleration = motion_rod_cases.spin(t, 6.0, 15.0)
        q, qd = np.split(y, 2)
        M, force, *_ = rod.equations(np.array([0.0, 0.0, turn, *q]), np.array([0.0, 0.0, speed, *qd]))
        return np.concatenate([qd, np.linalg.solve(M[3:, 3:], force[3:] - acceleration * M[3:, 2])])

    q = runge_kutta(rate, np.zeros(4), [3.0], 1e-10, 1e-13)[0, :2]
    found = motion_rod_cases.spin_up([3.0], EA=inf, terms=2)
    np.testing.assert_allclose(found["slope"], 10 * q[0], atol=1e-10)
    k = np.sqrt(1.2 * 36 / 2.8e7)
    stretched = np.tan(10 * k) / k - 10
    np.testing.assert_allclose(np.array(REFERENCE["spin-up"]["answer"]["tip"])[-1, 0], stretched, rtol=2e-3)


def test_stiff_slider_crank_is_rigid():
    """To the 1e-6 that a rod of a hundred thousand times the stiffness still bends."""
    times = np.array([0.01, 0.02])
    found = motion_rod_cases.slider_crank(times, E=2e16, extensible=False, terms=1, duration=0.01, step=1e-3)
    late = motion.slider_crank(times - 0.005, masses=(0.0, 7870.0 * np.pi * 0.003**2 * 0.3, 0.033))
    for key, tolerance in (("slider", 1e-7), ("torque", 3e-4), ("guide", 3e-4)):
        expected = np.stack([late["slider"], late["slider_velocity"]], 1) if key == "slider" else late[key]
        np.testing.assert_allclose(found[key], expected, atol=tolerance)


def test_spaghetti_as_printed():
    """D1-spaghetti at t = 2.5, error of the print 3e-5: momentum is the impulse, and what is free keeps it all."""
    entry = REFERENCE["spaghetti"]
    found = {key: np.array(value) for key, value in entry["answer"].items()}
    at = entry["times"].index(2.5)
    np.testing.assert_allclose(found["lower"][at], (3.60683, 0.04469, -0.42725), atol=1e-4)
    np.testing.assert_allclose(found["upper"][at], (3.98176, 8.53172, -0.54047), atol=1e-4)
    np.testing.assert_allclose(found["p"][at], (25.0, 0.0, 0.0), atol=1e-6)
    np.testing.assert_allclose(found["h"][at], (0.0, -121.6439, -241.1748), atol=2e-4)  # printed to 1e-4, ours as much
    free = np.array(entry["times"]) >= 5.0
    for key in ("p", "h", "energy"):
        kept = found[key][free]
        np.testing.assert_allclose(kept, np.broadcast_to(kept[0], kept.shape), atol=1e-4)


def test_elbow_keeps_its_energy():
    entry = REFERENCE["elbow"]
    energy = np.array(entry["answer"]["energy"])[np.array(entry["times"]) >= 2.0]
    np.testing.assert_allclose(energy, energy[0], rtol=1e-7)


# Times and resolution at which the stored answers are found again, and the error of that resolution.
AGAIN = {
    "spin-up": (1, {"terms": 5, "step": 0.1}, 1e-5),
    "spin-up-inextensible": (2, {"terms": 5, "step": 0.1}, 1e-5),
    "spin-up-shear": (1, {"terms": 5, "step": 0.1}, 1e-5),
    "slider-crank": (1, {"terms": 5}, 3e-3),
    "slider-crank-smooth": (1, {"terms": 5}, 1e-4),
    "elbow": (1, {"terms": 4, "step": 0.1}, 1e-3),
    "spaghetti": (1, {"terms": 4, "rtol": 1e-6}, 1e-3),
    "elbow-two-terms": (1, {"step": 0.1}, 1e-3),
    "spaghetti-two-terms": (1, {"rtol": 1e-6}, 1e-4),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", PROBLEMS)
def test_stored_rows_are_solved_anew(name):
    """The first times of each problem, on a coarser mesh; all of them by `motion_rod_cases.py`."""
    count, resolution, error = AGAIN[name]
    entry, (solver, data, times, _, _) = REFERENCE[name], PROBLEMS[name]
    assert tuple(entry["times"]) == approx(times)
    assert data.items() <= entry["data"].items()
    found = solver(times[:count], **data, **resolution)
    for key, value in found.items():
        stored = np.array(entry["answer"][key])
        np.testing.assert_allclose(value, stored[:count], atol=error * np.abs(stored).max(), err_msg=key)
