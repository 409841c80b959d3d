"""Cantilevers whose rigidities vary along their length, by shooting from the foot: written apart from flexmb (A13).

In space, with the frame R of the section and the forces n and moments m that act on the part before a cut,
    r' = R (1 + N/EA, 0, 0) with N = (R^T n) x,    R' = R hat(R^T m / (GIt, EIy, EIz)),    m' = -r' x n,    n = F
and m = 0 at the tip. The smooth pieces between breaks are integrated one after the other by DOP853 at rtol 1e-12.
"""

import itertools

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root


def hat(v):
    """Matrix of the vector product with v."""
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def tip(rigidities, length, force, breaks=(), steps=8):
    """Position and frame of the tip of a cantilever along x under a dead force.

    Args:
        rigidities: ``f(place)``: EA, GIt, EIy, EIz at a place from 0 to 1.
        length: Of the beam.
        force: At the tip, (3,).
        breaks: Places where the rigidities jump.
        steps: Load steps of the shooting.
    """
    force, ends = np.asarray(force, float), [0.0, *breaks, 1.0]

    def integrated(moment, load):
        state = np.concatenate([np.zeros(3), np.eye(3).ravel(), moment])

        def rate(place, state):
            frame, m = state[3:12].reshape(3, 3), state[12:]
            ea, git, eiy, eiz = rigidities(place)
            along = frame @ np.array([1 + (frame.T @ load)[0] / ea, 0, 0])
            turning = frame @ hat(frame.T @ m / np.array([git, eiy, eiz]))
            return length * np.concatenate([along, turning.ravel(), -np.cross(along, load)])

        for first, last in itertools.pairwise(ends):
            inside = (first + 1e-12, last - 1e-12)
            state = solve_ivp(rate, inside, state, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
        return state

    moment, scale = np.zeros(3), length * np.linalg.norm(force)
    for factor in np.linspace(0, 1, steps + 1)[1:]:
        load = factor * force
        found = root(lambda m, load=load: integrated(m * scale, load)[12:] / scale, moment / scale, tol=1e-13)
        moment = found.x * scale
    state = integrated(moment, force)
    assert np.linalg.norm(state[12:]) < 1e-9 * scale
    return state[:3], state[3:12].reshape(3, 3)


STEEL = {"E": 210e9, "G": 80e9}


def rectangle(width, thickness, torsion):
    """EA, EIy, EIz of a steel rectangle, and GIt by the torsion constant handed over."""
    e, g = STEEL["E"], STEEL["G"]
    return e * width * thickness, g * torsion, e * width * thickness**3 / 12, e * thickness * width**3 / 12


def saint_venant(width, thickness, terms=400):
    """Torsion constant of a rectangle by its series, summed until it stands."""
    w, t = max(width, thickness), min(width, thickness)
    odd = np.arange(1, terms, 2.0)
    total = np.sum(np.tanh(odd * np.pi * w / (2 * t)) / odd**5)
    return w * t**3 * (1 / 3 - 64 / np.pi**5 * t / w * total)


def notch(x, neck, radius):
    """Height of a bar with a circular notch from both sides, at a distance from its middle."""
    return neck + 2 * (radius - np.sqrt(radius**2 - x**2))


WIDTH, LENGTH, BAR = 0.018, 0.1, 0.03
CUT = np.sqrt(2.35e-3 * (10e-3 - 2.35e-3)) / BAR
# What varies: thickness by place, length, breaks, and the forces at the tip along the beam, across width and thickness.
CASES = {
    "taper": (lambda s: 5e-4 - 2e-4 * s, LENGTH, (), (-2.0, 2.5, 4.0)),
    "reinforced": (lambda s: 5e-3 if 0.2 < s < 0.8 else 5e-4, LENGTH, (0.2, 0.8), (-2.0, 6.0, 9.6)),
    "notch": (
        lambda s: notch((s - 0.5) * BAR, 3e-4, 5e-3) if abs(s - 0.5) < CUT else 5e-3,
        BAR,
        (0.5 - CUT, 0.5, 0.5 + CUT),
        (-2.0, 20.0, 32.0),
    ),
}


def solved(case, plane):
    """Tip of a case, (3,), with the force across the width left out in the plane."""
    thickness, length, breaks, force = CASES[case]
    force = np.array(force) * ([1, 0, 1] if plane else [1, 1, 1])

    def numbers(place):
        t = thickness(place)
        return rectangle(WIDTH, t, saint_venant(WIDTH, t, 200))

    return tip(numbers, length, force, breaks)[0]


# What :func:`solved` gives (`python tests/references/varying_rods.py` prints it).
TIPS = {
    ("taper", True): (0.08323114679089, 0.0, 0.04809130461799),
    ("taper", False): (0.08266504288198, 0.002233056639276, 0.04865912505278),
    ("reinforced", True): (0.09153843486121, 0.0, 0.03888026861937),
    ("reinforced", False): (0.09133062719232, 0.0009566926905103, 0.03931146672757),
    ("notch", True): (0.02995169722356, 0.0, 0.001221117161155),
    ("notch", False): (0.02995164604592, 1.764182977426e-06, 0.001221754113196),
}


if __name__ == "__main__":
    for case in CASES:
        for plane in (True, False):
            print((case, plane), [float(f"{x:.13g}") for x in solved(case, plane)])
