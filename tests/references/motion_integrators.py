"""Integrators of the motion references: Runge-Kutta of order 8, and Gauss's collocation for stiff rods.

Both step to every time asked for, so that no interpolation enters the answer.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import DOP853

RTOL = 1e-13


def runge_kutta(
    rate: Callable, start: ArrayLike, times: ArrayLike, rtol: float = RTOL, atol: float = 1e-15
) -> np.ndarray:
    """States of y' = rate(t, y), y(0) = start, at the times, (n_t, n_y).

    Args:
        rate: Right-hand side.
        start: State at t = 0.
        times: Not decreasing, not negative.
        rtol: Relative tolerance.
        atol: Absolute tolerance.
    """
    t, y, states = 0.0, np.array(start, float), []
    for end in np.atleast_1d(times):
        if end > t:
            solver = DOP853(rate, t, y, end, rtol=rtol, atol=atol)
            while solver.status == "running":
                solver.step()
            if solver.status != "finished":
                raise RuntimeError(f"The integration stopped at t = {solver.t}.")
            t, y = end, solver.y
        states.append(y)
    return np.array(states)


def collocation(stages: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gauss's method: nodes, weights and matrix, exact for polynomials."""
    x, w = np.polynomial.legendre.leggauss(stages)
    c = (x + 1) / 2
    powers = np.arange(1, stages + 1)
    return c, w / 2, (c[:, None] ** powers / powers) @ np.linalg.inv(c[:, None] ** (powers - 1))


def gauss(
    equations: Callable, stiffness: np.ndarray, times: ArrayLike, step: float, kinks: tuple = (), stages: int = 5
) -> np.ndarray:
    """Coordinates and rates of M(t, q, q') q'' = f(t, q, q'), at rest at q = 0 at t = 0, (n_t, 2, n_q).

    Gauss's collocation, of order 2 stages, A-stable and without damping: the step is as long as the motion allows
    and not as the stiffest strain asks. Its equations are solved to rounding by Newton's method with M of the step's
    start and the constant stiffness. Steps end at every time and at every kink of the load.

    Args:
        equations: M and f from t, q, q'.
        stiffness: That of q which f contains, (n_q,).
        times: Increasing, not negative.
        step: Largest.
        kinks: Times at which the equations are not smooth.
        stages: Of a step.
    """
    times = np.atleast_1d(times).astype(float)
    c, b, A = collocation(stages)
    eigenvalues, vectors = np.linalg.eig(A @ A)
    back, powers = np.linalg.inv(vectors), np.arange(stages)
    ahead = (1 + c[:, None]) ** powers @ np.linalg.inv(c[:, None] ** powers)
    q, qd = np.zeros((2, len(stiffness)))
    t, states = 0.0, {0.0: np.stack([q, qd])}
    for end in sorted({*times, *(k for k in kinks if k < times[-1])} - {0.0}):
        steps = int(np.ceil((end - t) / step - 1e-9))
        h = (end - t) / steps
        M, force = equations(t, q, qd)
        a = np.tile(np.linalg.solve(M, force), (stages, 1))
        for t_step in t + h * np.arange(steps):
            M, _ = equations(t_step, q, qd)
            inverse = np.linalg.inv(M + h**2 * eigenvalues[:, None, None] * np.diag(stiffness))
            before = np.inf
            for _ in range(40):
                q_s, qd_s = q + h * c[:, None] * qd + h**2 * A @ (A @ a), qd + h * A @ a
                pairs = [equations(t_step + h * ci, *y) for ci, *y in zip(c, q_s, qd_s, strict=True)]
                residual = np.array([f - m @ ai for (m, f), ai in zip(pairs, a, strict=True)])
                change = (vectors @ (inverse @ (back @ residual)[:, :, None])[:, :, 0]).real
                a = a + change
                size, scale = np.abs(change).max(), np.abs(a).max()
                # What no longer shrinks is rounding, of which accelerations of stiff strains carry much.
                if size <= 1e-13 * scale or before / 2 < size <= 1e-6 * scale:
                    break
                before = size
            else:
                raise RuntimeError(f"Newton's method did not converge at t = {t_step}.")
            q, qd = q + h * qd + h**2 * (b @ A) @ a, qd + h * b @ a
            a = ahead @ a
        t = end
        states[t] = np.stack([q, qd])
    return np.array([states[t] for t in times])
