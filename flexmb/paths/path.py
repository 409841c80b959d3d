"""Equilibrium path over the load factor, past limit points, with stability and linearisation at every step."""

from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Literal, NamedTuple, TypedDict, Unpack, overload

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..arguments import check_number, check_whole, is_concrete, short_repr
from ..compilation.compile import unguarded
from ..compilation.record import Record, static
from ..compilation.threads import one_thread
from ..display import Labelled, listed, short
from ..errors import AnalysisError, warn
from ..linear.buckling import multipliers_of, scaled_stiffness
from ..linear.linearize import AboutState, Linearization, Matrices, matrices_at
from ..linear.loose import refuse_negative_mass
from ..linear.spectrum import general_spectrum, spectrum, to_frequency, without_growth
from ..math.linear_solver import DENSE
from ..mechanics.loads import lacks_potential
from ..mechanics.prepared import kernel
from ..mechanics.residual import state
from ..model.by_name import ByName
from ..model.model import Model, as_determined, as_model
from ..model.topology import Parameters, Topology, extent_of
from ..numerical_limits import ROUND_OFF, SMALL_IMPERFECTION
from ..progress import reporting
from ..questions.frequency import frequencies_along
from ..questions.question import Along
from ..results import RESULTS
from ..statics.coarse import warn_of_coarse
from ..statics.equilibrium import check_stiffness
from ..statics.solver_choice import asked_solver, by_sparse, is_large, known_solver
from .critical import CriticalPoint
from .imperfection import bent_by_modes
from .over_load import OverLoad
from .sparse_path import SparsePath, path_of
from .sparse_walk import SparseEquations
from .stepper import Point, factors_at
from .stops import STRESS, stops_of, unmet
from .walk import DenseEquations, Step, Walker

# Results of a branch that leads nowhere.
LOST = (RESULTS.closed_path, RESULTS.max_steps)
# A small imperfection, as a share of the extent.


class Path(OverLoad, ByName, AboutState, Along, Labelled, Record):
    """Equilibria along a path; steps are the first axis. The arrays of ``matrices`` are attributes of this object too.

    Attributes:
        load_factor: Load factor, (steps,) [-].
        matrices: Coordinates ``x`` (steps, n_x), deformations ``e`` and stress resultants ``sigma`` (steps, n_e),
            ``reactions`` (steps, n_x), and the linearisation M0, C0, D0, K0, N0, G0 (steps, n_q, n_q) at each step.
        eigenvalues: Eigenvalues of (K0 + N0 + G0, M0), ascending, (steps, n) [rad^2/s^2]; real parts if they are
            complex; infinite for a motion without mass.
        multipliers: Load multipliers of linear buckling about each step, sorted by magnitude, with sign, (steps, n_q)
            [-]. A multiplier scales all loads of the step; with incremental loads it scales additional incremental
            loads. Infinite if the load has no effect.
        stable: Whether each step is stable, (steps,): all eigenvalues are positive. For loads without a potential they
            must also be real; with damping, no pole may have a positive real part.
        critical_points: Limit and bifurcation points in the order of the path. The uncertainty of a point is zero if
            flexmb found the critical state itself.
        result: Code of RESULTS.
        model: The mechanism, with its imperfections.
        stopped_by: Name of the condition of ``stop`` that ended the path at its last step, or None.
    """

    load_factor: Float[Array, "steps"]
    matrices: Matrices
    eigenvalues: Float[Array, "steps n"]
    multipliers: Float[Array, "steps n_q"]
    stable: Bool[np.ndarray, "steps"]
    critical_points: tuple[CriticalPoint, ...]
    result: Int[Array, ""]
    model: Model
    stopped_by: str | None = static(default=None)
    one_axis = "load_factor"
    picture: ClassVar[str | None] = "path"

    @property
    def frequencies(self) -> Float[Array, "steps n"]:
        """Square root of the eigenvalues over 2 pi with their sign, (steps, n) [Hz]."""
        return to_frequency(self.eigenvalues)

    def linearization(self, step: int | None = None, time: float | None = None) -> Linearization:
        """Return the linearised equations of motion about one step, for modes, compliance and state space.

        Args:
            step: Number of the step, from 0; by default the last.
            time: None; a path has no times.

        Raises:
            IndexError: There are fewer steps.
            ValueError: A time is given.
        """
        chosen = self.step_of(step, time)
        if not is_concrete(self.matrices):
            return Linearization(jax.tree.map(lambda a: a[chosen], self.matrices), self.model)
        # On the host: JAX would compile a program for the place in each shape of array.
        at_step = jax.tree.map(lambda a: a[chosen], jax.device_get(self.matrices))
        return Linearization(jax.device_put(at_step), self.model)

    def linearizations(self) -> Linearization:
        """Return the linearised equations at all steps; steps are the first axis."""
        return Linearization(self.matrices, self.model)

    def at_critical_points(self) -> "Path":
        """Return the critical points as states of a path, in their order.

        Raises:
            ValueError: There are none.
        """
        self.check_critical()
        linearizations = []
        for critical in self.critical_points:
            last_strain = self.e[int(np.argmin(np.sum((np.asarray(self.x) - critical.x) ** 2, axis=1)))]
            numbers: Any = critical.x, last_strain, None, critical.load_factor, np.zeros(0)
            at = Point(*numbers)
            linearizations.append(_look_at(self.model.topology, self.model.parameters, at, np.zeros((), np.int32)))
        matrices, multipliers = jax.tree.map(lambda *a: jax.device_put(np.stack(a)), *linearizations)
        values = jnp.asarray(np.sign(hertz := frequencies_along(matrices)) * (2 * np.pi * hertz) ** 2)
        loads = jax.device_put(np.array([point.load_factor for point in self.critical_points]))
        stable = np.zeros(len(linearizations), bool)
        return Path(loads, matrices, values, multipliers, stable, self.critical_points, self.result, self.model)


class _PathState(NamedTuple):
    """One state of a path; eigenvalues that may be complex are computed outside compiled code."""

    matrices: Matrices
    eigenvalues: Any
    multipliers: Float[Array, "n_q"]
    stable: Any


def _with_complex(state: _PathState, step: Step) -> _PathState:
    """The state with the eigenvalues of an unsymmetric stiffness, which may be complex."""
    m = state.matrices
    stiffness, damping, mass = np.asarray(m.K), np.asarray(m.C0) + np.asarray(m.D0), np.asarray(m.M0)
    values, _ = general_spectrum(stiffness, mass)
    # A motion without mass loses its stability where the determinant changes sign.
    stable = np.all(step.values > 0) & without_growth(stiffness, damping, mass)
    return state._replace(eigenvalues=values.real, stable=stable)


@kernel
def _look_at(topology: Topology, parameters: Parameters, point: Point, iterations: Int[Array, ""]):
    """Matrices and load multipliers of a state."""
    factors = factors_at(parameters, point.load)
    at = state(topology, parameters, factors, point.x, point.near, strained=point.strained)
    matrices = matrices_at(topology, parameters, factors, at, iterations, jnp.zeros((), jnp.int32))
    scaled = scaled_stiffness(topology, parameters, at, point.near)
    return matrices, multipliers_of(*scaled, unsymmetric=lacks_potential(topology))


@kernel
def _look(topology: Topology, parameters: Parameters, step: Step) -> _PathState:
    matrices, multipliers = _look_at(topology, parameters, step.point, step.corrections)
    if not matrices.symmetric:
        return _PathState(matrices, None, multipliers, None)
    eigenvalues, _, stable, _ = spectrum(matrices.K, matrices.M0)
    return _PathState(matrices, jnp.where(jnp.isnan(eigenvalues), jnp.inf, eigenvalues), multipliers, stable)


class _Options(TypedDict, total=False):
    max_steps: int
    step: float
    stop: Mapping[str, float] | None
    switch: bool | int | Mapping[int, int]
    imperfection: Mapping[int, float] | None
    progress: Callable[[int, float], None] | bool
    solver: Literal["dense", "sparse"] | None
    throw: bool


@overload
def path(model: Model, *, sparse: Literal[True], **options: Unpack[_Options]) -> SparsePath: ...
@overload
def path(model: Model, *, sparse: Literal[False], **options: Unpack[_Options]) -> Path: ...
@overload
def path(model: Model, *, sparse: bool | None = None, **options: Unpack[_Options]) -> Path | SparsePath: ...
@unguarded
def path(
    model: Model,
    *,
    max_steps: int = 200,
    step: float = 0.1,
    stop: Mapping[str, float] | None = None,
    switch: bool | int | Mapping[int, int] = False,
    imperfection: Mapping[int, float] | None = None,
    progress: Callable[[int, float], None] | bool = False,
    sparse: bool | None = None,
    solver: Literal["dense", "sparse"] | None = None,
    throw: bool = True,
) -> Path | SparsePath:
    """Return the equilibrium path over the load factor from 0 to 1, past limit points.

    The factor multiplies the incremental loads; the other loads are constant. Without incremental loads it multiplies
    all loads. In each step, Newton's method searches in a plane across the path, not at a given load. The load may
    therefore decrease along the path.

    Args:
        model: Mechanism, with concrete numbers; for derivatives see ``equilibrium`` and ``limit_load``.
        max_steps: Largest number of steps.
        step: Largest change of the load factor in a step, () [-].
        stop: Conditions that end the path. The path ends at the first condition that is met:

            - ``{"tip.y": -5e-3}``: a displacement from the undeformed mechanism [m, rad].
            - ``{"stress": 300e6}``: the largest von Mises stress of ``fm.stress`` [Pa].
            - ``{"critical_points": 2}``: the number of critical points.
            - ``{"load_factor": 2.0}``: a load factor [-]. The path ends at this factor, also at a factor above 1, or at
              0 after the load has turned back.
            - ``{"frequency 1": 5.0}`` [Hz] and any other quantity of :meth:`Path.along`: the path ends where the
              quantity passes the value.
        switch: Bifurcations at which the path changes to the other branch, by their number along the path from 1, and
            the direction: 1 along the motion phi of the point, -1 against it. Examples: ``{2: -1}``, ``{1: 1, 3: -1}``.
            True or 1 is ``{1: 1}``, -1 is ``{1: -1}``. If the path itself moves along phi at the point, 1 selects the
            direction of rising load factor on the other branch, and -1 the direction of falling load factor.
        imperfection: Imperfection of the undeformed mechanism, free of stress: the largest displacement [m] of each
            buckling mode, by its number from 1, such as ``{1: 1e-6}``. The modes are the modes of ``fm.buckling`` about
            the first state of the path, for the increasing loads. A positive imperfection increases the coordinate with
            the largest displacement. A motion of ``path.model`` starts in this shape, and start values count from this
            shape. A path by sparse matrices adds no start to a model without start values. Such a motion needs
            ``initial``.
        progress: True for a progress bar, or a function of the number of states and the load factor, called before each
            step. A keyboard interruption then ends the path with the states found so far and ``result`` stopped.
        sparse: True is ``solver="sparse"``, False ``solver="dense"``.
        solver: "sparse" for sparse matrices in all coordinates; the model needs no degrees of freedom. "dense" for
            dense matrices. None: the size of the model decides. With sparse matrices the result is a SparsePath. It has
            no matrices, and only the few eigenvalues nearest to zero. :meth:`Path.along` and the methods by name work
            as for a Path.
        throw: Raise if the path does not reach its end; otherwise the code is in ``result``.

    Returns:
        Path with x (steps, n_x) [m, rad, -], e and sigma (steps, n_e) [m, rad; N, N m], the matrices, eigenvalues and
        load multipliers at each step, and the critical points. ``stopped_by`` is the condition of ``stop`` that the
        last step meets. It meets a coordinate or a load factor to round-off, and a stress to 1e-9 of its value. flexmb
        checks displacements and load factors at the ends of steps and at extremes between them. It checks other
        quantities at the ends of steps only.

    Warns:
        FlexmbWarning: The path ended without meeting ``stop``, or without a bifurcation that ``switch`` names.
        CoarseWarning: A beam is bent or twisted too far for the accuracy of one beam, or stretched by more than 1 %.

    Raises:
        AnalysisError: max_steps; closed_path: the path returns to a state that it passed before; not_converged or
            singular_configuration; neutral_branch: a round bar may buckle to any side; singular_mass: a motion has a
            negative mass. Each message states what to try. ``error.path`` contains the computed part of the path,
            except after singular_mass.
        ValueError: max_steps or step is not positive; the stress is not below its limit at the start; there is no such
            buckling mode.
        KeyError: The coordinate is unknown.
        ModelError: ``stop`` has a stress, but no element has a section with a shape.

    Source:
        THEORY.md 7, eq. (7.8) and (7.9). At a critical point an eigenvalue of K changes sign. There psi^T (K t + r_load
        t_load) = 0 becomes psi^T r_load t_load = 0. Either the rate t_load of the load is zero (limit point), or psi^T
        r_load is zero (bifurcation).
    """
    model = as_model(model, "path")
    chosen = asked_solver(sparse, known_solver(solver))
    if chosen is None:
        # Buckling modes, of which an imperfection is made, need a potential.
        large = by_sparse(model, None) if imperfection is None else is_large(model)
    else:
        large = chosen != DENSE
    check_number("step", step)
    if check_whole("max_steps", max_steps) < 1 or not step > 0:
        raise ValueError(f"max_steps and step must be positive, but are {max_steps} and {step}.")
    to_switch = _switches(switch)
    wanted = _Wanted(step, max_steps, stop, to_switch, {} if imperfection else dict(to_switch), progress)
    if any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves(model)):
        raise TypeError("path needs concrete numbers. Differentiate equilibrium or limit_load instead.")
    if large:
        with one_thread():
            bent = model if imperfection is None else bent_by_modes(model, imperfection, sparse=True)
            answer = _sparse_path(bent, wanted, throw, hanging=chosen is None)
        if answer is not None:
            return _checked(*answer, wanted, throw)
    model = as_determined(model, "path")
    model = model if imperfection is None else bent_by_modes(model, imperfection)
    return _checked(*_dense_path(model, wanted), wanted, throw)


class _Wanted(NamedTuple):
    """Arguments of :func:`path`; ``to_switch`` loses each switch that the walk uses, ``asked`` keeps them."""

    step: float
    max_steps: int
    stop: Mapping[str, float] | None
    to_switch: dict[int, int]
    asked: dict[int, int]
    progress: Any


def _dense_path(model: Model, wanted: _Wanted) -> tuple[Path, Walker]:
    """The path, and the walk that found it."""

    def found_at(step: Step) -> _PathState:
        return _look(model.topology, model.parameters, step)

    def state_at(step: Step) -> Linearization:
        return Linearization(found_at(step).matrices, model)

    walker = Walker(DenseEquations(model), wanted.step, stops_of(model, wanted.stop, state_at))
    code = _follow(walker, wanted)
    states = [found_at(s) for s in walker.steps]
    if not states[0].matrices.symmetric:
        states = [_with_complex(state, step) for state, step in zip(states, walker.steps, strict=True)]
    # Stacked by NumPy: JAX would compile a program for each number of steps.
    states = jax.tree.map(lambda *a: np.stack(a), *states)
    massive = np.any(np.isfinite(states.eigenvalues), axis=0)
    refuse_negative_mass(Linearization(jax.tree.map(lambda a: a[0], states.matrices), model))
    path = Path(
        load_factor=jax.device_put(np.array([s.load for s in walker.steps])),
        matrices=jax.device_put(states.matrices),
        eigenvalues=jax.device_put(states.eigenvalues[:, massive]),
        multipliers=jax.device_put(states.multipliers),
        stable=states.stable,
        critical_points=tuple(walker.critical),
        result=jax.device_put(np.asarray(int(code), np.int32)),
        model=model,
        stopped_by=walker.ended or None,
    )
    return path, walker


def _sparse_path(model: Model, wanted: _Wanted, throw: bool, hanging: bool) -> tuple[SparsePath, Walker] | None:
    """:func:`_dense_path` by sparse factors; None for a body without stiffness at the begin, if ``hanging``.

    A failure on the way leaves the states before it, also in the error.
    """

    def state_at(step: Step) -> SparsePath:
        return path_of(equations, walker, [step])

    equations = SparseEquations(model)
    walker = Walker(equations, wanted.step, stops_of(model, wanted.stop, state_at))
    if hanging and walker.code == RESULTS.singular_stiffness:
        # With dense matrices motions without stiffness do not move at first.
        return None
    try:
        code = _follow(walker, wanted)
    except AnalysisError as fault:
        path = fault.path = path_of(equations, walker, walker.steps, RESULTS[fault.code])
        if throw:
            raise
        return path, walker
    return path_of(equations, walker, walker.steps, code), walker


def _follow(walker: Walker, wanted: _Wanted) -> RESULTS:
    """Walk, and return why the walk ended."""
    for limit in walker.conditions:
        if limit.name == STRESS and (begun := limit.of(walker.steps[0])) >= limit.target:
            raise ValueError(
                f'stop["{STRESS}"] is {short(limit.target)} Pa, but the path begins with {short(begun)} Pa.'
            )
    with reporting(wanted.progress, "states, load factor") as report:
        try:
            return walker.walk(wanted.max_steps, wanted.to_switch, report)
        except KeyboardInterrupt:
            if report is None:
                raise
            return RESULTS.stopped


def _checked(path: Path | SparsePath, walker: Walker, wanted: _Wanted, throw: bool) -> Path | SparsePath:
    """The path; raise if it did not reach its end, and warn of conditions that were not met."""
    code = RESULTS(int(path.result))
    if code == RESULTS.max_steps and np.max(np.abs(np.asarray(path.load_factor))) < ROUND_OFF:
        # A motion whose stiffness is round-off moves without end.
        code = RESULTS.singular_stiffness
    about = _instead_of_switch(path, wanted.asked) if wanted.asked.keys() - wanted.to_switch and code in LOST else ""
    try:
        check_stiffness(path.model, int(code), throw and code != RESULTS.stopped, about)
    except AnalysisError as error:
        error.path = path
        raise
    warn_of_coarse(path.model, path.e)
    if code == RESULTS.successful:
        _warn_of_unused(path, walker, wanted)
    return path


def _instead_of_switch(path: Path | SparsePath, asked: dict[int, int]) -> str:
    """Advice for a path whose switched branch leads nowhere."""
    size = short(SMALL_IMPERFECTION * float(extent_of(path.model.topology, path.model.parameters)))
    return (
        f"It left bifurcation {listed(sorted(asked))} by `switch`. Give imperfection={{1: {size}}} [m] instead of"
        " `switch`: the path then joins the branch and leaves it again without a bifurcation. Or leave the branch at"
        f" the next bifurcation: switch={asked | {max(asked) + 1: 1}}."
    )


def _switches(switch: Any) -> dict[int, int]:
    """Direction at each bifurcation, by its number from 1."""
    if isinstance(switch, Mapping):
        for number, side in switch.items():
            check_whole("switch", number, 1)
            if side not in (1, -1):
                raise ValueError(
                    f"Argument `switch` must have 1 or -1 for bifurcation {number}, but has {short_repr(side)}."
                )
        return {int(number): int(side) for number, side in switch.items()}
    if switch not in (False, True, -1):
        raise ValueError(
            "Argument `switch` must be False, True, 1 or -1, or such numbers by bifurcation, such as {2: -1}, but is"
            f" {short_repr(switch)}."
        )
    return {1: int(switch)} if switch else {}


def _warn_of_unused(path: Path | SparsePath, walker: Walker, wanted: _Wanted) -> None:
    """Warn of conditions and bifurcations that a path did not reach."""
    if wanted.stop and path.stopped_by is None:
        warn(unmet(wanted.stop, walker.steps, walker.conditions, len(walker.critical)))
    if wanted.to_switch:
        count = sum(point.kind == "bifurcation" for point in path.critical_points)
        which = ", ".join(map(str, sorted(wanted.to_switch)))
        warn(
            f"Argument `switch` names bifurcation {which}, but there are {count} of them on the path, up to load"
            f" factor {short(path.load_factor[-1])}."
        )
