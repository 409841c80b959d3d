"""A few shapes that hold the slow vibrations along a whole motion, and what follows them at once."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_whole
from ..linear.spectrum import spectrum

# Modes are taken at so many instants of a motion.
INSTANTS = 9


def check_modes(modes: int, most: int) -> int:
    """How many modes are kept, if there are so many."""
    return check_whole("modes", modes, 1, most)


def slow_modes(
    mass: Float[Array, "n_t n n"], stiffness: Float[Array, "n_t n n"], count: int
) -> tuple[Float[Array, "n count"], Float[Array, "n rest"]]:
    """Shapes that come closest to the lowest modes at several instants, and shapes of all other motions.

    They do not change with time, so that amplitudes of modes need no terms for their turning. Derivatives take them as
    given: which shapes are chosen decides on the error that is left, and not on what is converged to.

    Args:
        mass: M, (n_t, n, n).
        stiffness: K, (n_t, n, n); of an unsymmetric one the symmetric part.
        count: How many.

    Returns:
        Shapes, one a column, (n, count), orthonormal in the mean mass; and those of the rest, (n, n - count), which
        have no part in the momentum of the former on average.

    Source:
        THEORY.md 14, eq. (14.24).
    """
    mass, stiffness = jax.lax.stop_gradient((mass, stiffness))
    chosen = np.unique(np.linspace(0, mass.shape[0] - 1, INSTANTS).round().astype(int))
    own = mass[chosen], (stiffness[chosen] + jnp.swapaxes(stiffness[chosen], 1, 2)) / 2
    shapes = jax.lax.map(lambda at: spectrum(at[1], at[0])[1][:, :count], own)
    candidates = jnp.moveaxis(shapes, 0, 1).reshape(mass.shape[1], -1)
    mean = jnp.mean(mass, axis=0)
    weights, vectors = jnp.linalg.eigh(candidates.T @ mean @ candidates)
    kept = candidates @ (vectors[:, -count:] / jnp.sqrt(weights[-count:]))[:, ::-1]
    rest = jnp.linalg.qr(mean @ kept, mode="complete")[0][:, count:]
    return kept, rest
