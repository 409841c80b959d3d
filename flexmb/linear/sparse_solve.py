"""Solutions and lowest modes of large mechanisms by sparse factors on the host, with their derivatives."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Float

from ..arguments import is_concrete
from ..compilation.compile import jit
from ..compilation.threads import one_thread
from ..errors import AnalysisError
from ..math.element_matrices import ElementMatrices, Whole, times, times_transposed
from ..math.indices import put
from ..math.sparse import SparseFactors
from ..results import RESULTS
from .sparse_spectrum import Lowest, lowest_of_sparse, refuse_negative_masses
from .spectrum import EPS, FAINT, LOST

# Eigenvalues nearer than this, relatively, are taken to be repeated.
NEAR = 1e-8
# A free motion has no more elastic energy than this share of what round-off of the largest stiffness would be.
FREE = 1e-8


def on_host(function: Callable[..., Any], like: Any, *arguments: Any) -> Any:
    """Result of a function of arrays of NumPy: at once of concrete numbers, by a callback under a trace.

    Args:
        function: Function that calls nothing of JAX.
        like: Shapes and types of what it returns.
        arguments: Pytrees of arrays.
    """

    def called(*arguments: Any):
        with one_thread():
            return function(*jax.tree.map(np.asarray, arguments))

    if is_concrete(arguments):
        return jax.tree.map(jnp.asarray, called(*arguments))
    return jax.pure_callback(called, like, *arguments, vmap_method="sequential")


def spread(elements: ElementMatrices, moving: Float[Array, "n k"]) -> Float[Array, "n_x k"]:
    """Motions of all coordinates of those that move; what is held stays.

    Args:
        elements: Element matrices.
        moving: Of the coordinates that move, one a column, (n, k).
    """
    whole = jnp.zeros((elements.sizes.shape[0], moving.shape[1]), moving.dtype)
    return put(whole, elements.free, moving)


@jit
def product(elements: ElementMatrices, z: Float[Array, "r k"], values: Any = None) -> Float[Array, "r k"]:
    """Product of [[K - mu M, D^T], [D, 0]] and vectors.

    Args:
        elements: Element matrices.
        z: Motions and multipliers, one a column, (n + h, k).
        values: mu of each, (k,); None: zero.
    """
    n_x, (n, _), rows = elements.sizes.shape[0], elements.unknowns, elements.kept.shape[0]
    v = spread(elements, z[:n])
    multipliers = put(jnp.zeros((rows, z.shape[1]), z.dtype), elements.held, z[n:])
    forces = times(elements.stiffness, v, size=n_x) + times_transposed(elements.constraints, multipliers, size=n_x)
    if values is not None:
        forces = forces - times(elements.mass, v, size=n_x) * values
    return jnp.concatenate([forces[elements.free], times(elements.constraints, v, size=rows)[elements.held]])


def bordered(
    elements: ElementMatrices, z: Float[Array, "r *k"], border: Float[Array, "n b"], values: Any = None
) -> Array:
    """As :func:`product`, with motions to which the solution is to be orthogonal and the forces along them.

    Args:
        elements: Element matrices.
        z: Motions, multipliers and sizes of these forces, one a column, (n + h + b, k).
        border: Of the coordinates that move, one a column.
        values: As of :func:`product`.
    """
    (n, h) = elements.unknowns
    balance = product(elements, z[: n + h], values)
    balance = balance.at[:n].add(border @ z[n + h :])
    return jnp.concatenate([balance, border.T @ z[:n]])


def _false_stiffness(elements: ElementMatrices) -> float:
    """What round-off of the largest stiffness may be to any motion of extents and radians [N m]."""
    own = [np.abs(np.einsum("eii->ei", k)) * elements.sizes[at] ** 2 for at, _, k in elements.stiffness]
    return EPS * max((float(np.max(one, initial=0.0)) for one in own), default=0.0)


def _refuse_lost(lost: bool) -> None:
    """Refuse answers that round-off hides."""
    if lost:
        raise AnalysisError(RESULTS.lost_in_round_off.name, RESULTS.lost_in_round_off.message)


def _energies(elements: ElementMatrices, motions: np.ndarray) -> np.ndarray:
    """Twice the elastic energy of motions of all coordinates, one a column, from their deformations."""
    changed = np.zeros((len(elements.kept), motions.shape[1]))
    for at, columns, own in elements.constraints:
        changed[at] = own @ motions[columns]
    found = np.zeros(motions.shape[1])
    for at, by, own in elements.elastic:
        found += np.einsum("eik,eij,ejk->k", changed[at], own, changed[by])
    return found


def _solved(elements: ElementMatrices, right: np.ndarray, border: np.ndarray, transposed: bool = False) -> np.ndarray:
    whole = Whole(elements)
    factored = SparseFactors(whole.bordered(whole.at(), border)) if border.size else whole.factors(whole.at())
    if not factored.regular:
        raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)
    found, n = factored.solve(right, transposed), elements.unknowns[0]
    forces = np.asarray(right)[:n] * elements.sizes[elements.free, None]
    work = np.abs(np.sum(found[:n] * right[:n], axis=0))
    _refuse_lost(bool(np.any(_false_stiffness(elements) * work > LOST * np.sum(forces**2, axis=0))))
    return found


def solved(
    elements: ElementMatrices, right: Float[Array, "r k"], border: Float[Array, "n b"] | None = None
) -> Float[Array, "r k"]:
    """Motions and multipliers under forces, [[K, D^T], [D, 0]] z = right; differentiable in all arguments.

    Args:
        elements: Element matrices.
        right: Forces on the coordinates that move, and deformations of the constraints, one a column, (n + h, k).
        border: Vectors of the coordinates that move to which motions are to be orthogonal, with forces along them that
            see to it; None: none.

    Raises:
        AnalysisError: singular_stiffness; under a trace as an error of JAX with its text.
    """
    n, rows = elements.unknowns[0], right.shape[0]
    if border is None:
        border = jnp.zeros((n, 0))
    right = jnp.concatenate([right, jnp.zeros((border.shape[1], right.shape[1]))])
    return _bordered_solution(elements, right, border)[:rows]


@jax.custom_jvp
def _bordered_solution(elements: ElementMatrices, right: Float[Array, "r *k"], border: Float[Array, "n b"]) -> Array:
    return on_host(_solved, jax.ShapeDtypeStruct(right.shape, float), elements, right, border)


@_bordered_solution.defjvp
def _solved_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    elements, right, border = primals
    z = _bordered_solution(elements, right, border)

    def balance(elements: ElementMatrices, border: Float[Array, "n b"]):
        return bordered(elements, z, border)

    _, change = jax.jvp(balance, (elements, border), (tangents[0], tangents[2]))

    def solve(transposed: bool):
        return lambda _, right: jax.pure_callback(
            lambda *given: _solved(*jax.tree.map(np.asarray, given), transposed=transposed),
            jax.ShapeDtypeStruct(right.shape, float),
            elements,
            right,
            border,
            vmap_method="sequential",
        )

    def matvec(z: Float[Array, "r *k"]):
        return bordered(elements, z, border)

    return z, lax.custom_linear_solve(matvec, tangents[1] - change, solve(False), transpose_solve=solve(True))


def lowest(elements: ElementMatrices, count: int) -> Lowest:
    """Lowest eigenvalues of K v + D^T m = omega^2 M v, D v = 0, with their motions; differentiable.

    The sign of a motion is such that its largest entry, coordinates in extents and radians, is positive. Where
    eigenvalues are repeated, what depends on the choice of motions among theirs has no derivative.

    Args:
        elements: Element matrices.
        count: How many.

    Returns:
        omega^2, ascending, infinite for motions without mass, (count,) [rad^2/s^2]; motions of all coordinates,
        mass-normalised, zero for those, one a column, (n_x, count); multipliers of the constraints, (h, count).

    Source:
        THEORY.md 7, eq. (7.16): Lanczos method of ARPACK, shifted and inverted; derivatives as Nelson (1976).
    """
    # The number is handed on as a shape, which stays known.
    return _lowest(elements, jnp.zeros(_possible(elements, count)))


def _possible(elements: ElementMatrices, count: int) -> int:
    """So many of the motions that constraints leave."""
    n, h = elements.unknowns
    return min(count, n - h)


@jax.custom_jvp
def _lowest(elements: ElementMatrices, count: Array) -> Lowest:
    k, (n, h), n_x = count.shape[0], elements.unknowns, elements.sizes.shape[0]
    like = [jax.ShapeDtypeStruct(shape, float) for shape in ((k,), (n_x, k), (h, k))]

    def found(elements: ElementMatrices):
        whole = Whole(elements)
        tangent, mass = whole.at(), whole.mass
        refuse_negative_masses(mass, [own for *_, own in elements.mass], tangent)
        values, moving, multipliers = lowest_of_sparse(tangent, mass, k)
        motions = np.zeros((n_x, k))
        motions[elements.free] = moving
        heaviest = np.max(mass.diagonal() * elements.sizes[elements.free] ** 2, initial=0.0)
        false = _false_stiffness(elements) / heaviest if heaviest else 0.0
        # A free motion is as near to zero, and has no elastic energy; that of a critical state is, beside the others.
        near = np.abs(values) < false / LOST
        if np.any(_energies(elements, motions[:, near]) > FREE * false):
            others = lowest_of_sparse(tangent, mass, k + 1).values if np.all(near) and k < n - h else values
            others = np.abs(others[np.isfinite(others)])
            apart = np.min(others[others >= false / LOST], initial=np.inf)
            _refuse_lost(bool(np.isinf(apart) or false > FAINT * apart))
        sized = motions / elements.sizes[:, None]
        signs = np.sign(sized[np.argmax(np.abs(sized), axis=0), np.arange(k)])
        return values, motions * signs, multipliers * signs

    return Lowest(*on_host(found, tuple(like), elements))


@_lowest.defjvp
def _lowest_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    elements, count = primals
    at: Any = _lowest(elements, count)
    (n, h), n_x = elements.unknowns, elements.sizes.shape[0]
    z = jnp.concatenate([at.motions[elements.free], at.multipliers])
    massive, values = jnp.isfinite(at.values), _finite(at.values)
    gaps = jnp.abs(values[:, None] - values)
    near = gaps <= NEAR * jnp.maximum(jnp.abs(values)[:, None], jnp.abs(values))
    near = near & massive & massive[:, None]
    inertia = times(elements.mass, at.motions, size=n_x)[elements.free]

    def equations(elements: ElementMatrices):
        """Balance of each mode, and how far the modes that are near it are from being orthonormal to it."""
        mass = jnp.einsum("ij,ik->jk", at.motions, times(elements.mass, at.motions, size=n_x))
        return jnp.concatenate([product(elements, z, values), jnp.where(near, mass, 0.0) / 2])

    _, change = jax.jvp(equations, (elements,), (tangents[0],))

    def matvec(y: Float[Array, "r k"]):
        own, border = y[: n + h], y[n + h :]
        balance = product(elements, own, values)
        balance = balance.at[:n].add(inertia @ jnp.where(near, border, 0.0))
        return jnp.concatenate([balance, jnp.where(near, inertia.T @ own[:n], border)])

    def host(elements: ElementMatrices, values: np.ndarray, inertia: np.ndarray, near: np.ndarray, right: np.ndarray):
        whole = Whole(elements)
        found, ordering = np.array(right), None
        for i, value in enumerate(values):
            own = np.flatnonzero(near[:, i])
            if not len(own):
                # Without mass: nothing is asked of it.
                found[:, i] = 0.0
                continue
            rows = np.concatenate([np.arange(n + h), n + h + own])
            bordered = whole.bordered(whole.at(mass=-value), inertia[:, own])
            alike = ordering is not None and len(ordering) == bordered.shape[0]
            factored = SparseFactors(bordered, ordering if alike else None)
            ordering = factored.ordering
            found[rows, i] = factored.solve(right[rows, i])
        return found

    def solve(_: Any, right: Float[Array, "r *k"]):
        return jax.pure_callback(
            lambda *given: host(*jax.tree.map(np.asarray, given)),
            jax.ShapeDtypeStruct(right.shape, float),
            elements,
            values,
            inertia,
            near,
            right,
            vmap_method="sequential",
        )

    y = lax.custom_linear_solve(matvec, -change, solve, symmetric=True)
    # Of each mode the border's own entry is less the change of its eigenvalue.
    slopes = -jnp.diagonal(y[n + h :])
    changed: Any = slopes, spread(elements, y[:n]), y[n : n + h]
    return at, Lowest(*changed)


def _finite(values: Float[Array, "count"]) -> Float[Array, "count"]:
    """Eigenvalues, zero for motions without mass, whose motions are zero."""
    return jnp.where(jnp.isfinite(values), values, 0.0)


def lowest_values(elements: ElementMatrices, count: int) -> Float[Array, "count"]:
    """Lowest eigenvalues alone, as :func:`lowest`; their derivatives need no solution.

    Source:
        Rayleigh's quotient in the motions found: d(omega^2) = v^T (dK - omega^2 dM) v + 2 m^T dD v.
    """
    return _lowest_values(elements, jnp.zeros(_possible(elements, count)))


@jax.custom_jvp
def _lowest_values(elements: ElementMatrices, count: Array) -> Float[Array, "count"]:
    found: Any = _lowest(elements, count)
    return found.values


@_lowest_values.defjvp
def _lowest_values_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    elements, count = primals
    at: Any = _lowest(elements, count)
    z = jnp.concatenate([at.motions[elements.free], at.multipliers])

    def quotients(elements: ElementMatrices):
        return jnp.sum(z * product(elements, z, _finite(at.values)), axis=0)

    return at.values, jax.jvp(quotients, (elements,), (tangents[0],))[1]
