"""Rods in motion: spin-up, slider-crank with a flexible rod, elbow, spaghetti; problem data in, states at times out.

`python -m references.motion_rod_cases`, in `tests`, writes `motion_rod_references.py` anew, which takes some minutes;
the tests hold a part of it against these functions.
"""

import runpy
import sys
import time
from math import inf
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from references.motion_integrators import gauss, runge_kutta
from references.motion_rods import Field, Frames, PlanarRod, SpatialRod, at_rest, left_product, matrices

Answer = dict[str, np.ndarray]
HEAD = '''"""Reference numbers of rods in motion: written by `motion_rod_cases.py`, not by hand.

Each entry: the arguments of its function there (which states the problem), times, the answer at these, and as its error
the largest change from a coarser series and step.
"""

from math import inf

'''


def spin(t: float, speed: float, duration: float) -> tuple[float, float, float]:
    """Angle of a hub brought to a speed, with derivatives: W/T (t^2/2 + (T/2pi)^2 (cos(2pi t/T) - 1))."""
    if t >= duration:
        return speed * (t - duration / 2), speed, 0.0
    k = 2 * np.pi / duration
    turn = speed / duration * (t**2 / 2 + (np.cos(k * t) - 1) / k**2)
    return turn, speed / duration * (t - np.sin(k * t) / k), speed / duration * (1 - np.cos(k * t))


def spin_up(
    times: ArrayLike,
    length: float = 10.0,
    EI: float = 1.4e4,
    EA: float = 2.8e7,
    GA: float = inf,
    mass: float = 1.2,
    rotary: float = 0.0,
    speed: float = 6.0,
    duration: float = 15.0,
    terms: int = 6,
    step: float = 0.05,
) -> Answer:
    """A beam clamped to a hub of no radius whose angle is prescribed by :func:`spin`; planar, no gravity.

    Geometrically exact: centrifugal stiffening needs no term of its own. Data as Simo and Vu-Quoc's robot arm
    (recalled), here without shear and rotary inertia; theirs are GA = 1e7, rotary = 6e-4. Six terms give the tip to
    1e-6 of the largest deflection and eight to 1e-8; halving the step changes 1e-10.

    Args:
        times: [s].
        length: [m].
        EI: Bending stiffness [N m^2].
        EA: Extensional stiffness [N]; inf: inextensible.
        GA: Shear stiffness [N]; inf: no shear.
        mass: Per length [kg/m].
        rotary: Rotary inertia per length [kg m].
        speed: In the end [rad/s].
        duration: Until it is reached [s].
        terms: Of each strain's series.
        step: Of the integration [s].

    Returns:
        tip: displacement along the beam's undeformed axis and normal to it, turning with the hub, (n_t, 2) [m];
        slope: rotation of the tip against the hub [rad]; torque of the hub [N m].
    """
    rod = PlanarRod(length, EI, mass, EA, GA, rotary, terms)

    def whole(t, q, qd):
        turn, rate, acceleration = spin(t, speed, duration)
        z, zd = np.array([0.0, 0.0, turn, *q]), np.array([0.0, 0.0, rate, *qd])
        return *rod.equations(z, zd), acceleration

    def equations(t, q, qd):
        M, force, _, _, acceleration = whole(t, q, qd)
        return M[3:, 3:], force[3:] - M[3:, 2] * acceleration

    tips, slopes, torques = [], [], []
    states = gauss(equations, rod.stiffness, times, step, (duration,))
    for t, (q, qd) in zip(np.atleast_1d(times), states, strict=True):
        M, force, positions, angles, acceleration = whole(t, q, qd)
        qdd = np.linalg.solve(M[3:, 3:], force[3:] - M[3:, 2] * acceleration)
        turn = spin(t, speed, duration)[0]
        back = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        tips.append(back @ positions.r[-1] - [length, 0.0])
        slopes.append(angles.r[-1, 0] - turn)
        torques.append(M[2, 2:] @ [acceleration, *qdd] - force[2])
    return {"tip": np.array(tips), "slope": np.array(slopes), "torque": np.array(torques)}


def slider_crank(
    times: ArrayLike,
    speed: float = 150.0,
    crank: float = 0.15,
    length: float = 0.3,
    diameter: float = 0.006,
    E: float = 2e11,
    rho: float = 7870.0,
    slider: float = 0.033,
    duration: float = 0.0,
    extensible: bool = True,
    terms: int = 6,
    step: float = 2e-4,
) -> Answer:
    """Slider-crank whose rod bends: crank rigid, massless and driven, rod round, slider on y = 0, no gravity.

    From rest of the rod's deformations in the stretched position, at speed at once or brought to it by :func:`spin`.
    The rod's angle follows from the slider's place on the line, so that its strains are all there is to solve for.
    Data as in the literature on SPACAR (recalled). A sudden start has no smooth answer: with nine terms the middle is
    good to 1e-7 m and the torque to 1e-2 N m where the rod does not stretch, and where it does, waves along it keep
    velocity and forces from converging. A smooth start gives the middle to 1e-10 m and the torque to 4e-5 N m.

    Args:
        times: [s].
        speed: Of the crank [rad/s].
        crank: Its length [m].
        length: Of the rod [m].
        diameter: Of the rod [m].
        E: Young's modulus [Pa].
        rho: Density [kg/m^3].
        slider: Its mass [kg].
        duration: Until the speed is reached [s].
        extensible: Whether the rod stretches.
        terms: Of each strain's series.
        step: Of the integration [s].

    Returns:
        slider: x, and its velocity (n_t, 2); middle: distance of the rod's middle from the line between its ends, to
        the left of it, seen from the crank pin [m]; torque of the drive [N m]; guide: force on the slider [N].
    """
    area, second = np.pi * diameter**2 / 4, np.pi * diameter**4 / 64
    rod = PlanarRod(length, E * second, rho * area, EA=E * area if extensible else inf, terms=terms)

    def whole(t, q, qd):
        turn, rate, acceleration = spin(t, speed, duration)
        out = crank * np.array([np.cos(turn), np.sin(turn)])
        side = np.array([-out[1], out[0]])
        a, b = rod.place(q)
        z = np.array([*out, -np.arctan2(b, a) - np.arcsin(out[1] / np.hypot(a, b)), *q])
        zd = np.array([*(rate * side), 0.0, *qd])
        line = rod.field(z, zd)[0].J[-1, 1]
        zd[2] = -line @ zd / line[2]
        M, force, positions, _ = rod.equations(z, zd)
        J = positions.J[-1]
        M, force = M + slider * J.T @ J, force - slider * J.T @ positions.a[-1]
        # z'' = B q'' + given keeps the slider on its line.
        B = np.vstack([np.zeros((2, rod.n_q)), -line[3:] / line[2], np.eye(rod.n_q)])
        given = np.array([*(acceleration * side - rate**2 * out), 0.0, *np.zeros(rod.n_q)])
        given[2] = -(positions.a[-1, 1] + line @ given) / line[2]
        return M, force, B, given, positions, out, side

    def equations(t, q, qd):
        M, force, B, given, *_ = whole(t, q, qd)
        return B.T @ M @ B, B.T @ (force - M @ given)

    rows = []
    states = gauss(equations, rod.stiffness, times, step, (duration,))
    for t, (q, qd) in zip(np.atleast_1d(times), states, strict=True):
        M, force, B, given, positions, out, side = whole(t, q, qd)
        zdd = given + B @ np.linalg.solve(B.T @ M @ B, B.T @ (force - M @ given))
        needed, line = M @ zdd - force, positions.J[-1, 1]
        guide = needed[2] / line[2]
        middle, end = positions.r[-2:] - out
        height = (end[0] * middle[1] - end[1] * middle[0]) / np.hypot(*end)
        torque = (needed[:2] - line[:2] * guide) @ side
        rows.append((positions.r[-1, 0], positions.v[-1, 0], height, torque, guide))
    x, v, height, torque, guide = np.array(rows).T
    return {"slider": np.stack([x, v], axis=-1), "middle": height, "torque": torque, "guide": guide}


def elbow(
    times: ArrayLike,
    leg: float = 10.0,
    stretching: float = 1e6,
    bending: float = 1e3,
    mass: float = 1.0,
    rotary: tuple[float, float, float] = (20.0, 10.0, 10.0),
    peak: float = 50.0,
    terms: int = 4,
    step: float = 0.05,
) -> Answer:
    """Right-angle cantilever of Simo and Vu-Quoc: a pulse out of the plane on the elbow, then large free motion.

    Clamped at the origin, along x to the elbow, then along y to the tip. The dead force along z on the elbow rises
    linearly to its peak at t = 1 and falls to zero at t = 2; energy is constant after that. Data recalled. Seven terms
    give displacements to 1e-3 of their unit, up to t = 30 and of some 10 at most.

    Args:
        times: [s].
        leg: Length of each leg.
        stretching: EA = GA.
        bending: GJ = EI.
        mass: Per length.
        rotary: Rotary inertia per length, axis of the leg first.
        peak: Of the force.
        terms: Of each strain's series in each leg.
        step: Of the integration [s].

    Returns:
        elbow, tip: displacements (n_t, 3); energy: kinetic and elastic.
    """
    one = SpatialRod(leg, (bending,) * 3, (stretching,) * 3, mass, rotary, terms)
    n = one.n_q
    base = at_rest(np.zeros(3), np.eye(3), 2 * n)
    corner = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    stiffness = np.tile(one.stiffness, 2)

    def whole(q, qd):
        first = one.field(*base, q[:n], qd[:n], 0)
        second = one.field(first[0].end(), first[1].end().turned(corner), q[n:], qd[n:], n)
        (M1, f1), (M2, f2) = one.inertia(*first), one.inertia(*second)
        return M1 + M2, f1 + f2 - stiffness * q, first[0], second[0]

    def equations(t, q, qd):
        M, force, first, _ = whole(q, qd)
        pull = peak * max(0.0, 1 - abs(t - 1))
        return M, force + pull * first.J[-1, 2]

    places, energies = [], []
    for q, qd in gauss(equations, stiffness, times, step, (1.0, 2.0)):
        M, _, first, second = whole(q, qd)
        places.append((first.r[-1] - [leg, 0.0, 0.0], second.r[-1] - [leg, leg, 0.0]))
        energies.append(qd @ M @ qd / 2 + stiffness @ q**2 / 2)
    return {"elbow": np.array(places)[:, 0], "tip": np.array(places)[:, 1], "energy": np.array(energies)}


def spaghetti(times: ArrayLike, terms: int = 6, rtol: float = 1e-9) -> Answer:
    """D1-spaghetti: a free flexible rod, thrown by a force and a moment at its lower end, which are gone at t = 5.

    From (6, 0, 0) to (0, 8, 0), EA = GA = 1e4, EI = GJ = 500, mass 1 and rotary inertia (20, 10, 10) per length. Dead
    force (T/10, 0, 0), moment about fixed axes (0, -T/2, -T), T = 200 at t = 2.5, linear before and after. Ten terms
    give the ends to 1e-3; the energy depends on the mesh while the moment works on one point.

    Args:
        times: [s].
        terms: Of each strain's series.
        rtol: Relative tolerance of the integration.

    Returns:
        lower, upper: ends (n_t, 3); p: momentum, h: angular momentum about the origin (n_t, 3); energy.
    """
    rod = SpatialRod(10.0, (500.0,) * 3, (1e4,) * 3, 1.0, (20.0, 10.0, 10.0), terms)
    n = rod.n_q
    along = np.array([[-0.6, -0.8, 0.0], [0.8, -0.6, 0.0], [0.0, 0.0, 1.0]])
    none, unit = np.zeros((1, 3)), np.eye(6 + n)[None]
    load = np.array([0.1, 0.0, 0.0, 0.0, -0.5, -1.0])

    def whole(y):
        # Unknowns: place and quaternion of the lower end, strains; their velocities, the end's in space.
        r, turn, q, v, w, qd = np.split(y, [3, 7, 7 + n, 10 + n, 13 + n])
        r0 = Field(r[None], v[None], none, unit[:, :3])
        R0 = Frames(matrices(turn[None]) @ along, w[None], none, unit[:, 3:6])
        fields = rod.field(r0, R0, q, qd, 6)
        M, force = rod.inertia(*fields)
        force[6:] -= rod.stiffness * q
        return M, force, *fields

    def rate(t, y):
        M, force, *_ = whole(y)
        force[:6] += load * 200 * max(0.0, 1 - abs(t / 2.5 - 1))
        spun = left_product(y[10 + n : 13 + n]) @ y[3:7] / 2
        return np.concatenate([y[7 + n : 10 + n], spun, y[13 + n :], np.linalg.solve(M, force)])

    start = np.zeros(13 + 2 * n)
    start[[0, 3]] = 6.0, 1.0
    times, stops = np.atleast_1d(times).astype(float), np.unique([*np.atleast_1d(times), 2.5, 5.0])
    found = dict(zip(stops, runge_kutta(rate, start, stops[stops <= times.max()], rtol, 1e-3 * rtol), strict=False))
    rows = []
    for t in times:
        y = found[t]
        M, _, positions, _ = whole(y)
        r, q, speeds = y[:3], y[7 : 7 + n], y[7 + n :]
        # The first six rows of M give the momenta dual to velocity and spin of the lower end.
        p, h = M[:3] @ speeds, M[3:6] @ speeds
        energy = speeds @ M @ speeds / 2 + rod.stiffness @ q**2 / 2
        rows.append((r, positions.r[-1], p, h + np.cross(r, p), energy))
    names = ("lower", "upper", "p", "h", "energy")
    return {name: np.array([row[i] for row in rows]) for i, name in enumerate(names)}


ARM = {"GA": 1e7, "rotary": 6e-4}
SPIN_UP = tuple(1.5 * i for i in range(1, 13))
TURNS = tuple(0.008 * i for i in range(1, 11))
PROBLEMS = {
    "spin-up": (spin_up, {}, SPIN_UP, {"terms": 8}, {"terms": 7, "step": 0.1}),
    "spin-up-inextensible": (spin_up, {"EA": inf}, SPIN_UP, {"terms": 8}, {"terms": 7, "step": 0.1}),
    "spin-up-shear": (spin_up, ARM, SPIN_UP, {"terms": 8}, {"terms": 7, "step": 0.1}),
    "slider-crank": (slider_crank, {"extensible": False}, TURNS, {"terms": 9, "step": 1e-4}, {"terms": 7}),
    "slider-crank-smooth": (slider_crank, {"duration": 0.04}, TURNS, {"terms": 9, "step": 1e-4}, {"terms": 7}),
    "elbow": (
        elbow,
        {},
        (1.0, 2.0, 3.0, 5.0, 7.5, 10.0, 15.0, 20.0, 25.0, 30.0),
        {"terms": 7},
        {"terms": 6, "step": 0.1},
    ),
    "spaghetti": (
        spaghetti,
        {},
        (1.0, 2.5, 4.0, 5.0, 6.0, 8.0),
        {"terms": 10, "rtol": 1e-8},
        {"terms": 8, "rtol": 1e-7},
    ),
    # The same series as a simulation of few coefficients has; the error is that of the integration.
    "elbow-two-terms": (elbow, {"terms": 2}, (1.0, 2.0, 3.0), {}, {"step": 0.1}),
    "spaghetti-two-terms": (spaghetti, {"terms": 2}, (2.5, 5.0, 5.5), {"rtol": 1e-8}, {"rtol": 1e-7}),
}


def solve(name: str) -> dict:
    """Answer of a problem, and its largest change from a coarser resolution."""
    solver, data, times, fine, coarse = PROBLEMS[name]
    answer, other = (solver(times, **data, **resolution) for resolution in (fine, coarse))
    return {
        "data": data | fine,
        "times": times,
        "answer": {key: value.tolist() for key, value in answer.items()},
        "error": {key: float(np.abs(value - other[key]).max()) for key, value in answer.items()},
    }


def tidy(value):
    """Plain Python numbers of 12 digits; what is below 1e-13 is zero."""
    if isinstance(value, dict):
        return {name: tidy(entry) for name, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(tidy(entry) for entry in value)
    return (0.0 if abs(value) < 1e-13 else float(f"{value:.12g}")) if isinstance(value, float) else value


def write(names):
    """Solve the named problems, or all (an hour), and write `motion_rod_references.py`, then for the formatter."""
    place = Path(__file__).with_name("motion_rod_references.py")
    known = runpy.run_path(str(place))["REFERENCE"] if place.exists() else {}
    for name in names or PROBLEMS:
        begin = time.time()
        known[name] = tidy(solve(name))
        print(name, f"{time.time() - begin:.0f} s", known[name]["error"], flush=True)
        ordered = {name: known[name] for name in PROBLEMS if name in known}
        place.write_text(HEAD + f"REFERENCE = {ordered!r}\n")


if __name__ == "__main__":
    write(sys.argv[1:])
