"""Equilibrium path over the load factor, past limit points, with stability and linearisation at every step."""

from typing import Any, NamedTuple

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..arguments import check_number, check_whole, shown
from ..compilation.compile import jit
from ..compilation.record import Record
from ..display import AT_MOST, Result, States, Summary, course, short
from ..errors import AnalysisError
from ..linear.along import Along, frequencies_along
from ..linear.buckling import multipliers_of, scaled_stiffness
from ..linear.linearize import AboutState, Linearization, Matrices, Stressed, matrices_at
from ..linear.loose import refuse_negative_mass
from ..linear.spectrum import general_spectrum, is_real, spectrum, to_frequency
from ..mechanics.loads import LoadFactors, load_factors
from ..mechanics.residual import state
from ..model.by_name import ByName
from ..model.model import Model, as_determined
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import check, told
from .critical import CriticalPoint
from .stepper import Ramp
from .walk import Step, Walker


class Path(ByName, AboutState, Along, Result, Record):
    """Equilibria along a path, steps first. The arrays of ``matrices`` are attributes of this object too.

    Attributes:
        load_factor: Load factor, (steps,) [-].
        matrices: Coordinates ``x`` (steps, n_x), deformations ``e`` and stress resultants ``sigma`` (steps, n_e),
            ``reactions`` (steps, n_x), and the linearisation M0, C0, D0, K0, N0, G0 (steps, n_q, n_q) at each step.
        eigenvalues: Of (K0 + N0 + G0, M0), ascending, (steps, n) [rad^2/s^2]; real parts where they are complex;
            infinite where a motion has no mass.
        multipliers: Load multipliers of linear buckling about each step, by magnitude, sign kept, infinite where
            unbounded, (steps, n_q) [-]: of all loads at that step, or with incremental loads, of what more of those.
        stable: Whether all eigenvalues are positive, (steps,).
        critical_points: Limit and bifurcation points in the order of the path, with the uncertainty of those whose
            state could not be found itself.
        result: Code of RESULTS.
        model: The mechanism.
    """

    load_factor: Float[Array, "steps"]
    matrices: Matrices
    eigenvalues: Float[Array, "steps n"]
    multipliers: Float[Array, "steps n_q"]
    stable: Bool[np.ndarray, "steps"]
    critical_points: tuple[CriticalPoint, ...]
    result: Int[Array, ""]
    model: Model
    one_axis = "load_factor"

    @property
    def labels(self):
        """Names."""
        return self.model.labels

    @property
    def frequencies(self) -> Float[Array, "steps n"]:
        """Square root of the eigenvalues over 2 pi with their sign, (steps, n) [Hz]."""
        return to_frequency(self.eigenvalues)

    def linearization(self, step: int | None = None, time: float | None = None) -> Linearization:
        """Linearised equations of motion about one step, for modes, compliance and state space.

        Args:
            step: Which, from 0; the last unless given.
            time: None; a path has no times.

        Raises:
            IndexError: There are not so many steps.
            ValueError: A time is given.
        """
        if time is not None:
            raise ValueError("A path has no times: say which state by step=, such as step=-1 for the last.")
        count, chosen = len(self.load_factor), -1 if step is None else check_whole("step", step)
        if not -count <= chosen < count:
            raise IndexError(f"The path has {count} steps, numbered from 0, and {chosen} is none of them.")
        return Linearization(jax.tree.map(lambda a: a[chosen], self.matrices), self.model)

    def linearizations(self) -> Linearization:
        """Linearised equations at all steps, which stand in front."""
        return Linearization(self.matrices, self.model)

    def at_critical_points(self) -> "Path":
        """The critical points as states of a path of their own, in their order; at least one."""
        found = []
        for point in self.critical_points:
            near = self.e[int(np.argmin(np.sum((np.asarray(self.x) - point.x) ** 2, axis=1)))]
            factors = _factors(self.model, point.load_factor)
            found.append(_look_at(self.model.topology, self.model.parameters, factors, jnp.asarray(point.x), near))
        matrices, multipliers = jax.tree.map(lambda *a: jnp.stack(a), *found)
        values = jnp.asarray(np.sign(hertz := frequencies_along(matrices)) * (2 * np.pi * hertz) ** 2)
        loads = jnp.array([point.load_factor for point in self.critical_points])
        stable = np.zeros(len(found), bool)
        return Path(loads, matrices, values, multipliers, stable, self.critical_points, self.result, self.model)

    def factors(self, step: int) -> LoadFactors:
        """Load factors of the constant and of the incremental loads at one step.

        Args:
            step: Which, from 0.
        """
        return _factors(self.model, self.load_factor[step])

    def stressed(self) -> Stressed:
        """What the stress of all steps is computed from."""
        return Stressed(self.x, self.sigma, self.felt, self.e)

    def states(self) -> States:
        """The equilibria, over the load factor."""
        return States(self.model, self.x, "path", self.load_factor, "load factor [-]")

    def summary(self) -> Summary:
        """Outcome, steps, load factor and critical points."""
        points = [f"{point.kind} at {point.load_factor:.5g}" for point in self.critical_points]
        stable = np.asarray(self.stable)
        rows = {
            "result": told(self.result),
            "steps": f"{len(stable)}, {int(np.sum(stable))} of them stable",
            "load factor": f"up to {short(np.max(np.asarray(self.load_factor)))}",
            "critical points": ", ".join(points[:AT_MOST]) or "none",
        }
        return Summary(f"Path: {course(self.states())}", rows, "path")


def _factors(model: Model, load: Any) -> LoadFactors:
    """A path scales the incremental loads, or all where there are none."""
    return load_factors(load, 0.0) if model.parameters.increment is None else load_factors(1.0, load)


class _Found(NamedTuple):
    """What a path reports of one state; eigenvalues that may be complex are found outside compiled code."""

    matrices: Matrices
    eigenvalues: Any
    multipliers: Float[Array, "n_q"]
    stable: Any


def _with_complex(found: _Found, step: Step) -> _Found:
    """The same with the eigenvalues of an unsymmetric stiffness, which may be complex."""
    values, _ = general_spectrum(np.asarray(found.matrices.K), np.asarray(found.matrices.M0))
    steady = is_real(values) & (values.real > 0)
    # A motion without mass loses its stability where the determinant changes sign.
    return found._replace(eigenvalues=values.real, stable=np.all(steady) & np.all(step.values > 0))


@jit
def _look(topology: Topology, parameters: Parameters, ramp: Ramp, step: Step) -> _Found:
    point = step.point
    factors = ramp.at(point.load)
    at = state(topology, parameters, factors, point.x, point.near, strained=point.strained)
    matrices = matrices_at(topology, parameters, factors, at, step.corrections, jnp.zeros((), jnp.int32))
    multipliers = multipliers_of(*scaled_stiffness(topology, parameters, at, point.near))
    if not matrices.symmetric:
        return _Found(matrices, None, multipliers, None)
    eigenvalues, _, stable, _ = spectrum(matrices.K, matrices.M0)
    return _Found(matrices, jnp.where(jnp.isnan(eigenvalues), jnp.inf, eigenvalues), multipliers, stable)


@jit
def _look_at(topology: Topology, parameters: Parameters, factors: LoadFactors, x, near):
    """Matrices and load multipliers of a state on the path that is no step of it."""
    at = state(topology, parameters, factors, x, near)
    zero = jnp.zeros((), jnp.int32)
    matrices = matrices_at(topology, parameters, factors, at, zero, zero)
    return matrices, multipliers_of(*scaled_stiffness(topology, parameters, at, near))


def path(
    model: Model, *, max_steps: int = 200, step: float = 0.1, switch: bool | int = False, throw: bool = True
) -> Path:
    """Equilibrium path over the load factor from 0 to 1, past limit points.

    The factor multiplies the incremental loads while the others stay; without incremental loads it multiplies all.
    One Newton solve a step, with a plane across the path in place of a given load, so that the load may turn back.

    Args:
        model: Mechanism, with concrete numbers; for derivatives see ``equilibrium`` and ``limit_load``.
        max_steps: Steps at most.
        step: Largest change of the load factor in a step, () [-].
        switch: 1 or True: at the first bifurcation, go on along the branch in the direction of its phi; -1: against
            it.
        throw: Raise where the path does not reach factor 1; otherwise the code is in ``result``.

    Returns:
        Path with x (steps, n_x) [m, rad, -], e and sigma (steps, n_e) [m, rad; N, N m], the matrices, eigenvalues and
        load multipliers at each step, and the critical points.

    Raises:
        AnalysisError: max_steps; closed_path, where it comes back to a state that it passed before; not_converged or
            singular_configuration; singular_mass where a motion has a negative mass. Each says what to try, and has
            the path so far as ``error.path``, but for the last.
        ValueError: max_steps or step is not positive.

    Source:
        THEORY.md 7, eq. (7.8) and (7.9). A critical point is where an eigenvalue of K changes sign; from
        psi^T (K t + r_load t_load) = 0 the load's rate vanishes there unless psi^T r_load = 0: a limit point, or else a
        bifurcation.
    """
    as_determined(model, "path")
    check_number("step", step)
    if check_whole("max_steps", max_steps) < 1 or not step > 0:
        raise ValueError(f"max_steps and step must be positive, but are {max_steps} and {step}.")
    if switch not in (False, True, -1):
        raise ValueError(f"Argument `switch` must be False, True, 1 or -1, but is {shown(switch)}.")
    if any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves(model)):
        raise TypeError("path takes concrete numbers; differentiate equilibrium or limit_load instead.")
    walker = Walker(model, step)
    code = walker.walk(max_steps, float(switch))
    found = [_look(model.topology, model.parameters, walker.ramp, s) for s in walker.steps]
    if not found[0].matrices.symmetric:
        found = [_with_complex(one, step) for one, step in zip(found, walker.steps, strict=True)]
    # Stacked by numpy: the number of steps is new each time, and nothing is to be compiled for it.
    found = jax.tree.map(lambda *a: np.stack(a), *found)
    massive = np.any(np.isfinite(found.eigenvalues), axis=0)
    refuse_negative_mass(Linearization(jax.tree.map(lambda a: a[0], found.matrices), model))
    whole = Path(
        load_factor=jax.device_put(np.array([s.load for s in walker.steps])),
        matrices=jax.device_put(found.matrices),
        eigenvalues=jax.device_put(found.eigenvalues[:, massive]),
        multipliers=jax.device_put(found.multipliers),
        stable=found.stable,
        critical_points=tuple(walker.critical),
        result=jnp.asarray(int(code), jnp.int32),
        model=model,
    )
    try:
        check(int(code), throw)
    except AnalysisError as error:
        error.path = whole
        raise
    return whole
