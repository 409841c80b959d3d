"""Forces and energies of large mechanisms, computed from the deformations of elements to lose little to round-off.

The stiffness of many short beams is a small difference of large entries: the relative round-off grows with the
fourth power of their number along a leaf spring. In deformations it grows with the square.
"""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Inexact

from ..arguments import library_of
from ..compilation.compile import jit
from ..errors import AnalysisError
from ..numerical_limits import FORCE_ROUND_OFF, REFINED, UNREFINED
from ..results import RESULTS
from .element_matrices import ElementMatrices, matrix_times, times_transposed
from .indices import accumulate, put
from .linear import uneven

# Most corrections of a solution by iterative refinement.
MOST_CORRECTIONS = 20


def motions_from_free(elements: ElementMatrices, moving: Any) -> Any:
    """Motions of all coordinates, (n_x, k), from the motions of the free coordinates; all others are zero."""
    zeros = library_of(moving).zeros((elements.sizes.shape[0], moving.shape[1]), moving.dtype)
    return put(zeros, elements.free, moving)


def deformations_of_motions(elements: ElementMatrices, motions: Any) -> Any:
    """Deformations of motions of all coordinates, (n_e, k)."""
    return matrix_times(elements.constraints, motions, size=elements.kept.shape[0])


def forces(elements: ElementMatrices, z: Any, transposed: bool = False, s: Any = None, values: Any = None) -> Any:
    """Product of [[K - mu M, D^T], [D, 0]] and vectors, or of [[K + s C + s^2 M + i L, D^T], [D, 0]], (r, k)."""
    n = elements.unknowns[0]
    return forces_of(elements, motions_from_free(elements, z[:n]), z[n:], transposed, s, values)


def forces_of(
    elements: ElementMatrices, v: Any, multipliers: Any, transposed: bool = False, s: Any = None, values: Any = None
) -> Any:
    """As :func:`forces`, for motions of all coordinates, (n_x, k), also those that do not move by themselves."""
    n_x, product = v.shape[0], times_transposed if transposed else matrix_times
    changed = deformations_of_motions(elements, v)
    n_e = changed.shape[0]
    sigma = accumulate(product(elements.elastic, changed, size=n_e), elements.held, multipliers)
    if s is not None:
        sigma = sigma + s * product(elements.viscous, changed, size=n_e)
    if elements.lossy:
        sigma = sigma + 1j * product(elements.lossy, changed, size=n_e)
    balance = times_transposed(elements.constraints, sigma, size=n_x) + product(elements.curved, v, size=n_x)
    if values is not None:
        balance = balance - matrix_times(elements.mass, v, size=n_x) * values
    if s is not None:
        balance = balance + s**2 * product(elements.mass, v, size=n_x)
    return library_of(balance).concatenate([balance[elements.free], changed[elements.held]])


@jit
def saddle_product(
    elements: ElementMatrices, z: Inexact[Array, "r k"], values: Any = None, s: Any = None
) -> Inexact[Array, "r k"]:
    """As :func:`forces`, compiled."""
    return forces(elements, z, False, s, values)


def bordered_product(
    elements: ElementMatrices, z: Float[Array, "r *k"], border: Float[Array, "n b"], values: Any = None
) -> Array:
    """As :func:`saddle_product`, bordered by motions to which z is orthogonal; z ends with forces along them."""
    (n, h) = elements.unknowns
    balance = saddle_product(elements, z[: n + h], values)
    balance = balance.at[:n].add(border @ z[n + h :])
    return jnp.concatenate([balance, border.T @ z[:n]])


def energies_between(
    elements: ElementMatrices, left: Float[np.ndarray, "n_x k"], right: Float[np.ndarray, "n_x m"]
) -> Float[np.ndarray, "k m"]:
    """Elastic stiffness between motions of all coordinates, one per column."""
    before, behind = deformations_of_motions(elements, left), deformations_of_motions(elements, right)
    work = np.zeros((left.shape[1], right.shape[1]))
    for rows, columns, matrices in elements.elastic:
        work += np.tensordot(before[rows], matrices @ behind[columns], ((0, 1), (0, 1)))
    return work


def energies(elements: ElementMatrices, motions: Float[np.ndarray, "n_x k"]) -> Float[np.ndarray, "k"]:
    """Twice the elastic energy of motions of all coordinates, one per column."""
    changed, twice = deformations_of_motions(elements, motions), np.zeros(motions.shape[1])
    for rows, columns, matrices in elements.elastic:
        twice += np.einsum("eik,eij,ejk->k", changed[rows], matrices, changed[columns])
    return twice


def softness(solve: Callable[[np.ndarray], np.ndarray], sizes: Float[np.ndarray, "n"], rows: int, kind: Any) -> float:
    """Largest motion under uneven forces of size one, in extents and radians."""
    forces, n = np.zeros((rows, 1), kind), len(sizes)
    forces[:n, 0] = uneven(n) / sizes
    return float(np.max(np.abs(solve(forces)[:n, 0]) / sizes, initial=0.0))


def refined_solution(
    product: Callable[[np.ndarray], np.ndarray],
    solve: Callable[[np.ndarray], np.ndarray],
    right: Inexact[np.ndarray, "r k"],
    sizes: Float[np.ndarray, "n"],
    left: float = UNREFINED,
    soft: float | None = None,
) -> Inexact[np.ndarray, "r k"]:
    """Solution of A z = right, refined iteratively (Wilkinson 1963) by a product more accurate than the factors.

    Raises AnalysisError: lost_in_round_off: corrections do not become smaller.
    """
    n = len(sizes)

    def size(z: np.ndarray) -> np.ndarray:
        return np.max(np.abs(z[:n]) / sizes[:, None], axis=0, initial=0.0)

    z = solve(right)
    # Constraints may leave no more of a solution than round-off of the forces.
    soft = softness(solve, sizes, len(right), right.dtype) if soft is None else soft
    still = FORCE_ROUND_OFF * soft * np.max(np.abs(right[:n]) * sizes[:, None], axis=0, initial=0.0)
    before = np.inf
    for _ in range(MOST_CORRECTIONS):
        step = solve(right - product(z))
        change = size(step)
        share = np.max(np.where(change <= still, 0.0, change / np.maximum(size(z), np.finfo(float).tiny)), initial=0.0)
        if not share < before / 2:
            break
        z, before = z + step, share
        if share <= REFINED:
            break
    if not before <= left:
        raise AnalysisError(RESULTS.lost_in_round_off.name, RESULTS.lost_in_round_off.message)
    return z
