"""Equilibrium of large mechanisms: all coordinates, one multiplier per constraint, factors on the host.

Compiled code computes element matrices, and calls the host to solve its linear equations.
"""

import contextlib
import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..arguments import is_concrete
from ..compilation.host import call_host
from ..compilation.threads import one_thread
from ..errors import AnalysisError, ModelError
from ..math.by_deformations import forces, refined_solution, saddle_product
from ..math.derivative import jvp_of_varied
from ..math.element_matrices import AssembledEquations, BlockMatrices, ElementMatrices
from ..math.indices import put, scatter_vector
from ..math.linear_solver import SPARSE, LinearSolver
from ..math.sparse import SparseFactors, on_host_thread
from ..mechanics.deformation import deformations, zero_strain
from ..mechanics.inertia import InertialLoad, weight
from ..mechanics.loads import LoadFactors, has_loads, lacks_potential, nodal_forces, scaled_loads
from ..mechanics.prepared import kernel
from ..mechanics.stress_resultants import free_deformations, is_nonlinear_at_rest
from ..model.topology import Parameters, Topology
from ..numerical_limits import DEFORMATION_ROUND_OFF
from ..results import RESULTS, check, collect, collects, or_nan
from .newton_search import (
    Correction,
    Iterate,
    MatrixForm,
    Searched,
    prescribed_values,
    search_equilibrium,
    unloaded_start,
)
from .stable import has_negative_motion, is_unstable, pivots_tell_unstable
from .tangent import elastic_stress, element_matrices, unknowns


class Balanced(NamedTuple):
    """Equilibrium in all coordinates.

    Attributes:
        x: Nodal coordinates.
        multipliers: Stress resultants of the held deformations.
        near: Deformations from which angles are counted.
        strained: Deformations minus stress-free deformations, as iterated. The deformations of x have few correct
            digits in stiff elements. None: deformations of x.
        unstable: Whether the stiffness is known to be negative in some motion; not checked for traced numbers.
    """

    x: Float[Array, "n_x"]
    multipliers: Float[Array, "h"]
    near: Float[Array, "n_e"]
    iterations: Any = 0
    result: Any = 0
    strained: Any = None
    unstable: Any = False


class Loaded(NamedTuple):
    """A state under loads.

    Attributes:
        factors: Load factors.
        near: Its deformations, without a derivative.
        at: The state.
    """

    factors: LoadFactors
    near: Float[Array, "n_e"]
    at: Balanced


def _answer(
    elements: ElementMatrices, right: Any, *, solver: LinearSolver, transposed: bool = False, better: bool = True
):
    """Solution of the linear equations on the host, and a code of RESULTS, by NumPy and SciPy alone.

    ``better``: whether to refine the solution by the elements' matrices. The next correction reduces other errors.
    """

    def solve(z: np.ndarray):
        return factors.solve(z, transposed)

    try:
        factors = solver.factored(elements)
        if factors.regular:
            if better:
                columns, sizes = right.reshape(len(right), -1), elements.sizes[elements.free]
                solution = refined_solution(lambda z: forces(elements, z, transposed), solve, columns, sizes)
            else:
                solution = solve(right)
            return solution.reshape(right.shape), np.array(RESULTS.successful, np.int32)
        independent = AssembledEquations(elements).independent()
        why = RESULTS.singular_stiffness if independent else RESULTS.singular_configuration
    except AnalysisError as fault:
        why = RESULTS[fault.code]
    return np.full(np.shape(right), np.nan), np.array(why, np.int32)


def _estimated(elements: ElementMatrices, right: Float[np.ndarray, "r"]) -> Float[np.ndarray, "h"]:
    """Multipliers that balance forces best, with coordinates measured by their sizes, by NumPy and SciPy alone.

    ``right`` are forces out of balance without multipliers, and excess of the held deformations.
    """
    import scipy.sparse

    assembled = AssembledEquations(elements)
    n = assembled.n
    rows = assembled.at()[n:, :n]
    weights = scipy.sparse.diags_array(1 / elements.sizes[elements.free] ** 2)
    factors = SparseFactors(scipy.sparse.block_array([[weights, rows.T], [rows, None]], format="csc"))
    return factors.solve(np.concatenate([right[:n], np.zeros(len(right) - n)]))[n:]


def _turned(elements: ElementMatrices, right: np.ndarray, multipliers: np.ndarray, *, solver: LinearSolver):
    """Solution of the linear equations of a turn, a code of RESULTS, and multipliers to try instead of none.

    A hanging body has its stiffness from multipliers, which are unknown where a load begins.
    """
    z, code = _answer(elements, right, better=False, solver=solver)
    hangs = code == RESULTS.singular_stiffness and len(multipliers) and not np.any(multipliers)
    return z, code, _estimated(elements, right[:, 0]) if hangs else np.zeros(len(multipliers))


def _traced_answer(elements: ElementMatrices, right: Float[Array, "r *k"], **how: Any):
    """:func:`_answer` inside compiled code."""
    shapes = jax.ShapeDtypeStruct(right.shape, right.dtype), jax.ShapeDtypeStruct((), np.int32)
    return call_host(functools.partial(on_host_thread, functools.partial(_answer, **how)), shapes, elements, right)


@kernel
def undeformed_elements(topology: Topology, parameters: Parameters) -> ElementMatrices:
    """Element matrices of the undeformed mechanism without loads."""
    factors, none = LoadFactors(0.0, 0.0), zero_strain(topology)
    sigma = put(elastic_stress(topology, parameters, factors, none), topology.e.held, 0.0)
    return element_matrices(topology, parameters, factors, parameters.reference, none, sigma, none)[0]


def elements_times(size: int, pieces: BlockMatrices, v: Float[Array, "n"]) -> Array:
    """Sum of element matrices times a vector."""
    return scatter_vector(size, [(r, jnp.einsum("eij,ej->ei", matrix, v[c])) for r, c, matrix in pieces])


class TurnInCoordinates:
    """:class:`flexmb.statics.newton_search.Turn` in coordinates that move, and multipliers.

    Attributes:
        last: Element matrices.
        onto: Change of the coordinates that do not move by themselves.
        right: Forces out of balance, and excess of the held deformations.
        transposed: Constraints, transposed, in pieces.
    """

    def __init__(
        self,
        topology: Topology,
        parameters: Parameters,
        factors: LoadFactors,
        trial: Iterate,
        prescribed: Any,
        solver: LinearSolver = SPARSE,
    ):
        (free, fast, constrained), (wanted_x, wanted_e) = unknowns(topology), prescribed
        x, last_strain, strained, self._multipliers = trial
        self._solver = solver

        def stress(e: Float[Array, "n_e"]):
            return elastic_stress(topology, parameters, factors, e)

        sigma = put(stress(strained), constrained, self._multipliers)
        self.last, self.e = element_matrices(topology, parameters, factors, x, last_strain, sigma, strained)
        self.transposed = [(c, r, jnp.swapaxes(d, 1, 2)) for r, c, d in self.last.constraints]
        # The stress at x, to first order from the stress of the iterated deformations.
        self._stress_change = lambda change: jax.jvp(stress, (strained,), (change,))
        balancing = put(sum(self._stress_change(self.e - strained)), constrained, self._multipliers)
        pulling = elements_times(topology.n_x, self.transposed, balancing)
        lacking = nodal_forces(topology, parameters, factors, x) - pulling
        self.onto = put(jnp.zeros(topology.n_x), fast, wanted_x[fast] - x[fast])
        self.right = jnp.concatenate([lacking[free], (wanted_e - self.e)[constrained]]) - self.forces_of(self.onto)

    def spread(self, motion: Float[Array, "n"]) -> Float[Array, "n_x"]:
        """Motion of all coordinates."""
        return put(jnp.zeros(self.last.sizes.shape), self.last.free, motion)

    def forces_of(self, change: Float[Array, "n_x"]) -> Float[Array, "r"]:
        """Forces and held deformations of a change of all coordinates."""
        force = elements_times(change.shape[0], self.last.stiffness, change)
        return jnp.concatenate([force[self.last.free], self.deformed(change)[self.last.held]])

    def deformed(self, change: Float[Array, "n_x"]) -> Float[Array, "n_e"]:
        """See :class:`flexmb.statics.newton_search.Turn`."""
        return elements_times(self.e.shape[0], self.last.constraints, change)

    def is_round_off(self, sizes: Float[Array, "n_x"]) -> Bool[Array, ""]:
        """See :class:`flexmb.statics.newton_search.Turn`."""
        absolute = [(r, c, jnp.abs(d)) for r, c, d in self.last.constraints]
        error = DEFORMATION_ROUND_OFF * elements_times(self.e.shape[0], absolute, sizes)
        largest = jnp.abs(self._stress_change(error)[1])
        across = [(c, r, jnp.abs(d)) for c, r, d in self.transposed]
        pulled = elements_times(len(sizes), across, largest)[self.last.free]
        return jnp.all(jnp.abs(self.right[: len(pulled)]) <= pulled)

    def stiffnesses(self) -> Float[Array, "n"]:
        """See :class:`flexmb.statics.newton_search.Turn`."""
        diagonals = [(r, jnp.diagonal(matrix, axis1=1, axis2=2)) for r, _, matrix in self.last.structural]
        return scatter_vector(self.onto.shape[0], diagonals)[self.last.free]

    def energy(self, motion: Float[Array, "n"]) -> Float[Array, ""]:
        """See :class:`flexmb.statics.newton_search.Turn`."""
        changed = self.deformed(self.spread(motion))
        return changed @ elements_times(changed.shape[0], self.last.elastic, changed)

    def corrected(self, soft: Float[Array, "n"]) -> Correction:
        """See :class:`flexmb.statics.newton_search.Turn`."""
        n, h = self.last.unknowns
        bending = elements_times(self.onto.shape[0], self.last.structural, self.spread(soft))[self.last.free]
        right = jnp.stack([self.right, jnp.concatenate([bending, jnp.zeros(h)])], axis=1)
        like = [(n + h, 2), float], [(), np.int32], [(h,), float]
        shapes = tuple(jax.ShapeDtypeStruct(shape, kind) for shape, kind in like)
        host = functools.partial(on_host_thread, functools.partial(_turned, solver=self._solver))
        z, code, estimated = call_host(host, shapes, self.last, right, self._multipliers)
        why = jnp.where(code == RESULTS.successful, RESULTS.not_converged, code)
        return Correction(self.onto + self.spread(z[:n, 0]), z[:n, 1], self._multipliers + z[n:, 0], why, estimated)


@kernel
def _searched(topology: Topology, parameters: Parameters, target: LoadFactors, *, solver: LinearSolver) -> Searched:
    turn = functools.partial(TurnInCoordinates, solver=solver)
    form = MatrixForm(
        turn,
        lambda topology: (topology.x.free.shape[0], topology.e.held.shape[0]),
        looks_at_end=False,
        knows_stress=False,
    )
    return search_equilibrium(form, topology, parameters, target, unloaded_start(form, topology, parameters))


def search_in_coordinates(
    topology: Topology, parameters: Parameters, target: LoadFactors, solver: LinearSolver = SPARSE
) -> Balanced:
    """Equilibrium by Newton's method on coordinates and multipliers, without derivatives."""
    if not (has_loads(topology, parameters) or is_nonlinear_at_rest(topology)):
        none, zero = zero_strain(topology), jnp.zeros((), jnp.int32)
        multipliers = jnp.zeros(topology.e.held.shape[0])
        return Balanced(jnp.asarray(parameters.reference, float), multipliers, none, zero, zero, none)
    elements, reached, iterations, result = _searched(topology, parameters, target, solver=solver)
    x, last_strain, strained, multipliers = reached.at
    balance = Balanced(x, multipliers, last_strain, iterations, result, strained)
    if is_concrete((topology, parameters, target)):
        # The last correction is too small to change a sign.
        symmetric = not lacks_potential(topology)
        unstable = pivots_tell_unstable(jax.tree.map(np.asarray, elements), symmetric)
        if unstable and symmetric:
            elements = _tangent(topology, parameters, Loaded(target, last_strain, balance))
            unstable = has_negative_motion(jax.tree.map(np.asarray, elements))
        return balance._replace(unstable=unstable)
    return balance


# Its derivative is one solution with factors of the tangent at the state.
_differentiable = jax.custom_jvp(search_in_coordinates, nondiff_argnums=(3,))


def _balanced(
    topology: Topology, parameters: Parameters, target: LoadFactors, solver: LinearSolver = SPARSE
) -> Balanced:
    # For known numbers the derivative rule takes longer than the balance of a chain of fifty beams.
    known = is_concrete((topology, parameters, target))
    return (search_in_coordinates if known else _differentiable)(topology, parameters, target, solver)


@kernel
def lacking_at(topology: Topology, parameters: Parameters, loaded: Loaded):
    """Forces out of balance at the coordinates that move, and excess of the held deformations."""
    (factors, last_strain, at), (free, fast, constrained) = loaded, unknowns(topology)
    wanted_x, wanted_e = prescribed_values(topology, parameters, factors)
    x = put(at.x, fast, wanted_x[fast])
    e, pull = jax.vjp(lambda x: deformations(topology, parameters, x, last_strain), x)
    sigma = put(elastic_stress(topology, parameters, factors, e), constrained, at.multipliers)
    force = pull(sigma)[0] - nodal_forces(topology, parameters, factors, x)
    return jnp.concatenate([force[free], (e - wanted_e)[constrained]])


@kernel
def _tangent(topology: Topology, parameters: Parameters, loaded: Loaded):
    """Element matrices of the tangent at a state."""
    factors, last_strain, at = loaded
    sigma = put(elastic_stress(topology, parameters, factors, last_strain), unknowns(topology)[2], at.multipliers)
    return element_matrices(topology, parameters, factors, at.x, last_strain, sigma, last_strain)[0]


def solution_at(
    topology: Topology, parameters: Parameters, loaded: Loaded, right: Float[Array, "r"], solver: LinearSolver = SPARSE
) -> tuple[Array, Array]:
    """Solution of the equations linearised about a state, and a code; differentiable by ``right`` alone."""
    elements = _tangent(topology, parameters, loaded)
    if is_concrete((elements, right)):
        solution, code = _answer(*jax.tree.map(np.asarray, (elements, right)), solver=solver)
        return jax.device_put((solution, code))

    fixed: Any = jax.lax.stop_gradient(elements)

    def matvec(z: Float[Array, "r"]):
        return saddle_product(elements, z[:, None])[:, 0]

    def solve(transposed: bool):
        return lambda _, right: _traced_answer(fixed, right, transposed=transposed, solver=solver)

    return jax.lax.custom_linear_solve(matvec, right, solve(False), solve(True), has_aux=True)


@_differentiable.defjvp
def _balance_jvp(solver: LinearSolver, primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    topology, parameters, factors = primals
    # Keep the derivative rule: values from known numbers may be traced here, and a search on the host needs known ones.
    solved = _differentiable(topology, parameters, factors, solver)
    last_strain = deformations(topology, parameters, solved.x, solved.near)
    free, fast, _ = unknowns(topology)

    def equations(parameters: Parameters, factors: LoadFactors):
        return lacking_at(topology, parameters, Loaded(factors, last_strain, solved))

    _, change = jvp_of_varied(equations, primals[1:], tangents[1:])
    _, moved = jvp_of_varied(lambda *numbers: prescribed_values(topology, *numbers)[0][fast], primals[1:], tangents[1:])
    z, code = solution_at(topology, parameters, Loaded(factors, last_strain, solved), -change, solver)
    check(code, True)
    dx = put(put(jnp.zeros(topology.n_x), free, z[: free.shape[0]]), fast, moved)
    no_change: Any = np.zeros((), jax.dtypes.float0)
    still = jnp.zeros(topology.n_e)
    return solved, Balanced(dx, z[free.shape[0] :], still, no_change, no_change, still, no_change)


def balanced(topology: Topology, parameters: Parameters, target: LoadFactors) -> Balanced:
    """Equilibrium, differentiable, also a critical one; raise AnalysisError for known numbers."""
    balance = _balanced(topology, parameters, target)
    check(balance.result, True)
    return or_nan(balance, balance.result)


def refuse_what_is_not_sparse(topology: Topology) -> None:
    """Raise ModelError for loads or laws without a potential, for which sparse load multipliers have no equations."""
    if lacks_potential(topology):
        raise ModelError(
            "Load multipliers by sparse factors need a potential: loads that follow a body, moments about fixed axes in"
            " space and laws of several deformations have none. Give sparse=False, which accepts them, and a model with"
            " degrees of freedom. fm.path finds critical points by sparse factors too."
        )


@one_thread()
def sparse_equilibrium(
    topology: Topology, parameters: Parameters, target: LoadFactors, solver: LinearSolver = SPARSE
) -> tuple[tuple[Any, ...], Any]:
    """Fields of an :class:`flexmb.statics.Equilibrium` except the names, and whether it is known to be unstable."""
    at = _balanced(topology, parameters, target, solver)
    _collect_unstable(topology, parameters, target, at)
    return (*_quantities(topology, parameters, target, at), at.iterations, at.result), at.unstable


def _collect_unstable(topology: Topology, parameters: Parameters, target: LoadFactors, at: Balanced) -> None:
    """Add the code of an unstable state if codes are collected, as for traced designs."""
    if is_concrete((topology, parameters, target)) or not collects():
        return
    known: Any = jax.lax.stop_gradient((parameters, Loaded(target, at.near, at)))
    elements = _tangent(topology, *known)
    host_check = functools.partial(_is_unstable, symmetric=not lacks_potential(topology))
    unstable = call_host(functools.partial(on_host_thread, host_check), (jax.ShapeDtypeStruct((), bool),), elements)[0]
    collect(jnp.where(unstable, RESULTS.unstable_state, RESULTS.successful))


def _is_unstable(elements: ElementMatrices, *, symmetric: bool) -> tuple[np.ndarray]:
    """Whether a finite tangent is negative in some motion, by NumPy and SciPy alone."""
    finite = all(np.all(np.isfinite(number)) for number in jax.tree.leaves(elements))
    with contextlib.suppress(AnalysisError):
        return (np.array(finite and is_unstable(elements, symmetric)),)
    return (np.array(False),)


@kernel
def _quantities(topology: Topology, parameters: Parameters, factors: LoadFactors, at: Balanced):
    """Coordinates, deformations, stress resultants, gravity and motion, reactions and external forces."""
    constrained = unknowns(topology)[2]
    e = deformations(topology, parameters, at.x, at.near)
    carried = e
    if at.strained is not None:
        free = free_deformations(topology, parameters, scaled_loads(parameters, factors))
        known = at.strained if free is None else at.strained + free
        # The derivatives belong to the deformations of x.
        carried = e + jax.lax.stop_gradient(known - e)
    sigma = put(elastic_stress(topology, parameters, factors, carried), constrained, at.multipliers)
    return at.x, e, sigma, *acting(topology, parameters, factors, at.x, e, sigma)


@kernel
def acting(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    x: Float[Array, "n_x"],
    near: Float[Array, "n_e"],
    sigma: Float[Array, "n_e"],
):
    """Gravity, reactions and external forces at a state."""
    fast = unknowns(topology)[1]
    _, pull = jax.vjp(lambda x: deformations(topology, parameters, x, near), x)
    force = nodal_forces(topology, parameters, factors, x)
    gravity = scaled_loads(parameters, factors).gravity
    reactions = put(jnp.zeros(topology.n_x), fast, (pull(sigma)[0] - force)[fast])
    external = force + reactions
    if gravity is not None:
        external = external - weight(topology, parameters, x, gravity)
    return InertialLoad(gravity), reactions, external
