"""Measured frequency responses with complex values."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..control.frequency_response import frequency_response
from ..design.designs import float_array
from ..errors import warn
from .measurement import Measured, measured


def measured_response(
    hertz: Any,
    values: Any,
    deviation: Any = None,
    *,
    output: str | None = None,
    input: str | None = None,
    loss_factor: Any = None,
    gain: str | None = None,
    delay: str | None = None,
    logarithmic: bool = False,
    name: str = "response",
) -> Measured:
    """Describe the measured response of an output to a harmonic input.

    ``control.FrequencyResponse.load`` reads a universal file (data set 58), ``numpy.loadtxt`` reads a table.

    Args:
        hertz: Frequencies, (n_f,) [Hz].
        values: Complex response, (n_f,) [unit of the output over the unit of the input].
        deviation: Standard deviation of real part and of imaginary part, () or (n_f,) [unit of the response].
        output, input: Names of an output and an input of the model. Omit the name of a single output or input.
        loss_factor: Loss factor of structural damping, a number [-] or the name of a fitted parameter.
        gain: Name of a fitted parameter, a factor of the response [-].
        delay: Name of a fitted parameter, the delay of the measuring chain [s].
        logarithmic: Compare logarithm of magnitude and phase in place of real and imaginary part. This comparison has
            fewer local minima; use it far from the solution. flexmb divides the deviations by the measured magnitude.
        name: Name in tables and messages.

    Returns:
        Measured: first the real parts, then the imaginary parts.

    Raises:
        ValueError: Numbers of frequencies and values differ. A frequency or value is not finite. A response is zero
            with ``logarithmic``. Also the errors of :func:`measured`.

    Source:
        y = gain exp(-2 pi i f delay) H(2 pi i f) u.
    """
    places = np.atleast_1d(float_array(f"Measurement '{name}': frequencies", hertz))
    response: Any = np.atleast_1d(np.asarray(values, complex))
    if places.ndim > 1 or response.shape != places.shape:
        raise ValueError(
            f"Measurement '{name}' has {places.size} frequencies and {response.size} values: give one value for each."
        )
    wrong = np.flatnonzero(~(np.isfinite(places) & np.isfinite(response)))
    if len(wrong):
        raise ValueError(
            f"Measurement '{name}' has a value that is not finite, number {wrong[0] + 1} of {len(places)}."
            " Leave it out."
        )
    if logarithmic and np.any(response == 0):
        raise ValueError(f"Measurement '{name}' has a response of zero, which has no logarithm: leave it out.")
    if not np.any(response.imag) and np.all(response.real > 0):
        warn(
            f"Measurement '{name}' is real and positive at all frequencies, like a magnitude. flexmb compares complex"
            " responses: give real and imaginary parts."
        )
    fitted = [text for text in (loss_factor, gain, delay) if isinstance(text, str)]

    def answer(model: Any, **parameters: Any) -> Float[Array, "2*n_f"]:
        loss = parameters[loss_factor] if isinstance(loss_factor, str) else loss_factor
        asked = jnp.asarray(places)
        computed: Any = frequency_response(model, asked, outputs=output, inputs=input, loss_factor=loss).of()
        if gain is not None:
            computed = computed * jnp.asarray(parameters[gain], complex)
        if delay is not None:
            angle = -2 * np.pi * places * parameters[delay]
            computed = computed * jax.lax.complex(jnp.cos(angle), jnp.sin(angle))
        if logarithmic:
            computed = jnp.log(computed / response)
        return jnp.concatenate([computed.real, computed.imag])

    def sizes(computed: np.ndarray) -> np.ndarray:
        real, imaginary = np.split(computed, 2)
        return np.tile(np.abs(response) * np.exp(real) if logarithmic else np.hypot(real, imaginary), 2)

    parts, scatter = np.concatenate([response.real, response.imag]), deviation
    if deviation is not None:
        scatter = np.broadcast_to(float_array(f"Measurement '{name}': deviations", deviation), places.shape)
        scatter = np.tile(scatter / np.abs(response) if logarithmic else scatter, 2)
    if logarithmic:
        parts = np.zeros_like(parts)
    single = measured(answer, parts, scatter, name=name, over=np.tile(places, 2), label="frequency [Hz]")
    advice = "" if logarithmic else "measured_response(.., logarithmic=True) has fewer local minima"
    parameters = tuple(dict.fromkeys(fitted))
    return dataclasses.replace(single, parameters=parameters, relative=logarithmic, advice=advice, sizes=sizes)
