"""Stable inversion: inputs under which outputs of a linear system follow laws. They begin before the outputs move."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float
from numpy.polynomial import polynomial

from ..arguments import checked_times, is_concrete, short_repr
from ..compilation.record import Record, static
from ..control.state_space import state_matrices
from ..display import Result, Summary, among, listed, short, span
from ..errors import ModelError, warn
from ..linear.linearize import Linearization
from ..model.model import Model
from ..numerical_limits import JUMP_OF_LAW, MISSED_AT_REST, ZERO_OF_TERMS, ZERO_ON_AXIS
from .laws import Law, Shaped, as_law, sampled

# Degree of the polynomial between two times through the wanted outputs: exact for the laws of this room.
DEGREE = 9


class StableInversion(Result, Record):
    """Inputs under which the outputs of a linear system follow laws.

    Attributes:
        t: Times, (n_t,) [s].
        u: Inputs, (n_t, n_u) [N, N m].
        y: The outputs that follow laws, (n_t, n_y).
        z: State, (n_t, n_z).
        zeros: Zeros of the system: eigenvalues of its inverse, (n_z - sum of the relative degrees,) [1/s].
        degrees: Relative degree of each output: the order of its derivative that the inputs determine, (n_y,).
        error: Largest error of the outputs if the system starts from rest at the first time, without the earlier
            inputs, () [SI].
        inputs_of, outputs_of: Names of inputs and outputs.
    """

    t: Float[np.ndarray, "n_t"]
    u: Float[np.ndarray, "n_t n_u"]
    y: Float[np.ndarray, "n_t n_y"]
    z: Float[np.ndarray, "n_t n_z"]
    zeros: Any
    degrees: Any
    error: Float[np.ndarray, ""]
    inputs_of: tuple[str, ...] = static()
    outputs_of: tuple[str, ...] = static()
    one_axis = "t"

    @property
    def inputs(self) -> dict[str, Law]:
        """Inputs as functions of time, by their names."""
        return {name: sampled(self.t, self.u[:, i]) for i, name in enumerate(self.inputs_of)}

    def summary(self) -> Summary:
        """Return the range of each input, the zeros, and the error of a start from rest."""
        unstable = self.zeros[self.zeros.real > 0].real
        rows = {f"input {name}": span(self.u[:, i], "") for i, name in enumerate(self.inputs_of)}
        rows |= {f"output {name}": span(self.y[:, i], "") for i, name in enumerate(self.outputs_of)}
        rows["zeros"] = f"{len(self.zeros)}, in the right half plane {len(unstable)}"
        if len(unstable):
            rows["moves beforehand by"] = f"some {short(5 / np.min(unstable))} s"
        rows["error from rest"] = short(self.error)
        return Summary("Stable inversion", rows)


def stable_inversion(system: Any, trajectory: Mapping[str, Callable], times: ArrayLike) -> StableInversion:
    """Return bounded inputs under which outputs of a flexible mechanism follow laws, even with an unstable inverse.

    flexmb solves a boundary value problem over all time. It integrates the decaying part of the inverse forwards from
    rest at the start, and the growing part backwards from rest at the end. An input that is not collocated with its
    output therefore begins before the output moves: let the times begin early enough. ``error`` is the effect of the
    inputs before the first time.

    Args:
        system: Mechanism, its linearisation, or a ``control.StateSpace`` with named inputs and outputs; its numbers
            must be concrete.
        trajectory: Laws of outputs by name, as many as there are inputs. Values count from the state of linearisation.
            Laws are at rest before the first time and after the last.
        times: Ascending times at which to compute the inputs, (n_t,) [s].

    Returns:
        StableInversion.

    Raises:
        ValueError, TypeError: Times do not ascend, a law is not a function of time, or numbers are traced.
        ModelError: An output is unknown; numbers of outputs and inputs differ; the inputs cannot move an output;
            outputs depend on each other; zeros lie on the imaginary axis; a law is not smooth enough.

    Warns:
        FlexmbWarning: ``error``, for a start from rest at the first time, exceeds a thousandth of the largest output.

    Source:
        Devasia, Chen, Paden (1996), as THEORY.md 14, eq. (14.16) to (14.18).
    """
    if not is_concrete((system, times)):
        raise TypeError("Stable inversion takes concrete numbers, outside jax.jit, jax.grad and jax.vmap.")
    a, b, c, d, inputs, outputs = _system(system)
    if not isinstance(trajectory, Mapping) or not trajectory:
        raise ModelError(
            f"Argument `trajectory` must be a dictionary of outputs and laws, not {short_repr(trajectory)}."
        )
    grid = checked_times(times)
    names = list(trajectory)
    for name in names:
        if name not in outputs:
            raise ModelError(f"Trajectory '{name}' names no output of the system. Outputs are: {among(outputs, name)}.")
    if len(names) != len(inputs):
        raise ModelError(
            f"There must be as many laws as inputs, but there are {len(names)} ({among(names)}) and"
            f" {len(inputs)} ({among(inputs)})."
        )
    laws = [as_law(f"Trajectory '{name}'", trajectory[name]) for name in names]
    rows = [outputs.index(name) for name in names]
    inverse = _inverse(a, b, c[rows], d[rows], names)
    for name, degree in zip(names, inverse.degrees, strict=True):
        _check_smooth(name, trajectory[name], degree)
    z, u, y = _followed(inverse, laws, names, grid)
    error = _error_from_rest(a, c[rows], z, grid)
    if error > MISSED_AT_REST * np.max(np.abs(y)):
        unstable = np.real(inverse.zeros)[np.real(inverse.zeros) > 0]
        earlier = np.log(1 / ZERO_OF_TERMS) / np.min(unstable)
        warn(
            "The inputs begin before the first time: a start from rest at this time causes errors of up to"
            f" {short(error)}. Let the times begin earlier: about {short(earlier)} s before the outputs move."
        )
    return StableInversion(
        grid, u, y, z, inverse.zeros, np.array(inverse.degrees), np.asarray(error), tuple(inputs), tuple(names)
    )


class _Inverse(NamedTuple):
    """Inverse of a linear system: z = lift xi + internal eta, eta' = q eta + p w, u = gain (y^(r) - row z).

    Attributes:
        degrees: Relative degree of each output.
        lift: State per outputs and their derivatives xi, (n_z, r).
        internal: Basis of the states without effect on xi, (n_z, n_z - r).
        q, p: Equations of the internal states; w is xi, then the highest derivatives.
        gain, row: Equations of the inputs.
        zeros: Eigenvalues of q.
    """

    degrees: list[int]
    lift: np.ndarray
    internal: np.ndarray
    q: np.ndarray
    p: np.ndarray
    gain: np.ndarray
    row: np.ndarray
    zeros: Any


def _system(system: Any):
    """Matrices and names of a linear system."""
    if isinstance(system, Model | Linearization):
        parts, _ = state_matrices(system)
        inputs, outputs = ([s.name for s in some] for some in (system.labels.inputs, system.labels.outputs))
    elif all(hasattr(system, name) for name in "ABCD"):
        if getattr(system, "dt", 0):
            raise ModelError("Stable inversion takes a continuous system, not a sampled one.")
        parts = [getattr(system, name) for name in "ABCD"]
        inputs, outputs = list(system.input_labels), list(system.output_labels)
    else:
        raise TypeError(
            f"Stable inversion takes a Model, a Linearization or a control.StateSpace, not {short_repr(system)}."
        )
    a, b, c, d = (np.asarray(part, float) for part in parts)
    if a.ndim != 2:
        raise ModelError("This linearisation is along a motion. Give one time of it, such as lin.at_time(0).")
    return a, b, c, d, inputs, outputs


def _inverse(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, names: list[str]) -> _Inverse:
    """Inverse of a system by its relative degrees. Source: THEORY.md 14, eq. (14.16) and (14.17)."""
    import scipy.linalg

    n, degrees, chains, rows, gains = len(a), [], [], [], []
    for i, name in enumerate(names):
        row, output_rows, through = c[i], [], d[i]
        size = np.abs(d[i])
        while not np.any(np.abs(through) > ZERO_OF_TERMS * size):
            output_rows.append(row)
            if len(output_rows) > n:
                raise ModelError(f"Output '{name}' cannot be moved by the inputs.")
            through, size = row @ b, np.abs(row) @ np.abs(b)
            row = row @ a
        degrees.append(len(output_rows))
        chains += output_rows
        rows.append(row)
        gains.append(through)
    # An output of degree zero is y = C z + D u; others have y^(r) = C A^r z + C A^(r-1) B u.
    plant, row = np.array(gains), np.array(rows)
    scale = np.max(np.abs(plant), axis=1, keepdims=True)
    if np.linalg.cond(plant / scale) > 1 / ZERO_OF_TERMS:
        raise ModelError(
            f"The plant is singular: the inputs move {listed(names)} in ways that depend on one another. Let them act"
            " elsewhere, or give the law of another output."
        )
    gain = np.linalg.inv(plant)
    chain = np.array(chains).reshape(-1, n)
    # Rows of equal size, so that round-off does not hide states without effect.
    size = np.linalg.norm(chain, axis=1, keepdims=True)
    lift = np.linalg.pinv(chain / size) / size.T if len(chain) else np.zeros((n, 0))
    internal = scipy.linalg.null_space(chain / size) if len(chain) else np.eye(n)
    closed = a - b @ gain @ row
    q = internal.T @ closed @ internal
    p = np.concatenate([internal.T @ closed @ lift, internal.T @ b @ gain], axis=1)
    zeros = np.linalg.eigvals(q) if len(q) else np.zeros(0)
    on_axis = np.abs(zeros.real) <= ZERO_ON_AXIS * np.abs(zeros) if len(zeros) else np.zeros(0, bool)
    if np.any(on_axis):
        hertz = sorted({float(f"{abs(z.imag) / (2 * np.pi):.4g}") for z in zeros[on_axis]})
        raise ModelError(
            f"The plant from the inputs to {listed(names)} has zeros on the imaginary axis, at"
            f" {listed([short(f) for f in hertz])} Hz: vibrations without effect on the outputs would never end. Add"
            " damping, or choose another output."
        )
    return _Inverse(degrees, lift, internal, q, p, gain, row, zeros)


def _check_smooth(name: str, law: Any, degree: int) -> None:
    """Refuse a law with jumps in derivatives below the relative degree, which would need infinite inputs."""
    if isinstance(law, Shaped):
        law = getattr(law, "law", None)
    if not isinstance(law, Law) or degree == 0:
        return
    breaks, coefficients = np.asarray(law.breaks), np.asarray(law.coefficients)
    lengths = np.diff(breaks)
    for order in range(degree):
        pieces = polynomial.polyder(coefficients, order, axis=1)
        terms = pieces * lengths[:, None] ** np.arange(pieces.shape[1])
        begins, ends, largest = pieces[:, 0], np.sum(terms, axis=1), np.max(np.sum(np.abs(terms), axis=1))
        before = [begins[0] if order == 0 else 0.0, *ends]
        after = [*begins, ends[-1] if order == 0 else 0.0]
        jumps = np.abs(np.array(before) - np.array(after))
        if np.max(jumps) > JUMP_OF_LAW * largest:
            raise ModelError(
                f"Trajectory '{name}' is not smooth enough: its derivative of order {order} jumps at"
                f" {short(breaks[int(np.argmax(jumps))])} s, but the inputs determine the derivative of order {degree}"
                " (the relative degree). Use a smoother law, such as fm.trajectory.septic."
            )


def _followed(inverse: _Inverse, laws: Sequence[Callable[..., Any]], names: Sequence[str], grid: np.ndarray):
    """States, inputs and outputs at the times. Source: THEORY.md 14, eq. (14.18)."""

    def derivatives(t: Float[Array, ""]):
        """Outputs and their derivatives below the relative degree, then the derivatives of this degree."""
        values_by_law = []
        for law, degree in zip(laws, inverse.degrees, strict=True):
            functions = [law]
            for _ in range(degree):
                functions.append(_derivative(functions[-1]))
            values_by_law.append([f(t) for f in functions])
        return jnp.stack([v for row in values_by_law for v in row[:-1]] + [row[-1] for row in values_by_law])

    every = jax.jit(jax.vmap(derivatives))
    at = np.asarray(every(jnp.asarray(grid)))
    n_xi = sum(inverse.degrees)
    for when, values in (("first", at[0]), ("last", at[-1])):
        largest = np.max(np.abs(at[:, :n_xi]), axis=0)
        moving = np.abs(values - _at_rest(values, inverse.degrees))[:n_xi] > JUMP_OF_LAW * largest
        if np.any(moving):
            name = names[int(np.searchsorted(np.cumsum(inverse.degrees), np.argmax(moving), side="right"))]
            raise ModelError(
                f"Trajectory '{name}' is not at rest at the {when} of the times. Let the times cover the whole law."
            )
    eta = np.zeros((len(grid), len(inverse.q)))
    if len(inverse.q):
        eta = _internal(inverse, every, grid, at)
    z = at[:, :n_xi] @ inverse.lift.T + eta @ inverse.internal.T
    u = (at[:, n_xi:] - z @ inverse.row.T) @ inverse.gain.T
    return z, u, at[:, _places_of_outputs(inverse.degrees)]


def _derivative(f: Callable[..., Any]):
    return lambda t: jax.jvp(f, (t,), (jnp.ones_like(t),))[1]


def _internal(inverse: _Inverse, every: Callable[..., Any], grid: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Internal states: the decaying part from the first time on, the growing part from the last time back."""
    import scipy.linalg

    decomposition: Any = scipy.linalg.schur(inverse.q, sort="lhp")
    t, z, stable = decomposition
    p = z.T @ inverse.p
    # Separate both parts: T11 X - X T22 = -T12.
    x = scipy.linalg.solve_sylvester(t[:stable, :stable], -t[stable:, stable:], -t[:stable, stable:])
    fast, slow = t[:stable, :stable], t[stable:, stable:]
    decaying, growing = p[:stable] - x @ p[stable:], p[stable:]
    lengths = np.diff(grid)
    # Between two times the wanted outputs are a polynomial of the share of the interval, through Chebyshev's points.
    nodes = (1 - np.cos(np.pi * (2 * np.arange(DEGREE + 1) + 1) / (2 * DEGREE + 2))) / 2
    places = (grid[:-1, None] + nodes * lengths[:, None]).ravel()
    followed = np.asarray(every(jnp.asarray(places))).reshape(len(lengths), DEGREE + 1, -1)
    to_powers = np.linalg.inv(polynomial.polyvander(nodes - 0.5, DEGREE))
    about_middle = np.einsum("pn,ind->ipd", to_powers, followed)

    def steps(q: np.ndarray, p: np.ndarray, direction: int):
        """States from interval to interval. They decay in the direction of the steps: 1 is forwards, -1 backwards."""
        state = np.zeros((len(grid), len(q)))
        if not len(q):
            return state
        # Derivatives by the share of the interval, where the step begins.
        powers = np.eye(DEGREE + 1)
        shift = np.array(
            [polynomial.polyval(-0.5 * direction, polynomial.polyder(powers, j)) for j in range(len(powers))]
        )
        ahead = (float(direction) ** np.arange(DEGREE + 1))[:, None] * shift
        begun = np.einsum("jp,ipd->ijd", ahead, about_middle[::direction])
        state[0] = -np.linalg.solve(q, p @ _at_rest(at[::direction][0], inverse.degrees))
        transitions = _by_length(partial(_transition, direction * q, direction * p), lengths[::direction])
        for i, transition in enumerate(transitions):
            state[i + 1] = transition @ np.concatenate([state[i], begun[i].ravel()])
        return state[::direction]

    forwards, back = steps(fast, decaying, 1), steps(slow, growing, -1)
    return np.concatenate([forwards + back @ x.T, back], axis=1) @ z.T


def _places_of_outputs(degrees: list[int]) -> np.ndarray:
    """Places of the outputs themselves: derivatives of degree zero stand after all others."""
    firsts, n_xi = np.cumsum([0, *degrees[:-1]]), sum(degrees)
    return np.where(np.array(degrees) > 0, firsts, n_xi + np.arange(len(degrees)))


def _at_rest(values: np.ndarray, degrees: list[int]):
    """Outputs with all their derivatives zero."""
    still, places = np.zeros_like(values), _places_of_outputs(degrees)
    still[places] = values[places]
    return still


def _by_length(transition: Callable[[float], np.ndarray], lengths: np.ndarray) -> Iterator[np.ndarray]:
    """Matrix of each interval, computed once for equal lengths."""
    matrices: dict[str, np.ndarray] = {}
    for length in lengths:
        key = f"{length:.12g}"
        if key not in matrices:
            matrices[key] = transition(length)
        yield matrices[key]


def _transition(q: np.ndarray, p: np.ndarray, length: float) -> np.ndarray:
    """Matrix from the state before an interval and the scaled derivatives of the wanted outputs to the state after."""
    import scipy.linalg

    n, m = p.shape
    augmented = np.zeros((n + (DEGREE + 1) * m,) * 2)
    augmented[:n, :n], augmented[:n, n : n + m] = q * length, p * length
    augmented[n:-m, n + m :] = np.eye(DEGREE * m)
    return scipy.linalg.expm(augmented)[:n]


def _error_from_rest(a: np.ndarray, c: np.ndarray, z: np.ndarray, grid: np.ndarray) -> float:
    """Largest output of the part that a start from rest leaves out, in free motion."""
    import scipy.linalg

    missing = [-z[0]]
    for transition in _by_length(lambda length: scipy.linalg.expm(a * length), np.diff(grid)):
        missing.append(transition @ missing[-1])
    return max(float(np.max(np.abs(c @ state), initial=0.0)) for state in missing)
