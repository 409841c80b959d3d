"""Controllers in one form: python-control systems and functions, and their connection to a mechanism by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_real, is_concrete, returned
from ..compilation.record import Record, static
from ..display import kind_of
from ..errors import ModelError, first_line
from ..numerical_limits import INTEGRATOR_POLE
from .controlled_form import Feedback
from .drive import Table

# Default labels of python-control.
UNNAMED = ("u[", "y[")


class Sampled(Record):
    """A controller that acts at equal intervals from the start of a simulation; its output is constant in between.

    Attributes:
        step: ``u, z_next = step(t, z, y)``: inputs of the mechanism, (n_u,) [N, N m], from its outputs at the sample,
            (n_y,), in the order of their names in the builder.
        period: Interval [s].
        start: States at the start, (n_z,).
        windup, reads, drives: As for :class:`Feedback`.
    """

    step: Callable[..., Any]
    period: float = static()
    start: Any = ()
    windup: Any = None
    reads: tuple[str, ...] | None = static(default=None)
    drives: tuple[str, ...] | None = static(default=None)


def at_time(matrix: Any, t: Float[Array, ""]) -> Any:
    """A matrix, or the value of a table at a time."""
    return matrix(t) if isinstance(matrix, Table) else matrix


def linear_controller(
    matrices: Sequence[Any], period: float | None, windup: Any, reads: Any = None, drives: Any = None
) -> Feedback | Sampled:
    """Controller z' = A z + B y, u = C z + D y; with a period [s], z' is the state at the next sample.

    Each of the four matrices may be a :class:`Table` over time.
    """
    a, b, c, d = matrices
    # Empty names, not None, show that the controller is a linear system.
    names: Any = {"windup": windup, "reads": reads or (), "drives": drives}
    count = np.shape(a.values if isinstance(a, Table) else a)[-1]

    def output(t: Float[Array, ""], z: Any, y: Float[Array, "n_y"]):
        return at_time(c, t) @ z + at_time(d, t) @ y

    def rate(t: Float[Array, ""], z: Any, y: Float[Array, "n_y"]):
        return at_time(a, t) @ z + at_time(b, t) @ y

    start = jnp.zeros(count)
    if period:
        return Sampled(lambda t, z, y: (output(t, z, y), rate(t, z, y)), float(period), start, **names)
    return Feedback(output, rate, start, **names)


def check_finite(what: str, matrices: Sequence[Any]) -> None:
    """Raise ModelError for known matrices A, B, C, D that are not finite; `what` names the system."""
    known_matrices = {name: matrix for name, matrix in zip("ABCD", matrices, strict=True) if is_concrete(matrix)}
    if wrong := [name for name, matrix in known_matrices.items() if not np.all(np.isfinite(matrix))]:
        raise ModelError(f"Numbers of the {what} are not finite. They are in its {', '.join(wrong)}.")


def matrices_of(system: Any) -> tuple[tuple[Any, Any, Any, Any], float | None, Any, Any]:
    """A to D of a linear system, its interval, and the names of its inputs and outputs; None where it has none.

    Raises:
        ModelError: The system is not linear, not proper or not finite, or it is sampled without an interval.
    """
    if hasattr(system, "num") and hasattr(system, "den"):
        system = _realised(system)
    if not all(hasattr(system, name) for name in "ABCD"):
        raise ModelError(
            f"A {type(system).__name__} is no linear system. Give a control.StateSpace or a control.TransferFunction."
        )
    period = getattr(system, "dt", 0)
    if period is True:
        raise ModelError("The controller is sampled, but has no interval. Give it dt in seconds.")
    parts = [getattr(system, name) for name in "ABCD"]
    check_real("The controller", parts, ModelError)
    check_finite("controller", parts)
    a, b, c, d = (jnp.asarray(part, float) if not is_concrete(part) else np.asarray(part, float) for part in parts)
    reads, drives = (_named(getattr(system, labels, None)) for labels in ("input_labels", "output_labels"))
    return (a, b, c, d), float(period) if period else None, reads, drives


def _named(labels: Any) -> tuple[str, ...] | None:
    return None if not labels or any(name.startswith(UNNAMED) for name in labels) else tuple(labels)


def _realised(system: Any) -> Any:
    """A transfer function as a state space."""
    import control

    try:
        return control.ss(system)
    except Exception as fault:
        first = first_line(fault)
        raise ModelError(
            f"The controller's transfer function has no state space: {first}. It must be proper: no numerator of higher"
            " degree than its denominator. Give a differentiating action a filter."
        ) from fault


def windup_of(a: Any, c: Any, sampled: bool) -> Any:
    """Rate of a controller's integrators per excess of its outputs, (n_z, n_u); None without integrators.

    With the eigenvectors V of the eigenvalues that do not decay it is V (C V)^+. The outputs of these states then
    follow the limits (THEORY.md 14, eq. (14.41)). NaN for integrators in a chain, more than the outputs distinguish, or
    a traced A.
    """
    if not np.shape(a)[0]:
        return None
    unknown = np.full((np.shape(a)[0], np.shape(c)[0]), np.nan)
    if not is_concrete(a):
        return unknown
    a = np.asarray(a)
    values, vectors = np.linalg.eig(a)
    size = max(1.0, float(np.max(np.abs(values))))
    lasting = np.abs(values) >= 1 - INTEGRATOR_POLE if sampled else np.real(values) >= -INTEGRATOR_POLE * size
    if not np.any(lasting):
        return None
    v = vectors[:, lasting]
    if np.linalg.matrix_rank(v) < v.shape[1]:
        return unknown
    if not is_concrete(c):
        # Real vectors with the same span.
        real_and_imaginary: Any = np.concatenate([np.real(v), np.imag(v)], axis=1)
        basis = np.linalg.svd(real_and_imaginary)[0][:, : v.shape[1]]
        return basis @ jnp.linalg.pinv(c @ basis)
    seen = np.asarray(c) @ v
    if np.linalg.matrix_rank(seen) < v.shape[1]:
        return unknown
    return np.real(v @ np.linalg.pinv(seen))


def controller_of(control: Any) -> Feedback | Sampled:
    """Controller from a python-control system, a function ``u = f(t, y)``, Feedback or Sampled."""
    if isinstance(control, Feedback | Sampled):
        return control
    if (hasattr(control, "A") and hasattr(control, "D")) or (hasattr(control, "num") and hasattr(control, "den")):
        matrices, period, reads, drives = matrices_of(control)
        return linear_controller(matrices, period, windup_of(matrices[0], matrices[2], bool(period)), reads, drives)
    if callable(control) and not hasattr(control, "input_labels"):
        return Feedback(lambda t, z, y: control(t, y))
    raise ModelError(
        "Argument `control` must be a control.StateSpace or TransferFunction, a function u = f(t, y), a Feedback or"
        f" Sampled, but is {kind_of(control)}."
    )


def signal_places(names: tuple[str, ...] | None, there: Sequence[str], what: str) -> list[int] | None:
    """Places of a controller's signals among the mechanism's, by name; None if no name is the mechanism's."""
    # Names in python-control have no dots.
    known = {name.replace(".", " "): i for i, name in enumerate(there)}
    places = [known.get(name.replace(".", " ")) for name in names or ()]
    if all(place is None for place in places):
        return None
    if None in places:
        wrong = (names or ())[places.index(None)]
        raise ModelError(
            f"The controller is connected by name, but '{wrong}' is no {what} of the mechanism. It has:"
            f" {', '.join(there)}."
        )
    return [place for place in places if place is not None]


def check_sizes(system: Any, inputs: Sequence[str], outputs: Sequence[str]) -> None:
    """Raise ModelError for a linear system that is not connected by name and has other sizes than the mechanism."""
    matrices, _, reads, drives = matrices_of(system)
    shape = np.shape(matrices[3])
    by_name = signal_places(reads, outputs, "output"), signal_places(drives, inputs, "input")
    sizes = zip(by_name, shape[::-1], (outputs, inputs), strict=True)
    if any(places is None and size != len(names) for places, size, names in sizes):
        few = shape[1] <= len(outputs) and shape[0] <= len(inputs)
        reads, drives = (
            [name.replace(".", " ") for name in names] for names in (outputs[: shape[1]], inputs[: shape[0]])
        )
        such_as = f", such as control.ss(controller, inputs={reads}, outputs={drives})" if few else ""
        raise ModelError(
            f"The controller has {shape[1]} inputs and {shape[0]} outputs, but the mechanism has {len(outputs)}"
            f" outputs ({', '.join(outputs)}) and {len(inputs)} inputs ({', '.join(inputs)}). Connect it by these"
            f" names{such_as}; or give it as many."
        )


def connected(controller: Feedback | Sampled, inputs: Sequence[str], outputs: Sequence[str], seen: Callable):
    """A controller of the same kind between all outputs and inputs of a mechanism.

    Its signals are matched by name if it has the mechanism's names, else by order. `seen` maps time, all outputs, and
    the places of those that the controller reads by name (or None), to what the controller reads.
    """
    reads = signal_places(controller.reads, outputs, "output")
    places = None if reads is None else np.array(reads)
    drives = signal_places(controller.drives, inputs, "input")

    def signals_read(t: Float[Array, ""], y: Float[Array, "n_y"]):
        return seen(t, y, places)

    def everywhere(output: Any):
        u = returned("The controller", output)
        if drives is None or u.shape != (len(drives),):
            return u
        return jnp.zeros(len(inputs)).at[np.array(drives)].set(u)

    if isinstance(controller, Sampled):
        step = controller.step

        def sampled(t: Float[Array, ""], z: Any, y: Float[Array, "n_y"]):
            result = step(t, z, signals_read(t, y))
            return (everywhere(result[0]), *result[1:]) if isinstance(result, tuple) and result else result

        return dataclasses.replace(controller, step=sampled)
    output, rate = controller.output, controller.rate
    follows = (
        None if rate is None else lambda t, z, y: returned("The controller's rate", rate(t, z, signals_read(t, y)))
    )
    return dataclasses.replace(
        controller, output=lambda t, z, y: everywhere(output(t, z, signals_read(t, y))), rate=follows
    )
