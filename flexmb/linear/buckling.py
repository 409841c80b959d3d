"""Linear buckling: load multipliers about the loaded state, sign kept."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float, Int

from ..arguments import check_whole, is_concrete
from ..compilation.compile import jit, unguarded
from ..compilation.record import Record
from ..display import Labelled, Quantities, States, Summary, kind_of, modal_summary, numbered_quantities
from ..errors import ModelError, warn
from ..math.indices import put
from ..math.linear import factorise, general_eigen, is_positive_definite, pencil
from ..math.linear_solver import DENSE, SPARSE, LinearSolver
from ..mechanics.deformation import deformation_curvature, deformation_jacobian, multipliers
from ..mechanics.loads import LoadFactors, lacks_potential, load_factors_of, load_stiffness, nodal_forces, scaled_loads
from ..mechanics.prepared import kernel
from ..mechanics.residual import State, linear_response, state
from ..mechanics.stress_resultants import stress_of_loads
from ..model.model import Model, as_determined, as_model
from ..model.topology import Parameters, Topology, coordinate_scales
from ..numerical_limits import (
    BENT_BY_LOADS,
    FAR_BEFORE_BUCKLING,
    KNOWN_EIGENVALUE,
    STRESS_ROUND_OFF,
    UNBOUNDED_MULTIPLIER,
)
from ..results import RESULTS, or_nan
from ..statics.equilibrium import check_stiffness
from ..statics.newton_search import prescribed_values
from ..statics.solve import solve_state
from ..statics.solver_choice import asked_solver, few_of, is_large, warn_of_fewer
from .about import Where
from .linearize import Linearization, ManyStates, Matrices, Shapes, linearize, linearized_by_elements
from .sparse_buckling import moved_by_loads, sparse_multipliers
from .spectrum import is_real


class Buckling(Shapes, Labelled, Record):
    """Load multipliers and buckling modes, by magnitude.

    ``buckled.position("top")`` returns values of the state to which the multipliers refer. ``buckled.shape("top")``
    returns the motion of a node in each mode.

    Attributes:
        multipliers: Solutions lambda of det(K0 + N0 + lambda G0) = 0, with sign, (n,) [-].
        shapes: Buckling modes in the coordinates, scaled to a largest entry of 1, (n_x, n).
        lin: Linearization about the state to which the multipliers refer.
    """

    multipliers: Float[Array, "n"]
    shapes: Float[Array, "n_x n"]
    lin: Linearization
    one_axis = "multipliers"

    def states(self) -> States:
        """Return the modes about their state, each with its load multiplier."""
        numbered = enumerate(np.asarray(self.multipliers).tolist())
        titles = [f"buckling mode {i + 1}: λ = {multiplier:.5g}" for i, multiplier in numbered]
        return States(self.lin.model, self.lin.x, "modes", moves=self.shapes, titles=titles)

    def quantities_by_name(self) -> Quantities:
        """Return the load multipliers by the number of the mode, from 1."""
        return numbered_quantities("mode", {"multiplier": (self.multipliers, "-")})

    def summary(self) -> Summary:
        """Return the load multipliers."""
        texts = [f"load multiplier {multiplier:.5g}" for multiplier in np.asarray(self.multipliers).tolist()]
        scaled = "all loads" if self.lin.model.parameters.increment is None else "the loads with increment=True"
        rows = {"load multiplier": f"factor of {scaled} at which the mechanism buckles"}
        return modal_summary("Buckling", self.states(), texts, rows if texts else {"load multipliers": "none"})


def curvature_of_increment(
    topology: Topology, parameters: Parameters, at: State, near: Float[Array, "n_e"]
) -> tuple[Float[Array, "n_x n_x"], Float[Array, "n_e"], Float[Array, "n_x"]]:
    """Stiffness in the coordinates, stresses and displacements that the incremental loads add, to first order."""
    no_preload = LoadFactors(0.0, 1.0)
    unloaded = dataclasses.replace(parameters, strain=None)
    force = nodal_forces(topology, parameters, no_preload, at.x)
    wanted_x, wanted_e = prescribed_values(topology, unloaded, no_preload)
    shift = wanted_x - parameters.reference
    extra = stress_of_loads(topology, unloaded, scaled_loads(unloaded, no_preload), at.S)
    # Constraints balance the stress that an element adds at a held deformation.
    extra = jnp.zeros(topology.n_e) if extra is None else put(extra, topology.e.held, 0.0)
    excess = at.jacobian @ shift - wanted_e
    dx, _ = linear_response(topology, at, excess, shift, at.jacobian.T @ extra - force)
    elastic = at.S @ (at.jacobian @ dx) + extra
    # The turned stresses of the preload are balanced too; otherwise multipliers would depend on the choice of degrees
    # of freedom.
    turned = 0.0 if at.curvature is None else at.curvature @ dx
    sigma = multipliers(topology, at.transfer, at.jacobian, elastic, force - turned)
    curvature = deformation_curvature(topology, parameters, at.x, near, sigma)
    return curvature - load_stiffness(topology, parameters, no_preload, at.x), sigma, dx


def scaled_stiffness(
    topology: Topology,
    parameters: Parameters,
    at: State,
    near: Float[Array, "n_e"],
    raised: tuple[Topology, Parameters, State] | None = None,
) -> tuple[Float[Array, "n_q n_q"], Float[Array, "n_q n_q"], Float[Array, ""]]:
    """Constant and scaled stiffness about a state (THEORY.md 7, eq. (7.4)), and 1/lambda of round-off.

    The last is infinite if all scaled stiffness is round-off. `raised`: topology, parameters and state in which the
    incremental loads grow, if more is held there.
    """
    if parameters.increment is None:
        stays, scaled, curvature = at.K0, at.G0, at.curvature
        sigma, moved = at.sigma, coordinate_scales(topology, parameters)
    else:
        stays = at.K0 + at.G0
        grown = (topology, parameters, at) if raised is None else raised
        curvature, sigma, moved = curvature_of_increment(*grown, near)
        scaled = at.transfer.DFx.T @ curvature @ at.transfer.DFx
    tangent = at.x, near, at.jacobian, at.S, at.transfer.DFx
    return stays, scaled, _noise(topology, parameters, tangent, (stays, scaled), curvature, sigma, moved)


def _noise(
    topology: Topology,
    parameters: Parameters,
    tangent: tuple[Array, ...],
    stiffnesses: tuple[Float[Array, "n_q n_q"], Float[Array, "n_q n_q"]],
    curvature: Float[Array, "n_x n_x"] | None,
    sigma: Float[Array, "n_e"],
    moved: Float[Array, "n_x"],
) -> Float[Array, ""]:
    """Largest 1/lambda that round-off of the stress resultants causes.

    Elastic stress resultants are wrong by stiffness times the round-off of the deformations, all of them by the
    round-off of the forces that they balance. `moved` are the coordinates whose round-off counts.
    """
    x, last_strain, jacobian, stiffness, dfx = tangent
    rows = jnp.abs(jacobian) * coordinate_scales(topology, parameters)
    largest = jnp.max(rows.T @ jnp.abs(sigma), initial=0.0)
    reach = jnp.max(rows, axis=1, initial=0.0)
    elastic = put(jnp.abs(stiffness) @ (jnp.abs(jacobian) @ jnp.abs(moved)), topology.e.held, 0.0)
    wrong = STRESS_ROUND_OFF * (elastic + jnp.where(reach > 0, largest / jnp.where(reach > 0, reach, 1.0), 0.0))
    relative = factorise(stiffnesses[0]).solve(
        dfx.T @ deformation_curvature(topology, parameters, x, last_strain, wrong) @ dfx
    )
    # The root of the trace of its square bounds its eigenvalues.
    noise = jnp.sqrt(jnp.abs(jnp.sum(relative * relative.T)))
    nothing = _is_nothing(topology, parameters, stiffnesses[1], curvature, dfx)
    return jax.lax.stop_gradient(jnp.where(nothing, jnp.inf, jnp.where(jnp.isfinite(noise), noise, 0.0)))


def _is_nothing(
    topology: Topology,
    parameters: Parameters,
    scaled: Float[Array, "n_q n_q"],
    curvature: Float[Array, "n_x n_x"] | None,
    dfx: Float[Array, "n_x n_q"],
) -> Bool[Array, ""]:
    """Whether the scaled stiffness is round-off, as for a bar along its own axis.

    Each entry of an element's curvature may be wrong by the round-off of the element's largest entry, in sizes of the
    coordinates.
    """
    if curvature is None:
        return jnp.array(True)
    sizes, most = jnp.asarray(coordinate_scales(topology, parameters)), jnp.zeros_like(scaled)
    for block in topology.blocks:
        if block.e.shape[1]:
            element_curvature, size = curvature[block.x[:, :, None], block.x[:, None, :]], sizes[block.x]
            largest = jnp.max(
                jnp.abs(element_curvature) * size[:, :, None] * size[:, None, :], axis=(1, 2), initial=0.0
            )
            reached = jnp.sum(jnp.abs(dfx[block.x]) / size[:, :, None], axis=1)
            most = most + (reached.T * largest) @ reached
    return jnp.all(jnp.abs(scaled) <= STRESS_ROUND_OFF * most)


def bounded_of(inverse: Float[Array, "n"], noise: Float[Array, ""]) -> Float[Array, "n"]:
    """Load multipliers from 1/lambda; infinite if unbounded, or below the round-off `noise`."""
    least = jnp.maximum(jnp.max(jnp.abs(inverse), initial=0.0) / UNBOUNDED_MULTIPLIER, noise)
    bounded = (jnp.abs(inverse) > least) & (inverse != 0)
    return jnp.where(bounded, 1 / jnp.where(bounded, inverse, 1.0), jnp.inf)


def _unsymmetric_pairs(k: Float[Array, "n n"], g: Float[Array, "n n"]):
    """Real 1/lambda (zero for complex ones and round-off), vectors, and the largest size of complex ones."""
    operator = factorise(k).solve(-g)
    inverse, vectors, conditions = general_eigen(operator)
    real = jnp.isfinite(inverse.real) & is_real(inverse) & _is_resolved(operator, inverse, conditions)
    complex_ones = jnp.max(jnp.where(real, 0.0, jnp.abs(inverse)), initial=0.0)
    return jnp.where(real, inverse.real, 0.0), vectors.real, complex_ones


def _is_resolved(
    operator: Float[Array, "n n"], values: Complex[Array, "n"], conditions: Float[Array, "n"]
) -> Bool[Array, "n"]:
    """Whether each eigenvalue of an unsymmetric matrix is known beside its round-off, which grows with its condition.

    Follower loads may have no multipliers: round-off then makes eigenvalues of K^-1 G, by a root of the order of its
    size.
    """
    operator, values = jax.lax.stop_gradient((operator, values))
    return len(values) * np.finfo(float).eps * jnp.linalg.norm(operator) * conditions < KNOWN_EIGENVALUE * jnp.abs(
        values
    )


@jit
def multipliers_of(
    k: Float[Array, "n n"], g: Float[Array, "n n"], noise: Float[Array, ""], *, unsymmetric: bool = False
) -> Float[Array, "n"]:
    """Real load multipliers by magnitude (tutorial WA 1239 (2012), eq. (A.2), solved for 1/lambda).

    Infinite if the load does not act, or only in complex pairs. `noise` is the 1/lambda of round-off; `unsymmetric`
    means no potential.
    """
    if unsymmetric:
        values, _, _ = _unsymmetric_pairs(k, g)
    else:
        # The constant stiffness may have any definiteness.
        inverse = jnp.linalg.eigvals(factorise(k).solve(-g))
        values = jnp.where(jnp.isfinite(inverse.real) & is_real(inverse), inverse.real, 0.0)
    bounded = bounded_of(values, noise)
    return bounded[jnp.argsort(jnp.abs(bounded))]


@kernel
def multipliers_about(topology: Topology, parameters: Parameters, m: Matrices) -> Float[Array, "n_q"]:
    """Load multipliers of a linearised state with all loads scaled."""
    _, jacobian = deformation_jacobian(topology, parameters, m.x, m.e)
    curvature = deformation_curvature(topology, parameters, m.x, m.e, m.sigma)
    tangent, sizes = (m.x, m.e, jacobian, m.S, m.DFx), coordinate_scales(topology, parameters)
    noise = _noise(topology, parameters, tangent, (m.K0, m.G0), curvature, m.sigma, sizes)
    return multipliers_of(m.K0, m.G0, noise, unsymmetric=lacks_potential(topology))


@kernel
def _buckling(topology: Topology, parameters: Parameters, target: LoadFactors):
    at, last_strain, result, *_ = solve_state(topology, parameters, target)
    return _buckling_about(topology, parameters, at, last_strain, result)


@kernel
def _buckling_at(
    topology: Topology, parameters: Parameters, factors: LoadFactors, x: Float[Array, "n_x"], near: Float[Array, "n_e"]
):
    """:func:`_buckling` about a known state."""
    at = state(topology, parameters, factors, x, near)
    return _buckling_about(topology, parameters, at, near, jnp.asarray(RESULTS.successful, jnp.int32))


def _buckling_about(
    topology: Topology, parameters: Parameters, at: State, last_strain: Float[Array, "n_e"], result: Int[Array, ""]
):
    """Multipliers, modes in the coordinates, whether complex ones hide a lower load, motion by the loads, and code."""
    k, g, noise = scaled_stiffness(topology, parameters, at, last_strain)
    dfx = at.transfer.DFx
    if lacks_potential(topology):
        inverse, vectors, complex_ones = _unsymmetric_pairs(k, g)
    else:
        inverse, vectors = pencil(-(g + g.T) / 2, (k + k.T) / 2)
        complex_ones = jnp.zeros(())
    order = jnp.argsort(-jnp.abs(jax.lax.stop_gradient(inverse)))
    inverse, vectors = inverse[order], vectors[:, order]
    multiplier = bounded_of(inverse, noise)
    hidden = (complex_ones > noise) & (complex_ones > jnp.max(jnp.abs(inverse), initial=0.0))
    stable = is_positive_definite((k + k.T) / 2)
    result = jnp.where((result == RESULTS.successful) & ~stable, RESULTS.unstable, result)
    grown = None if parameters.increment is None else curvature_of_increment(topology, parameters, at, last_strain)[2]
    return multiplier, dfx @ vectors, hidden, moved_by_loads(topology, parameters, at.x, grown), result


def _warn_of_moving(multiplier: Array, moved: Array, all_scaled: bool) -> None:
    """Warn if the loads move the mechanism far before it buckles, or in the given state."""
    lowest = np.min(np.abs(np.asarray(multiplier)), initial=np.inf)
    if np.isfinite(lowest) and lowest * float(moved) > FAR_BEFORE_BUCKLING:
        warn(
            f"At the load multiplier {lowest:.4g} these loads move the mechanism by {lowest * float(moved):.2g} times"
            " its extent, or turn it by as many radians. Linear buckling neglects this motion, and may be far off."
            " Follow the path (fm.path, mode 10)."
        )
    elif np.isfinite(lowest) and all_scaled and float(moved) > BENT_BY_LOADS:
        warn(
            f"At load factor 1, these loads move the mechanism by {float(moved):.2g} times its extent, or turn it by"
            f" as many radians. Load multipliers refer to this state: the lowest, {lowest:.4g} in size, times the loads"
            " is the buckling load only if it is 1. For multipliers about the unloaded mechanism, give the loads"
            " increment=True, or follow the path (fm.path, mode 10)."
        )


def _asked(model: Model, function: str, throw: bool, where: Where):
    """Multipliers and modes that a public function is asked for, and the linearisation of a path's state."""
    as_determined(model, function)
    lin, factors = _about(model, where, function)
    about = (model.topology, model.parameters, factors)
    answer = _buckling(*about) if lin is None else _buckling_at(*about, lin.x, lin.e)
    multiplier, shapes, hidden, moved, result = answer
    check_stiffness(model, result, throw)
    if is_concrete(hidden) and hidden:
        warn(
            "Follower loads, moments about fixed axes or laws without a potential act here. The load multipliers of"
            " smallest size are complex: before it buckles the mechanism may flutter, and load multipliers do not show"
            " flutter. Compute the poles under these loads (fm.poles, mode 7), or a path (fm.path, mode 10)."
        )
    if is_concrete((multiplier, moved, result)) and int(result) == RESULTS.successful:
        _warn_of_moving(multiplier, moved, model.parameters.increment is None and where.at is None)
    multiplier, shapes = or_nan((multiplier, shapes), result, throw)
    return multiplier, shapes, lin


def _about(model: Model, where: Where, function: str) -> tuple[Linearization | None, LoadFactors]:
    """State of a path and its load factors; or None and the load factors of the equilibrium to compute."""
    where.refuse(function)
    at = where.at
    if at is None:
        increment = 0.0 if where.increment is None else where.increment
        return None, load_factors_of(model, 1.0, increment, function)
    if not isinstance(at, ManyStates) or at.states().kind != "path":
        raise TypeError(f"Argument `at` of fm.{function} must be a Path of the model, not {kind_of(at)}.")
    return where.state(model, function), at.factors(-1 if where.step is None else where.step)


@unguarded
def buckling_loads(
    model: Model,
    *,
    count: int | None = None,
    sparse: bool | None = None,
    solver: str | LinearSolver | None = None,
    throw: bool = True,
    at: ManyStates | None = None,
    step: int | None = None,
    increment: float | None = None,
) -> Float[Array, "n_q"]:
    """Return the load multipliers of linear buckling.

    Args:
        model: Mechanism with loads; differentiable in ``model.parameters``. The multiplier scales the incremental
            loads, and the other loads are a constant preload. Without incremental loads it scales all loads, about the
            equilibrium under these loads. If these loads bend the mechanism, multiplier times loads depends on the
            size of the loads. It is the true buckling load only if the multiplier is 1.
        count: Number of multipliers of smallest size; all by default.
        sparse: Use sparse matrices; needs ``count``, but no degrees of freedom. See :func:`flexmb.equilibrium`. By
            default the size of the model decides, if ``count`` is given and no stiffness is negative. Multipliers by
            sparse matrices have first derivatives only.
        solver: "sparse", "dense", or a LinearSolver in place of sparse factors, as for :func:`flexmb.frequencies`.
        throw: Raise if the equilibrium fails or is unstable; sparse matrices always raise.
        at: Path of the model. The multipliers then refer to one of its states instead of an equilibrium.
        step: Number of the state of the path, from 0; -1 for the last.
        increment: Factor of the incremental loads in the initial state, () [-]; zero by default.

    Returns:
        (n_q,) or (count,) [-], sorted by magnitude, with sign; infinite if the load has no effect beyond round-off.

    Raises:
        ValueError: ``count`` is not positive, or missing with ``sparse``.
        AnalysisError: The equilibrium was not found, or its stiffness is not positive definite.
        NotImplementedError: A second derivative is computed with sparse matrices.

    Warns:
        FlexmbWarning: Loads or laws without a potential act, and the smallest multipliers are complex. Or the mechanism
            deflects by a large amount before it buckles. Or, without incremental loads, it deflects by more than 0.1 of
            its extent or 0.1 rad at load factor 1. Or there are fewer than ``count`` multipliers.

    Source:
        det(K0 + N0 + lambda G0) = 0, tutorial WA 1239 (2012), eq. (A.2).
    """
    how = throw, Where(at, step, None, increment)
    answer = _by_sparse(model, "buckling_loads", *how, count, asked_solver(sparse, solver))
    smallest = (_asked(model, "buckling_loads", *how) if answer is None else answer)[0]
    warn_of_fewer("buckling_loads", count, len(smallest), "load multipliers")
    return smallest[:count]


def _by_sparse(
    model: Model,
    function: str,
    throw: bool,
    where: Where,
    count: int | None,
    solver: LinearSolver | None,
    linearizes: bool = False,
) -> tuple[Any, Any, Linearization | None] | None:
    """Result of :func:`_asked` by sparse factors, for ``count`` multipliers; None if dense matrices answer.

    ``linearizes``: whether to linearise about the equilibrium first, which has no derivative.
    """
    if count is not None:
        check_whole("count", count, 1)
    model = as_model(model, function)
    by_factors = solver not in (None, DENSE)
    if by_factors and count is None:
        raise ValueError("With `sparse` give a Model and `count`, the number of load multipliers wanted.")
    large = is_large(model) or (isinstance(where.at, ManyStates) and where.at.by_sparse)
    chosen = solver is None and throw and large and few_of(model, count)
    if count is None or not (by_factors or chosen):
        return None
    about, factors = _about(model, where, function)
    try:
        about = linearized_by_elements(model, factors) if about is None and linearizes else about
        values, shapes, moved = sparse_multipliers(model, factors, int(count), about, solver or SPARSE)
        if is_concrete((values, moved)):
            _warn_of_moving(values, moved, model.parameters.increment is None and where.at is None)
        return values, shapes, about
    except ModelError as refused:
        try:
            as_determined(model, function)
        except ModelError:
            # Dense matrices cannot answer either: report the reason of the sparse ones.
            raise refused from None
        if by_factors:
            raise
    return None


@unguarded
def buckling(
    model: Model,
    *,
    count: int | None = None,
    sparse: bool | None = None,
    solver: str | LinearSolver | None = None,
    throw: bool = True,
    at: ManyStates | None = None,
    step: int | None = None,
    increment: float | None = None,
) -> Buckling:
    """Return load multipliers and modes of linear buckling.

    Args:
        model: Mechanism with loads; see :func:`buckling_loads`.
        count, sparse, solver, throw, at, step, increment: As for :func:`buckling_loads`.

    Returns:
        Buckling with multipliers (n,) [-] and shapes (n_x, n), without infinite multipliers.

    Raises:
        AnalysisError: See :func:`buckling_loads`.
        TypeError: Numbers are traced; use :func:`buckling_loads`.

    Warns:
        FlexmbWarning: See :func:`buckling_loads`. There are fewer than ``count`` finite multipliers.

    Source:
        See :func:`buckling_loads`.
    """
    if not is_concrete(model):
        raise TypeError(
            "The number of bounded load multipliers depends on traced numbers. Use fm.buckling_loads under jax.grad and"
            " jax.jit."
        )
    where = Where(at, step, None, increment)
    answer = _by_sparse(model, "buckling", throw, where, count, asked_solver(sparse, solver), linearizes=True)
    multiplier, shapes, lin = _asked(model, "buckling", throw, where) if answer is None else answer
    bounded = int(np.sum(np.isfinite(multiplier)[:count]))
    warn_of_fewer("buckling", count, bounded, "finite load multipliers")
    multiplier, shapes = np.asarray(multiplier), np.asarray(shapes)[:, :bounded]
    largest = shapes[np.argmax(np.abs(shapes), axis=0), np.arange(bounded)]
    lin = lin or linearize(model, increment=increment or 0.0, throw=throw)
    return Buckling(jax.device_put(multiplier[:bounded]), jax.device_put(shapes / largest), lin)
