"""Solutions and lowest modes of large mechanisms by sparse factors on the host, with their derivatives."""

import contextlib
import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Float

from ..arguments import is_concrete, library_of
from ..compilation.host import call_host
from ..compilation.threads import one_thread
from ..errors import AnalysisError
from ..math.by_deformations import (
    bordered_product,
    energies,
    forces,
    motions_from_free,
    refined_solution,
    saddle_product,
)
from ..math.element_matrices import AssembledEquations, ElementMatrices, matrix_times
from ..math.linear_solver import SPARSE, LinearSolver
from ..math.sparse import SparseFactors, on_host_thread
from ..numerical_limits import FAINT, FREE_ENERGY, KNOWN_BY_FACTORS, REPEATED_EIGENVALUE
from ..results import RESULTS
from .sparse_spectrum import Lowest, lowest_of_sparse, refuse_negative_masses
from .spectrum import EPS

NOTHING = complex(np.nan, np.nan)


def call_on_host(function: Callable[..., Any], like: Any, *arguments: Any) -> Any:
    """Result of a function of arrays, with the shapes of ``like``: at once for concrete numbers, else by a callback."""
    if is_concrete(arguments):
        # Known numbers stay known within a trace.
        with one_thread(), jax.core.eval_context():
            return jax.device_put(function(*jax.tree.map(np.asarray, arguments)))
    return _traced(function, like, *arguments)


def _traced(function: Callable[..., Any], like: Any, *arguments: Any) -> Any:
    """:func:`call_on_host` inside compiled code; NaN for failures and for arguments that are not finite."""
    expected = [(leaf.shape, np.dtype(leaf.dtype).str) for leaf in jax.tree.leaves(like)]
    finite = functools.partial(_nan_unless_finite, function, expected)
    leaves = call_host(functools.partial(on_host_thread, finite), jax.tree.leaves(like), *arguments)
    return jax.tree.unflatten(jax.tree.structure(like), leaves)


def _nan_unless_finite(
    function: Callable[..., Any], expected: list[tuple[Any, str]], *arguments: Any
) -> list[np.ndarray]:
    if all(np.all(np.isfinite(number)) for number in jax.tree.leaves(arguments)):
        with contextlib.suppress(AnalysisError), one_thread():
            return jax.tree.leaves(function(*arguments))
    return [np.full(shape, NOTHING if np.dtype(kind).kind == "c" else np.nan, kind) for shape, kind in expected]


def _false_stiffness(elements: ElementMatrices) -> float:
    """Stiffness of any motion of extents and radians that round-off of the largest may cause [N m]."""
    sized = [np.abs(np.einsum("eii->ei", k)) * elements.sizes[at] ** 2 for at, _, k in elements.stiffness]
    return EPS * max((float(np.max(diagonal, initial=0.0)) for diagonal in sized), default=0.0)


def _solved(
    elements: ElementMatrices, right: np.ndarray, border: np.ndarray, *, solver: LinearSolver, transposed: bool = False
) -> np.ndarray:
    if border.size:
        assembled = AssembledEquations(elements)
        factored = SparseFactors(assembled.bordered(assembled.at(), border))
    else:
        factored = solver.factored(elements)
    if not factored.regular:
        raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)
    right, n_borders, (n, h) = np.asarray(right), border.shape[1], elements.unknowns

    def exact(z: np.ndarray):
        image = forces(elements, z[: n + h], transposed)
        image[:n] += border @ z[n + h :]
        return np.concatenate([image, border.T @ z[:n]]) if n_borders else image

    sizes = elements.sizes[elements.free]
    return refined_solution(exact, lambda residual: factored.solve(residual, transposed), right, sizes)


def sparse_solution(
    elements: ElementMatrices,
    right: Float[Array | np.ndarray, "r k"],
    border: Any = None,
    solver: LinearSolver = SPARSE,
) -> Float[Array, "r k"]:
    """Motions and multipliers under forces, [[K, D^T], [D, 0]] z = right; differentiable in all arguments.

    Columns of ``right`` are forces and deformations of the constraints. The solution is orthogonal to the motions
    ``border``, by forces along them. A singular stiffness raises, and is NaN under a trace.
    """
    if border is None:
        return _bordered_solution(elements, right, np.zeros((elements.unknowns[0], 0)), solver)
    rows, library = right.shape[0], library_of((right, border))
    right = library.concatenate([right, library.zeros((border.shape[1], right.shape[1]))])
    return _bordered_solution(elements, right, border, solver)[:rows]


@functools.partial(jax.custom_jvp, nondiff_argnums=(3,))
def _bordered_solution(
    elements: ElementMatrices, right: Float[Array, "r *k"], border: Float[Array, "n b"], solver: LinearSolver
) -> Array:
    how = functools.partial(_solved, solver=solver)
    return call_on_host(how, jax.ShapeDtypeStruct(right.shape, float), elements, right, border)


@_bordered_solution.defjvp
def _solved_jvp(solver: LinearSolver, primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    elements, right, border = primals
    z = _bordered_solution(elements, right, border, solver)

    def balance(elements: ElementMatrices, border: Float[Array, "n b"]):
        return bordered_product(elements, z, border)

    _, change = jax.jvp(balance, (elements, border), (tangents[0], tangents[2]))

    def solve(transposed: bool):
        how = functools.partial(_solved, solver=solver, transposed=transposed)
        return lambda _, right: _traced(how, jax.ShapeDtypeStruct(right.shape, float), elements, right, border)

    def matvec(z: Float[Array, "r *k"]):
        return bordered_product(elements, z, border)

    return z, lax.custom_linear_solve(matvec, tangents[1] - change, solve(False), transpose_solve=solve(True))


def lowest(elements: ElementMatrices, count: int, solver: LinearSolver = SPARSE) -> Lowest:
    """Lowest eigenvalues of K v + D^T m = omega^2 M v, D v = 0, with their motions; differentiable.

    Eigenvalues are infinite for motions without mass. Motions of all coordinates are mass-normalised; their largest
    entry, in extents and radians, is positive. Results that depend on the choice of motions of a repeated eigenvalue
    have no derivative. THEORY.md 7, eq. (7.16): shift-inverted Lanczos method of ARPACK; derivatives by Nelson (1976).
    """
    # The number is a shape, which stays known under a trace.
    return _lowest(elements, np.zeros(_possible(elements, count)), solver)


def _possible(elements: ElementMatrices, count: int) -> int:
    """Number of motions, at most the number of motions that the constraints allow."""
    n, h = elements.unknowns
    return min(count, n - h)


@functools.partial(jax.custom_jvp, nondiff_argnums=(2,))
def _lowest(elements: ElementMatrices, count: Array, solver: LinearSolver) -> Lowest:
    k, h, n_x = count.shape[0], elements.unknowns[1], elements.sizes.shape[0]
    like = [jax.ShapeDtypeStruct(shape, float) for shape in ((k,), (n_x, k), (h, k))]

    return Lowest(*call_on_host(functools.partial(_lowest_on_host, count=k, solver=solver), tuple(like), elements))


def _lowest_on_host(elements: ElementMatrices, *, count: int, solver: LinearSolver):
    """Lowest eigenvalues, motions of all coordinates and multipliers, by NumPy and SciPy alone."""
    n, h = elements.unknowns
    assembled = AssembledEquations(elements)
    refuse_negative_masses(assembled)
    values, moving, multipliers = lowest_of_sparse(assembled, count, solver)
    motions = motions_from_free(elements, moving)
    heaviest = np.max(assembled.mass.diagonal() * elements.sizes[elements.free] ** 2, initial=0.0)
    false = _false_stiffness(elements) / heaviest if heaviest else 0.0
    # A free motion has an eigenvalue near zero and no elastic energy; a critical state has one beside other
    # eigenvalues.
    uncertain = np.abs(values) < false / KNOWN_BY_FACTORS
    if np.any(energies(elements, motions[:, uncertain]) > FREE_ENERGY * false):
        others = (
            lowest_of_sparse(assembled, count + 1, solver).values if np.all(uncertain) and count < n - h else values
        )
        others = np.abs(others[np.isfinite(others)])
        next_value = np.min(others[others >= false / KNOWN_BY_FACTORS], initial=np.inf)
        if np.isinf(next_value) or false > FAINT * next_value:
            raise AnalysisError(RESULTS.lost_in_round_off.name, RESULTS.lost_in_round_off.message)
    sized = motions / elements.sizes[:, None]
    signs = np.sign(sized[np.argmax(np.abs(sized), axis=0), np.arange(count)])
    return values, motions * signs, multipliers * signs


@_lowest.defjvp
def _lowest_jvp(solver: LinearSolver, primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    elements, count = primals
    at: Any = _lowest(elements, count, solver)
    (n, h), n_x = elements.unknowns, elements.sizes.shape[0]
    z = jnp.concatenate([at.motions[elements.free], at.multipliers])
    massive, values = jnp.isfinite(at.values), _finite(at.values)
    gaps = jnp.abs(values[:, None] - values)
    repeated = gaps <= REPEATED_EIGENVALUE * jnp.maximum(jnp.abs(values)[:, None], jnp.abs(values))
    repeated = repeated & massive & massive[:, None]
    inertia = matrix_times(elements.mass, at.motions, size=n_x)[elements.free]

    def equations(elements: ElementMatrices):
        """Balance of each mode, and its deviation from orthonormality to modes near it."""
        mass = jnp.einsum("ij,ik->jk", at.motions, matrix_times(elements.mass, at.motions, size=n_x))
        return jnp.concatenate([saddle_product(elements, z, values), jnp.where(repeated, mass, 0.0) / 2])

    _, change = jax.jvp(equations, (elements,), (tangents[0],))

    def matvec(y: Float[Array, "r k"]):
        changes, border = y[: n + h], y[n + h :]
        balance = saddle_product(elements, changes, values)
        balance = balance.at[:n].add(inertia @ jnp.where(repeated, border, 0.0))
        return jnp.concatenate([balance, jnp.where(repeated, inertia.T @ changes[:n], border)])

    def solve(_: Any, right: Float[Array, "r *k"]):
        like = jax.ShapeDtypeStruct(right.shape, float)
        return _traced(_bordered_by_repeated, like, elements, values, inertia, repeated, right)

    y = lax.custom_linear_solve(matvec, -change, solve, symmetric=True)
    # The border's own entry of each mode is minus the change of its eigenvalue.
    slopes = -jnp.diagonal(y[n + h :])
    changed: Any = slopes, motions_from_free(elements, y[:n]), y[n : n + h]
    return at, Lowest(*changed)


def _bordered_by_repeated(
    elements: ElementMatrices, values: np.ndarray, inertia: np.ndarray, repeated: np.ndarray, right: np.ndarray
):
    """Solution for each mode, orthogonal to those near it, by NumPy and SciPy alone."""
    n, h = elements.unknowns
    assembled, sizes = AssembledEquations(elements), elements.sizes[elements.free]
    mass, solutions, ordering = assembled.mass, np.array(right), None
    for i, value in enumerate(values):
        neighbours = np.flatnonzero(repeated[:, i])
        if not len(neighbours):
            # A motion without mass has no change.
            solutions[:, i] = 0.0
            continue
        rows = np.concatenate([np.arange(n + h), n + h + neighbours])
        matrix = assembled.bordered(assembled.at(mass=-value), inertia[:, neighbours])
        alike = ordering is not None and len(ordering) == matrix.shape[0]
        factored = SparseFactors(matrix, ordering if alike else None)
        ordering = factored.ordering

        def exact(y: np.ndarray, border: np.ndarray = inertia[:, neighbours], value: float = value):
            image = forces(elements, y[: n + h])
            image[:n] += border @ y[n + h :] - value * (mass @ y[:n])
            return np.concatenate([image, border.T @ y[:n]])

        solutions[rows, i] = refined_solution(exact, factored.solve, right[rows, i : i + 1], sizes)[:, 0]
    return solutions


def _finite(values: Float[Array, "count"]) -> Float[Array, "count"]:
    """Eigenvalues, zero for motions without mass."""
    return jnp.where(jnp.isfinite(values), values, 0.0)


def lowest_values(elements: ElementMatrices, count: int, solver: LinearSolver = SPARSE) -> Float[Array, "count"]:
    """Lowest eigenvalues as in :func:`lowest`. Rayleigh's quotient yields their derivatives, without a solution."""
    return _lowest_values(elements, np.zeros(_possible(elements, count)), solver)


@functools.partial(jax.custom_jvp, nondiff_argnums=(2,))
def _lowest_values(elements: ElementMatrices, count: Array, solver: LinearSolver) -> Float[Array, "count"]:
    modes: Any = _lowest(elements, count, solver)
    return modes.values


@_lowest_values.defjvp
def _lowest_values_jvp(solver: LinearSolver, primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    elements, count = primals
    at: Any = _lowest(elements, count, solver)
    z = jnp.concatenate([at.motions[elements.free], at.multipliers])

    def quotients(elements: ElementMatrices):
        return jnp.sum(z * saddle_product(elements, z, _finite(at.values)), axis=0)

    return at.values, jax.jvp(quotients, (elements,), (tangents[0],))[1]
