"""Codes of success and failure of an analysis.

Compiled kernels return the integer; Python turns it into a member or raises its message. ``equinox.Enumeration`` would
do the same, but its comparisons run array operations on the host, which slows a new process.
"""

import enum
import functools
import operator
from typing import Any

import jax
import jax.core
import jax.numpy as jnp
import numpy as np

from .arguments import check_flag, undifferentiated
from .collecting import Collector
from .errors import AnalysisError


class RESULTS(enum.IntEnum):
    """Outcome of an analysis; ``message`` states what to try."""

    message: str

    def __new__(cls, value: int, message: str):
        """Make a member with its text."""
        member = int.__new__(cls, value)
        member._value_ = value
        member.message = message
        return member

    successful = 0, ""
    not_finite = (
        1,
        "A matrix of the analysis is not finite. The mechanism may be in a configuration where an element is"
        " undefined, such as a length of zero; check its numbers.",
    )
    singular_configuration = (
        2,
        "The degrees of freedom do not determine the configuration: the constraint matrix is singular, as at a dead"
        " point. Name other degrees of freedom, or run the mobility analysis to see which nodes and elements take"
        " part.",
    )
    not_converged = (
        3,
        "The static equilibrium was not found, with load steps down to the smallest allowed. The load may be beyond"
        " what the mechanism can carry (a limit load): lower it, or use more elements.",
    )
    unstable = (
        4,
        "The stiffness K0 + N0 at the equilibrium is not positive definite, and load multipliers are counted from a"
        " stable state: support or stiffen the free motion, or lower the load.",
    )
    singular_mass = (
        5,
        "The mass matrix is singular: a motion carries no mass, or a negative mass. Add mass or inertia to its nodes,"
        ' or make that degree of freedom dependent. A simulation with form="reduced" needs mass only along the degrees'
        " of freedom.",
    )
    singular_stiffness = (
        6,
        "The static equations are singular: a motion has no stiffness, or the load is a critical load. Support or"
        " stiffen that motion, or change the load.",
    )
    max_steps = (
        7,
        "The path did not reach its end within the allowed number of steps. Allow more steps (max_steps, --max-steps),"
        " or look at the path so far: it may turn back and never reach its end.",
    )
    critical_state = (
        8,
        "The equilibrium was found, but at a critical state: the loads reduce the stiffness of a motion to less than a"
        " ten-thousandth. The derivative does not exist, or is valid for no finite change. Lower the load, follow the"
        " path, or differentiate limit_load.",
    )
    out_of_reach = (
        9,
        "There is no configuration with these degrees of freedom: the mechanism cannot be assembled there, or they"
        " exceed 20 000 radians or 20 000 times its size. Check their values, or name others.",
    )
    step_too_small = (
        10,
        "The motion could not be followed: the time step became too small. A mass may be missing or negative, a load"
        " may jump (name the time in `jumps`), or the motion itself may run away; the results up to there are kept.",
    )
    motion_unfinished = (
        11,
        "The motion did not reach its end within the allowed number of steps. Allow more (max_steps), ask for less"
        " accuracy (rtol), or use a solver for stiff motion. A stiff element that the start strains vibrates at every"
        " step: give it damping, or start it unstrained; the results up to there are kept.",
    )
    step_too_large = (
        12,
        "With steps of this size the motion runs away, or the equations of a step are not solved. Take a smaller dt0,"
        " or the default solver, which finds its steps itself; the results up to there are kept.",
    )
    stopped = (
        13,
        "The analysis was stopped from the keyboard; the results up to there are kept.",
    )
    closed_path = (
        14,
        "The path came back to a state that it had passed before: it is closed and does not reach its end. Follow"
        " another branch (switch, imperfection), start from other loads, or look at the path so far.",
    )
    ran_away = (
        15,
        "The motion runs away: a coordinate exceeds a hundred million radians, or a hundred million times the size of"
        " the mechanism. The loop of a controller is unstable (see fm.control.closed_loop), a"
        " stiffness or damping is negative, or a load grows without bound. The results up to there are kept.",
    )
    lost_in_round_off = (
        16,
        "Stiffnesses differ so much that round-off of the largest hides the softest motions. The answer would be wrong."
        " Make very stiff parts rigid, such as very short beams: leave out their sections, or join their nodes. Use"
        " fewer beams if thousands are in a row. Deformations as degrees of freedom, as build() finds them, lose fewer"
        " digits than positions.",
    )
    unstable_state = (
        17,
        "The equilibrium was found, but it is not stable: its stiffness is negative in some motion. No mechanism stays"
        " there by itself. Lower the load, or follow the path to a stable state by fm.path(model, switch=True).",
    )
    other_clamps = (
        18,
        "Ends of leaf springs are clamped differently in this design and in the first design, but all designs share one"
        " structure. A neighbouring part passed three times the thickness, or a fold passed 5 degrees. Set `clamped`"
        " for all designs, or begin with a design on the same side.",
    )
    forces_jump = (
        19,
        "The force of a law or of a controller jumps as the mechanism moves. The derivative is wrong, since it neglects"
        " that the time of the jump changes: replace the jump by a steep function, such as jnp.tanh.",
    )
    impossible_design = (
        20,
        "No mechanism has these dimensions: a size, a modulus or a mass is not positive, an element has no length, a"
        " number is not finite, or the constraints do not fit. Keep them out by the bounds, or build the model from"
        " these dimensions alone: the error states the fault.",
    )
    infeasible = (
        21,
        "No design within the bounds meets the limits. Widen the bounds or the limits, or start elsewhere (starts).",
    )
    not_optimal = (
        22,
        "The design did not settle within the allowed number of evaluations. Allow more (max_evaluations), or look at"
        " the history: the best design so far is returned.",
    )
    target_missed = (
        24,
        "A target is missed: bounds, limits or other targets prevent it. Widen the bounds or the limits, let more"
        " dimensions vary, or change the target.",
    )
    local_minimum = (
        25,
        "A target is missed: no small change of the dimensions brings the design nearer, although no bound and no limit"
        " is active. This is a local minimum, or targets contradict each other. Start elsewhere (starts).",
    )
    poor_fit = (
        34,
        "The model does not fit the data: its differences are larger than the stated scatter explains. Look at the"
        " residuals, state a larger scatter, fit more parameters, or start elsewhere (starts).",
    )
    event_not_found = (
        23,
        "An event has ended the motion, but the root finder of `event` did not find its time. Give the root finder"
        " larger tolerances or more steps, or use a method that stays within the step (optimistix.Bisection for one"
        " condition). Without a root finder, the motion ends with the step.",
    )
    outside_workspace = (
        30,
        "The trajectory leaves the workspace: the mechanism cannot be assembled there, or a driven coordinate cannot"
        " continue in that direction. Shorten the trajectory, or drive another degree of freedom (driven).",
    )
    singular_plant = (
        31,
        "The inputs cannot produce the forces along the driven motions: their effects depend on one another, or an"
        " input has no effect. Let them act elsewhere, or name other inputs.",
    )
    out_of_memory = (
        32,
        "The memory does not suffice for the factors of the equations. Use fewer elements, such as spectral beams"
        " instead of many short ones, or a machine with more memory.",
    )
    neutral_branch = (
        33,
        "Two motions lose their stiffness at once, and one of them has no stiffness along the branch. A round or square"
        " bar, for example, may buckle to any side. The path is therefore not determined. Choose a side by an"
        " imperfection, such as imperfection={1: 1e-3}, or by a small load.",
    )


# Outcomes with an answer, best first. A critical state and jumping forces have no derivative; a mechanism does not stay
# in an unstable state.
NO_DERIVATIVE = (RESULTS.critical_state, RESULTS.forces_jump)
ANSWERED = (RESULTS.successful, *NO_DERIVATIVE, RESULTS.unstable_state)


def outcome_text(result: Any) -> str:
    """Name of an outcome by its code, and for a failure its message."""
    member = RESULTS(int(result))
    return f"{member.name}. {member.message}" if member.message else member.name


_CODES = Collector("codes")
# Collect codes that analyses would raise outside a trace, while a function of designs is traced.
collected = _CODES.collecting


def check(result: Any, throw: bool, about: str = "") -> None:
    """Raise AnalysisError if a code, () or a batch, is a failure; collect traced codes.

    Codes in ``ANSWERED`` are successes. ``throw=False`` does nothing. ``about`` is added to the message.
    """
    check_flag("throw", throw)
    if not throw:
        return
    result = undifferentiated(result)
    if isinstance(result, jax.core.Tracer):
        collect(result)
        return
    codes = np.asarray(result)
    # A single code is the usual case, and needs no array operations.
    batch = codes.ndim > 0
    worst = int(np.max(np.where(np.isin(codes, ANSWERED), RESULTS.successful, codes)) if batch else codes)
    if worst not in ANSWERED:
        member = RESULTS(worst)
        raise AnalysisError(member.name, member.message + (f" {about}" if about else ""))


def or_nan(answer: Any, result: Any, throw: bool = True, of: Any = ()) -> Any:
    """A traced answer that is NaN after a failure, since a trace cannot raise.

    Derivatives with respect to the numbers ``of`` are then NaN too. The answer is unchanged if codes are collected, and
    with ``throw=False``. For a batch of codes, each array has the batch as its first axis.
    """
    if not throw or not isinstance(result, jax.core.Tracer) or collects():
        return answer
    failed = functools.reduce(operator.and_, [result != int(code) for code in ANSWERED])
    # Sums and products make derivatives NaN too, not zero. A product with varying numbers would lose them where part of
    # the answer is NaN by itself, as after the event that ends a motion.
    factor, lost = jnp.where(failed, jnp.nan, 1.0), 0.0
    for number in jax.tree.leaves(of):
        if isinstance(number, jax.core.Tracer) and jnp.issubdtype(number.dtype, jnp.floating):
            known = jnp.where(jnp.isfinite(number), number, 0.0)
            lost = lost + jnp.where(failed, jnp.nan, 0.0) * jnp.sum(known - jax.lax.stop_gradient(known))

    def marked(number: Any) -> Any:
        if not isinstance(number, jax.core.Tracer) or not jnp.issubdtype(number.dtype, jnp.inexact):
            return number
        if jnp.iscomplexobj(number):
            return jax.lax.complex(marked(jnp.real(number)), marked(jnp.imag(number)))
        shape = failed.shape + (1,) * (number.ndim - failed.ndim)
        return number * factor.reshape(shape) + jnp.reshape(lost, shape if jnp.ndim(lost) else ())

    return jax.tree.map(marked, answer)


def collects() -> bool:
    """Whether codes are collected here."""
    return _CODES.here() is not None


def collect(result: Any) -> None:
    """Collect a code, () or a batch, possibly traced, if codes are collected here."""
    if (codes := _CODES.here()) is not None:
        codes.append(result)


def worst_of(codes: list[Any]) -> Any:
    """The first failure among codes, each () or a batch; without one, the worst outcome with an answer."""
    worst_code: Any = jnp.zeros((), jnp.int32)
    grade = worst_code
    for code in codes:
        flat_codes = jnp.ravel(jnp.asarray(code, jnp.int32))
        graded = jnp.full_like(flat_codes, len(ANSWERED))
        for i, result in enumerate(ANSWERED):
            graded = jnp.where(flat_codes == int(result), i, graded)
        worst = jnp.argmax(graded)
        worse = graded[worst] > grade
        worst_code, grade = jnp.where(worse, flat_codes[worst], worst_code), jnp.where(worse, graded[worst], grade)
    return worst_code
