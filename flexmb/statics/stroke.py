"""Static equilibria along a stroke or load. Each search starts from the previous equilibrium."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..arguments import check_numbers, is_concrete, undifferentiated
from ..compilation.compile import unguarded
from ..compilation.record import Record
from ..display import Labelled, States, Summary, course, span
from ..errors import ModelError, warn
from ..mechanics.loads import LoadFactors, lacks_potential, warn_of_increment
from ..mechanics.prepared import kernel
from ..model.by_name import ByName
from ..model.model import Labels, Model, as_determined
from ..model.topology import Parameters, Topology
from ..results import ANSWERED, RESULTS, collect, or_nan
from .coarse import warn_of_coarse
from .equilibrium import Equilibrium, check_stiffness, load_factor_text
from .solve import Begin, acting_at, solve_onward, undeformed
from .stable import is_negative


class Equilibria(ByName, Labelled, Record):
    """Static equilibria under successive loads; states are the first axis.

    Attributes:
        load_factor: Factor of the loads in each state, (states,) [-].
        increment: Factor of the incremental loads in each state, (states,) [-].
        each: All states as one :class:`Equilibrium` with states as first axis, as from ``jax.vmap``.
        model: The mechanism.
    """

    load_factor: Float[Array, "states"]
    increment: Float[Array, "states"]
    each: Equilibrium
    model: Model
    one_axis = "increment"

    def __getitem__(self, number: int) -> Equilibrium:
        """One of them, as for ``fm.stress(model, at=states[-1])``."""
        if not -len(self) <= number < len(self):
            raise IndexError(f"There are {len(self)} equilibria, numbered from 0. Number {number} is none of them.")
        state, *factors = jax.tree.map(lambda array: array[number], (self.each, self.load_factor, self.increment))
        return state.known(self.model, LoadFactors(*factors)) if is_concrete((state, self.model)) else state

    def __len__(self) -> int:
        return self.increment.shape[0]

    @property
    def labels(self) -> Labels:
        """Names."""
        return self.model.labels

    @property
    def x(self) -> Float[Array, "states n_x"]:
        """Nodal coordinates, (states, n_x) [m, rad, -]."""
        return self.each.x

    @property
    def e(self) -> Float[Array, "states n_e"]:
        """Deformations, (states, n_e) [m, rad]."""
        return self.each.e

    @property
    def sigma(self) -> Float[Array, "states n_e"]:
        """Stress resultants, (states, n_e) [N, N m]."""
        return self.each.sigma

    @property
    def reactions(self) -> Float[Array, "states n_x"]:
        """Forces of the supports on the mechanism, dual to x, (states, n_x) [N, N m]."""
        return self.each.reactions

    @property
    def external(self) -> Float[Array, "states n_x"]:
        """Loads except weight, plus reactions, dual to x, (states, n_x) [N, N m]."""
        return self.each.external

    @property
    def iterations(self) -> Int[Array, "states"]:
        """Newton iterations for each state, (states,)."""
        return self.each.iterations

    @property
    def result(self) -> Int[Array, "states"]:
        """Code of RESULTS of each state, (states,)."""
        return self.each.result

    def states(self) -> States:
        """Return the equilibria, over the factor that varies."""
        over = "increment" if np.ptp(np.asarray(self.increment)) > 0 else "load_factor"
        return States(self.model, self.x, "path", getattr(self, over), f"{over.replace('_', ' ')} [-]")

    def summary(self) -> Summary:
        """Return outcomes, factors and iterations."""
        codes = np.asarray(self.result)
        counts = [f"{np.sum(codes == code)} {RESULTS(int(code)).name}" for code in np.unique(codes)]
        rows = {
            "result": ", ".join(counts),
            "increment": span(self.increment),
            "load factor": span(self.load_factor),
            "iterations": str(int(np.sum(np.asarray(self.iterations)))),
        }
        return Summary(f"Equilibria: {course(self.states())}", rows, "mechanism")


@kernel
def _equilibria(topology: Topology, parameters: Parameters, targets: LoadFactors):
    def onward(begin: Begin, target: LoadFactors):
        at, result, iterations, reached = solve_onward(topology, parameters, target, begin)
        # After a failure, the next search starts from the last equilibrium that was found.
        good, factors = (result == RESULTS.successful) | (result == RESULTS.critical_state), reached.factors
        begin = jax.tree.map(lambda new, old: jnp.where(good, new, old), reached, begin)
        unstable = is_negative(*jax.lax.stop_gradient((at.K0 + at.G0, at.K0)), symmetric=not lacks_potential(topology))
        state = at.x, at.e, at.sigma, *acting_at(topology, parameters, at), iterations, result
        return begin, (state, unstable, factors)

    start = jax.lax.stop_gradient(undeformed(topology, parameters))
    _, (states, unstable, reached) = jax.lax.scan(onward, start, targets)
    codes = states[-1]
    failures = jnp.where(codes == RESULTS.critical_state, RESULTS.successful, codes)
    worst = jnp.where(jnp.any(failures != RESULTS.successful), jnp.max(failures), jnp.max(codes))
    return states, worst.astype(jnp.int32), unstable, reached


@unguarded
def equilibria(
    model: Model,
    *,
    increment: Float[Array, "states"] | float | None = None,
    load_factor: Float[Array, "states"] | float = 1.0,
    throw: bool = True,
) -> Equilibria:
    """Return static equilibria along a stroke or a load. Each search starts from the previous equilibrium.

    One compiled program solves all of them, with few Newton iterations for close states. If several equilibria exist,
    the order of the factors determines which of them are found. For a stroke, prescribe a displacement of 1 m with
    ``increment=True``. The factors are then strokes in metres, and ``reactions`` contains the drive force.

    Args:
        model: Mechanism; differentiable in ``model.parameters``, forward and reverse.
        increment: Factors of the incremental loads, (states,) [-]; zero by default.
        load_factor: Factors of the loads, (states,), or one factor for all states, () [-].
        throw: Raise if a solve fails; otherwise the codes are in ``result``. After a failure, the next search starts
            from the last equilibrium that was found.

    Returns:
        Equilibria with x (states, n_x) [m, rad, -], e and sigma (states, n_e), reactions (states, n_x) [N, N m].

    Raises:
        ValueError: Factors are not finite, or neither argument is a list of factors.
        ModelError: There are no incremental loads.
        AnalysisError: singular_configuration, singular_stiffness or not_converged. The message states what to try.
            Beyond a limit load the code is not_converged; ``fm.path`` can pass a limit load.

    Warns:
        FlexmbWarning: There are incremental loads, and ``increment`` is not given; or some states are not stable.
        CoarseWarning: A beam is bent or twisted too far for the accuracy of one beam, or stretched by more than 1 %.

    Source:
        As ``equilibrium``; THEORY.md 4, 5 and 7. Derivatives follow from the equations at each state, THEORY.md 10,
        eq. (10.1).
    """
    as_determined(model, "equilibria")
    if increment is None:
        warn_of_increment(model, "equilibria")
    elif model.parameters.increment is None:
        raise ModelError("The model has no incremental loads for `increment` to scale. Give them increment=True.")
    named_factors: dict[str, Any] = {"load_factor": load_factor, "increment": 0.0 if increment is None else increment}
    for name, value in named_factors.items():
        check_numbers(f"Argument `{name}`", value)
        if np.ndim(value) > 1:
            raise ValueError(
                f"Argument `{name}` must be a list of factors, (states,), but has shape {np.shape(value)}."
            )
    lengths = {len(value) for value in named_factors.values() if np.ndim(value)}
    if len(lengths) != 1 or 0 in lengths:
        raise ValueError(
            "Give `increment` as a list of factors, or `load_factor`, or both of one length"
            f" (got {' and '.join(map(str, sorted(lengths))) or 'none'}). For one state there is fm.equilibrium."
        )
    factors = [jnp.broadcast_to(jnp.asarray(value, float), tuple(lengths)) for value in named_factors.values()]
    targets = LoadFactors(*factors)
    states, worst, unstable, reached = _equilibria(model.topology, model.parameters, targets)
    check_stiffness(model, worst, throw, _first_missed(model, states[-1], targets, reached))
    fields: Any = (*or_nan(states, states[-1], throw), model.labels)
    if is_concrete((model, states, unstable)):
        warn_of_coarse(model, fields[1])
        _warn_of_unstable_ones(np.asarray(unstable) & (np.asarray(states[-1]) == RESULTS.successful))
    elif throw:
        collect(jnp.where(jnp.any(unstable), RESULTS.unstable_state, RESULTS.successful))
    return Equilibria(factors[0], factors[1], Equilibrium(*fields), model)


def _first_missed(model: Model, codes: Any, targets: LoadFactors, reached: LoadFactors) -> str:
    """Factors of the first equilibrium that was not found, and of the last load step towards it; or empty."""
    codes, targets, reached = undifferentiated((codes, targets, reached))
    if not is_concrete((codes, targets, reached)) or np.all(answered := np.isin(codes, ANSWERED)):
        return ""
    first = int(np.argmin(answered))
    at, up_to = (load_factor_text(model, jax.tree.map(lambda f: f[first], factors)) for factors in (targets, reached))
    return (
        f"Of {len(answered)} equilibria, number {first} was the first not found, at {at}. Load steps reached {up_to}."
        " fm.path goes past a limit load."
    )


def _warn_of_unstable_ones(which: np.ndarray) -> None:
    """Warn of equilibria that were found and are not stable, by their numbers."""
    unstable = np.flatnonzero(which)
    if len(unstable):
        collect(RESULTS.unstable_state)
        warn(
            f"Of {len(which)} equilibria, {len(unstable)} are not stable, number {unstable[0]} first: their stiffness"
            " is negative in some motion. No mechanism stays there by itself. fm.path finds the first unstable state"
            " and, with switch=True, follows the stable states."
        )
