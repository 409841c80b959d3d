"""Natural frequencies, mode shapes and poles of the linearised mechanism."""

from typing import Any, cast

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float, Int

from ..arguments import check_whole, is_concrete, undifferentiated
from ..compilation.compile import jit, unguarded
from ..compilation.record import Record
from ..compilation.threads import one_thread
from ..display import Labelled, Quantities, States, Summary, modal_summary, numbered_quantities
from ..math.element_matrices import AssembledEquations, matrix_times
from ..math.linear_solver import DENSE, LinearSolver
from ..mechanics.loads import LoadFactors, lacks_potential, load_factors_of
from ..mechanics.prepared import kernel
from ..model.model import Model, as_determined
from ..model.topology import Parameters, Topology
from ..results import RESULTS, check, collects, or_nan
from ..statics.equilibrium import Equilibrium, without_stiffness
from ..statics.solver_choice import asked_solver, few_of, warn_of_fewer
from .about import Where, by_elements, linearized
from .linearize import Linearization, ManyStates, Matrices, Shapes, linearize, matrices
from .loose import (
    naming_culprit,
    negative_mass,
    negative_mass_note,
    refuse_negative_mass,
    refuse_without_anything,
    stiffest_element_note,
    without_anything,
)
from .sparse_poles import poles_of_sparse
from .sparse_solve import lowest, lowest_values
from .sparse_spectrum import refuse_negative_masses
from .spectrum import poles_of, real_frequencies, slowest, spectrum, to_frequency
from .traced_poles import poles_of_elements, traced_poles


class Modes(Shapes, Labelled, Record):
    """Natural frequencies and mode shapes, by ascending eigenvalue, without massless motions.

    ``modes.position("top")`` returns values of the state about which the mechanism vibrates. ``modes.shape("top")``
    returns the motion of a node in each mode.

    Attributes:
        eigenvalues: Eigenvalues of (K0 + N0 + G0, M0), negative if unstable, (n,) [rad^2/s^2].
        frequencies: sign(eigenvalue) sqrt(|eigenvalue|)/(2 pi), (n,) [Hz].
        shapes: Mass-normalised mode shapes in the coordinates, one mode for each column, (n_x, n) [1/sqrt(kg) ..].
        q_shapes: Mode shapes in the degrees of freedom, (n_q, n).
        massless: Number of motions without mass. With sparse matrices it is 0 if all computed modes have mass.
        stable: Whether the stiffness is positive definite.
        lin: Linearization of the state.
    """

    eigenvalues: Float[Array, "n"]
    frequencies: Float[Array, "n"]
    shapes: Float[Array, "n_x n"]
    q_shapes: Float[Array, "n_q n"]
    massless: int
    stable: bool
    lin: Linearization
    one_axis = "eigenvalues"

    def states(self) -> States:
        """Return the modes about their state, each with its frequency."""
        titles = [f"mode {i + 1}: {text}" for i, text in enumerate(self._told())]
        return States(self.lin.model, self.lin.x, "modes", moves=self.shapes, titles=titles)

    def quantities_by_name(self) -> Quantities:
        """Return frequencies and eigenvalues by the number of the mode, from 1."""
        values = {"frequency": (self.frequencies, "Hz"), "eigenvalue": (self.eigenvalues, "rad²/s²")}
        return numbered_quantities("mode", values)

    def _told(self) -> list[str]:
        values = zip(np.asarray(self.frequencies).tolist(), np.asarray(self.eigenvalues).tolist(), strict=True)
        return [f"{hertz:.5g} Hz" if hertz >= 0 else f"unstable, ω² = {square:.4g} rad²/s²" for hertz, square in values]

    def summary(self) -> Summary:
        """Return frequencies and stability."""
        rows = {"stable": "yes" if self.stable else "no"}
        if self.massless:
            rows["motions without mass"] = str(self.massless)
        return modal_summary("Modes", self.states(), self._told(), rows)


@jit
def _frequencies_at(m: Matrices, *, count: int | None):
    values, _, _, result = spectrum(m.K, m.M0, count)
    return to_frequency(values), jnp.where(m.result == RESULTS.successful, result, m.result)


@kernel
def _frequencies(topology: Topology, parameters: Parameters, target: LoadFactors, *, count: int | None):
    return _frequencies_at(matrices(topology, parameters, target), count=count)


def refuse_unsymmetric(symmetric: bool) -> None:
    """Raise NotImplementedError for frequencies of a stiffness without a potential."""
    if not symmetric:
        raise NotImplementedError(
            "The stiffness is unsymmetric: because of loads or laws without a potential, such as moments about fixed"
            " axes in space, or the velocity in a state of motion. Frequencies may be complex. Use fm.poles instead."
        )


def _asked(
    model: Any, function: str, count: int | None, where: Where, solver: LinearSolver | None, throw: bool = True
) -> tuple[Linearization | None, int | None]:
    """Linearization for sparse matrices, or None, and the number wanted, which these need."""
    count = None if count is None else check_whole("count", count, 1)
    large = None
    by_factors = solver not in (None, DENSE)
    if count is not None or not by_factors:
        large = by_elements(model, function, where, solver, few=few_of(model, count), throw=throw)
    if count is None and (by_factors or large is not None):
        raise ValueError(f"With sparse matrices give `count`, the number of {function} wanted.")
    return large, count


@unguarded
def frequencies(
    model: Model | Linearization,
    *,
    count: int | None = None,
    sparse: bool | None = None,
    solver: str | LinearSolver | None = None,
    throw: bool = True,
    at: Equilibrium | Linearization | ManyStates | None = None,
    step: int | None = None,
    time: float | None = None,
    increment: float | None = None,
) -> Float[Array, "n"]:
    """Return the natural frequencies about the static equilibrium under the constant loads.

    PRESCRIBED coordinates do not vibrate: a drive is rigid in all modes.

    Args:
        model: Mechanism, differentiable in ``model.parameters``, or a linearisation of it, such as at a stroke.
        count: Number of the lowest frequencies; all by default. For a large model, a few frequencies are much faster.
        sparse: Compute ``count`` frequencies by sparse matrices in all coordinates; the model needs no degrees of
            freedom. See :func:`flexmb.equilibrium`. By default the size of the model decides, if ``count`` is given.
        solver: "sparse", "dense", or a :class:`flexmb.math.linear_solver.LinearSolver` in place of sparse factors.
        throw: Raise if the equilibrium or the eigenproblem fails.
        at: Equilibrium, Path, Motion or Linearization of the model, whose state replaces the equilibrium. flexmb
            refuses a state of a model with other names or dimensions, and a known state for traced numbers.
        step: Number of the state of a path or a motion, from 0; -1 for the last.
        time: Time of the state of a motion, one of its output times [s].
        increment: Factor of the incremental loads of the equilibrium, () [-]; zero by default.

    Returns:
        (n_q,) or (count,) [Hz], ascending. A frequency is negative if omega^2 is negative: the state is then unstable
        in this motion. It is infinite for a motion without mass. About a state of motion the frequencies include K0 +
        N0 + G0 and M0, but not C0 and D0.
            Complex frequencies are NaN, and frequencies about a state of motion cannot be traced; see :func:`poles`.

    Raises:
        ValueError: ``count`` is not positive, or missing with ``sparse``.
        AnalysisError: The equilibrium was not found, or a motion has neither mass nor stiffness, or a negative mass.

    Warns:
        FlexmbWarning: The mechanism has fewer than ``count`` frequencies. All of them are returned.

    Source:
        THEORY.md 7, eq. (7.2); tutorial WA 1239 (2012), eq. (A.1).
    """
    where = Where(at, step, time, increment)
    large, count = _asked(model, "frequencies", count, where, asked_solver(sparse, solver), throw)
    if large is not None:
        refuse_unsymmetric(large.symmetric)
        with naming_culprit(large):
            hertz = to_frequency(lowest_values(large.elements, cast(int, count), large.solver))
        warn_of_fewer("frequencies", count, len(hertz), "frequencies")
        return hertz
    # Studies of designs also collect whether a state is stable.
    if isinstance(model, Linearization) or at is not None or collects():
        model = linearized(model, "frequencies", throw, where)
        m = model.matrices
        warn_of_fewer("frequencies", count, len(m.M0), "frequencies")
        if at is not None and m.moving is not None:
            return jnp.asarray(real_frequencies(np.asarray(m.K), np.asarray(m.M0))[:count])
        refuse_unsymmetric(m.symmetric)
        values, result = _frequencies_at(m, count=count)
    else:
        where.refuse("frequencies")
        target = load_factors_of(as_determined(model, "frequencies"), 1.0, increment, "frequencies")
        warn_of_fewer("frequencies", count, model.topology.n_q, "frequencies")
        refuse_unsymmetric(not lacks_potential(model.topology))
        values, result = _frequencies(model.topology, model.parameters, target, count=count)
    check_spectrum(result, throw, model)
    return or_nan(values, result, throw)


def modal_frequencies(lin: Linearization) -> tuple[Float[Array, "n"], Int[Array, ""]]:
    """Frequencies of a linearisation, (n_q,) [Hz], and an unchecked code of RESULTS."""
    return _frequencies_at(lin.matrices, count=None)


def check_spectrum(result: Array | np.ndarray, throw: bool, model: Any) -> None:
    """:func:`flexmb.results.check`, with names of moving coordinates if mass or stiffness is at fault."""
    about, model, known = "", undifferentiated(model), undifferentiated(result)
    if throw and is_concrete((model, known)):
        code = int(known)
        if code in (RESULTS.singular_mass, RESULTS.singular_stiffness):
            lin = model if isinstance(model, Linearization) else linearize(model, increment=0.0, throw=False)
            if code == RESULTS.singular_mass:
                about = negative_mass_note(negative_mass(lin))
            else:
                about = without_anything(lin) or without_stiffness(lin.model)
        if code == RESULTS.lost_in_round_off:
            about = stiffest_element_note(model if isinstance(model, Model) else model.model)
    check(result, throw, about)


@jit
def _modes(m: Matrices):
    values, vectors, stable, result = spectrum(m.K, m.M0)
    return values, to_frequency(values), m.DFx @ vectors, vectors, stable, result


@unguarded
def modes(
    model: Model | Linearization,
    *,
    count: int | None = None,
    sparse: bool | None = None,
    solver: str | LinearSolver | None = None,
    throw: bool = True,
    at: Equilibrium | Linearization | ManyStates | None = None,
    step: int | None = None,
    time: float | None = None,
    increment: float | None = None,
) -> Modes:
    """Return natural frequencies and mode shapes about the static equilibrium under the constant loads.

    Args:
        model: Mechanism, or its linearisation.
        count: Number of the lowest modes; all by default.
        sparse, solver: As for :func:`frequencies`. Modes by sparse matrices are differentiable in the parameters: their
            eigenvalues always, their shapes if no eigenvalue is repeated.
        throw: Raise if the equilibrium or the eigenproblem fails.
        at, step, time, increment: State, as for :func:`frequencies`.

    Returns:
        Modes with eigenvalues (n,) [rad^2/s^2], frequencies (n,) [Hz] and shapes (n_x, n).

    Raises:
        AnalysisError: The equilibrium was not found, or a motion has neither mass nor stiffness, or a negative mass.
        TypeError: Numbers are traced, and the matrices are dense; use :func:`frequencies`.

    Warns:
        FlexmbWarning: The mechanism has fewer than ``count`` modes with mass.

    Source:
        THEORY.md 7, eq. (7.2); tutorial WA 1239 (2012), eq. (A.1).
    """
    where = Where(at, step, time, increment)
    large, count = _asked(model, "modes", count, where, asked_solver(sparse, solver), throw)
    if large is not None:
        return _modes_of_large(large, count)
    lin = linearized(model, "modes", throw, where)
    refuse_unsymmetric(lin.matrices.symmetric)
    values, hertz, shapes, q_shapes, stable, result = _modes(lin.matrices)
    check_spectrum(result, throw, lin)
    if isinstance(values, jax.core.Tracer):
        raise TypeError("The number of modes depends on traced numbers. Use fm.frequencies under jax.grad and jax.jit.")
    finite = int(np.sum(np.isfinite(values)))
    some = finite if count is None else min(count, finite)
    warn_of_fewer("modes", count, some, "modes with mass")
    return Modes(
        values[:some], hertz[:some], shapes[:, :some], q_shapes[:, :some], values.shape[0] - finite, bool(stable), lin
    )


def _modes_of_large(lin: Linearization, count: Any) -> Modes:
    """A few modes by sparse matrices, with shapes in the degrees of freedom."""
    refuse_unsymmetric(lin.symmetric)
    with naming_culprit(lin):
        answer: Any = lowest(lin.elements, count, lin.solver)
    values, motions, massless, stable = answer.values, answer.motions, 0, False
    roles = lin.model.topology
    deformed = matrix_times(lin.elements.constraints, motions, size=roles.n_e)
    q_shapes = jnp.concatenate([motions[roles.x.dof], deformed[roles.e.dof]])
    if is_concrete(answer):
        stable, some = bool(np.all(values[:1] > 0)), int(np.sum(np.isfinite(values)))
        if some < len(values):
            moving, constraints = lin.elements.unknowns
            massless = moving - constraints - some
            values, motions, q_shapes = values[:some], motions[:, :some], q_shapes[:, :some]
    warn_of_fewer("modes", count, len(values), "modes with mass")
    return Modes(values, to_frequency(values), motions, q_shapes, massless, stable, lin)


@one_thread()
@unguarded
def poles(
    model: Model | Linearization,
    *,
    count: int | None = None,
    sparse: bool | None = None,
    solver: str | LinearSolver | None = None,
    at: Equilibrium | Linearization | ManyStates | None = None,
    step: int | None = None,
    time: float | None = None,
    increment: float | None = None,
) -> Complex[np.ndarray, "n"]:
    """Return the poles of lambda^2 M0 + lambda (C0 + D0) + K0 + N0 + G0, ordered by |Im|.

    Args:
        model: Mechanism, or its linearisation.
        count: Number of poles nearest to zero; all by default. One pole more is returned if this completes a complex
            pair. ``jax.grad`` and ``jax.jit`` need ``count``, and return exactly this number.
        sparse, solver: Compute ``count`` poles by sparse matrices, as for :func:`frequencies`.
        at, step, time, increment: State, as for :func:`frequencies`.

    Returns:
        (n,) [rad/s], without the infinite poles of motions without mass. Differentiable in ``model.parameters``, except
        where two poles coincide, as at critical damping or for a free motion: derivatives are NaN there.

    Raises:
        AnalysisError: The equilibrium was not found, or a motion has a negative mass. singular_stiffness: a motion has
            neither mass, stiffness nor damping; with sparse matrices, neither mass nor stiffness. not_converged: the
            sparse solver did not converge.
        ValueError: ``count`` is not positive, or missing with sparse matrices, or too large.
        TypeError: Numbers are traced, as under ``jax.grad``, and ``count`` is missing.

    Warns:
        FlexmbWarning: The mechanism has fewer than ``count`` poles.

    Source:
        THEORY.md 7, eq. (7.3); companion form with the pencil's mass, solved by the QZ method; by sparse matrices
        (7.20). Derivatives: (10.4).
    """
    where = Where(at, step, time, increment)
    large, count = _asked(model, "poles", count, where, asked_solver(sparse, solver))
    if large is not None:
        nearest = _poles_of_large(large, count)
        warn_of_fewer("poles", count, len(nearest), "finite poles")
        return nearest
    lin = linearized(model, "poles", where=where)
    refuse_negative_mass(lin)
    # Damping alone leaves a pole at zero; without damping any number would be a pole.
    refuse_without_anything(lin, damped=False)
    if not is_concrete(lin.matrices):
        return _poles_of_traced(lin.matrices, count)
    # On the host from the start: within another program JAX would trace sums of its arrays.
    m = jax.tree.map(np.asarray, lin.matrices)
    nearest = slowest(poles_of(m.K, m.C0 + m.D0, m.M0), count)
    warn_of_fewer("poles", count, len(nearest), "finite poles")
    return nearest


def _poles_of_traced(m: Matrices, count: int | None) -> Any:
    n = len(m.M0)
    if count is None:
        raise TypeError(
            "The number of poles depends on traced numbers. Under jax.grad and jax.jit give fm.poles `count`."
        )
    if count > 2 * n:
        raise ValueError(
            f"Argument `count` of fm.poles is {count}, but {n} degrees of freedom have at most {2 * n} poles."
        )
    values, result = traced_poles(m.K, m.C0 + m.D0, m.M0, count)
    check(result, True)
    return or_nan(values, result)


def _poles_of_large(lin: Linearization, count: Any) -> Any:
    """A few poles by sparse matrices."""
    if not is_concrete(lin.elements):
        with naming_culprit(lin):
            return poles_of_elements(lin.elements, count)
    assembled = AssembledEquations(jax.tree.map(np.asarray, lin.elements))
    refuse_negative_masses(assembled)
    with naming_culprit(lin):
        return poles_of_sparse(assembled, count, lin.solver)
