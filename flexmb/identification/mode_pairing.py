"""Measured natural frequencies, paired with modes of the model by number or by measured shapes."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_whole
from ..design.designs import float_array
from ..linear.linearize import linearize
from ..linear.modes import check_spectrum, frequencies, refuse_unsymmetric
from ..linear.spectrum import spectrum, to_frequency
from ..numerical_limits import WORST_MAC
from ..results import or_nan
from ..statics.solver_choice import up_to
from .measurement import Measured, measured


def measured_modes(
    hertz: Any,
    deviation: Any = None,
    *,
    numbers_of_modes: Sequence[int] | None = None,
    shapes: Any = None,
    at: Sequence[str] = (),
    among: int | None = None,
    name: str = "frequencies",
) -> Measured:
    """Describe measured natural frequencies of a mechanism at its equilibrium.

    Without shapes, frequency i is the frequency of mode i, or of the mode with the given number. With shapes, flexmb
    pairs the measured modes with modes of the model by the similarity of their shapes. Modes may then change their
    order while parameters change.

    Args:
        hertz: Measured frequencies, (m,) [Hz].
        deviation: Standard deviation, () or (m,) [Hz].
        numbers_of_modes: Numbers of the modes, from 1, (m,); by default 1 to m.
        shapes: Measured shapes as columns, in any scale, (sensors, m). flexmb uses them for pairing only.
        at: Coordinates that the sensors measure, such as "tip.y", (sensors,).
        among: Number of modes of the model that flexmb compares with the measured shapes; by default twice m.
        name: Name in tables and messages.

    Returns:
        Measured. Its ``check`` raises ValueError for a measured mode without partner.

    Raises:
        ValueError: The number of mode numbers or of shapes differs from the number of frequencies. Frequencies fall
            while their mode numbers rise. Shapes have no sensors, or sensors have no shapes.

    Source:
        Modal assurance criterion: Allemang, Brown 1982. Pairs maximise its sum (Hungarian algorithm of optax).
    """
    array = np.atleast_1d(float_array(f"Measurement '{name}': values", hertz))
    count = len(array)
    if shapes is None:
        if len(at):
            raise ValueError(f"Measurement '{name}' names sensors but has no shapes: give `shapes`, or leave out `at`.")
        which = np.arange(1, count + 1) if numbers_of_modes is None else np.asarray(numbers_of_modes)
        for number in which.tolist():
            check_whole("numbers_of_modes", number, 1)
        if which.shape != (count,) or len(set(which.tolist())) < count:
            raise ValueError(f"Measurement '{name}' has {count} frequencies: give as many numbers of modes, each once.")
        order = np.argsort(which)
        if falls := np.flatnonzero(np.diff(array[order]) < 0).tolist():
            lower, upper = order[falls[0]], order[falls[0] + 1]
            raise ValueError(
                f"Measurement '{name}' has {array[lower]:g} Hz for mode {which[lower]} and {array[upper]:g} Hz for mode"
                f" {which[upper]}. Modes are numbered by ascending frequency."
            )
        most = int(which.max())

        def answer_by_number(model: Any) -> Float[Array, "m"]:
            lowest = frequencies(model, count=up_to(most, model))
            # JAX would return the last mode for any larger index.
            if len(lowest) < most:
                raise ValueError(f"Measurement '{name}' has mode {most}, but the model has {len(lowest)} modes.")
            return lowest[which - 1]

        return measured(answer_by_number, array, deviation, name=name, over=which, label="mode")
    if numbers_of_modes is not None:
        raise ValueError(f"Measurement '{name}' has shapes, which select the modes: leave out `numbers_of_modes`.")
    matrix = float_array(f"Measurement '{name}': shapes", shapes)
    if matrix.shape != (len(at), count) or not np.all(np.isfinite(matrix)):
        raise ValueError(
            f"Measurement '{name}' has {count} frequencies and {len(at)} sensors, but shapes of {matrix.shape}: give"
            " finite numbers, one row per sensor and one column per mode."
        )
    among = check_whole("among", among, count) if among is not None else 2 * count

    def answer_by_shape(model: Any) -> Float[Array, "m"]:
        values, moved = _modes_at_sensors(model, at, among)
        return to_frequency(values)[partners(moved, matrix)[0]]

    def check(model: Any) -> None:
        pairs, alike = partners(_modes_at_sensors(model, at, among)[1], matrix)
        for i in np.flatnonzero(np.asarray(alike) < WORST_MAC):
            raise ValueError(
                f"Mode {i + 1} of measurement '{name}', {array[i]:g} Hz, has no partner in the model: the modal"
                f" assurance criterion is {float(alike[i]):.2f} with its mode {int(pairs[i]) + 1}. Check the shape, the"
                " sensors, or look among more modes (among)."
            )

    single = measured(answer_by_shape, array, deviation, name=name, over=np.arange(1, count + 1), label="measured mode")
    return dataclasses.replace(single, check=check)


def _modes_at_sensors(model: Any, at: Sequence[str], count: int) -> tuple[Array, Float[Array, "sensors modes"]]:
    """Return the lowest eigenvalues, and the motion of the sensors in these modes, without derivatives."""
    lin = linearize(model)
    names = [str(entry) for entry in lin.labels.x]
    for text in at:
        if text not in names:
            raise KeyError(f"There is no coordinate '{text}' for a sensor; coordinates are {', '.join(names)}.")
    m = lin.matrices
    refuse_unsymmetric(m.symmetric)
    values, vectors, _, result = spectrum(m.K, m.M0)
    check_spectrum(result, True, lin)
    values = or_nan(values, result)
    moved = (m.DFx @ vectors)[np.array([names.index(text) for text in at])]
    return values[:count], jax.lax.stop_gradient(moved[:, :count])


def partners(moved: Float[Array, "sensors modes"], shapes: np.ndarray) -> tuple[Array, Array]:
    """Return the modes paired with measured shapes, (m,), and their modal assurance criterion, (m,)."""
    import optax

    sizes = jnp.sum(jnp.asarray(shapes).T ** 2, axis=1)[:, None] * jnp.sum(moved**2, axis=0)
    alike = (shapes.T @ moved) ** 2 / jnp.maximum(sizes, jnp.finfo(float).tiny)
    rows, columns = optax.assignment.hungarian_algorithm(-alike)
    order = jnp.argsort(rows)
    return columns[order], alike[rows[order], columns[order]]
