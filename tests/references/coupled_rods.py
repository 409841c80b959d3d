"""Cantilevers with a full stiffness matrix of their section and an offset mass: written apart from flexmb (A15).

In space, with the frame R of the section and the force n and moment m that act on the part before a cut,
    C^-1 (R^T n, R^T m) = (eps, gamma_y, gamma_z, kappa),   r' = R (1 + eps, gamma_y, gamma_z),   R' = R hat(kappa),
    n' = -q,   m' = -r' x n - R c x q,   with q the weight per length, which acts at c = (0, y, z) of the section.
"""

import numpy as np
from numpy.polynomial import Polynomial
from references.varying_rods import hat
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import root


def equilibrium(stiffness, length, force, weight=(0, 0, 0), center=(0, 0), steps=8):
    """Position and frame of the tip under a dead force, and force and moment at the root in its axes.

    Args:
        stiffness: (6, 6), or (4, 4) without shears.
        length: Of the beam along x.
        force: At the tip, (3,).
        weight: Per length, (3,).
        center: Place of the weight in the section, (2,).
        steps: Load steps of the shooting.
    """
    rows = np.arange(6) if len(stiffness) == 6 else np.array([0, 3, 4, 5])
    compliance = np.zeros((6, 6))
    compliance[np.ix_(rows, rows)] = np.linalg.inv(stiffness)
    force, weight, c = np.asarray(force, float), np.asarray(weight, float), np.array([0.0, *center])

    def integrated(moment, factor):
        def rate(s, state):
            frame, m = state[3:12].reshape(3, 3), state[12:]
            n, q = factor * (force + (length - s) * weight), factor * weight
            strains = compliance @ np.concatenate([frame.T @ n, frame.T @ m])
            along = frame @ (strains[:3] + np.eye(3)[0])
            turned = frame @ hat(strains[3:])
            return np.concatenate([along, turned.ravel(), -np.cross(along, n) - np.cross(frame @ c, q)])

        start = np.concatenate([np.zeros(3), np.eye(3).ravel(), moment])
        return solve_ivp(rate, (0, length), start, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]

    scale, moment = length * np.linalg.norm(force + length * weight), np.zeros(3)
    for factor in np.linspace(0, 1, steps + 1)[1:]:
        found = root(lambda m, factor=factor: integrated(m * scale, factor)[12:] / scale, moment / scale, tol=1e-13)
        moment = found.x * scale
    state = integrated(moment, 1.0)
    assert np.linalg.norm(state[12:]) < 1e-9 * scale
    return state[:3], state[3:12].reshape(3, 3), np.concatenate([force + length * weight, moment])


def small_compliance(stiffness, length):
    """Displacement and rotation of the tip of a cantilever by a small force and moment there, (6, 6)."""
    compliance, (places, weights) = np.linalg.inv(stiffness), np.polynomial.legendre.leggauss(6)
    found = np.zeros((6, 6))
    for place, weight in zip((places + 1) / 2 * length, weights / 2 * length, strict=True):
        carried = np.eye(6)
        carried[3:, :3] = hat(np.array([length - place, 0, 0]))
        found += weight * carried.T @ compliance @ carried
    return found


def frequencies(stiffness, length, mass, center, inertia, terms=12):
    """Angular frequencies of a cantilever without shear, by Ritz with polynomials.

    Args:
        stiffness: (4, 4).
        length: Of the beam along x.
        mass: Per length.
        center: Place of the centre of mass, (2,).
        inertia: Jx, Jy, Jz, Jyz per length about it.
        terms: Polynomials for each of u, v, w and the twist.
    """
    (y, z), (jx, jy, jz, jyz) = center, inertia
    places, weights = np.polynomial.legendre.leggauss(terms + 6)
    x, weights = (places + 1) / 2, weights / 2 * length

    def values(lowest, derivative):
        own = [Polynomial([0] * lowest + [1]) * Polynomial.fromroots([0.5]) ** k for k in range(terms)]
        return np.array([(one.deriv(derivative) if derivative else one)(x) for one in own]) / length**derivative

    # Values of u, v, w, twist and their derivatives, of all coefficients: (derivative, field, coefficient, place).
    fields = np.zeros((3, 4, 4 * terms, len(x)))
    for field, lowest in enumerate((1, 2, 2, 1)):
        for derivative in range(3):
            fields[derivative, field, field * terms : (field + 1) * terms] = values(lowest, derivative)
    (u, v, w, twist), (du, dv, dw, dtwist), (_, ddv, ddw, _) = fields
    strains = np.array([du, dtwist, -ddw, ddv])
    moved = np.array([u - z * dw - y * dv, v - z * twist, w + y * twist])
    turned = np.array([twist, -dw, dv])
    tensor = np.array([[jx, 0, 0], [0, jy, jyz], [0, jyz, jz]])
    k = np.einsum("iap,ij,jbp,p->ab", strains, stiffness, strains, weights)
    m = np.einsum("iap,ibp,p->ab", moved, moved, mass * weights)
    m += np.einsum("iap,ij,jbp,p->ab", turned, tensor, turned, weights)
    return np.sqrt(eigh(k, m, eigvals_only=True))
