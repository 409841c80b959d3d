"""Equations of motion, integrated by diffrax."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import diffrax
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..numerical_limits import SAME_TIME, SHORTEST_TIME_STEP
from ..results import RESULTS
from .balance import Balance, Before, elastic_energy, is_seen
from .chain_form import ChainForm
from .events import passing_of
from .integrator import Integrator
from .kinks import kinks_of
from .protocol import Equations, MotionState
from .rosenbrock import Rodas5P
from .solver import MotionTerm, Projected
from .step_control import DisplacementController
from .steps_again import Span


class Solved(NamedTuple):
    """Result of the steps.

    Attributes:
        states: States at the times, in rows; infinite if not reached.
        moved: Greatest displacement so far (extents, radians).
        steps: Number of steps.
        result: Code of RESULTS.
        jumped: Whether a force has jumped, if that was checked.
        balance: Energy balance.
    """

    states: MotionState
    moved: Float[Array, ""]
    steps: Int[Array, ""]
    result: Int[Array, ""]
    jumped: Bool[Array, ""] | bool
    balance: Balance


def solve(
    equations: Equations,
    span: Span,
    start: MotionState,
    integrator: Integrator,
    before: Before,
    parts: float,
    *,
    adjoint: diffrax.AbstractAdjoint,
    every: bool,
    recorded: bool = False,
) -> tuple[Solved, Float[Array, "most"] | None]:
    """States at times and, if recorded, the ends of all kept steps, (max_steps,) [s], infinite beyond the last.

    Args:
        before: Values that control the first step.
        parts: The first step is at most this fraction of the time.
        adjoint: How diffrax differentiates.
        every: Whether steps across all kinks are short, as for derivatives.
    """
    t0, t1, times, _, _ = span
    solver, controller = _solver_and_steps(equations, integrator, span, start, before, every)
    equal = isinstance(controller, diffrax.ConstantStepSize)
    z0, regular = equations.acceleration(t0, start)
    # Without mass in every motion nothing is integrated.
    t1, times = jnp.where(regular, t1, t0), jnp.where(regular, times, t0)
    fast = jax.lax.stop_gradient(jnp.max(jnp.abs(z0[: equations.size]), initial=1e-30))
    rows = diffrax.SubSaveAt(ts=times)
    solution = diffrax.diffeqsolve(
        MotionTerm(equations),
        solver,
        t0,
        t1,
        _first_step(integrator, fast, t1 - t0, parts, equal),
        start,
        saveat=diffrax.SaveAt(
            subs=[rows, diffrax.SubSaveAt(steps=True, fn=lambda t, y, args: t)] if recorded else [rows],
            controller_state=True,
        ),
        stepsize_controller=controller,
        adjoint=adjoint,
        event=integrator.event,
        max_steps=integrator.max_steps,
        solver_state=z0 if isinstance(solver, Rodas5P) else None,
        throw=False,
    )
    saved: Any = solution.ys
    states = saved[0]
    if integrator.event is not None:
        # A motion that ends at its first time still has its start.
        states = jax.tree.map(lambda row, first: jnp.where((times <= t0)[:, None], first, row), states, start)
    result = _code(solution, states, equal, integrator.event)
    result = jnp.where(regular, result, RESULTS.singular_mass).astype(jnp.int32)
    state: Any = solution.controller_state
    if isinstance(controller, diffrax.ClipStepSizeController):
        controller, state = controller.controller, state.inner_state
    jumped = jnp.zeros((), bool)
    if isinstance(controller, DisplacementController):
        _, before, search = state
        jumped = search.jumped
    steps = solution.stats["num_steps"].astype(jnp.int32)
    return Solved(states, before.moved, steps, result, jumped, before.balance), saved[1] if recorded else None


def _solver_and_steps(
    equations: Equations, integrator: Integrator, span: Span, start: MotionState, before: Before, every: bool
) -> tuple[Any, Any]:
    """Solver and step size controller of diffrax, as given or chosen."""
    controller, jumps = integrator.controller, span.jumps
    solver = Rodas5P(jumps=jumps is not None) if integrator.solver is None else integrator.solver
    adapts = isinstance(solver.solver if isinstance(solver, Projected) else solver, diffrax.AbstractAdaptiveSolver)
    if controller is None and not adapts:
        controller = diffrax.ConstantStepSize()
    elif controller is None:
        if isinstance(solver, Rodas5P) and not isinstance(equations, ChainForm):
            solver = Rodas5P(solver.jumps, balanced=True)
            begun = jax.lax.stop_gradient(elastic_energy(equations, span.t0, start))
            before = before._replace(balance=before.balance.with_energy(begun))
        balanced = isinstance(solver, Rodas5P) and solver.balanced
        controller = DisplacementController(
            rtol=integrator.rtol,
            atol=integrator.atol,
            pcoeff=0.1,
            icoeff=0.3,
            dtmin=SHORTEST_TIME_STEP * (span.t1 - span.t0),
            force_dtmin=False,
            before=before,
            states=equations.states,
            equations=equations if is_seen(equations) and not balanced else None,
            kinks=kinks_of(equations, every),
            passing=passing_of(integrator.event, equations.states),
        )
    if isinstance(solver, Projected):
        solver = solver.with_tolerances(controller)
    onto: Any = {"step_ts": span.stops, "jump_ts": jumps}
    adaptive = isinstance(controller, diffrax.AbstractAdaptiveStepSizeController)
    if adaptive and any(stops is not None for stops in onto.values()):
        controller = diffrax.ClipStepSizeController(controller, **onto)
    return solver, controller


def _code(solution: Any, states: MotionState, equal: bool, event: Any) -> Int[Array, ""]:
    """Code of RESULTS of a solution of diffrax."""
    outcome, codes = solution.result, diffrax.RESULTS
    failed = RESULTS.step_too_large if equal else RESULTS.step_too_small
    result = jnp.where(outcome == codes.successful, RESULTS.successful, failed)
    result = jnp.where(outcome == codes.max_steps_reached, RESULTS.motion_unfinished, result)
    result = jnp.where(outcome == codes.internal_error, RESULTS.ran_away, result)
    if event is not None:
        ends = outcome == codes.event_occurred
        lost = functools.reduce(jnp.logical_or, jax.tree.leaves(solution.event_mask)) & ~ends
        return jnp.where(ends, RESULTS.successful, jnp.where(lost, RESULTS.event_not_found, result))
    wrong = (result == RESULTS.successful) & ~jnp.all(jnp.isfinite(states.u))
    return jnp.where(wrong, failed, result)


def _first_step(integrator: Integrator, fast: Float[Array, ""], span: Float[Array, ""], parts: float, equal: bool):
    """First step: as given, or a step in which the greatest acceleration causes a motion of some ten tolerances."""
    requested = jnp.asarray(integrator.dt0)
    guess = jnp.fmin(jnp.sqrt(20 * (integrator.rtol + integrator.atol) / fast), span / parts)
    first = jnp.where(requested > 0, requested, guess)
    if not equal:
        return first
    # Round-off must not add a step to a whole number of equal steps.
    steps = jnp.round(span / first)
    return jnp.where(jnp.abs(span / first - steps) < SAME_TIME * steps, span / steps, first)
