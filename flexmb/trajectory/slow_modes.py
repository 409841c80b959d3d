"""A few shapes for the slow vibrations along a motion, with the quasi-static response of all others."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit
from ..linear.spectrum import spectrum
from ..math.linear import factorise
from .varying_equations import cubic_spline

# Number of instants of a motion at which modes are computed.
INSTANTS = 9


class SlowModes(NamedTuple):
    """Shapes of a few vibrations along a motion, and the flexibility of all others.

    Attributes:
        shapes: T, one shape a column.
        rates: Their rates [1/s].
        second_rates: Their second rates [1/s^2].
        rest: Static displacements of all else per force.
    """

    shapes: Float[Array, "n_t n count"]
    rates: Float[Array, "n_t n count"]
    second_rates: Float[Array, "n_t n count"]
    rest: Float[Array, "n_t n n"]


def slow_modes(
    t: Float[Array, "n_t"], mass: Float[Array, "n_t n n"], stiffness: Float[Array, "n_t n n"], count: int
) -> SlowModes:
    """Shapes near the lowest modes that change with time as slowly as the mechanism.

    One set of common shapes approximates the lowest modes at several instants best. At each time the static response
    of all other shapes is added. So modes need no tracking, signs do not matter, and frequencies may cross.
    Derivatives treat the common shapes, modes of the symmetric part of the stiffness, as constant.
    Source: THEORY.md 14, eq. (14.24).
    """
    matrices = jax.lax.stop_gradient((mass, (stiffness + jnp.swapaxes(stiffness, 1, 2)) / 2))
    chosen = np.unique(np.linspace(0, mass.shape[0] - 1, INSTANTS).round().astype(int))
    mode_shapes = jax.lax.map(
        lambda at: spectrum(at[1], at[0])[1][:, :count], tuple(matrix[chosen] for matrix in matrices)
    )
    candidates = jnp.moveaxis(mode_shapes, 0, 1).reshape(mass.shape[1], -1)
    mean = jnp.mean(matrices[0], axis=0)
    weights, vectors = jnp.linalg.eigh(candidates.T @ mean @ candidates)
    common = candidates @ (vectors[:, -count:] / jnp.sqrt(weights[-count:]))[:, ::-1]
    others = jnp.linalg.qr(mean @ common, mode="complete")[0][:, count:]

    def at_one_time(stiffness: Float[Array, "n n"]):
        flexibility = others @ factorise(others.T @ stiffness @ others).solve(others.T)
        return common - flexibility @ stiffness @ common, flexibility

    shapes, flexibility = jax.lax.map(at_one_time, stiffness)
    rates = cubic_spline(t, shapes).slopes
    return SlowModes(shapes, rates, cubic_spline(t, rates).slopes, flexibility)


def projected(
    modes: SlowModes,
    mass: Float[Array, "n_t n n"],
    damping: Float[Array, "n_t n n"],
    stiffness: Float[Array, "n_t n n"],
) -> tuple[Float[Array, "n_t count count"], ...]:
    """Mass, damping and stiffness for amplitudes p, q = T p: T^T M T, T^T (C T + 2 M T_d), T^T (K T + C T_d + M T_dd).

    Source: THEORY.md 14, eq. (14.25).
    """
    first, second, third, _ = modes
    transposed = jnp.swapaxes(first, 1, 2)
    return (
        transposed @ mass @ first,
        transposed @ (damping @ first + 2 * mass @ second),
        transposed @ (stiffness @ first + damping @ second + mass @ third),
    )


def amplitudes(
    modes: SlowModes, mass: Float[Array, "n_t n n"], q: Float[Array, "n"], qd: Float[Array, "n"]
) -> tuple[Float[Array, "count"], Float[Array, "count"]]:
    """First amplitudes and rates that are closest to given displacements and rates in the norm of the mass."""
    shapes = modes.shapes[0]
    momenta = shapes.T @ mass[0]
    factors = factorise(momenta @ shapes)
    p = factors.solve(momenta @ q)
    return p, factors.solve(momenta @ (qd - modes.rates[0] @ p))


@jit
def reduced_system(t: Float[Array, "n_t"], system: tuple[Array, ...], *, modes: int):
    """A linear time-varying system in amplitudes of a few slow modes; THEORY.md 14, eq. (14.24) to (14.26).

    Args:
        system: A, B, C, D and the mass M at all times, and the first state. The first n states are displacements, the
            next n their rates, with n rows of M; further states stay as they are.

    Returns:
        The same for the amplitudes; shapes, (n_t, n, modes); and their stiffness with shapes taken as constant.
    """
    whole_a, whole_b, whole_c, whole_d, mass, z0 = system
    n = mass.shape[1]
    below = slice(n, 2 * n)
    by_q, by_rate = whole_a[:, below, :n], whole_a[:, below, below]
    slow = slow_modes(t, mass, -mass @ by_q, modes)
    shapes = slow.shapes
    reduced_mass, damping, stiffness = projected(slow, mass, -mass @ by_rate, -mass @ by_q)

    def at_one_time(at: tuple[Array, ...]):
        a, b, c, d, mass, reduced_mass, damping, stiffness, shapes, rates, second, flexibility = at
        more = a.shape[0] - 2 * n
        still, beside = jnp.zeros_like(shapes), jnp.zeros((n, more))
        velocity = jnp.concatenate([rates, shapes, beside], axis=1)
        transformation = jax.scipy.linalg.block_diag(jnp.block([[shapes, still], [rates, shapes]]), jnp.eye(more))
        momenta, factors = shapes.T @ mass, factorise(reduced_mass)
        # States are shifted by inputs that move held things.
        pushed = factors.solve(momenta @ jnp.concatenate([a[:n, 2 * n :], b[:n]], axis=1))
        upper = jnp.concatenate([jnp.eye(modes, 2 * modes, k=modes), pushed[:, :more]], axis=1)
        over = pushed[:, more:]
        by_more = momenta @ (a[below, 2 * n :] - rates @ pushed[:, :more])
        lower = factors.solve(jnp.concatenate([-stiffness, -damping, by_more], axis=1))
        drive = factors.solve(momenta @ (b[below] - rates @ over))
        # Quasi-static response of the rest to inputs, damping and inertia of the kept amplitudes.
        acceleration = jnp.concatenate([second, 2 * rates, beside], axis=1) + shapes @ lower
        by_state = flexibility @ (mass @ (a[below, below] @ velocity - acceleration))
        by_input = flexibility @ (mass @ b[below] - mass @ (shapes @ drive))
        return (
            jnp.concatenate([upper, lower, a[2 * n :] @ transformation]),
            jnp.concatenate([over, drive, b[2 * n :]]),
            c @ transformation + c[:, :n] @ by_state,
            d + c[:, :n] @ by_input,
        )

    rows = whole_a, whole_b, whole_c, whole_d, mass, reduced_mass, damping, stiffness, *slow
    parts = jax.lax.map(at_one_time, rows)
    start = jnp.concatenate([*amplitudes(slow, mass, z0[:n], z0[below]), z0[2 * n :]])
    still = jnp.swapaxes(shapes, 1, 2) @ (-mass @ by_q) @ shapes
    return (*parts, reduced_mass, start), shapes, still
