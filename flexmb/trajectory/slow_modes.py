"""A few shapes that hold the slow vibrations along a whole motion, and what follows them at once."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_whole
from ..compilation.compile import jit
from ..linear.spectrum import spectrum
from ..math.linear import factorise
from .cubic import spline

# Modes are taken at so many instants of a motion.
INSTANTS = 9


def check_modes(modes: int, most: int) -> int:
    """How many modes are kept, if there are so many."""
    return check_whole("modes", modes, 1, most)


class SlowModes(NamedTuple):
    """Shapes of a few motions along a motion, how they change with time, and what is flexible beside them.

    Attributes:
        shapes: T, one shape a column, (n_t, n, count).
        rates: Its rate, (n_t, n, count) [1/s].
        second_rates: Its second rate, (n_t, n, count) [1/s^2].
        rest: Displacements of all else by forces, at rest, (n_t, n, n).
    """

    shapes: Float[Array, "n_t n count"]
    rates: Float[Array, "n_t n count"]
    second_rates: Float[Array, "n_t n count"]
    rest: Float[Array, "n_t n n"]


def slow_modes(
    t: Float[Array, "n_t"], mass: Float[Array, "n_t n n"], stiffness: Float[Array, "n_t n n"], count: int
) -> SlowModes:
    """Shapes close to the lowest modes, that change with time as slowly as the mechanism does.

    A set of shapes is common to all times: those that have most in common with the lowest modes at several instants. To
    them the rest adds at each time what it does at rest. So no mode has to be told from its neighbour, or its sign from
    the opposite, and frequencies may cross. Derivatives take the common shapes as given.
    Source: THEORY.md 14, eq. (14.24).

    Args:
        stiffness: K, (n_t, n, n); the common shapes are taken of the symmetric part.
    """
    own = jax.lax.stop_gradient((mass, (stiffness + jnp.swapaxes(stiffness, 1, 2)) / 2))
    chosen = np.unique(np.linspace(0, mass.shape[0] - 1, INSTANTS).round().astype(int))
    found = jax.lax.map(lambda at: spectrum(at[1], at[0])[1][:, :count], tuple(of[chosen] for of in own))
    candidates = jnp.moveaxis(found, 0, 1).reshape(mass.shape[1], -1)
    mean = jnp.mean(own[0], axis=0)
    weights, vectors = jnp.linalg.eigh(candidates.T @ mean @ candidates)
    common = candidates @ (vectors[:, -count:] / jnp.sqrt(weights[-count:]))[:, ::-1]
    others = jnp.linalg.qr(mean @ common, mode="complete")[0][:, count:]

    def one(stiffness: Float[Array, "n n"]):
        rest = others @ factorise(others.T @ stiffness @ others).solve(others.T)
        return common - rest @ stiffness @ common, rest

    shapes, rest = jax.lax.map(one, stiffness)
    rates = spline(t, shapes).slopes
    return SlowModes(shapes, rates, spline(t, rates).slopes, rest)


def projected(
    modes: SlowModes,
    mass: Float[Array, "n_t n n"],
    damping: Float[Array, "n_t n n"],
    stiffness: Float[Array, "n_t n n"],
) -> tuple[Float[Array, "n_t count count"], ...]:
    """Mass, damping and stiffness of the amplitudes p of q = T p.

    Returns T^T M T, T^T (C T + 2 M T_d) and T^T (K T + C T_d + M T_dd), (n_t, count, count) each. Source: THEORY.md 14,
    eq. (14.25).
    """
    first, second, third, _ = modes
    left = jnp.swapaxes(first, 1, 2)
    return (
        left @ mass @ first,
        left @ (damping @ first + 2 * mass @ second),
        left @ (stiffness @ first + damping @ second + mass @ third),
    )


def amplitudes(
    modes: SlowModes, mass: Float[Array, "n_t n n"], q: Float[Array, "n"], qd: Float[Array, "n"]
) -> tuple[Float[Array, "count"], Float[Array, "count"]]:
    """First amplitudes and their rates that come closest to given displacements in the norm of the mass."""
    shapes = modes.shapes[0]
    momenta = shapes.T @ mass[0]
    factors = factorise(momenta @ shapes)
    p = factors.solve(momenta @ q)
    return p, factors.solve(momenta @ (qd - modes.rates[0] @ p))


@jit
def reduced_system(t: Float[Array, "n_t"], system: tuple[Array, ...], *, modes: int):
    """A linear time-varying system in the amplitudes of a few motions, and their rates.

    Source: THEORY.md 14, eq. (14.24) to (14.26).

    Args:
        system: A, B, C, D and the mass M with the times in front, and the state at the first time. The first n states
            are displacements, the next n their rates, with n rows of M; others stay as they are.

    Returns:
        The same of the amplitudes; shapes, (n_t, n, modes); and their stiffness as if shapes stayed as they are in each
        moment, (n_t, modes, modes).
    """
    whole_a, whole_b, whole_c, whole_d, mass, z0 = system
    n = mass.shape[1]
    below = slice(n, 2 * n)
    by_q, by_rate = whole_a[:, below, :n], whole_a[:, below, below]
    slow = slow_modes(t, mass, -mass @ by_q, modes)
    shapes = slow.shapes
    own, damping, stiffness = projected(slow, mass, -mass @ by_rate, -mass @ by_q)

    def one(
        a: Float[Array, "z z"],
        b: Float[Array, "z n_u"],
        c: Float[Array, "n_y z"],
        d: Float[Array, "n_y n_u"],
        mass: Float[Array, "n n"],
        own: Float[Array, "modes modes"],
        damping: Float[Array, "modes modes"],
        stiffness: Float[Array, "modes modes"],
        shapes: Float[Array, "n modes"],
        rates: Float[Array, "n modes"],
        second: Float[Array, "n modes"],
        rest: Float[Array, "n n"],
    ):
        more = a.shape[0] - 2 * n
        still, beside = jnp.zeros_like(shapes), jnp.zeros((n, more))
        velocity = jnp.concatenate([rates, shapes, beside], axis=1)
        whole = jax.scipy.linalg.block_diag(jnp.block([[shapes, still], [rates, shapes]]), jnp.eye(more))
        momenta, force = shapes.T @ mass, mass @ b[below]
        factors = factorise(own)
        # Where inputs move what is held, states are shifted by them.
        pushed = jnp.concatenate([a[:n, 2 * n :], b[:n]], axis=1)
        pushed = factors.solve(momenta @ pushed)
        upper = jnp.eye(modes, 2 * modes, k=modes)
        upper, over = jnp.concatenate([upper, pushed[:, :more]], axis=1), pushed[:, more:]
        forces = jnp.concatenate(
            [-stiffness, -damping, momenta @ (a[below, 2 * n :] - rates @ pushed[:, :more])], axis=1
        )
        lower, drive = factors.solve(forces), factors.solve(momenta @ (b[below] - rates @ over))
        # What is left out, at rest under inputs, damping and inertia of what is kept.
        acceleration = jnp.concatenate([second, 2 * rates, beside], axis=1) + shapes @ lower
        by_state = rest @ (mass @ (a[below, below] @ velocity - acceleration))
        by_input = rest @ (force - mass @ (shapes @ drive))
        seen = c[:, :n]
        return (
            jnp.concatenate([upper, lower, a[2 * n :] @ whole]),
            jnp.concatenate([over, drive, b[2 * n :]]),
            c @ whole + seen @ by_state,
            d + seen @ by_input,
        )

    given = whole_a, whole_b, whole_c, whole_d, mass, own, damping, stiffness, *slow
    parts = jax.lax.map(lambda of: one(*of), given)
    start = jnp.concatenate([*amplitudes(slow, mass, z0[:n], z0[below]), z0[2 * n :]])
    still = jnp.swapaxes(shapes, 1, 2) @ (-mass @ by_q) @ shapes
    return (*parts, own, start), shapes, still
