"""Why a solve succeeded or failed.

Compiled kernels return the integer; the wrapper in Python turns it into a member or raises its text. An
``equinox.Enumeration`` would do the same, but comparing its members runs array operations on the host, which a fresh
process pays for.
"""

import enum
import functools
import operator
from typing import Any

from .collecting import Collector
from .errors import AnalysisError


class RESULTS(enum.IntEnum):
    """Outcome of an analysis; each message says what to try.

    Attributes:
        message: The text for a person.
    """

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
        "The mass matrix is singular: some motion carries no mass, or a negative one. Add mass or inertia to its nodes,"
        ' or make that degree of freedom dependent; in a simulation form="reduced" asks for mass of the degrees of'
        " freedom alone.",
    )
    singular_stiffness = (
        6,
        "The static equations are singular: a motion meets no stiffness, or the load is a critical load."
        " Support or stiffen that motion, or change the load.",
    )
    max_steps = (
        7,
        "The path did not reach its end within the allowed number of steps. Allow more steps (max_steps,"
        " --max-steps), or look at the path so far: it may turn back for good.",
    )
    critical_state = (
        8,
        "The equilibrium was found, but at a critical state: the loads take away all but a ten-thousandth of the"
        " stiffness of some motion, so that the derivative does not exist or holds for no finite change. Lower the"
        " load, follow the path, or differentiate limit_load.",
    )
    out_of_reach = (
        9,
        "There is no configuration with these degrees of freedom: the mechanism cannot be assembled there, or they are"
        " beyond 20 000 radians or times its size. Check their values, or name others.",
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
        "It was stopped from the keyboard; the results up to there are kept.",
    )
    closed_path = (
        14,
        "The path came back to a state that it had passed before: it is closed and does not reach its end. Follow"
        " another branch (switch, imperfection), start from other loads, or look at the path so far.",
    )
    ran_away = (
        15,
        "The motion runs away: something has moved a hundred million times the size of the mechanism, or radians. The"
        " loop of a controller is unstable, as fm.control.closed_loop(model, controller) tells, a stiffness or damping"
        " is negative, or a load grows without bound; the results up to there are kept.",
    )
    lost_in_round_off = (
        16,
        "Stiffnesses are so far apart that round-off of the largest hides the softest motions, and the answer would be"
        " wrong. Make rigid what is that stiff, such as a very short beam: leave out its section, or join its nodes. Of"
        " thousands of beams in a row take fewer. Degrees of freedom that are deformations, as build() finds them, lose"
        " fewer digits than positions.",
    )
    unstable_state = (
        17,
        "The equilibrium was found, but it is not stable: its stiffness is negative in some motion, so that no"
        " mechanism stays there by itself. Lower the load, or follow the way to a stable state by fm.path(model,"
        " switch=True).",
    )
    other_clamps = (
        18,
        "Ends of leaf springs are clamped otherwise in this design than in the first one, whose structure all designs"
        " have: a part beside one is three times as thick and was not, or is no more, or a fold passed 5 degrees. Say"
        " with `clamped` what holds for all, or begin with a design on the same side.",
    )
    forces_jump = (
        19,
        "The force of a law or of a controller jumps as the mechanism moves. A derivative leaves out that the instant"
        " of the jump moves, and is wrong: make the force steep in place of a jump, such as by jnp.tanh.",
    )
    impossible_design = (
        20,
        "No mechanism has these dimensions: a size, a modulus or a mass is not positive, an element has no length, a"
        " number is not finite, or the constraints do not fit. Keep them out by the bounds, or build the model from"
        " these dimensions alone: the error says what is wrong.",
    )
    infeasible = (
        21,
        "No design within the bounds was found that keeps the limits. Widen the bounds or the limits, or start"
        " elsewhere (starts).",
    )
    not_optimal = (
        22,
        "The design did not settle within the allowed number of evaluations. Allow more (max_evaluations), or look at"
        " the history: the best design so far is returned.",
    )
    target_missed = (
        24,
        "A target is missed: bounds, limits or the other targets stand against it. Widen the bounds or the limits, let"
        " more dimensions vary, or change the target.",
    )
    local_minimum = (
        25,
        "A target is missed where no small change of the dimensions brings the design nearer, although no bound and no"
        " limit holds it: a local minimum, or targets that contradict each other. Start elsewhere (starts).",
    )
    poor_fit = (
        34,
        "The model does not fit the data: its differences are larger than the stated scatter explains. Look at the"
        " residuals, state a larger scatter, fit more parameters, or start elsewhere (starts).",
    )
    event_not_found = (
        23,
        "An event has ended the motion, but the root finder of `event` did not find when. Give it larger tolerances or"
        " more steps, a method that keeps to the step (of one condition optimistix.Bisection), or none, to end with the"
        " step.",
    )
    outside_workspace = (
        30,
        "The trajectory leaves the workspace: the mechanism cannot be assembled there, or what is driven cannot go on"
        " in that direction. Shorten the trajectory, or drive another degree of freedom (driven).",
    )
    singular_plant = (
        31,
        "The inputs cannot give the forces along what is driven: their effects on it depend on one another, or one has"
        " none. Let them act elsewhere, or name other inputs.",
    )
    out_of_memory = (
        32,
        "The memory does not suffice for the factors of the equations. Use fewer elements, such as spectral beams in"
        " place of many short ones, or a machine with more memory.",
    )
    neutral_branch = (
        33,
        "Two motions lose their stiffness at once, and on the branch one of them meets none: a round or square bar may"
        " buckle to any side, so that where the path goes is not determined. Say where: by an imperfection, such as"
        " imperfection={1: 1e-3}, or a small load to one side.",
    )


# Outcomes that have an answer, from the best on: at a critical state and where forces jump that has no derivative, in
# an unstable one no mechanism stays.
NO_DERIVATIVE = (RESULTS.critical_state, RESULTS.forces_jump)
ANSWERED = (RESULTS.successful, *NO_DERIVATIVE, RESULTS.unstable_state)


def told(result: Any) -> str:
    """An outcome for a person, by its code: its name, and of a failure what to try."""
    member = RESULTS(int(result))
    return f"{member.name}. {member.message}" if member.message else member.name


_CODES = Collector("codes")
# Collect the codes that analyses would raise outside a trace, while a function of designs is traced.
collected = _CODES.collecting


def check(result: Any, throw: bool, about: str = "") -> None:
    """Raise AnalysisError for a code, () or a batch of them, that is a failure; a traced one is collected.

    Codes among ``ANSWERED`` are successes. With ``throw=False`` nothing happens. ``about`` is added to the message.
    """
    import jax.core
    import numpy as np

    from .arguments import check_flag, undifferentiated

    check_flag("throw", throw)
    if not throw:
        return
    result = undifferentiated(result)
    if isinstance(result, jax.core.Tracer):
        collect(result)
        return
    codes = np.asarray(result)
    # One code is what nearly all are, and takes no operations on arrays.
    batch = codes.ndim > 0
    worst = int(np.max(np.where(np.isin(codes, ANSWERED), RESULTS.successful, codes)) if batch else codes)
    if worst not in ANSWERED:
        member = RESULTS(worst)
        raise AnalysisError(member.name, member.message + (f" {about}" if about else ""))


def or_nan(answer: Any, result: Any, throw: bool = True, of: Any = ()) -> Any:
    """A traced answer, NaN with its derivatives by the numbers ``of`` where it failed: nothing can be raised there.

    The answer stays as it is where codes are collected, and with ``throw=False``. Of a batch of codes, each array has
    the batch as its first axis.
    """
    import jax.core
    import jax.numpy as jnp

    if not throw or not isinstance(result, jax.core.Tracer) or collects():
        return answer
    failed = functools.reduce(operator.and_, [result != int(code) for code in ANSWERED])
    # By sums and products: where it failed the derivatives are no numbers either, and not zero. A product with what
    # varies would have none where some of the answer is no number of itself, as after the event that ends a motion.
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
    """Add a code, () or a batch of them, which may be traced, where codes are collected."""
    if (codes := _CODES.here()) is not None:
        codes.append(result)


def worst_of(codes: list[Any]) -> Any:
    """The first failure among codes, each () or a batch, or the worst outcome that has an answer; () [-], int32."""
    import jax.numpy as jnp

    found: Any = jnp.zeros((), jnp.int32)
    grade = found
    for code in codes:
        own = jnp.ravel(jnp.asarray(code, jnp.int32))
        graded = jnp.full_like(own, len(ANSWERED))
        for i, one in enumerate(ANSWERED):
            graded = jnp.where(own == int(one), i, graded)
        worst = jnp.argmax(graded)
        worse = graded[worst] > grade
        found, grade = jnp.where(worse, own[worst], found), jnp.where(worse, graded[worst], grade)
    return found
