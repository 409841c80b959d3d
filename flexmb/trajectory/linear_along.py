"""Linear equations along a motion: matrices that vary with time, interpolated between the times, and their files."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, ArrayLike, Float

from .. import __version__
from ..arguments import as_reals, check_number, check_numbers, check_whole, checked_times, is_concrete, short_repr
from ..compilation.compile import jit
from ..compilation.record import Record, static
from ..control.state_space import StateMatrices, state_matrices
from ..display import Column, Labelled, Quantities, Summary, short, span
from ..files import save_arrays
from ..linear.spectrum import real_frequencies
from ..numerical_limits import NO_VIBRATION, SAME_TIME
from .about_motion import about, check_freedoms, freedoms_of, origins_of, outputs_of
from .slow_modes import reduced_system
from .varying_equations import Spline, cubic_spline, integrate_varying, with_halved_steps

if TYPE_CHECKING:
    import control


class TimeVarying(Labelled, Record):
    """Linear time-varying system z_dot = A(t) z + B(t) u, y = C(t) z + D(t) u along a motion.

    z, u and y are deviations from the motion. Displacements of the degrees of freedom come first, then their rates.
    The states are the same at all times. A cubic spline (SciPy's ``CubicSpline``) can therefore interpolate the
    matrices.

    Attributes:
        t: Times, (n_t,) [s].
        A: (n_t, n_z, n_z).
        B: (n_t, n_z, n_u).
        C: (n_t, n_y, n_z).
        D: (n_t, n_y, n_u).
        M: Mass of the first n states, whose rates are the next n, (n_t, n, n).
        u0: Inputs of the motion itself, (n_t, n_u) [N, N m; for motions of supports m, rad and their rates].
        y0: Outputs of the motion, (n_t, n_y) [m, rad, ..].
        z0: States of the motion at the first time, (n_z,).
        sigma: Stress resultants of the motion, (n_t, n_e) [N, N m].
        basis: Shapes of the first n states in the degrees of freedom, (n_t, n_q, n); None if the states are the degrees
            of freedom.
        error: For a reduced system, the largest relative error of each frequency at any time, (n,) [-]; otherwise, and
            under a trace, None.
        left_out: For a reduced system, the lowest frequency that is not kept, (n_t,) [Hz]; otherwise None.
        state_labels: Names of the states.
        input_labels: Names of the inputs.
        output_labels: Names of the outputs.
        origins: Coordinates in the undeformed mechanism for outputs that are displacements, NaN for other outputs,
            (n_y,) [m]; None if unknown.
    """

    t: Float[Array, "n_t"]
    A: Float[Array, "n_t n_z n_z"]
    B: Float[Array, "n_t n_z n_u"]
    C: Float[Array, "n_t n_y n_z"]
    D: Float[Array, "n_t n_y n_u"]
    M: Float[Array, "n_t n n"]
    u0: Float[Array, "n_t n_u"]
    y0: Float[Array, "n_t n_y"]
    z0: Float[Array, "n_z"]
    sigma: Float[Array, "n_t n_e"]
    basis: Float[Array, "n_t n_q n"] | None
    error: Float[Array, "n"] | None
    left_out: Float[Array, "n_t"] | None
    state_labels: tuple[str, ...] = static()
    input_labels: tuple[str, ...] = static()
    output_labels: tuple[str, ...] = static()
    origins: Float[Array, "n_y"] | None = None
    one_axis = "t"

    def quantities_by_name(self) -> Quantities:
        """Matrices, inputs and outputs of the motion by time; row i of A and B has the name "d/dt state i"."""
        names = {"state": self.state_labels, "rate": tuple(f"d/dt {name}" for name in self.state_labels)}
        names |= {"input": self.input_labels, "output": self.output_labels}
        along = {"time": Column(("time",), self.t, "s")}
        along |= {name: Column((name,), np.array(labels, str)) for name, labels in names.items()}
        axes = {"A": ("rate", "state"), "B": ("rate", "input"), "C": ("output", "state"), "D": ("output", "input")}
        axes |= {"u0": ("input",), "y0": ("output",)}
        columns = {name: Column(("time", *over), getattr(self, name)) for name, over in axes.items()}
        return Quantities(("time",), along, columns)

    def __call__(self, t: ArrayLike) -> StateMatrices:
        """Matrices at one time, by a cubic spline.

        Args:
            t: Time, () [s], from the first to the last.

        Raises:
            ValueError: The time lies outside.

        Source:
            THEORY.md 14, eq. (14.20).
        """
        if is_concrete(t):
            check_number("t", t)
        self._within("t", jnp.asarray(t, float))
        return _matrices_at(_splined(self.t, (self.A, self.B, self.C, self.D)), jnp.asarray(t, float))

    def frequencies(self) -> Float[np.ndarray, "n_t n"]:
        """Return undamped frequencies at each time, ascending, (n_t, n) [Hz]; negative if unstable, NaN if complex.

        Raises:
            TypeError: The matrices are traced; frequencies need concrete numbers.

        Source:
            THEORY.md 7, eq. (7.2).
        """
        if not is_concrete(self.A):
            raise TypeError(
                "Frequencies along a motion need concrete numbers: compute them outside jax.jit, jax.grad and jax.vmap."
                " The matrices A and M of the system have derivatives."
            )
        n = self.M.shape[1]
        return _frequencies_along(-self.M @ self.A[:, n : 2 * n, :n], self.M)

    def statespace(self, t: float) -> control.StateSpace:
        """Return the system with constant matrices: the matrices of one time.

        Args:
            t: Time, () [s].

        Source:
            THEORY.md 7, eq. (7.7).
        """
        import control

        states, inputs, outputs = self._plain_names()
        return control.StateSpace(*map(np.asarray, self(t)), states=states, inputs=inputs, outputs=outputs)

    def solution(
        self,
        times: ArrayLike,
        u: Any = None,
        initial: ArrayLike | None = None,
        *,
        rtol: float | None = None,
        substeps: int | None = None,
    ) -> tuple[Float[Array, "n_y k"], Float[Array, "n_z k"]]:
        """Return outputs and states over time, as differentiable arrays.

        Args:
            times: Ascending, within the times of the system, (k,) [s].
            u: Inputs at these times, linear in between: (n_u, k), or (k,) for a single input, or a dictionary of (k,)
                by name. In a dictionary, missing inputs are zero. None: all inputs are zero.
            initial: States at the first time, (n_z,); None: zero.
            rtol: Wanted error, relative to the largest value of each output [-]; None: 1e-6. Not beside ``substeps``.
            substeps: Integration steps between two times; None: as many as ``rtol`` needs, or 4 under a trace.

        Returns:
            Outputs, (n_y, k), and states, (n_z, k), as deviations from the motion.

        Raises:
            ValueError: Times are outside the times of the system, or sizes do not agree.

        Warns:
            FlexmbWarning: The error does not reach ``rtol``.

        Source:
            THEORY.md 14, eq. (14.21).
        """
        times, u, start = self._given(times, u, initial)
        run = partial(_solved, _splined(self.t, (self.A, self.B, self.C, self.D)), times, u, start)

        def difference(fine: tuple[Array, Array], coarse: tuple[Array, Array]):
            seen, before = (solution[0] if self.output_labels else solution[1] for solution in (fine, coarse))
            size = jnp.max(jnp.abs(seen), axis=1, initial=0.0)
            off = jnp.max(jnp.abs(seen - before), axis=1, initial=0.0)
            return float(jnp.max(jnp.where(size > 0, off / jnp.where(size > 0, size, 1.0), 0.0), initial=0.0))

        traced = not is_concrete((self, times, u, start))
        return with_halved_steps(
            run, difference, substeps, rtol, 1e-6, traced, "The response of the time-varying system"
        )[0]

    def response(
        self,
        times: ArrayLike,
        u: Any = None,
        initial: ArrayLike | None = None,
        *,
        rtol: float | None = None,
        substeps: int | None = None,
    ) -> control.TimeResponseData:
        """Return the response to inputs and an initial state, like ``control.forced_response`` for a constant system.

        Args:
            times: See :meth:`solution`.
            u: See :meth:`solution`.
            initial: See :meth:`solution`.
            rtol: See :meth:`solution`.
            substeps: See :meth:`solution`.

        Returns:
            control.TimeResponseData with time (k,), outputs (n_y, k), states (n_z, k) and inputs (n_u, k), deviations
            from the motion.

        Raises:
            ValueError: See :meth:`solution`.

        Source:
            See :meth:`solution`.
        """
        import control

        y, z = self.solution(times, u, initial, rtol=rtol, substeps=substeps)
        times, u, _ = self._given(times, u, initial)
        time, y, z, u = (np.asarray(values) for values in (times, y, z, u.T))
        names = dict(zip(("state_labels", "input_labels", "output_labels"), self._plain_names(), strict=True))
        return control.TimeResponseData(time, y, states=z, inputs=u, title="Along a motion", **names)

    def reduced(self, modes: int) -> TimeVarying:
        """Return the system in the amplitudes of a few slowly varying modes; other motions respond quasi-statically.

        Args:
            modes: Number of modes to keep. Their shapes approximate the lowest modes at nine instants.

        Returns:
            TimeVarying with ``error`` and ``left_out``.

        Raises:
            ValueError: There are fewer modes.

        Source:
            THEORY.md 14, eq. (14.24) and (14.25).
        """
        n = self.M.shape[1]
        check_whole("modes", modes, 1, n)
        system, shapes, still = reduced_system(self.t, (self.A, self.B, self.C, self.D, self.M, self.z0), modes=modes)
        names = [f"mode {i + 1}" for i in range(modes)]
        labels = (*names, *(f"d {name}" for name in names), *self.state_labels[2 * n :])
        basis = shapes if self.basis is None else self.basis @ shapes
        parts = dict(zip(("A", "B", "C", "D", "M", "z0"), system, strict=True))
        smaller = dataclasses.replace(self, **parts, basis=basis, state_labels=labels)
        if not is_concrete(self):
            return smaller
        full_values, reduced_values = self.frequencies(), _frequencies_along(still, smaller.M)
        size = np.maximum(np.abs(full_values[:, :modes]), NO_VIBRATION * np.max(np.abs(full_values)))
        left_out = full_values[:, modes] if modes < n else np.full(len(full_values), np.inf)
        error = np.max(np.abs(reduced_values - full_values[:, :modes]) / size, axis=0)
        return dataclasses.replace(smaller, error=jnp.asarray(error), left_out=jnp.asarray(left_out))

    def save(self, path: str | os.PathLike) -> None:
        """Save the system as .npz or .mat, under the names of SPACAR's ltv file.

        The file also contains the names "states", "inputs" and "outputs", and "about": JSON that describes each array
        and what is left out (the second-order output tensor G, NYS and NRBM).

        Args:
            path: File.

        Raises:
            ValueError: The path has another ending.
            OSError: The folder is missing or not writable.

        Source:
            SPACAR's names; see :data:`DESCRIPTIONS`.
        """
        save_arrays(path, arrays_of(self), {"flexmb": __version__, "arrays": DESCRIPTIONS, "left out": LEFT_OUT})

    def summary(self) -> Summary:
        """Return times, sizes and the range of the frequencies."""
        t = np.asarray(self.t)
        hertz = self.frequencies()
        rows = {
            "time": f"{short(t[0])} to {short(t[-1])} s, {len(t)} times",
            "states": _listed(self.state_labels),
            "inputs": _listed(self.input_labels),
            "outputs": _listed(self.output_labels),
            "lowest frequency": span(hertz[:, 0], "Hz"),
            "highest frequency": span(hertz[:, -1], "Hz"),
        }
        return Summary(f"{type(self).__name__}: linear system of {len(self.state_labels)} states along a motion", rows)

    def _plain_names(self) -> list[list[str]]:
        """Names of states, inputs and outputs without dots, as control requires."""
        labels = self.state_labels, self.input_labels, self.output_labels
        return [[name.replace(".", " ") for name in names] for names in labels]

    def _within(self, name: str, times: ArrayLike) -> None:
        if not is_concrete((self.t, times)):
            return
        first, last = float(self.t[0]), float(self.t[-1])
        slack = SAME_TIME * max(abs(first), abs(last))
        if np.any(np.asarray(times) < first - slack) or np.any(np.asarray(times) > last + slack):
            raise ValueError(
                f"Argument `{name}` must lie within the times of the system, {short(first)} to {short(last)} s, but is"
                f" {short_repr(np.asarray(times).tolist())}."
            )

    def _given(self, times: ArrayLike, u: Any, initial: ArrayLike | None):
        """Times, inputs (k, n_u) and initial state as arrays."""
        times = jnp.asarray(checked_times(times), float)
        self._within("times", times)
        sizes, known = (len(self.input_labels), times.shape[0]), ", ".join(self.input_labels) or "none"
        if isinstance(u, Mapping):
            if unknown := [name for name in u if name not in self.input_labels]:
                raise ValueError(f"There is no input '{unknown[0]}'; there is {known}.")
            rows = [as_reals("Argument `u`", u.get(name, 0.0)) for name in self.input_labels]
            u = jnp.stack([jnp.broadcast_to(row, sizes[1:]) for row in rows]) if rows else None
        u = jnp.zeros(sizes) if u is None else as_reals("Argument `u`", u)
        u = u[None] if u.ndim == 1 and sizes[0] == 1 else u
        if u.shape != sizes:
            raise ValueError(
                f"Argument `u` must have a row for each input ({known}) and a column for"
                f" each time, {sizes}, but has shape {u.shape}."
            )
        count = len(self.state_labels)
        start = jnp.zeros(count) if initial is None else as_reals("Argument `initial`", initial)
        if start.shape != (count,):
            raise ValueError(
                f"Argument `initial` must have one number for each of the {count} states, not shape {start.shape}."
            )
        check_numbers("Argument `u`", u, sizes)
        check_numbers("Argument `initial`", start, (count,))
        return times, u.T, start


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:6]) + (f", … ({len(names)})" if len(names) > 6 else "") if names else "none"


def _frequencies_along(stiffness: Float[Array, "n_t n n"], mass: Float[Array, "n_t n n"]) -> np.ndarray:
    pairs = zip(np.asarray(stiffness), np.asarray(mass), strict=True)
    return np.array([real_frequencies(k, m) for k, m in pairs])


@jit
def _splined(t: Float[Array, "n_t"], parts: tuple[Any, ...]) -> tuple[Spline, ...]:
    return tuple(cubic_spline(t, part) for part in parts)


@jit
def _matrices_at(splines: tuple[Spline, ...], t: Float[Array, ""]) -> StateMatrices:
    return StateMatrices(*(spline(t) for spline in splines))


@jit
def _solved(
    splines: tuple[Spline, ...],
    times: Float[Array, "k"],
    u: Float[Array, "k n_u"],
    start: Float[Array, "n_z"],
    count: Any = None,
    *,
    substeps: int | None = None,
):
    """Outputs and states: z_dot = A z + B u as a second-order equation in the integral of z, without stiffness."""
    a, b, c, d = splines
    eye = jnp.eye(start.shape[0])

    def equation(t: Float[Array, ""]):
        i = jnp.clip(jnp.searchsorted(times, t, side="right") - 1, 0, times.shape[0] - 2)
        inputs = u[i] + (t - times[i]) / (times[i + 1] - times[i]) * (u[i + 1] - u[i])
        return eye, -a(t), jnp.zeros_like(eye), b(t) @ inputs

    _, z = integrate_varying(equation, times, jnp.zeros_like(start), start, count if substeps is None else substeps)
    y = jax.lax.map(lambda at: c(at[0]) @ at[1] + d(at[0]) @ at[2], (times, z, u))
    return y.T, z.T


def time_varying(along: Any) -> TimeVarying:
    """Return the linear time-varying system along a simulated or nominal motion.

    Args:
        along: Motion of a simulation (SPACAR's mode 4), or nominal motion of inverse dynamics (mode 3) with its inputs.
            Its times should resolve changes of the matrices, not vibrations.

    Returns:
        TimeVarying from the named inputs to the named outputs of the model [SI].

    Raises:
        TypeError: The argument is neither a Motion nor a Nominal.
        ModelError, AnalysisError: As :func:`flexmb.control.state_matrices`; or the motion did not reach its end, or the
            degrees of freedom do not determine the configuration at some time.

    Warns:
        FlexmbWarning: One input moves several coordinates, such as two supports, but these coordinates move differently
            along the motion.

    Source:
        THEORY.md 6, eq. (6.4) and (6.5), 7, eq. (7.7), and 14, eq. (14.20).
    """
    motion, u0, _ = about(along, "time_varying")
    y0 = getattr(along, "y0", None)
    y0 = outputs_of(motion) if y0 is None else y0
    model = motion.model
    check_freedoms(motion)
    lin = motion.linearizations()
    (a, b, c, d), states = state_matrices(lin)
    orders = [signal.terms[0].order or 0 for signal in model.signals()[0]]
    # State matrices order displacements moved by inputs after the degrees of freedom, their rates after these.
    moved, speeds = sum(order > 0 for order in orders), sum(order > 1 for order in orders)
    n = (a.shape[1] - moved - speeds) // 2
    order = np.concatenate(
        [np.arange(n), n + moved + np.arange(n), n + np.arange(moved), 2 * n + moved + np.arange(speeds)]
    )
    freedom_names = [name.removesuffix(" shifted") for name in states[:n]] or model.q_labels
    states = [states[i] for i in order] if states else [*freedom_names, *(f"d {name}" for name in freedom_names)]
    names = [tuple(s.name for s in signals) for signals in (model.labels.inputs, model.labels.outputs)]
    place = np.array([model.q_labels.index(name) for name in freedom_names], int)
    a, b, c, mass, start = _ordered(a, b, c, lin.M0, freedoms_of(motion), order, place)
    matrices, along_it = (a, b, c, d, mass), (u0, y0, start, lin.sigma)
    none = None, None, None
    return TimeVarying(motion.t, *matrices, *along_it, *none, tuple(states), *names, origins=origins_of(model))


@jit
def _ordered(a: Any, b: Any, c: Any, mass: Any, freedoms: Any, order: Array, place: Array):
    """Matrices in the order of the states of :class:`TimeVarying`, and its first state."""
    first = [freedom[0, place] for freedom in freedoms]
    start = jnp.concatenate([*first, jnp.zeros(len(order) - 2 * len(place))])
    return a[:, order][:, :, order], b[:, order], c[:, :, order], mass[:, place][:, :, place], start


DESCRIPTIONS = {
    "NNOM": "number of nominal inputs, columns of U0",
    "NX": "number of states",
    "NU": "number of inputs",
    "NY": "number of outputs",
    "DFT": "1 where D is not zero at some time",
    "X0": "states of the motion itself at the first time: degrees of freedom or amplitudes, then their rates",
    "T": "times [s]; A to Y0 have a row for each, matrices in it column by column",
    "A": "NX by NX",
    "B": "NX by NU",
    "C": "NY by NX",
    "D": "NY by NU",
    "M0": "mass of the first half of the states",
    "C0B": "C0 + D0 of them",
    "K0B": "K0 + N0 + G0 of them",
    "SIG0": "stress resultants along the motion [N, N m]",
    "U0": "inputs along it",
    "Y0": "outputs along it",
}
LEFT_OUT = (
    "G, NYS and NRBM are missing: the outputs are not expanded to second order, and the two numbers are not documented."
)


def arrays_of(system: TimeVarying) -> dict[str, np.ndarray]:
    """Arrays of the file by name."""
    n = system.M.shape[1]
    a, b, c, d, mass = (np.asarray(getattr(system, name)) for name in "ABCDM")
    rows = {
        "A": a,
        "B": b,
        "C": c,
        "D": d,
        "M0": mass,
        "C0B": -mass @ a[:, n : 2 * n, n : 2 * n],
        "K0B": -mass @ a[:, n : 2 * n, :n],
        "SIG0": np.asarray(system.sigma),
        "U0": np.asarray(system.u0),
        "Y0": np.asarray(system.y0),
    }
    numbers = {"NNOM": system.u0.shape[1], "NX": a.shape[1], "NU": b.shape[2], "NY": c.shape[1], "DFT": int(np.any(d))}
    return {
        **{name: np.asarray(number) for name, number in numbers.items()},
        "X0": np.asarray(system.z0),
        "T": np.asarray(system.t),
        # Column by column: the last axis varies slowest.
        **{name: np.swapaxes(row, 1, -1).reshape(len(row), -1) for name, row in rows.items()},
        **{f"{name}s": np.array(getattr(system, f"{name}_labels"), dtype=str) for name in ("state", "input", "output")},
    }
