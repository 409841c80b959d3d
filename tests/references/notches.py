"""Compliance of notch hinges about their axis, in closed form: written apart from flexmb (A13).

Euler-Bernoulli beams, angle between the ends of the notch under a moment. Circular: Paros and Weisbord (1965), Machine
Design 37, 151. Elliptic, the shape of Smith, Badami, Dale and Xu (1997), Review of Scientific Instruments 68, 1474:
with x = along sin(phi) the integral is that of a circle with the half axis across, times along/across. Corner-filleted:
a flat neck between two halves of a circular notch. The papers were not looked up; the formulas agree with quadrature of
12/(E b h^3) over the length to ten digits (`python tests/references/notches.py`).
"""

import numpy as np
from scipy.integrate import quad


def circular(e, width, neck, height, radius):
    """Of a notch with arcs of circles, which need not be half ones.

    Args:
        e: Young's modulus.
        width: Of the bar, along the axis of the hinge.
        neck: Height left in the middle.
        height: Of the bar.
        radius: Of the arcs.
    """
    beta, gamma = neck / (2 * radius), height / (2 * radius)
    square = 2 * beta + beta**2
    sine = np.sqrt(1 - (1 + beta - gamma) ** 2)
    shape = ((1 + beta) / gamma**2 + (3 + 2 * beta + beta**2) / (gamma * square)) * sine
    turn = np.arctan(np.sqrt((2 + beta) / beta) * (gamma - beta) / sine)
    return 3 / (2 * e * width * radius**2 * square) * (shape + 6 * (1 + beta) / square**1.5 * turn)


def elliptic(e, width, neck, height, along, across):
    """Of a notch with arcs of ellipses, with their half axes along the bar and across it."""
    return along / across * circular(e, width, neck, height, across)


def filleted(e, width, neck, flat, radius):
    """Of a flat neck with quarter circles at its ends, up to where they end."""
    return 12 * flat / (e * width * neck**3) + circular(e, width, neck, neck + 2 * radius, radius)


def integrated(e, width, neck, height, along, across):
    """What :func:`elliptic` gives, by quadrature."""
    end = along * np.sqrt(1 - (1 - (height - neck) / (2 * across)) ** 2)

    def bending(x):
        return 12 / (e * width * (neck + 2 * across * (1 - np.sqrt(1 - (x / along) ** 2))) ** 3)

    return quad(bending, -end, end, points=[0.0], epsabs=0, epsrel=1e-12, limit=200)[0]


if __name__ == "__main__":
    for sizes in ((3e-4, 5e-3, 5e-3, 5e-3), (3e-4, 4e-3, 6e-3, 2e-3), (3e-4, 2.3e-3, 1e-3, 1e-3)):
        print(sizes, elliptic(210e9, 0.01, *sizes), integrated(210e9, 0.01, *sizes))
