"""Motions with known answers, written apart from flexmb and never importing it: closed forms, Runge-Kutta of order 8.

Every function takes the times at which its answer is wanted and returns a dict of arrays over these times. The keys of
problems are those of the reference list (C3, C4, C5, D5). Rods in motion are in `motion_rods.py`.
"""

from collections.abc import Callable

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike
from references.motion_integrators import RTOL, runge_kutta
from scipy.linalg import eigh
from scipy.special import ellipj, ellipk, ellipkm1

GRAVITY = 9.81

Answer = dict[str, np.ndarray]


def pendulum(times: ArrayLike, length: float = 1.0, angle: float = -np.pi / 2, g: float = GRAVITY) -> Answer:
    """D5-pendulum: a point mass on a massless rod, from rest; closed form, 1e-14.

    sin(theta/2) = k cd(sqrt(g/l) t), k = sin(angle/2), theta from the lower vertical, x to the right, y up.

    Args:
        times: [s].
        length: Of the rod [m].
        angle: At rest, from the lower vertical [rad].
        g: Gravity, down [m/s^2].

    Returns:
        theta [rad], rate [rad/s], position (n_t, 2) [m], tension per mass [m/s^2], period [s].
    """
    k, omega = np.sin(angle / 2), np.sqrt(g / length)
    sn, cn, dn, _ = ellipj(omega * np.asarray(times, float), k**2)
    theta = 2 * np.arcsin(k * cn / dn)
    # d(cd u)/du = -(1 - m) sn/dn^2, and cos(theta/2) = sqrt(1 - m)/dn.
    rate = -2 * k * np.sqrt(1 - k**2) * omega * sn / dn
    return {
        "theta": theta,
        "rate": rate,
        "position": length * np.stack([np.sin(theta), -np.cos(theta)], axis=-1),
        "tension": length * rate**2 + g * np.cos(theta),
        "period": np.asarray(4 * ellipk(k**2) / omega),
    }


def fourbar(
    times: ArrayLike,
    loops: int = 1,
    angle: float = np.pi / 2,
    rate: float = -1.0,
    g: float = GRAVITY,
    rtol: float = RTOL,
) -> Answer:
    """D5-fourbar: a chain of parallelograms, all bars uniform, of unit length and mass; 1e-11 in theta at t = 10.

    loops + 1 cranks turn by theta from the ground line, loops couplers move with the cranks' tips:
    I theta'' = -m g cos theta, I = (loops + 1)/3 + loops, m = (loops + 1)/2 + loops.

    Args:
        times: [s].
        loops: Parallel loops.
        angle: Of the cranks at t = 0 [rad].
        rate: Its derivative at t = 0 [rad/s].
        g: Gravity, down [m/s^2].
        rtol: Relative tolerance of the integration.

    Returns:
        theta, rate, joint: tip of the first crank from its support (n_t, 2), energy (zero at theta = 0).
    """
    inertia, weight = (loops + 1) / 3 + loops, g * ((loops + 1) / 2 + loops)
    states = runge_kutta(lambda t, y: np.array([y[1], -weight / inertia * np.cos(y[0])]), (angle, rate), times, rtol)
    theta, turning = states.T
    return {
        "theta": theta,
        "rate": turning,
        "joint": np.stack([np.cos(theta), np.sin(theta)], axis=-1),
        "energy": inertia * turning**2 / 2 + weight * np.sin(theta),
    }


def double_pendulum(
    times: ArrayLike,
    masses: tuple[float, float] = (1.0, 1.0),
    lengths: tuple[float, float] = (1.0, 1.0),
    angles: tuple[float, float] = (np.pi / 2, np.pi / 2),
    rates: tuple[float, float] = (0.0, 0.0),
    g: float = GRAVITY,
    rtol: float = RTOL,
) -> Answer:
    """Two point masses on massless rods, angles from the lower vertical; 1e-11 up to 2 s, before chaos has grown.

    (m1 + m2) l1 a'' + m2 l2 (b'' cos(a - b) + b'^2 sin(a - b)) = -(m1 + m2) g sin a
    l2 b'' + l1 (a'' cos(a - b) - a'^2 sin(a - b)) = -g sin b

    Args:
        times: [s].
        masses: Upper and lower [kg].
        lengths: Of the rods [m].
        angles: At t = 0 [rad].
        rates: At t = 0 [rad/s].
        g: Gravity, down [m/s^2].
        rtol: Relative tolerance of the integration.

    Returns:
        angles (n_t, 2), rates (n_t, 2), positions (n_t, 2 masses, 2), energy (zero with both at the support's height).
    """
    (m1, m2), (l1, l2) = masses, lengths

    def rate(t, y):
        a, b, ad, bd = y
        c, s = np.cos(a - b), np.sin(a - b)
        matrix = np.array([[(m1 + m2) * l1, m2 * l2 * c], [l1 * c, l2]])
        right = (-m2 * l2 * bd**2 * s - (m1 + m2) * g * np.sin(a), l1 * ad**2 * s - g * np.sin(b))
        return np.array([ad, bd, *np.linalg.solve(matrix, right)])

    states = runge_kutta(rate, (*angles, *rates), times, rtol)
    turn, turning = states[:, :2], states[:, 2:]
    arms = np.array(lengths)[:, None] * np.stack([np.sin(turn), -np.cos(turn)], axis=-1)
    speeds = np.array(lengths)[:, None] * turning[..., None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    positions, velocities = np.cumsum(arms, axis=1), np.cumsum(speeds, axis=1)
    energy = (velocities**2).sum(-1) @ np.array(masses) / 2 + g * positions[..., 1] @ np.array(masses)
    return {"angles": turn, "rates": turning, "positions": positions, "energy": energy}


def slider_crank(
    times: ArrayLike,
    speed: float = 150.0,
    crank: float = 0.15,
    rod: float = 0.3,
    masses: tuple[float, float, float] = (0.0, 0.0666, 0.033),
    g: float = 0.0,
) -> Answer:
    """Rigid slider-crank at constant speed, closed form: rod and crank uniform, slider on y = 0, gravity along -y.

    Crank angle t = speed times time, rod angle sin p = -(crank/rod) sin t; the torque that keeps the speed is
    ½ I'(t) speed² + V'(t) with the kinetic energy ½ I(t) speed² and the potential energy V(t).

    Args:
        times: [s].
        speed: Of the crank [rad/s].
        crank: Its length [m].
        rod: Its length [m].
        masses: Of crank, rod and slider [kg].
        g: Gravity [m/s^2].

    Returns:
        angle, rod_angle, rod_rate, slider: x (n_t), slider_velocity, slider_acceleration, torque of the drive [N m],
        guide: force of the guide on the slider along y [N].
    """
    t = speed * np.asarray(times, float)
    m_crank, m_rod, m_slider = masses
    c, s, ratio = np.cos(t), np.sin(t), crank / rod
    cp, sp = np.sqrt(1 - (ratio * s) ** 2), -ratio * s
    # Derivatives by t: of the rod angle p, of the slider x = crank cos t + rod cos p, of the rod's middle.
    p = np.arctan2(sp, cp)
    p1 = -ratio * c / cp
    p2 = (ratio * s + sp * p1**2) / cp
    x = crank * c + rod * cp
    x1 = -crank * s - rod * sp * p1
    x2 = -crank * c - rod * (cp * p1**2 + sp * p2)
    middle1 = np.stack([-crank * s - rod / 2 * sp * p1, crank * c / 2])
    middle2 = np.stack([-crank * c - rod / 2 * (cp * p1**2 + sp * p2), -crank * s / 2])
    turning = m_rod * rod**2 / 12
    half_slope = m_rod * (middle1 * middle2).sum(0) + turning * p1 * p2 + m_slider * x1 * x2
    torque = half_slope * speed**2 + g * crank * c * (m_crank + m_rod) / 2
    # Moments on the rod about the crank pin: inertia forces at its middle and at the slider, gravity, the guide.
    lever = rod * np.stack([cp, sp])
    inertia_x, inertia_y = middle2 * speed**2 + np.array([[0.0], [g]])
    moment = turning * p2 * speed**2 + m_rod / 2 * (lever[0] * inertia_y - lever[1] * inertia_x)
    moment = moment + m_slider * (lever[0] * g - lever[1] * x2 * speed**2)
    return {
        "angle": t,
        "rod_angle": p,
        "rod_rate": p1 * speed,
        "slider": x,
        "slider_velocity": x1 * speed,
        "slider_acceleration": x2 * speed**2,
        "torque": torque,
        "guide": moment / lever[0],
    }


def cross(a, b) -> np.ndarray:
    """Vector product of two vectors; numpy's own takes ten times as long for one pair."""
    (a1, a2, a3), (b1, b2, b3) = a, b
    return np.array([a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1])


def product(p, q) -> np.ndarray:
    """Quaternion product p q, scalar first."""
    (a, b, c, d), (w, x, y, z) = p, q
    return np.array(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ]
    )


def matrices(q: ArrayLike) -> np.ndarray:
    """Rotation matrices (..., 3, 3) of quaternions (..., 4), scalar first; their length drops out."""
    q = np.asarray(q, float)
    w, x, y, z = np.moveaxis(q / np.sqrt((q**2).sum(-1, keepdims=True)), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def turning_body(
    times: ArrayLike,
    inertia: ArrayLike,
    rates: ArrayLike,
    torque: Callable[[float, np.ndarray], ArrayLike] | None = None,
    turn: ArrayLike = (1.0, 0.0, 0.0, 0.0),
    rtol: float = RTOL,
) -> Answer:
    """A rigid body turning about a point: J w' + w x J w = torque, q' = q (0, w)/2; 1e-11 over some ten turns.

    Args:
        times: [s].
        inertia: Principal moments about the point, (3,) [kg m^2].
        rates: Angular velocity in body axes at t = 0, (3,) [rad/s].
        torque: From time and the rotation matrix, in body axes, (3,) [N m]; none if None.
        turn: Quaternion at t = 0, scalar first.
        rtol: Relative tolerance of the integration.

    Returns:
        quaternions (n_t, 4), rates (n_t, 3) in body axes, rotations (n_t, 3, 3), energy: kinetic, momentum: angular,
        in axes fixed in space (n_t, 3).
    """
    J = np.asarray(inertia, float)

    def rate(t, y):
        q, w = y[:4], y[4:]
        moment = np.zeros(3) if torque is None else np.asarray(torque(t, matrices(q)))
        return np.concatenate([product(q, (0.0, *w)) / 2, (moment - cross(w, J * w)) / J])

    states = runge_kutta(rate, np.concatenate([turn, rates]), times, rtol)
    rotations, w = matrices(states[:, :4]), states[:, 4:]
    return {
        "quaternions": states[:, :4],
        "rates": w,
        "rotations": rotations,
        "energy": (J * w**2).sum(-1) / 2,
        "momentum": np.einsum("tij,tj->ti", rotations, J * w),
    }


def dzhanibekov(times: ArrayLike, rtol: float = RTOL) -> Answer:
    """D5-dzhanibekov: a free body J = (1, 2, 3), rates (1e-3, 1, 0); 1e-9 over a period of 57.5 s.

    Args:
        times: [s].
        rtol: Relative tolerance of the integration.

    Returns:
        As :func:`turning_body`, and the period of the second rate, closed form.
    """
    inertia, rates = (1.0, 2.0, 3.0), (1e-3, 1.0, 0.0)
    return turning_body(times, inertia, rates, rtol=rtol) | {"period": np.asarray(free_period(inertia, rates))}


def free_period(inertia: ArrayLike, rates: ArrayLike) -> float:
    """Period of a free body's rates, J1 < J2 < J3 and h^2 < 2 E J2 (it turns about the first axis); closed form.

    4 K(m)/n, n^2 = (J2 - J1)(2 E J3 - h^2)/(J1 J2 J3), 1 - m = (J3 - J1)(2 E J2 - h^2)/((J2 - J1)(2 E J3 - h^2)).

    Args:
        inertia: Principal moments, increasing, (3,).
        rates: At any time, (3,).
    """
    J, w = np.asarray(inertia, float), np.asarray(rates, float)
    # 2 E J_k - h^2 without cancellation.
    third, second = (np.sum(J * (J[k] - J) * w**2) for k in (2, 1))
    n = np.sqrt((J[1] - J[0]) * third / np.prod(J))
    return float(4 * ellipkm1((J[2] - J[0]) * second / ((J[1] - J[0]) * third)) / n)


def heavy_top(times: ArrayLike, rtol: float = RTOL) -> Answer:
    """C5-heavy-top: m = 15, fixed at O, centre of mass at body (0, 1, 0), fast about that axis; 1e-10 at t = 1.

    Args:
        times: [s].
        rtol: Relative tolerance of the integration.

    Returns:
        As :func:`turning_body`, and centre (n_t, 3); energy counts the potential energy, zero at O's height.
    """
    mass, g, arm = 15.0, GRAVITY, np.array([0.0, 1.0, 0.0])
    inertia = np.array([0.234375, 0.46875, 0.234375]) + mass * (arm @ arm - arm**2)

    def torque(t, rotation):
        return cross(arm, -mass * g * rotation[2])

    found = turning_body(times, inertia, (0.0, 150.0, -4.61538), torque, rtol=rtol)
    centre = found["rotations"] @ arm
    return found | {"centre": centre, "energy": found["energy"] + mass * g * centre[:, 2]}


def shaft(
    speed: float, wave: int = 1, diameter: float = 0.05, length: float = 1.0, E: float = 210e9, rho: float = 7850.0
) -> tuple[float, float]:
    """C4-shaft: whirl of a simply supported spinning Rayleigh shaft in the fixed frame, closed form [rad/s].

    (1 + r^2 k^2) w^2 - 2 speed r^2 k^2 w - (EI/rho A) k^4 = 0, k = wave pi/length, r = diameter/4.

    Args:
        speed: Of the shaft about its axis [rad/s].
        wave: Number of half waves.
        diameter: [m].
        length: [m].
        E: Young's modulus [Pa].
        rho: Density [kg/m^3].

    Returns:
        Forward and backward whirl, both positive.
    """
    r, k = diameter / 4, wave * np.pi / length
    slender, gyroscopic, elastic = 1 + (r * k) ** 2, speed * (r * k) ** 2, E / rho * r**2 * k**4
    root = np.sqrt(gyroscopic**2 + slender * elastic)
    return (root + gyroscopic) / slender, elastic / (root + gyroscopic)


def rotating_beam(eta: float, hub: float = 0.0, modes: int = 3, terms: int = 20) -> Answer:
    """C3-rotating: a cantilever spinning on a hub, inextensible, Euler-Bernoulli, L = EI = rho A = 1; 1e-11.

    int w'' v'' + int T w' v' = omega^2 int w v for all v, T = eta^2 (hub (1 - x) + (1 - x^2)/2); lead-lag loses
    eta^2 int w v. The curvature w'' is a Legendre series, so that the bending stiffness is the identity.

    Args:
        eta: Speed times sqrt(rho A L^4/EI).
        hub: Radius at which the beam is clamped, over L.
        modes: Number wanted.
        terms: Of the series.

    Returns:
        flap, lead_lag: frequencies in the unit of eta.
    """
    nodes, weights = legendre.leggauss(2 * terms + 8)
    x, weights = (nodes + 1) / 2, weights / 2
    slope, deflection = np.zeros((2, terms, x.size))
    for k in range(terms):
        unit = np.sqrt(2 * k + 1) * np.eye(terms)[k]
        once = legendre.legint(unit, lbnd=-1, scl=0.5)
        slope[k], deflection[k] = (legendre.legval(nodes, c) for c in (once, legendre.legint(once, lbnd=-1, scl=0.5)))
    tension = eta**2 * (hub * (1 - x) + (1 - x**2) / 2)
    stiffness = np.eye(terms) + (slope * tension * weights) @ slope.T
    # Inverse eigenvalues: the lowest frequencies are then the well conditioned ones.
    inverse = eigh((deflection * weights) @ deflection.T, stiffness, eigvals_only=True)[::-1][:modes]
    return {"flap": np.sqrt(1 / inverse), "lead_lag": np.sqrt(1 / inverse - eta**2)}
