"""Compliance of rigid bodies on prismatic beams, small displacements, by the tip compliances of a cantilever alone.

Shares nothing with the package. Shear: a force F on the tip moves it by F L/(GA k) more.
"""

from typing import NamedTuple

import numpy as np


class Bar(NamedTuple):
    """A beam between points of two bodies, each by name and place; body "base" is held."""

    first: str
    p: tuple[float, ...]
    last: str
    q: tuple[float, ...]


class Numbers(NamedTuple):
    """Rigidities [N, N m^2] and shear rigidities [N], with y along the width and z across the thickness."""

    EA: float
    GIt: float
    EIy: float
    EIz: float
    GAy: float
    GAz: float


def tip(length: float, s: Numbers) -> np.ndarray:
    """Displacement and rotation of a cantilever's tip by force and moment on it, (6, 6), x along the beam."""
    found = np.zeros((6, 6))
    found[0, 0], found[3, 3] = length / s.EA, length / s.GIt
    for across, about, sign, ei, ga in ((1, 5, 1, s.EIz, s.GAy), (2, 4, -1, s.EIy, s.GAz)):
        found[across, across] = length**3 / (3 * ei) + length / ga
        found[about, about] = length / ei
        found[across, about] = found[about, across] = sign * length**2 / (2 * ei)
    return found


def carried(lever: np.ndarray) -> np.ndarray:
    """Motion of a point of a body from that of its node, (6, 6)."""
    x, y, z = lever
    found = np.eye(6)
    found[:3, 3:] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
    return found


def compliance(
    bars: list[Bar], places: dict[str, tuple[float, ...]], section: Numbers, width: np.ndarray
) -> np.ndarray:
    """Compliance of the body "stage" at its place, (6, 6) [m/N, rad/N, m/(N m), rad/(N m)].

    Args:
        bars: Beams.
        places: Of the nodes of the bodies but for "base" [m].
        section: Of all beams.
        width: Direction of their local y, (3,).
    """
    names = [*places]
    stiffness = np.zeros((6 * len(names), 6 * len(names)))
    for bar in bars:
        p, q = np.array(bar.p), np.array(bar.q)
        length = np.linalg.norm(q - p)
        x = (q - p) / length
        axes = np.kron(np.eye(2), np.stack([x, width, np.cross(x, width)]))
        # How the tip moves from where the body of the foot would carry it.
        own = np.zeros((6, 6 * len(names)))
        for body, sign in ((bar.first, -1), (bar.last, 1)):
            if body != "base":
                i = 6 * names.index(body)
                own[:, i : i + 6] += sign * axes @ carried(q - places[body])
        stiffness += own.T @ np.linalg.inv(tip(length, section)) @ own
    i = 6 * names.index("stage")
    return np.linalg.inv(stiffness)[i : i + 6, i : i + 6]
