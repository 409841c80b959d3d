"""Forces and energies of large mechanisms by the deformations of their elements, which lose little to round-off.

Of many short beams the stiffness of the whole is a small difference of large entries: round-off is a share of the
fourth power of their number along a leaf spring. Deformations are differences of motions, and lose the square.
"""

from collections.abc import Callable
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Inexact

from ..arguments import library_of
from ..compilation.compile import jit
from ..errors import AnalysisError
from ..results import RESULTS
from .element_matrices import ElementMatrices, times, times_transposed
from .indices import put
from .linear import uneven

# A correction that is so small a share of the solution ends its refinement; one that no longer falls by half, and is
# larger than LEFT, is refused.
DONE, LEFT = 1e-13, 1e-6
# So many are made.
MOST_CORRECTIONS = 20
# Round-off of forces, as share of the largest.
NOISE = 10 * float(np.finfo(float).eps)


def spread(elements: ElementMatrices, moving: Any) -> Any:
    """Motions of all coordinates of those that move; what is held stays. Returns (n_x, k)."""
    whole = library_of(moving).zeros((elements.sizes.shape[0], moving.shape[1]), moving.dtype)
    return put(whole, elements.free, moving)


@jit
def product(
    elements: ElementMatrices, z: Inexact[Array, "r k"], values: Any = None, s: Any = None
) -> Inexact[Array, "r k"]:
    """Product of [[K - mu M, D^T], [D, 0]] and vectors, or of [[K + s C + s^2 M + i L, D^T], [D, 0]]."""
    n_x, (n, _), n_e = elements.sizes.shape[0], elements.unknowns, elements.kept.shape[0]
    v = spread(elements, z[:n])
    changed = times(elements.constraints, v, size=n_e)
    sigma = times(elements.elastic, changed, size=n_e) + put(jnp.zeros_like(changed), elements.held, z[n:])
    if s is not None:
        sigma = sigma + s * times(elements.viscous, changed, size=n_e)
    if elements.lossy:
        sigma = sigma + 1j * times(elements.lossy, changed, size=n_e)
    found = times_transposed(elements.constraints, sigma, size=n_x) + times(elements.curved, v, size=n_x)
    if values is not None:
        found = found - times(elements.mass, v, size=n_x) * values
    if s is not None:
        found = found + s**2 * times(elements.mass, v, size=n_x)
    return jnp.concatenate([found[elements.free], changed[elements.held]])


def bordered(
    elements: ElementMatrices, z: Float[Array, "r *k"], border: Float[Array, "n b"], values: Any = None
) -> Array:
    """As :func:`product`, with motions to which the solution is to be orthogonal and the forces along them.

    Args:
        z: Motions, multipliers and sizes of these forces, one a column, (n + h + b, k).
    """
    (n, h) = elements.unknowns
    balance = product(elements, z[: n + h], values)
    balance = balance.at[:n].add(border @ z[n + h :])
    return jnp.concatenate([balance, border.T @ z[:n]])


def deformed(elements: ElementMatrices, motions: Inexact[np.ndarray, "n_x k"]) -> Inexact[np.ndarray, "n_e k"]:
    """Deformations of motions of all coordinates, on the host."""
    found = np.zeros((len(elements.kept), motions.shape[1]), motions.dtype)
    for at, columns, own in elements.constraints:
        found[at] = own @ motions[columns]
    return found


def pulled(elements: ElementMatrices, sigma: Inexact[np.ndarray, "n_e k"]) -> Inexact[np.ndarray, "n_x k"]:
    """Forces on all coordinates of stress resultants, on the host."""
    return times_transposed(elements.constraints, sigma, size=len(elements.sizes))


def forces(
    elements: ElementMatrices, z: Inexact[np.ndarray, "r k"], transposed: bool = False, s: complex | None = None
) -> Inexact[np.ndarray, "r k"]:
    """As :func:`product`, on the host."""
    n = elements.unknowns[0]
    v = np.zeros((len(elements.sizes), z.shape[1]), z.dtype)
    v[elements.free] = z[:n]
    return forces_of(elements, v, z[n:], transposed, s)


def forces_of(
    elements: ElementMatrices,
    v: Inexact[np.ndarray, "n_x k"],
    multipliers: Inexact[np.ndarray, "h k"] | float = 0.0,
    transposed: bool = False,
    s: complex | None = None,
) -> Inexact[np.ndarray, "r k"]:
    """As :func:`forces`, of motions of all coordinates, also of those that do not move by themselves."""
    n_x, n_e = len(elements.sizes), len(elements.kept)
    changed, product = deformed(elements, v), times_transposed if transposed else times
    sigma = product(elements.elastic, changed, size=n_e)
    sigma[elements.held] += multipliers
    if s is not None:
        sigma = sigma + s * product(elements.viscous, changed, size=n_e)
    if elements.lossy:
        sigma = sigma + 1j * product(elements.lossy, changed, size=n_e)
    found = pulled(elements, sigma) + product(elements.curved, v, size=n_x)
    if s is not None:
        found = found + s**2 * product(elements.mass, v, size=n_x)
    return np.concatenate([found[elements.free], changed[elements.held]])


def energies_between(
    elements: ElementMatrices, left: Float[np.ndarray, "n_x k"], right: Float[np.ndarray, "n_x m"]
) -> Float[np.ndarray, "k m"]:
    """Elastic stiffness between motions of all coordinates, one a column."""
    before, behind = deformed(elements, left), deformed(elements, right)
    found = np.zeros((left.shape[1], right.shape[1]))
    for at, by, own in elements.elastic:
        found += np.tensordot(before[at], own @ behind[by], ((0, 1), (0, 1)))
    return found


def energies(elements: ElementMatrices, motions: Float[np.ndarray, "n_x k"]) -> Float[np.ndarray, "k"]:
    """Twice the elastic energy of motions of all coordinates, one a column."""
    changed, found = deformed(elements, motions), np.zeros(motions.shape[1])
    for at, by, own in elements.elastic:
        found += np.einsum("eik,eij,ejk->k", changed[at], own, changed[by])
    return found


def softness(solve: Callable[[np.ndarray], np.ndarray], sizes: Float[np.ndarray, "n"], rows: int, kind: Any) -> float:
    """How far uneven forces of about one move, both in extents and radians."""
    forces, n = np.zeros((rows, 1), kind), len(sizes)
    forces[:n, 0] = uneven(n) / sizes
    return float(np.max(np.abs(solve(forces)[:n, 0]) / sizes, initial=0.0))


def refined(
    product: Callable[[np.ndarray], np.ndarray],
    solve: Callable[[np.ndarray], np.ndarray],
    right: Inexact[np.ndarray, "r k"],
    sizes: Float[np.ndarray, "n"],
    left: float = LEFT,
    soft: float | None = None,
) -> Inexact[np.ndarray, "r k"]:
    """Solution of A z = right, corrected until it is that of a product which is less spoilt than the factors.

    Raises AnalysisError: lost_in_round_off: corrections do not become smaller. Source: Iterative refinement (Wilkinson
    1963).
    """
    n = len(sizes)

    def size(z: np.ndarray) -> np.ndarray:
        return np.max(np.abs(z[:n]) / sizes[:, None], axis=0, initial=0.0)

    z = solve(right)
    # What round-off of the forces moves: constraints may leave no more of a solution.
    soft = softness(solve, sizes, len(right), right.dtype) if soft is None else soft
    still = NOISE * soft * np.max(np.abs(right[:n]) * sizes[:, None], axis=0, initial=0.0)
    before = np.inf
    for _ in range(MOST_CORRECTIONS):
        step = solve(right - product(z))
        found = size(step)
        share = np.max(np.where(found <= still, 0.0, found / np.maximum(size(z), np.finfo(float).tiny)), initial=0.0)
        if not share < before / 2:
            break
        z, before = z + step, share
        if share <= DONE:
            break
    if not before <= left:
        raise AnalysisError(RESULTS.lost_in_round_off.name, RESULTS.lost_in_round_off.message)
    return z
