"""Linear time-varying systems in a few motions that vary slowly, which all others follow."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..compilation.compile import jit
from ..math.linear import factorise
from .slow_modes import amplitudes, projected, slow_modes


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
