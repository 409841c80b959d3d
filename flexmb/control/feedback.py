"""A controller around the linearised mechanism, as a state space or by frequency."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float

from ..arguments import as_reals, is_concrete, numbers, shown
from ..compilation.compile import jit
from .energy_form import EnergyForm
from .frequency_response import one_of

# Numbers of the outputs that a controller reads, and of the inputs that it drives.
Places = tuple[tuple[int, ...], tuple[int, ...]]


class Controller(NamedTuple):
    """Controller u = H y, its sign included.

    Attributes:
        measured: Numbers of the outputs that it reads.
        driven: Numbers of the inputs that it drives.
        matrices: A, B, C and D; None if it is known by frequency alone.
        by_frequency: Function of frequencies, (n_f,) [Hz], that returns (n_f, n_driven, n_measured).
    """

    measured: tuple[int, ...]
    driven: tuple[int, ...]
    matrices: tuple[Any, Any, Any, Any] | None
    by_frequency: Callable[[Any], Any]


def controller_of(
    given: Any, measured: Any, driven: Any, outputs: Sequence[str], inputs: Sequence[str], sign: float
) -> Controller:
    """Controller from a control.LTI, (A, B, C, D), gains, or a function of frequencies; raise for wrong ones.

    ``measured`` and ``driven`` name outputs and inputs; None for the names of the controller's signals, or all.
    """
    shape, labels, matrices, respond = _told(given)
    places = []
    for kind, names, all_of, count, own_names in (
        ("measured", measured, outputs, shape and shape[1], labels and labels[0]),
        ("driven", driven, inputs, shape and shape[0], labels and labels[1]),
    ):
        what = "output" if kind == "measured" else "input"
        if names is None:
            known = {name.replace(".", " ") for name in all_of}
            names = (
                own_names if own_names and all(name.replace(".", " ") in known for name in own_names) else list(all_of)
            )
        names = [names] if isinstance(names, str) else list(names)
        if count is not None and len(names) != count:
            raise ValueError(
                f"The controller has {count} {'inputs' if what == 'output' else 'outputs'}, but the mechanism has"
                f" {len(names)} {what}s. Choose some by `{kind}`, of: {', '.join(all_of)}."
            )
        places.append(tuple(one_of(what, all_of, name) for name in names))
    sizes = (len(places[1]), len(places[0]))
    if matrices is not None:
        a, b, c, d = matrices
        matrices = (a, b, sign * c, sign * d)

    def by_frequency(hertz: Float[Array | np.ndarray, "n_f"]):
        gain: Any = respond(hertz) if matrices is None else _of_states(matrices, hertz)
        gain = np.asarray(gain, complex) if is_concrete(gain) else gain.astype(complex)
        if gain.ndim == 1 and sizes == (1, 1):
            gain = gain[:, None, None]
        if gain.shape != (len(hertz), *sizes):
            raise ValueError(
                f"The controller, a function of frequencies, must return shape {(len(hertz), *sizes)}, not"
                f" {gain.shape}."
            )
        return gain if matrices is not None else sign * gain

    return Controller(places[0], places[1], matrices, by_frequency)


def _told(given: Any) -> tuple[Any, Any, Any, Any]:
    """Shape (outputs, inputs) and labels if known, matrices or a function of frequencies."""
    if type(given).__module__.split(".")[0] == "control":
        import control

        if getattr(given, "isdtime", lambda **_: False)(strict=True):
            raise ValueError(
                "A sampled controller has no response to continuous noise. Give the continuous controller that it is"
                " made from."
            )
        labels = list(given.input_labels), list(given.output_labels)
        shape = given.noutputs, given.ninputs
        if isinstance(given, control.FrequencyResponseData):
            return (
                shape,
                labels,
                None,
                lambda hertz: np.moveaxis(np.asarray(given(2j * np.pi * np.asarray(hertz), squeeze=False)), -1, 0),
            )
        own: Any = control.ss(given)
        return shape, labels, tuple(as_reals("The controller", part) for part in (own.A, own.B, own.C, own.D)), None
    if callable(given):
        return None, None, None, given
    if isinstance(given, tuple) and len(given) == 4:
        a, b, c, d = (jnp.atleast_2d(as_reals("The controller", part)) for part in given)
        n = a.shape[0]
        d_shape = (c.shape[0], b.shape[1])
        if a.shape != (n, n) or b.shape[0] != n or c.shape[1] != n or d.shape != d_shape:
            raise ValueError("The matrices A, B, C and D of the controller have sizes that do not agree.")
        return d.shape, None, (a, b, c, d), None
    if (array := numbers(given)) is not None and array.ndim in (0, 2):
        d = jnp.atleast_2d(jnp.asarray(array, float))
        none = jnp.zeros((0, 0)), jnp.zeros((0, d.shape[1])), jnp.zeros((d.shape[0], 0)), d
        return d.shape, None, none, None
    raise TypeError(
        "A controller is a system of python-control, a tuple of A, B, C and D, gains (n_driven, n_measured), or a"
        f" function of frequencies, not {shown(given)}."
    )


@jit
def _of_states(matrices: Any, hertz: Float[Array, "n_f"]) -> Complex[Array, "n_f i j"]:
    a, b, c, d = (part.astype(complex) for part in matrices)
    n = a.shape[0]
    direct = jnp.broadcast_to(d, (len(hertz), *d.shape))
    if not n:
        return direct
    s = 2j * np.pi * jnp.asarray(hertz).astype(complex)
    right = jnp.broadcast_to(b, (len(hertz), *b.shape))
    return c @ jnp.linalg.solve(s[:, None, None] * jnp.eye(n, dtype=complex) - a, right) + direct


def closed(
    plant: EnergyForm, matrices: Any, places: Places | None, us: Sequence[int], sensed: Sequence[int]
) -> EnergyForm:
    """State space from noise at inputs and of sensors to all outputs of the closed loop (THEORY.md 14, eq. (14.35)).

    Inputs are the inputs of ``us``, then sensors of the outputs ``sensed``. States of the controller are last.
    """
    a, b, c, d, rough = plant
    w = np.asarray(us, int)
    if places is None:
        return EnergyForm(a, b[:, w], c, d[:, w], rough[:, w])
    ak, bk, ck, dk = matrices
    ms, ds = (np.asarray(place) for place in places)
    noise = jnp.asarray(np.equal.outer(ms, np.asarray(sensed, int)).astype(float))
    bd, dd = b[:, ds], d[:, ds]
    bw = jnp.concatenate([b[:, w], jnp.zeros((len(a), len(sensed)))], axis=1)
    dw = jnp.concatenate([d[:, w], jnp.zeros((len(c), len(sensed)))], axis=1)
    read = jnp.concatenate([d[ms][:, w], noise], axis=1)
    around = jnp.eye(len(ds)) - dk @ dd[ms]
    by_z, by_x, by_w = (jnp.linalg.solve(around, part) for part in (dk @ c[ms], ck, dk @ read))
    seen = dd[ms]
    whole = jnp.concatenate(
        [
            jnp.concatenate([a + bd @ by_z, bd @ by_x], axis=1),
            jnp.concatenate([bk @ (c[ms] + seen @ by_z), ak + bk @ seen @ by_x], axis=1),
        ]
    )
    enters = jnp.concatenate([bw + bd @ by_w, bk @ (read + seen @ by_w)])
    leaves = jnp.concatenate([c + dd @ by_z, dd @ by_x], axis=1)
    # If a sensor's signal is not known, neither is the loop.
    lost = rough[:, w] | jnp.any(rough[ms][:, w], axis=0) | jnp.any(rough[ms][:, ds])
    return EnergyForm(
        whole, enters, leaves, dw + dd @ by_w, jnp.concatenate([lost, jnp.zeros((len(c), len(sensed)), bool)], axis=1)
    )


def closed_by_frequency(
    plant: Complex[Array, "n_f n_y n_u"],
    gain: Complex[Array, "n_f n_d n_m"] | None,
    places: Places | None,
    us: Sequence[int],
    sensed: Sequence[int],
) -> Complex[Array, "n_f n_y n_s"]:
    """Responses of all outputs to noise at inputs and of sensors (THEORY.md 14, eq. (14.33)); see :func:`closed`."""
    enters = plant[:, :, np.asarray(us, int)]
    if places is None or gain is None:
        return enters
    ms, ds = (np.asarray(place) for place in places)
    noise = np.equal.outer(ms, np.asarray(sensed, int)).astype(complex)
    noise = jnp.broadcast_to(jnp.asarray(noise), (len(plant), *noise.shape))
    enters = jnp.concatenate([enters, jnp.zeros((*plant.shape[:2], len(sensed)), complex)], axis=2)
    read = jnp.concatenate([plant[:, ms][:, :, np.asarray(us, int)], noise], axis=2)
    around = jnp.eye(len(ds), dtype=complex) - gain @ plant[:, ms][:, :, ds]
    return enters + plant[:, :, ds] @ jnp.linalg.solve(around, gain @ read)
