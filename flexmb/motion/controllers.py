"""Controllers in one form: systems of python-control, functions, and how they connect to a mechanism by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_real, is_concrete, returned
from ..compilation.record import Record, static
from ..errors import ModelError, first_line
from .controlled_form import Feedback
from .drive import Table

# An eigenvalue is that of an integrator where it is as near to zero, of a sampled one to one, as round-off leaves it.
INTEGRATES = 1e-8
# Labels that python-control gives where a user gives none.
UNNAMED = ("u[", "y[")


class Sampled(Record):
    """A controller that acts at equal intervals from the start of the simulation; its output is held in between.

    Attributes:
        step: ``u, z_next = step(t, z, y)``: inputs of the mechanism, (n_u,) [N, N m], from its outputs at the
            sample, in the order in which the builder named them.
        period: Interval [s].
        start: State at the start, (n_z,).
        windup: As for :class:`Feedback`.
        reads, drives: As for :class:`Feedback`.
    """

    step: Callable[..., Any]
    period: float = static()
    start: Any = ()
    windup: Any = None
    reads: tuple[str, ...] | None = static(default=None)
    drives: tuple[str, ...] | None = static(default=None)


def at_time(of: Any, t: Float[Array, ""]) -> Any:
    """A matrix, or that of a table at a time."""
    return of(t) if isinstance(of, Table) else of


def linear_controller(
    matrices: Sequence[Any], period: float | None, windup: Any, reads: Any = None, drives: Any = None
) -> Feedback | Sampled:
    """Controller z' = A z + B y, u = C z + D y, or sampled with z' the state at the next sample.

    Args:
        matrices: A, B, C, D; each may be a :class:`Table` over time.
        period: Interval of samples [s]; None for a continuous one.
        windup: As :attr:`Feedback.windup`.
        reads, drives: As those of Feedback.
    """
    a, b, c, d = matrices
    names: Any = {"windup": windup, "reads": reads, "drives": drives}
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
    """Refuse matrices A, B, C, D with numbers that are not finite, as far as they are known.

    Args:
        what: What they are of, for the message.

    Raises:
        ModelError: See above, with their names.
    """
    known = {name: own for name, own in zip("ABCD", matrices, strict=True) if is_concrete(own)}
    if wrong := [name for name, own in known.items() if not np.all(np.isfinite(own))]:
        raise ModelError(f"Numbers of the {what} are not finite, in its {', '.join(wrong)}.")


def matrices_of(system: Any) -> tuple[tuple[Any, Any, Any, Any], float | None, Any, Any]:
    """A to D of a linear system, its interval, and the names of its inputs and outputs, None where it has none.

    Args:
        system: ``control.StateSpace`` or ``control.TransferFunction``, or what has A, B, C, D, which may be traced.

    Raises:
        ModelError: It is sampled without an interval, it is not proper, its numbers are not finite, or it is none.
    """
    if hasattr(system, "num") and hasattr(system, "den"):
        system = _realised(system)
    if not all(hasattr(system, name) for name in "ABCD"):
        raise ModelError(
            f"A {type(system).__name__} is no linear system: give a control.StateSpace or a control.TransferFunction."
        )
    period = getattr(system, "dt", 0)
    if period is True:
        raise ModelError("The controller is sampled, but says not how often: give it dt in seconds.")
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
            f"The controller's transfer function has no state space: {first}. A proper one has, whose numerators are of"
            " no higher degree than their denominators; give a differentiating action a filter."
        ) from fault


def windup_of(a: Any, c: Any, sampled: bool) -> Any:
    """What an excess of the outputs does to the integrators of a controller, so that they follow; None without any.

    With the eigenvectors V of the eigenvalues that do not decay it is V (C V)^+, under which the outputs that these
    states make follow the limits (THEORY.md 14, eq. (14.41)).

    Args:
        a: (n_z, n_z).
        c: (n_u, n_z).
        sampled: Whether it is sampled.

    Returns:
        (n_z, n_u); not finite where integrators stand in a chain, are more than the outputs tell apart, or are not
        known, of a traced A.
    """
    if not np.shape(a)[0]:
        return None
    if not is_concrete(a):
        return np.full((np.shape(a)[0], np.shape(c)[0]), np.nan)
    a = np.asarray(a)
    values, vectors = np.linalg.eig(a)
    size = max(1.0, float(np.max(np.abs(values))))
    lasting = np.abs(values) >= 1 - INTEGRATES if sampled else np.real(values) >= -INTEGRATES * size
    if not np.any(lasting):
        return None
    v = vectors[:, lasting]
    unknown = np.full((a.shape[0], np.shape(c)[0]), np.nan)
    if np.linalg.matrix_rank(v) < v.shape[1]:
        return unknown
    if not is_concrete(c):
        # In real numbers, which span the same.
        both: Any = np.concatenate([np.real(v), np.imag(v)], axis=1)
        basis = np.linalg.svd(both)[0][:, : v.shape[1]]
        return basis @ jnp.linalg.pinv(c @ basis)
    seen = np.asarray(c) @ v
    if np.linalg.matrix_rank(seen) < v.shape[1]:
        return unknown
    return np.real(v @ np.linalg.pinv(seen))


def controller_of(control: Any) -> Feedback | Sampled:
    """A controller given as python-control system, as function ``u = f(t, y)``, as Feedback or Sampled.

    Raises:
        ModelError: It is none of these; see :func:`matrices_of`.
    """
    if isinstance(control, Feedback | Sampled):
        return control
    if (hasattr(control, "A") and hasattr(control, "D")) or (hasattr(control, "num") and hasattr(control, "den")):
        matrices, period, reads, drives = matrices_of(control)
        return linear_controller(matrices, period, windup_of(matrices[0], matrices[2], bool(period)), reads, drives)
    if callable(control) and not hasattr(control, "input_labels"):
        return Feedback(lambda t, z, y: control(t, y))
    raise ModelError(
        "Argument `control` must be a control.StateSpace or TransferFunction, a function u = f(t, y), a Feedback or"
        f" Sampled, not a {type(control).__name__}."
    )


def placed(names: tuple[str, ...] | None, there: Sequence[str], what: str) -> list[int] | None:
    """Where a controller's signals are among those of the mechanism, by name; None where the order says it.

    Args:
        names: The controller's, or None.
        there: The mechanism's.
        what: "input" or "output", for the message.

    Raises:
        ModelError: Some of the names are the mechanism's and some are not.
    """
    # python-control takes no dot in a name.
    known = {name.replace(".", " "): i for i, name in enumerate(there)}
    own = [known.get(name.replace(".", " ")) for name in names or ()]
    if all(place is None for place in own):
        return None
    if None in own:
        wrong = (names or ())[own.index(None)]
        raise ModelError(
            f"The controller is connected by name, but '{wrong}' is no {what} of the mechanism: {', '.join(there)}."
        )
    return [place for place in own if place is not None]


def check_sizes(system: Any, inputs: Sequence[str], outputs: Sequence[str]) -> None:
    """Refuse a linear system of other sizes than the mechanism's, unless it is connected by name.

    Args:
        system: With D, or a transfer function.
        inputs, outputs: Names of the mechanism's.

    Raises:
        ModelError: See above.
    """
    matrices, _, reads, drives = matrices_of(system)
    shape = np.shape(matrices[3])
    found = placed(reads, outputs, "output"), placed(drives, inputs, "input")
    wrong = [
        own is None and size != len(all_of)
        for own, size, all_of in zip(found, shape[::-1], (outputs, inputs), strict=True)
    ]
    if any(wrong):
        raise ModelError(
            f"The controller has {shape[1]} inputs and {shape[0]} outputs, but the mechanism has {len(outputs)}"
            f" outputs ({', '.join(outputs)}) and {len(inputs)} inputs ({', '.join(inputs)}). Connect it by these"
            " names, or give it as many."
        )


def connected(controller: Feedback | Sampled, inputs: Sequence[str], outputs: Sequence[str], seen: Callable):
    """A controller from all outputs of a mechanism to all its inputs, in their order.

    Args:
        controller: Its signals are found by name where it has the mechanism's names, else they go by their order.
        inputs, outputs: Names of the mechanism's.
        seen: What the controller is given: function of time and outputs.

    Returns:
        The same kind of controller.
    """
    reads = placed(controller.reads, outputs, "output")
    drives = placed(controller.drives, inputs, "input")

    def given(t: Float[Array, ""], y: Float[Array, "n_y"]):
        y = seen(t, y)
        return y if reads is None else y[np.array(reads)]

    def everywhere(found: Any):
        u = returned("The controller", found)
        if drives is None or u.shape != (len(drives),):
            return u
        return jnp.zeros(len(inputs)).at[np.array(drives)].set(u)

    if isinstance(controller, Sampled):
        step = controller.step

        def sampled(t: Float[Array, ""], z: Any, y: Float[Array, "n_y"]):
            found = step(t, z, given(t, y))
            return (everywhere(found[0]), *found[1:]) if isinstance(found, tuple) and found else found

        return dataclasses.replace(controller, step=sampled)
    output, rate = controller.output, controller.rate
    follows = None if rate is None else lambda t, z, y: returned("The controller's rate", rate(t, z, given(t, y)))
    return dataclasses.replace(controller, output=lambda t, z, y: everywhere(output(t, z, given(t, y))), rate=follows)
