"""The reference solver is right: against closed forms, printed and independent numbers, initial-value problems."""

from math import inf

import numpy as np
import pytest
from references import rod_cases, shooting
from references.rod_cases import PROBLEMS
from references.rod_references import REFERENCE
from references.rods import Assembly, Cantilever, PlanarRod, SpatialRod, matrix, quaternion
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import jv

ORIGIN = (0.0, 0.0, 0.0)
ALONG_X = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
# Half a unit in the last printed digit, and as much again for the printed one's own rounding by another solver.
PRINTED = 1e-10

# A1-elastica: P L^2/EI; deflection, shortening, tip angle.
ELASTICA = [
    (0.2, 0.0663644821, 0.0026465483, 0.0996361630),
    (0.4, 0.1309752421, 0.0103539215, 0.1971546237),
    (1.0, 0.3017207738, 0.0564332363, 0.4613519497),
    (1.5, 0.4109782112, 0.1079415007, 0.6395398262),
    (2.0, 0.4934574804, 0.1606417208, 0.7817498316),
    (2.5, 0.5556594627, 0.2099584574, 0.8949967510),
    (3.0, 0.6032534411, 0.2544201846, 0.9860169467),
    (4.0, 0.6699641813, 0.3289412422, 1.1212393475),
    (5.0, 0.7137915236, 0.3876283607, 1.2153681176),
]
# A2-postbuckling: tip angle [deg]; P/Pcr, x/L, y/L.
POSTBUCKLING = [
    (20, 1.0153968655, 0.9697309074, 0.2194130424),
    (40, 1.0636632664, 0.8812035117, 0.4222403401),
    (60, 1.1517196205, 0.7410196061, 0.5932076462),
    (80, 1.2938893239, 0.5593959190, 0.7194971047),
    (100, 1.5183887933, 0.3489893004, 0.7915394965),
]
# A5-bend45: P, torsion constant; tip.
BEND = [
    (300.0, 1 / 6, (22.244679, 58.778897, 40.192392)),
    (450.0, 1 / 6, (18.508065, 52.238262, 48.503492)),
    (300.0, 0.140577, (22.112514, 58.535709, 40.480758)),
]
# A9-princeton: P, angle [deg]; uy, uz, ux, twist [deg].
PRINCETON = [
    (4.448, 15, (0.00520928, 0.02079990, -0.00054371, -0.222692)),
    (4.448, 90, (0.0, 0.07807766, -0.00725916, 0.0)),
    (8.896, 0, (0.01071360, 0.0, -0.00013553, 0.0)),
    (8.896, 45, (0.00888740, 0.10903588, -0.01438777, -1.664822)),
    (8.896, 75, (0.00356832, 0.14220759, -0.02458146, -0.773847)),
]
# B1-guide-stroke: x; Fx, y, phi, Kz. Digits of each as printed.
GUIDE = [
    (1e-4, 0.002399940, -6.0e-9, -5.000e-9, 959993.653),
    (0.01, 0.240017862, -0.0000599991, -5.344e-7, 898286.668),
    (0.02, 0.480178956, -0.0002400209, -1.275e-6, 752989.682),
    (0.05, 1.202960515, -0.0015012125, -6.815e-6, 352530.027),
]
# B3-cross-pivot: crossing fraction, angle [deg]; moment over angle, shift.
PIVOT = [
    (0.5, 5, 2.00253510, 8.96862e-4),
    (0.5, 10, 2.01010020, 3.579963e-3),
    (0.1273, 5, 5.33469182, 6.6881e-6),
    (0.1273, 10, 5.33756828, 5.37295e-5),
]


@pytest.mark.parametrize(("alpha", "deflection", "shortening", "angle"), ELASTICA)
def test_elastica(alpha, deflection, shortening, angle):
    problem = Cantilever(PlanarRod(1.0), ORIGIN, force=(0.0, alpha))
    tip = problem.tip(shooting.solve(problem))
    np.testing.assert_allclose(tip, [1 - shortening, deflection, angle], atol=PRINTED)


@pytest.mark.parametrize(("degrees", "load", "x", "y"), POSTBUCKLING)
def test_postbuckling(degrees, load, x, y):
    P = load * np.pi**2 / 4
    aside = Cantilever(PlanarRod(1.0), ORIGIN, force=(-P, 0.2))
    straight = Cantilever(PlanarRod(1.0), ORIGIN, force=(-P, 0.0))
    z, _ = shooting.correct(straight, shooting.solve(aside), np.eye(4)[-1])
    # The printed load has eleven digits, and the angle grows as the root of the load above the critical one.
    tip = straight.tip(z) * np.array([1.0, np.sign(z[2]), np.sign(z[2])])  # of the two branches, one
    np.testing.assert_allclose(tip, [x, y, np.deg2rad(degrees)], atol=2e-9)


@pytest.mark.parametrize("turns", [1, 2, 5])
@pytest.mark.parametrize("kind", ["moment", "follower_moment"])
def test_rollup_in_the_plane(turns, kind):
    angle = 2 * np.pi * turns
    problem = Cantilever(PlanarRod(1.0), ORIGIN, **{kind: (angle,)})
    np.testing.assert_allclose(problem.tip(shooting.solve(problem)), [0.0, 0.0, angle], atol=1e-11)


@pytest.mark.parametrize("row", REFERENCE["rollup-space"]["rows"])
def test_rollup_in_space_is_a_tilted_circle(row):
    axis, angle, tip = row[0], row[1], row[3:]
    root = matrix(np.array(quaternion(REFERENCE["rollup-space"]["turn"])))
    bent = np.array([0.0, 0.0, -1.0]) if axis == 1 else np.array([0.0, 1.0, 0.0])
    circle = (np.sin(angle) * np.eye(3)[0] + (1 - np.cos(angle)) * bent) / angle
    np.testing.assert_allclose(tip[:3], root @ circle, atol=1e-11)
    turned = matrix(np.array(quaternion(angle * root[:, axis]))) @ root
    np.testing.assert_allclose(matrix(np.array(tip[3:])), turned, atol=1e-10)


@pytest.mark.parametrize("kind", ["moment", "follower_moment"])
def test_moment_in_any_direction_makes_a_helix(kind):
    """Equal stiffness: the spatial curvature M/EI is constant, and so is the moment seen by the sections."""
    turn, moment = np.array([0.3, 0.4, 0.5]), np.array([1.0, 2.0, 3.0])
    root = matrix(quaternion(turn))
    fixed = moment if kind == "moment" else root @ moment
    problem = Cantilever(SpatialRod(1.0), (*ORIGIN, *quaternion(turn)), **{kind: tuple(moment)})
    tip = problem.tip(shooting.solve(problem))
    axis, angle = fixed / np.linalg.norm(fixed), np.linalg.norm(fixed)
    start = root[:, 0]
    along = axis * (axis @ start)
    helix = along + ((start - along) * np.sin(angle) + np.cross(axis, start) * (1 - np.cos(angle))) / angle
    np.testing.assert_allclose(tip[:3], helix, atol=1e-11)
    np.testing.assert_allclose(matrix(tip[3:]), matrix(quaternion(fixed)) @ root, atol=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize(("P", "J", "tip"), BEND)
def test_bend45(P, J, tip):
    problem = rod_cases.arc(PROBLEMS["follower-arc"] | {"J": J}, force=(0.0, 0.0, P))
    np.testing.assert_allclose(problem.tip(shooting.solve(problem))[:3], tip, atol=1e-6)


@pytest.mark.parametrize(("P", "degrees", "expected"), PRINCETON)
def test_princeton(P, degrees, expected):
    L, chord, t, E, nu = 0.508, 12.3777e-3, 3.2024e-3, 71.7e9, 0.31
    G, area = E / 2 / (1 + nu), chord * t
    inertia = E * chord * t**3 / 12, E * t * chord**3 / 12
    rod = SpatialRod(L, G * 1.1340719e-10, *inertia, E * area, 5 / 6 * G * area, 5 / 6 * G * area)
    angle = np.deg2rad(degrees)
    problem = Cantilever(rod, ALONG_X, force=(0.0, P * np.cos(angle), P * np.sin(angle)))
    tip = problem.tip(shooting.solve(problem, steps=2))
    R = matrix(tip[3:])
    twist = np.rad2deg(np.arctan2(R[2, 1], R[1, 1]))
    np.testing.assert_allclose([tip[1], tip[2], tip[0] - L], expected[:3], atol=1e-8)
    np.testing.assert_allclose(twist, expected[3], atol=1e-6)


@pytest.mark.parametrize(("x", "force", "y", "phi", "support"), GUIDE)
def test_guide_stroke(x, force, y, phi, support):
    data = {"l": 1.0, "b": 1.0, "EI": 1.0, "EA": 480000.0}
    row = rod_cases.guide_row(rod_cases.planar_guide(data, given={0: x}))
    np.testing.assert_allclose(row[0], force, atol=1e-9)
    np.testing.assert_allclose(row[3], y, atol=1e-10)
    np.testing.assert_allclose(row[4], phi, rtol=1e-3)
    # The printed stiffness is a difference quotient, good to seven digits; the tangent at x = 1e-4 is 959993.4056.
    np.testing.assert_allclose(row[6], support, rtol=3e-7)


@pytest.mark.parametrize(("fraction", "degrees", "stiffness", "shift"), PIVOT)
def test_cross_pivot(fraction, degrees, stiffness, shift):
    angle = np.deg2rad(degrees)
    problem = rod_cases.cross_pivot(fraction, inf, angle, 0.0)
    z = shooting.solve(problem)
    np.testing.assert_allclose(problem.wrench(z)[2] / angle, stiffness, atol=1e-8)
    np.testing.assert_allclose(np.linalg.norm(problem.platform(z)[:2]), shift, rtol=1e-5)


def test_cross_pivot_starts_with_its_linear_stiffness():
    for fraction in (0.5, 0.1273):
        problem = rod_cases.cross_pivot(fraction, inf, 0.0, 0.0)
        compliance = problem.compliance(problem.start)
        np.testing.assert_allclose(1 / compliance[2, 2], 8 * (3 * fraction**2 - 3 * fraction + 1), rtol=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rod", "force", "expected"),
    [
        (PlanarRod(1.0), (-1.0, 0.0), np.pi**2 / 4),
        (PlanarRod(1.0, load=(-1.0, 0.0)), None, 7.8373474389),
        (PlanarRod(0.5, GA=100.0), (-1.0, 0.0), 9.0504906001),
        (PlanarRod(0.5, GA=20.0), (-1.0, 0.0), 7.2450598150),
        (PlanarRod(0.5, EA=500.0, GA=100.0), (-1.0, 0.0), 9.1934485),
        (PlanarRod(0.5, EA=100.0, GA=20.0), (-1.0, 0.0), 7.5746136),
    ],
    ids=["Euler", "self-weight", "Haringx", "Haringx-soft", "Haringx-EA", "Haringx-EA-soft"],
)
def test_buckling_in_the_plane(rod, force, expected):
    """A11: a pinned column is twice a cantilever of half its length."""
    critical = shooting.critical_factor(Cantilever(rod, ORIGIN, force=force), 1.0)
    np.testing.assert_allclose(critical, expected, rtol=1e-8)


@pytest.mark.slow("distributed--0.16666666666666666-6.0")
@pytest.mark.parametrize(("kind", "order", "factor"), [("tip", -1 / 4, 2.0), ("distributed", -1 / 6, 6.0)])
def test_lateral_buckling(kind, order, factor):
    """Narrow strip: P L^2/sqrt(EIz GJ) is twice the first zero of J_(-1/4), q L^3/sqrt(EIz GJ) six of J_(-1/6)."""
    case = (kind, 1e6, 0.0, 1.0)
    (row,) = rod_cases.lateral({"cases": [case]})
    zero = brentq(lambda x: jv(order, x), 1.5, 2.5, xtol=1e-14)
    # Bending before buckling adds about (GJ + EIz)/2 EIy = 1e-6.
    np.testing.assert_allclose(row[-1], factor * zero * (1 + 1e-6), rtol=3e-7)
    for stored in REFERENCE["lateral"]["rows"]:
        if stored[:4] == case:
            np.testing.assert_allclose(row[-1], stored[-1], rtol=1e-9)


@pytest.mark.slow
def test_frame_leaves_its_plane():
    (row,) = rod_cases.frame_lateral(PROBLEMS["frame-lateral"] | {"cases": [(2.16, 1.0)]})
    np.testing.assert_allclose(row[-1], 1.0875184, atol=6e-8)
    np.testing.assert_allclose(row, REFERENCE["frame-lateral"]["rows"][0], rtol=1e-9)


@pytest.mark.parametrize("row", REFERENCE["follower-force"]["rows"])
def test_follower_force_marched_from_the_tip(row):
    """In the tip's frame the load is known, so that the rod is an initial-value problem and nothing is sought."""
    P, EA, GA, *tip = row

    def rates(s, state):
        _, _, phi, m = state
        along, across = 1 + P * np.sin(phi) / EA, P * np.cos(phi) / GA
        dx, dy = (
            np.cos(phi) * along - np.sin(phi) * across,
            np.sin(phi) * along + np.cos(phi) * across,
        )
        return [dx, dy, m, -dx * P]

    x, y, phi, _ = solve_ivp(rates, (1.0, 0.0), np.zeros(4), rtol=1e-12, atol=1e-14).y[:, -1]
    c, s = np.cos(phi), np.sin(phi)
    np.testing.assert_allclose([-c * x - s * y, s * x - c * y, -phi], tip, atol=1e-9)


@pytest.mark.parametrize("row", REFERENCE["follower-arc"]["rows"])
def test_follower_force_on_the_arc_marched_from_the_tip(row):
    P, data = row[0], REFERENCE["follower-arc"]
    area, inertia, R = data["side"] ** 2, data["side"] ** 4 / 12, data["R"]
    stretch = np.array([data["E"], data["k"] * data["G"], data["k"] * data["G"]]) * area
    bend = np.array([data["G"] * data["J"], data["E"] * inertia, data["E"] * inertia])
    n = np.array([0.0, 0.0, P])

    def rates(s, state):
        Q, m = state[3:12].reshape(3, 3), state[12:]
        dr = Q @ (np.array([1.0, 0.0, 0.0]) + Q.T @ n / stretch)
        kx, ky, kz = Q.T @ m / bend + np.array([0.0, 0.0, -1 / R])
        return np.r_[dr, (Q @ np.array([[0, -kz, ky], [kz, 0, -kx], [-ky, kx, 0]])).ravel(), -np.cross(dr, n)]

    start = np.r_[np.zeros(3), np.eye(3).ravel(), np.zeros(3)]
    end = solve_ivp(rates, (R * data["angle"], 0.0), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    tip = matrix(quaternion((0.0, 0.0, np.pi / 2))) @ end[3:12].reshape(3, 3).T
    np.testing.assert_allclose(-tip @ end[:3], row[1:4], atol=1e-8)
    np.testing.assert_allclose(tip, matrix(np.array(row[4:])), atol=1e-10)


def test_rod_in_space_equals_rod_in_the_plane():
    """With extension, shear, distributed load, curvature and all kinds of end load."""
    flat = PlanarRod(2.0, 3.0, 50.0, 30.0, 0.4, (0.2, -0.3))
    deep = SpatialRod(2.0, 1.0, 5.0, 3.0, 50.0, 30.0, 20.0, (0.0, 0.0, 0.4), (0.2, -0.3, 0.0))
    plane = Cantilever(flat, ORIGIN, (0.5, 1.0), (0.7,), (-0.4, 0.8), (-0.3,))
    ends = (0.5, 1.0, 0.0), (0.0, 0.0, 0.7), (-0.4, 0.8, 0.0), (0.0, 0.0, -0.3)
    space = Cantilever(deep, ALONG_X, *ends)
    x, y, phi = plane.tip(shooting.solve(plane))
    tip = space.tip(shooting.solve(space))
    np.testing.assert_allclose(tip, [x, y, 0.0, np.cos(phi / 2), 0.0, 0.0, np.sin(phi / 2)], atol=1e-11)


@pytest.mark.slow
def test_prescribed_pose_in_space_needs_the_load_that_causes_it():
    rod = SpatialRod(1.0, 0.7, 2.0, 1.0, 200.0, 90.0, 80.0)
    force, moment = np.array([0.3, 0.5, -0.8]), np.array([0.2, -0.3, 0.4])
    loaded = Cantilever(rod, ALONG_X, tuple(force), tuple(moment))
    pose = loaded.tip(shooting.solve(loaded))
    turn = pose[4:] / np.linalg.norm(pose[4:]) * 2 * np.arccos(pose[3])
    shift = dict(enumerate(np.r_[pose[:3] - [1.0, 0.0, 0.0], turn]))
    held = Assembly(((rod, ALONG_X, ALONG_X),), (1.0, *ALONG_X[1:]), np.zeros(6), shift)
    z = shooting.solve(held)
    np.testing.assert_allclose(held.wrench(z), [*force, *moment], atol=1e-9)


def test_tangent_is_the_change_of_the_wrench():
    """Of the loaded guide in space, by differences of displacements; symmetric, since the load is dead and central."""
    data = PROBLEMS["guide-spatial"]
    free = rod_cases.spatial_guide(data, (9.5, 0.0, 1.0), 5 / 6)
    z = shooting.solve(free, steps=2)
    K = free.stiffness(z)
    np.testing.assert_allclose(K, K.T, atol=1e-8 * np.abs(K).max())
    more, step = rod_cases.spatial_guide(data, (9.5, 0.0, 1.0), 5 / 6), np.array([1e-3, 0.0, 1e-2])
    changed = Assembly(more.leaves, more.home, np.r_[np.array([9.5, 0.0, 1.0]) + step, np.zeros(3)])
    guess, _ = shooting.correct(changed, z, np.eye(z.size)[-1])
    moved = (changed.platform(guess) - free.platform(z))[:3]
    np.testing.assert_allclose(moved, np.linalg.solve(K, np.r_[step, np.zeros(3)])[:3], rtol=3e-3)


@pytest.mark.parametrize("row", REFERENCE["lee-frame"]["rows"], ids=["extensible", "inextensible"])
def test_lee_frame(row):
    """Stored states are equilibria; the load is stationary at its limits, and so is v where the path turns back."""
    data = REFERENCE["lee-frame"]
    EA, path, limits, returns = row
    problem, unit = rod_cases.lee_frame(data["L"], data["EI"], EA), data["EI"] / data["L"] ** 2
    for u, v, P, *start in (*path[::8], *limits, *returns):
        z = np.array([*start, P / unit])
        assert np.abs(problem.residual(z[:, None])).max() < 1e-7 * data["L"]
        x, y, _ = problem.joint(z[:, None], 2)[:, 0]
        np.testing.assert_allclose([x - data["L"] / 5, data["L"] - y], [u, v], atol=1e-7)
    for _, _, P, *start in limits:
        assert abs(shooting.tangent(problem, np.array([*start, P / unit]), np.ones(4))[-1]) < 1e-7
    for _, _, P, *start in returns:
        z = np.array([*start, P / unit])
        along = problem.scale * shooting.tangent(problem, z, np.ones(4))
        slope = shooting.jacobian(lambda w: problem.joint(w, 2)[1:2], z, problem.scale)[1]
        assert abs((slope @ along).item()) < 1e-6 * data["L"]
    if EA < inf:  # recalled from the literature: 1.855 and -0.94
        np.testing.assert_allclose([limits[0][2], limits[1][2]], [1.855, -0.942], atol=1e-3)


def numbers(value):
    """All numbers of nested rows, in order."""
    if isinstance(value, (list, tuple)):
        return [number for entry in value for number in numbers(entry)]
    return [] if isinstance(value, str) else [float(value)]


SLOW = ("lee-frame", "lateral", "frame-lateral")  # their first rows are solved above


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in PROBLEMS if name not in SLOW])
def test_stored_rows_are_solved_anew(name):
    """The first case of each problem; all of them by `rod_cases.py`."""
    entry = REFERENCE[name]
    few = {key: entry[key][:1] for key in ("cases", "EA", "fractions", "forces") if isinstance(entry.get(key), list)}
    rows = list(PROBLEMS[name]["solver"](entry | few))
    for row, stored in zip(rows, entry["rows"], strict=False):
        actual, expected = np.array(numbers(row)), np.array(numbers(stored))
        np.testing.assert_array_equal(np.isfinite(actual), np.isfinite(expected))
        finite = np.isfinite(expected)
        np.testing.assert_allclose(actual[finite], expected[finite], rtol=1e-8, atol=1e-11)
