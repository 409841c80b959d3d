"""Static equilibrium of a mechanism under its loads."""

import functools
from typing import Any, ClassVar, Literal

import jax
import numpy as np
from jaxtyping import Array, Float, Int

from ..arguments import is_concrete, undifferentiated
from ..checks.mobility import allowed_motions, constraints, shares
from ..compilation.compile import unguarded
from ..compilation.record import Record, static
from ..display import Result, States, Summary, largest, short, unit_of_force
from ..math.by_deformations import motions_from_free
from ..math.element_matrices import AssembledEquations
from ..math.linear_solver import DENSE, SPARSE, LinearSolver
from ..math.sparse import unresisted
from ..math.subspace import null_spaces
from ..mechanics.inertia import InertialLoad
from ..mechanics.loads import LoadFactors, lacks_potential, load_factors_of
from ..mechanics.prepared import kernel
from ..mechanics.stress_resultants import has_law, is_nonlinear, known_stiffness_pieces
from ..model.by_name import TURN_OF, ByName
from ..model.model import Labels, Model, as_determined, as_model
from ..model.topology import Parameters, Topology
from ..numerical_limits import LOOSE_BY_ROUND_OFF, NO_STIFFNESS
from ..results import RESULTS, check, or_nan, outcome_text
from .coarse import warn_of_coarse
from .solve import acting_at, solve_state
from .solver_choice import LARGE, is_long_chain, solver_for
from .sparse import sparse_equilibrium, undeformed_elements
from .stable import collect_unstable, unstable_motions, warn_of_unstable

# Failures that a motion without stiffness may cause.
STIFFNESS_MISSING = (RESULTS.not_converged, RESULTS.singular_stiffness)


class Equilibrium(ByName, Result, Record):
    """Static equilibrium under constant loads.

    Attributes:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        e: Deformations, (n_e,) [m, rad].
        sigma: Stress resultants; for FIXED deformations the constraint force, (n_e,) [N, N m].
        felt: Gravity, which acts on the mass along the elements.
        reactions: Force of the supports on the mechanism, dual to x, (n_x,) [N, N m]; zero without a support.
        external: Loads except weight, plus reactions, dual to x, (n_x,) [N, N m].
        iterations: Newton iterations of all load steps.
        result: Code of RESULTS. After critical_state the state is correct, but its derivative is not.
        labels: Names.
    """

    x: Float[Array, "n_x"]
    e: Float[Array, "n_e"]
    sigma: Float[Array, "n_e"]
    felt: InertialLoad
    reactions: Float[Array, "n_x"]
    external: Float[Array, "n_x"]
    iterations: Int[Array, ""]
    result: Int[Array, ""]
    labels: Labels = static()
    one_axis = "x"
    # The model, if its numbers were known; no field, since nothing is computed with it.
    asked_of: ClassVar[Model | None] = None
    # Factors of its loads, likewise.
    factors: ClassVar[LoadFactors | None] = None

    def __getstate__(self) -> dict[str, Any]:
        """Its fields alone: the model may contain functions that no file can store."""
        return {name: value for name, value in vars(self).items() if name not in ("asked_of", "factors")}

    def states(self) -> States | None:
        """Return the equilibrium as a state of its model; None if the model is not stored in it.

        Raises:
            AnalysisError: The equilibrium was not found.
        """
        if self.asked_of is None:
            return None
        check(self.result, True, "There is no state to show.")
        return States(self.asked_of, self.x)

    def known(self, model: Model, factors: LoadFactors) -> "Equilibrium":
        """Return itself, with its model and its loads.

        Args:
            model: The mechanism, with concrete numbers.
            factors: Factors of its loads.
        """
        vars(self).update(asked_of=model, factors=factors)
        return self

    def summary(self) -> Summary:
        """Return the outcome, and the largest deformation, stress resultant and reaction with their names."""
        rows = {
            "result": outcome_text(self.result),
            "iterations": str(int(self.iterations)),
            "largest deformation": largest(self.e, self.labels.e, "[m, rad]"),
            "largest stress resultant": largest(self.sigma, self.labels.e, "[N, N m]"),
            "largest reaction": largest(self.reactions, self.labels.x, unit_of_force),
        }
        return Summary(f"Equilibrium: {len(self.x)} coordinates, {len(self.e)} deformations", rows)


@kernel
def _equilibrium(topology: Topology, parameters: Parameters, target: LoadFactors):
    at, _, result, iterations, reached = solve_state(topology, parameters, target, tell_critical=True)
    answer = at.x, at.e, at.sigma, *acting_at(topology, parameters, at), iterations, result
    # Only for checks: their derivatives would take longer than all others.
    k0 = at.K0
    return answer, jax.lax.stop_gradient((k0 + at.G0, k0, at.transfer.DFx, reached))


@unguarded
def equilibrium(
    model: Model,
    *,
    load_factor: float = 1.0,
    increment: float | None = None,
    sparse: bool | None = None,
    solver: Literal["dense", "sparse"] | LinearSolver | None = None,
    throw: bool = True,
) -> Equilibrium:
    """Return the static equilibrium under the constant loads.

    Newton's method iterates over configurations that satisfy the constraints. flexmb estimates the constraint forces
    before the first step, since the stiffness of a hanging body comes from these forces. Beyond a buckling load the
    result may be an unstable state, with a warning. :func:`flexmb.path` follows the path to a stable state.

    Args:
        model: Mechanism; differentiable in ``model.parameters``.
        load_factor: Factor of the loads, () [-].
        increment: Factor of the incremental loads, () [-]; zero by default.
        sparse: True is ``solver="sparse"``, False ``solver="dense"``.
        solver: "sparse" for sparse matrices in all coordinates. They need no degrees of freedom
            (``Builder.build(check=False)``). "dense" for dense matrices, or a
            :class:`flexmb.math.linear_solver.LinearSolver`. None: sparse for a large mechanism or a long chain,
            otherwise dense.
        throw: Raise if the solve fails; otherwise the code is in ``result``. A critical state does not raise: check
            ``result`` before using a derivative.

    Returns:
        Equilibrium with x (n_x,) [m, rad, -], e and sigma (n_e,) [m, rad; N, N m], reactions (n_x,) [N, N m].

    Raises:
        AnalysisError: singular_configuration, singular_stiffness or not_converged. The message states what to try.
        ValueError: A factor is not finite, there are no incremental loads, or ``sparse`` contradicts ``solver``.

    Warns:
        FlexmbWarning: There are incremental loads, and ``increment`` is not given; or the state is not stable. (For
            traced numbers there is no warning: check the signs of :func:`flexmb.frequencies`.)
        CoarseWarning: A beam is bent or twisted too far for the accuracy of one beam, or stretched by more than 1 %.

    Source:
        THEORY.md 4, 5 and 7, eq. (5.1) and (7.1).
    """
    model = as_model(model, "equilibrium")
    chosen, free = solver_for(model, sparse, solver), sparse is None and solver is None
    if free and chosen == DENSE and is_concrete(model) and is_long_chain(model.topology):
        chosen = SPARSE
    in_coordinates = chosen != DENSE
    model = model if in_coordinates else as_determined(model, "equilibrium")
    target = load_factors_of(model, load_factor, increment, "equilibrium")
    solve: Any = functools.partial(sparse_equilibrium, solver=chosen) if in_coordinates else _equilibrium
    solution, looked_at = solve(model.topology, model.parameters, target)
    solved = Equilibrium(*solution, labels=model.labels)
    about = ""
    if not in_coordinates and is_concrete(reached := undifferentiated(looked_at[-1])):
        about = f"Load steps reached {load_factor_text(model, reached)}."
    check_stiffness(model, solved.result, throw, about)
    if known := is_concrete((model, solved, looked_at)):
        solved.known(model, target)
    solved = or_nan(solved, solved.result, throw)
    if known and int(solved.result) == RESULTS.successful:
        warn_of_coarse(model, solved.e)
        if in_coordinates and looked_at:
            warn_of_unstable(model)
        elif not in_coordinates:
            stiffness, structural, to_x, _ = looked_at
            motions = unstable_motions(stiffness, structural, not lacks_potential(model.topology))
            if motions.shape[1]:
                warn_of_unstable(model, np.asarray(to_x) @ motions)
    elif throw and not in_coordinates:
        stiffness, structural, *_ = looked_at
        collect_unstable([stiffness], structural, not lacks_potential(model.topology))
    return solved


def load_factor_text(model: Model, factors: LoadFactors) -> str:
    """Load factors in words, for a message."""
    loads, more = (short(float(np.asarray(factor))) for factor in factors)
    return f"load factor {loads}" if model.parameters.increment is None else f"increment {more} and load factor {loads}"


def check_stiffness(model: Model, result: Any, throw: bool, reached: str = "") -> None:
    """:func:`flexmb.results.check`, with the names of motions that nothing elastic resists.

    ``reached`` is a sentence on how far the search came.
    """
    known, code = undifferentiated((model, result))
    about = [reached] if reached else []
    if throw and is_concrete((known, code)) and int(code) in STIFFNESS_MISSING:
        if missing := without_stiffness(known):
            check(RESULTS.singular_stiffness, throw, missing)
        bends = sorted({block.element.name for block in known.topology.blocks if has_law(block)})
        if bends and int(code) == RESULTS.not_converged:
            about.append(
                f"A law of {', '.join(bends)} has a sharp bend, such as a stop. The search may fail at this bend. Round"
                " it, such as by jnp.logaddexp."
            )
    check(result, throw, " ".join(about))


def without_stiffness(model: Model) -> str:
    """Sentence on motions without any elastic deformation of the undeformed mechanism; or empty."""
    topology = model.topology
    if is_nonlinear(topology):
        return ""
    loose = _loose_of_large(model) if topology.n_x > LARGE else _loose_motions(model)
    return _loose_note(model, loose) if loose.shape[1] else ""


def _loose_motions(model: Model) -> np.ndarray:
    """Motions without stiffness, (n_x, k), of any number."""
    topology = model.topology
    elastic = np.zeros(topology.n_e, bool)
    for at, _, matrices in known_stiffness_pieces(topology, model.parameters):
        elastic[np.asarray(at)] |= np.einsum("eii->ei", np.asarray(matrices)) > 0
    elastic[np.asarray(topology.e.held)] = False
    constraint_set = constraints(model)
    motions, _ = allowed_motions(model, constraint_set)
    _, _, free = null_spaces(constraint_set.jacobian[elastic] @ motions)
    return constraint_set.motion(motions @ free, np.arange(topology.n_x))


def _loose_of_large(model: Model) -> np.ndarray:
    """The motion without stiffness, (n_x, 1), or none, by sparse factors."""
    assembled = AssembledEquations(jax.tree.map(np.asarray, undeformed_elements(model.topology, model.parameters)))
    motion = unresisted(assembled.at(), assembled.n)
    if motion is None:
        return np.zeros((model.topology.n_x, 0))
    stiffness = assembled.at()[: assembled.n, : assembled.n]
    stiffnesses, resistance = np.abs(stiffness.diagonal()), abs(motion @ stiffness @ motion)
    least = max(NO_STIFFNESS * np.sum(motion**2 * stiffnesses), LOOSE_BY_ROUND_OFF * np.max(stiffnesses))
    if resistance > least:
        return np.zeros((model.topology.n_x, 0))
    return motions_from_free(assembled.elements, motion[:, None])


def _loose_note(model: Model, loose: np.ndarray) -> str:
    names = "; ".join(
        ", ".join(f"{s.of}.{s.symbol} ({s.share:.2g})" for s in shares(motion, model.labels.x)[:4])
        for motion in loose.T
    )
    turned = any(name.startswith(TURN_OF) for name, *_ in model.labels.elements)
    tilts = ' A rotation turned about one axis is free about the others, unless tilt="fixed".' if turned else ""
    return (
        f"In the undeformed mechanism nothing elastic resists {names}. Fix it, stiffen it, or clamp what is pinned"
        f" there (a rigid_beam does not turn the rotation of its second node; a rigid_body does).{tilts}"
    )
