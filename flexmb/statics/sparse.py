"""Equilibrium of large mechanisms: all coordinates, one multiplier for each constraint, sparse factors.

Element matrices are computed by compiled code, added up and factored on the host. One turn of Newton's method is
written once; turns follow each other on the host where numbers are known, inside compiled code where they are traced:
there a call of the host answers the linear equations.
"""

import contextlib
import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import is_concrete
from ..compilation.host import call_host
from ..compilation.threads import one_thread
from ..errors import AnalysisError, ModelError
from ..math.by_deformations import forces, product, refined
from ..math.derivative import jvp_of_varied
from ..math.element_matrices import ElementMatrices, Whole
from ..math.indices import put
from ..math.sparse import SparseFactors, on_host_thread
from ..mechanics.blocks import kernel
from ..mechanics.deformation import deformations
from ..mechanics.inertia import Felt, weight
from ..mechanics.loads import LoadFactors, has_loads, lacks_potential, nodal_forces, scaled_loads
from ..mechanics.stress_resultants import free_deformations, is_nonlinear_at_rest
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS, check, collect, collects, or_nan
from .search import Search, corrected, linear_equations, start
from .solve import held_values
from .stable import has_negative_motion, is_unstable, pivots_tell_unstable
from .tangent import elastic_stress, element_matrices, unknowns


class Balanced(NamedTuple):
    """Equilibrium in all coordinates.

    Attributes:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        multipliers: Stress resultants of the held deformations, (h,) [N, N m].
        near: Deformations that angles are counted from, (n_e,) [m, rad].
        iterations: Newton iterations.
        result: Code of RESULTS.
        strained: Deformations less those that are free of stress, as the search carries them: x tells those of stiff
            elements to few digits, (n_e,) [m, rad]; None: those of x.
        unstable: Whether the stiffness is known to be negative in some motion; not looked at where numbers are traced.
    """

    x: Float[Array, "n_x"]
    multipliers: Float[Array, "h"]
    near: Float[Array, "n_e"]
    iterations: Any = 0
    result: Any = 0
    strained: Any = None
    unstable: Any = False


def _answer(elements: ElementMatrices, right: Any, *, transposed: bool = False, better: bool = True):
    """Solution of the linear equations on the host, and what they are: a code of RESULTS; NumPy and SciPy alone.

    Args:
        elements: Element matrices.
        right: (n + h,) or (n + h, k).
        transposed: Whether of the transposed equations.
        better: Whether the solution is refined by the elements' matrices; a correction is not, which a next one mends.
    """
    try:
        whole = Whole(elements)
        factors = whole.factors(whole.at())
        if factors.regular:
            if not better:
                found = factors.solve(right, transposed)
            else:
                columns, sizes = right.reshape(len(right), -1), elements.sizes[elements.free]
                found = refined(
                    lambda z: forces(elements, z, transposed), lambda z: factors.solve(z, transposed), columns, sizes
                ).reshape(right.shape)
            return found, np.array(RESULTS.successful, np.int32)
        why = RESULTS.singular_stiffness if whole.independent() else RESULTS.singular_configuration
    except AnalysisError as fault:
        why = RESULTS[fault.code]
    return np.full(np.shape(right), np.nan), np.array(why, np.int32)


def _estimated(elements: ElementMatrices, right: Float[np.ndarray, "r"]) -> Float[np.ndarray, "h"]:
    """Multipliers that balance forces best, coordinates measured by their sizes; NumPy and SciPy alone.

    Args:
        elements: Element matrices.
        right: Forces out of balance where there are no multipliers, and excess of the held deformations, (n + h,).
    """
    import scipy.sparse

    whole = Whole(elements)
    n = whole.n
    rows = whole.at()[n:, :n]
    weights = scipy.sparse.diags_array(1 / elements.sizes[elements.free] ** 2)
    factors = SparseFactors(scipy.sparse.block_array([[weights, rows.T], [rows, None]], format="csc"))
    return factors.solve(np.concatenate([right[:n], np.zeros(len(right) - n)]))[n:]


def _turned(elements: ElementMatrices, right: Float[np.ndarray, "r 2"], multipliers: Float[np.ndarray, "h"]):
    """Solution of the linear equations of a turn, a code of RESULTS, and multipliers to try it with in place of none.

    What hangs has its stiffness from multipliers, of which nothing is known where a load begins.
    """
    z, code = _answer(elements, right, better=False)
    hangs = code == RESULTS.singular_stiffness and len(multipliers) and not np.any(multipliers)
    return z, code, _estimated(elements, right[:, 0]) if hangs else np.zeros(len(multipliers))


def _traced_turn(elements: ElementMatrices, right: Float[Array, "r 2"], multipliers: Float[Array, "h"]):
    """The same inside compiled code."""
    shapes = tuple(
        jax.ShapeDtypeStruct(shape, kind)
        for shape, kind in ((right.shape, float), ((), np.int32), (multipliers.shape, float))
    )
    turned = functools.partial(on_host_thread, _turned)
    return call_host(turned, shapes, elements, right, multipliers)


def _traced_answer(elements: ElementMatrices, right: Float[Array, "r *k"], **how: bool):
    """The same inside compiled code."""
    shapes = jax.ShapeDtypeStruct(right.shape, right.dtype), jax.ShapeDtypeStruct((), np.int32)
    return call_host(functools.partial(on_host_thread, functools.partial(_answer, **how)), shapes, elements, right)


def undeformed_elements(topology: Topology, parameters: Parameters) -> ElementMatrices:
    """Element matrices where Newton's method begins without loads, arrays of NumPy."""
    begin = start(topology, parameters)
    return jax.tree.map(np.asarray, linear_equations(topology, parameters, LoadFactors(0.0, 0.0), begin)[0].elements)


def _found(topology: Topology, parameters: Parameters, target: LoadFactors) -> Balanced:
    """Equilibrium by Newton's method on coordinates and multipliers."""
    known, symmetric = is_concrete((topology, parameters, target)), not lacks_potential(topology)
    s, unstable = start(topology, parameters), False
    if not (has_loads(topology, parameters) or is_nonlinear_at_rest(topology)):
        s = s._replace(finished=True)
    if known:
        while not s.finished:
            linear, still = linear_equations(topology, parameters, target, s)
            elements, right = jax.tree.map(np.asarray, (linear.elements, linear.right))
            z, code, estimated = _turned(elements, right, np.asarray(s.trial.multipliers))
            if np.any(estimated):
                s = s._replace(trial=s.trial._replace(multipliers=jnp.asarray(estimated)))
                continue
            s = corrected(topology, parameters, target, s, linear, z, code, still)
            # The last correction is too small to change a sign.
            unstable = bool(s.finished) and pivots_tell_unstable(elements, symmetric)
    else:

        def turn(s: Search) -> Search:
            linear, still = linear_equations(topology, parameters, target, s)
            z, code, estimated = _traced_turn(linear.elements, linear.right, s.trial.multipliers)
            again = s._replace(trial=s.trial._replace(multipliers=estimated), iterations=s.iterations + 1)
            onward = corrected(topology, parameters, target, s, linear, z, code, still)
            return jax.tree.map(lambda a, b: jnp.where(jnp.any(estimated != 0), a, b), again, onward)

        s = jax.lax.while_loop(lambda s: ~s.finished, turn, s)
    balance = Balanced(s.done.x, s.done.multipliers, s.done.near, s.iterations, s.result, s.done.strained)
    if unstable and symmetric:
        elements = _tangent(topology, parameters, target, balance.near, balance)
        unstable = has_negative_motion(jax.tree.map(np.asarray, elements))
    return balance._replace(unstable=unstable)


# Its derivative is one solution with factors of the tangent at the state.
_differentiable = jax.custom_jvp(_found)


def _balanced(topology: Topology, parameters: Parameters, target: LoadFactors) -> Balanced:
    # For numbers the rule of derivatives would take longer to pass by than a chain of fifty beams to balance.
    known = is_concrete((topology, parameters, target))
    return _found(topology, parameters, target) if known else _differentiable(topology, parameters, target)


@kernel
def lacking_at(
    topology: Topology, parameters: Parameters, factors: LoadFactors, near: Float[Array, "n_e"], at: Balanced
):
    """Forces out of balance at the coordinates that move, and excess of the held deformations."""
    free, fast, held = unknowns(topology)
    wanted_x, wanted_e = held_values(topology, parameters, factors)
    x = put(at.x, fast, wanted_x[fast])
    e, pull = jax.vjp(lambda x: deformations(topology, parameters, x, near), x)
    sigma = put(elastic_stress(topology, parameters, factors, e), held, at.multipliers)
    force = pull(sigma)[0] - nodal_forces(topology, parameters, factors, x)
    return jnp.concatenate([force[free], (e - wanted_e)[held]])


@kernel
def _tangent(topology: Topology, parameters: Parameters, factors: LoadFactors, near: Float[Array, "n_e"], at: Balanced):
    """Element matrices of the tangent at a state."""
    sigma = put(elastic_stress(topology, parameters, factors, near), unknowns(topology)[2], at.multipliers)
    return element_matrices(topology, parameters, factors, at.x, near, sigma, near)[0]


def solution_at(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    near: Float[Array, "n_e"],
    at: Balanced,
    right: Float[Array, "r"],
) -> tuple[Array, Array]:
    """Solution of the equations linearised about a state, with one right-hand side, and a code of RESULTS.

    Args:
        near: Deformations there, (n_e,) [m, rad].
        at: The state, known.
        right: Forces and deformations, in which alone it is differentiable, (n + h,).
    """
    elements = _tangent(topology, parameters, factors, near, at)
    if is_concrete((elements, right)):
        found, code = _answer(*jax.tree.map(np.asarray, (elements, right)))
        return jax.device_put((found, code))

    fixed: Any = jax.lax.stop_gradient(elements)

    def matvec(z: Float[Array, "r"]):
        return product(elements, z[:, None])[:, 0]

    def solve(transposed: bool):
        return lambda _, right: _traced_answer(fixed, right, transposed=transposed)

    return jax.lax.custom_linear_solve(matvec, right, solve(False), solve(True), has_aux=True)


@_differentiable.defjvp
def _balance_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    topology, parameters, factors = primals
    # Not past the rule: what is computed here with known numbers may be traced, and a search on the host asks for them.
    solved = _differentiable(topology, parameters, factors)
    near = deformations(topology, parameters, solved.x, solved.near)
    free, fast, _ = unknowns(topology)

    def equations(parameters: Parameters, factors: LoadFactors):
        return lacking_at(topology, parameters, factors, near, solved)

    _, change = jvp_of_varied(equations, primals[1:], tangents[1:])
    _, moved = jvp_of_varied(lambda *numbers: held_values(topology, *numbers)[0][fast], primals[1:], tangents[1:])
    z, code = solution_at(topology, parameters, factors, near, solved, -change)
    check(code, True)
    dx = put(put(jnp.zeros(topology.n_x), free, z[: free.shape[0]]), fast, moved)
    no_change: Any = np.zeros((), jax.dtypes.float0)
    still = jnp.zeros(topology.n_e)
    return solved, Balanced(dx, z[free.shape[0] :], still, no_change, no_change, still, no_change)


def balanced(topology: Topology, parameters: Parameters, target: LoadFactors) -> Balanced:
    """Equilibrium, differentiable; a critical one is as good as others.

    Raises:
        AnalysisError: singular_configuration, singular_stiffness or not_converged, where numbers are known.
    """
    found = _balanced(topology, parameters, target)
    check(found.result, True)
    return or_nan(found, found.result)


def refuse_what_is_not_sparse(topology: Topology) -> None:
    """Raise where load multipliers by sparse factors have no equations.

    Raises:
        ModelError: Loads that follow a body, moments about fixed axes, or laws of several deformations.
    """
    if lacks_potential(topology):
        raise ModelError(
            "By sparse factors load multipliers are found of what has a potential: loads that follow a body, moments"
            " about fixed axes in space and laws of several deformations have none. Give sparse=False, which takes"
            " them, and a model with degrees of freedom; fm.path finds its critical points by sparse factors too."
        )


@one_thread()
def sparse_equilibrium(topology: Topology, parameters: Parameters, target: LoadFactors) -> tuple[tuple[Any, ...], Any]:
    """Static equilibrium by sparse factors.

    Args:
        topology: Structure, which needs no degrees of freedom (``Builder.build(check=False)``).

    Returns:
        What an :class:`flexmb.statics.Equilibrium` holds, but for the names: x, e, sigma, felt, reactions, external,
        iterations, result; and whether it is known to be unstable.
    """
    at = _balanced(topology, parameters, target)
    _collect_unstable(topology, parameters, target, at)
    return (*_quantities(topology, parameters, target, at), at.iterations, at.result), at.unstable


def _collect_unstable(topology: Topology, parameters: Parameters, target: LoadFactors, at: Balanced) -> None:
    """Add the code of an unstable state where codes are collected, as of designs that are traced."""
    if is_concrete((topology, parameters, target)) or not collects():
        return
    known: Any = jax.lax.stop_gradient((parameters, target, at))
    elements = _tangent(topology, *known[:2], known[2].near, known[2])
    told = functools.partial(_is_unstable, symmetric=not lacks_potential(topology))
    unstable = call_host(functools.partial(on_host_thread, told), (jax.ShapeDtypeStruct((), bool),), elements)[0]
    collect(jnp.where(unstable, RESULTS.unstable_state, RESULTS.successful))


def _is_unstable(elements: ElementMatrices, *, symmetric: bool) -> tuple[np.ndarray]:
    """Whether a tangent is negative in some motion, of an equilibrium that was found; NumPy and SciPy alone."""
    finite = all(np.all(np.isfinite(number)) for number in jax.tree.leaves(elements))
    with contextlib.suppress(AnalysisError):
        return (np.array(finite and is_unstable(elements, symmetric)),)
    return (np.array(False),)


@kernel
def _quantities(topology: Topology, parameters: Parameters, factors: LoadFactors, at: Balanced):
    """Coordinates, deformations, stress resultants, what mass feels, reactions and external forces."""
    held = unknowns(topology)[2]
    e = deformations(topology, parameters, at.x, at.near)
    carried = e
    if at.strained is not None:
        free = free_deformations(topology, parameters, scaled_loads(parameters, factors))
        known = at.strained if free is None else at.strained + free
        # By x they change as its deformations do.
        carried = e + jax.lax.stop_gradient(known - e)
    sigma = put(elastic_stress(topology, parameters, factors, carried), held, at.multipliers)
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
    """What mass feels, reactions and external forces at a state."""
    fast = unknowns(topology)[1]
    _, pull = jax.vjp(lambda x: deformations(topology, parameters, x, near), x)
    force = nodal_forces(topology, parameters, factors, x)
    gravity = scaled_loads(parameters, factors).gravity
    reactions = put(jnp.zeros(topology.n_x), fast, (pull(sigma)[0] - force)[fast])
    external = force + reactions
    if gravity is not None:
        external = external - weight(topology, parameters, x, gravity)
    return Felt(gravity), reactions, external
