"""Shooting: Newton, load control, arc length, limit points and critical loads of a `problem`, which has

    residual(z) (size, k) -> (size - 1, k),  scale (size,),  start (size,)

where z holds the unknown start values and, last, the load factor, in columns; `scale` is what one unit of each entry is
and `start` the unloaded state. Derivatives are by complex step, exact to rounding: a residual is written once and must
be analytic (no abs, no conjugate).
"""

from math import inf

import numpy as np
from scipy.optimize import brentq

STEP = 1e-30


class NotConverged(Exception):
    """No equilibrium was found."""


def jacobian(function, z, scale):
    """Value (n,) and derivative (n, size) of a column function at z, by complex step."""
    value = function(z[:, None] + 1j * STEP * np.diag(scale))
    return value[:, 0].real, value.imag / (STEP * scale)


def correct(problem, z, direction):
    """Newton from z within the plane `direction` . (z/scale) = const; z and the scaled Jacobian (size - 1, size).

    Ends when steps are below 1e-11, or below 1e-6 and no longer shrinking (rounding, times axial over bending
    stiffness).
    """
    scale, last = problem.scale, inf
    goal = direction @ (z / scale)
    for _ in range(20):
        with np.errstate(over="ignore", invalid="ignore"):
            value, slope = jacobian(problem.residual, z, scale)
        rows = np.vstack([slope * scale, direction])
        weight = 1 / np.abs(rows).max(1)
        step = np.linalg.solve(rows * weight[:, None], weight * np.r_[value, direction @ (z / scale) - goal])
        z, size = z - scale * step, np.abs(step).max()
        if not np.isfinite(size) or size > 1e4:
            break
        if size < 1e-11 or (size < 1e-6 and size > 0.3 * last):
            return z, slope * scale
        last = size
    raise NotConverged("no equilibrium here")


def solve(problem, factor=1.0, start=None, steps=4):
    """Equilibrium at a load factor, followed from `start` (unloaded) in steps, halved where Newton fails."""
    z = problem.start if start is None else start
    axis = np.eye(z.size)[-1]
    step, ahead, slope = (factor - z[-1]) / steps, factor - z[-1], None
    while abs(ahead) > 1e-14 * abs(factor) or slope is None:
        step = np.sign(ahead) * min(abs(step), abs(ahead))
        guess = z + axis * step if slope is None else z + slope * step
        guess[-1] = factor if step == ahead else guess[-1]
        try:
            new, _ = correct(problem, guess, axis)
        except (NotConverged, np.linalg.LinAlgError):
            step /= 2
            if abs(step) < 1e-4 * abs(factor):
                raise
            continue
        new[-1] = guess[-1]
        slope = (new - z) / step if step else 0 * z
        z, ahead, step = new, factor - new[-1], step * 1.5
    return z


def tangent(problem, z, before):
    """Direction of the path at z, in scaled entries, of unit length and along `before`."""
    _, slope = jacobian(problem.residual, z, problem.scale)
    t = np.linalg.svd(slope * problem.scale)[2][-1]
    return t * (np.sign(t @ before) or 1.0)


def trace(problem, start, first, until, step=0.1, largest=0.5, limit=400):
    """Path by arc length in scaled entries from `start` towards `first`: lists of z and of tangents."""
    zs, ts = [start], [tangent(problem, start, first)]
    while not until(zs[-1]) and len(zs) < limit:
        try:
            z, _ = correct(problem, zs[-1] + problem.scale * step * ts[-1], ts[-1])
            t = tangent(problem, z, ts[-1])
            if t @ ts[-1] < 0.95:  # a sharp bend: the step might skip to another branch
                raise NotConverged
        except (NotConverged, np.linalg.LinAlgError):
            step /= 2
            if step < 1e-7:
                raise
            continue
        zs, ts, step = [*zs, z], [*ts, t], min(1.3 * step, largest)
    return zs, ts


def turning_points(problem, zs, ts, output=None):
    """States on a traced path where an output is extreme (by default the load factor); output(z) by columns, (1, k)."""

    def rate(z, t):
        if output is None:
            return t[-1]
        return (jacobian(output, z, problem.scale)[1] @ (problem.scale * t)).item()

    found, rates = [], [rate(z, t) for z, t in zip(zs, ts, strict=True)]
    for i in range(len(zs) - 1):
        if rates[i] * rates[i + 1] < 0:

            def at(length, z=zs[i], t=ts[i]):
                return correct(problem, z + problem.scale * length * t, t)[0]

            far = ts[i] @ ((zs[i + 1] - zs[i]) / problem.scale)
            length = brentq(lambda d, t=ts[i]: rate(at(d), tangent(problem, at(d), t)), 0, far, xtol=1e-11)
            found.append(at(length))
    return found


def critical_factor(problem, step, free=None, most=100):
    """First load factor where the Jacobian of the start values, or its block `free`, is singular; sought in steps."""
    free = range(problem.scale.size - 1) if free is None else free
    z = solve(problem, step, steps=1)

    def block(z):
        slope = jacobian(problem.residual, z, problem.scale)[1] * problem.scale
        return np.linalg.det(slope[np.ix_(free, free)] / problem.scale[free, None])

    for _ in range(most):
        z, before = solve(problem, z[-1] + step, z, 1), z
        if block(z) * block(before) < 0:
            return brentq(lambda f: block(solve(problem, f, before, 1)), before[-1], z[-1], rtol=1e-12)  # noqa: B023
    raise NotConverged("no singular state found")
