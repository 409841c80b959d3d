"""Balances that any motion keeps: energy, linear and angular momentum; from positions, velocities and accelerations."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
from numpy.polynomial import legendre
from numpy.typing import ArrayLike

import flexmb as fm
from flexmb.mechanics.inertia import mass_matrix, uniform_motion


class Panels:
    """Times with a Gauss rule of five points between any two of those wanted, to integrate along a motion.

    Args:
        wanted: Ascending, the first is the start [s].
    """

    def __init__(self, wanted: ArrayLike):
        ends = np.asarray(wanted, float)
        nodes, weights = legendre.leggauss(5)
        halves = np.diff(ends)[:, None] / 2
        inner = ends[:-1, None] + halves * (1 + nodes)
        self.weights = halves * weights
        self.times = np.append(np.column_stack([ends[:-1], inner]).ravel(), ends[-1])
        self.wanted = np.arange(len(ends)) * 6

    def integral(self, values: ArrayLike) -> np.ndarray:
        """From the start to each wanted time.

        Args:
            values: At all times, (n_t, ...).
        """
        inner = np.asarray(values)[:-1].reshape(*self.weights.shape[:1], 6, *np.shape(values)[1:])[:, 1:]
        panels = np.einsum("ij,ij...->i...", self.weights, inner)
        return np.concatenate([np.zeros((1, *panels.shape[1:])), np.cumsum(panels, axis=0)])


def energy_rate(motion: fm.motion.Motion, step: float) -> np.ndarray:
    """Derivative of the whole energy along a motion, by differences of order four, (n_t,) [W].

    Args:
        motion: Motion.
        step: Of the differences [s].
    """
    a = motion.observe().xdd

    def energy(h):
        moved = dict(t=motion.t + h, x=motion.x + h * motion.xd + h**2 / 2 * a, xd=motion.xd + h * a)
        return np.asarray(dataclasses.replace(motion, **moved).observe().energy)

    near, far = ((energy(k * step) - energy(-k * step)) / (2 * k * step) for k in (1, 2))
    return (4 * near - far) / 3


def _rigid_motions(model: fm.Model):
    """Nodal velocities of the mechanism moved as one body about the origin: constant part, and part linear in x."""
    n, labels = model.topology.n_x, model.labels
    axes = np.asarray(model.topology.axes)
    space = labels.dimension == 3
    k = 6 if space else 3
    constant, linear = np.zeros((n, k)), np.zeros((n, k, n))
    for i in range(labels.dimension):
        constant[axes[i], i] = 1.0
    for turn, (i, j) in enumerate([(1, 2), (2, 0), (0, 1)] if space else [(0, 1)]):
        linear[axes[j], labels.dimension + turn, axes[i]] = 1.0
        linear[axes[i], labels.dimension + turn, axes[j]] = -1.0
    rotations = [i for i, entry in enumerate(labels.x) if entry.kind == "rotation" and entry.component == 1]
    for i in rotations:
        if not space:
            constant[i, 2] = 1.0
            continue
        # l' = (0, w) l / 2, quaternions with the scalar first.
        for turn, (a, b) in enumerate([(2, 3), (3, 1), (1, 2)]):
            own, column = turn + 1, 3 + turn
            for row, of, sign in ((0, own, -1.0), (own, 0, 1.0), (a, b, -1.0), (b, a, 1.0)):
                linear[i + row, column, i + of] = sign / 2
    return jnp.asarray(constant), jnp.asarray(linear)


@jax.jit
def _momenta(model: fm.Model, constant, linear, states):
    topology, parameters = model.topology, model.parameters

    def one(state):
        x, v, a, force = state

        def momentum(x, v):
            return (constant + linear @ x).T @ (mass_matrix(topology, parameters, x) @ v)

        value, rate = jax.jvp(momentum, (x, v), (v, a))
        rigid = constant + linear @ x
        if parameters.loads.gravity is not None:
            falling = uniform_motion(topology, parameters.loads.gravity)
            force = force + mass_matrix(topology, parameters, x) @ falling
        return value, rate, rigid.T @ force

    return jax.lax.map(one, states)


@dataclasses.dataclass(frozen=True)
class Momenta:
    """Linear and angular momentum about the origin; last axis: x, y, moment in the plane; x, y, z, moments in space.

    Attributes:
        value: (n_t, 3 or 6) [N s, N m s].
        rate: Derivative by time, from the accelerations [N, N m].
        force: Of reactions and gravity [N, N m].
    """

    value: np.ndarray
    rate: np.ndarray
    force: np.ndarray


def momenta(motion: fm.motion.Motion) -> Momenta:
    """Momenta of a mechanism at every time of its motion.

    Args:
        motion: Motion.
    """
    seen = motion.observe()
    states = (motion.x, motion.xd, seen.xdd, seen.reactions)
    return Momenta(*(np.asarray(a) for a in _momenta(motion.model, *_rigid_motions(motion.model), states)))


def check_balances(
    motion: fm.motion.Motion,
    panels: Panels,
    *,
    step: float,
    differences: float,
    integrated: float,
    applied: ArrayLike | None = None,
):
    """Energy changes by the power, momenta by reactions, gravity and loads: at every time, and integrated.

    The rates hold at any state, whatever the integration; the integrals are those of the motion that was found.

    Args:
        motion: Motion at the times of the panels.
        panels: Times.
        step: Of the differences of energy [s].
        differences: Error of these differences, as share of the greatest power of reactions and inertia.
        integrated: Error of integration and panels, as share of the greatest momentum and energy.
        applied: Forces and moments about the origin by loads, (n_t, 3 or 6) [N, N m].
    """
    seen, found = motion.observe(), momenta(motion)
    flow = np.abs(np.asarray(seen.xdd * motion.xd)).max() + np.abs(seen.power).max()
    np.testing.assert_allclose(energy_rate(motion, step), seen.power, atol=differences * flow)
    force = found.force if applied is None else found.force + np.asarray(applied)
    # Round-off: forces that are in balance, of many coordinates; a free body has none.
    least = np.abs(found.value).max() / (panels.times[-1] - panels.times[0])
    np.testing.assert_allclose(found.rate, force, atol=1e-12 * max(np.abs(force).max(), least))
    for value, rate in ((np.asarray(seen.energy), seen.power), (found.value, force)):
        change = value[panels.wanted] - value[0]
        size = max(np.abs(value).max(), np.abs(seen.kinetic).max() if value.ndim == 1 else 0.0)
        np.testing.assert_allclose(change, panels.integral(rate), atol=integrated * size)
