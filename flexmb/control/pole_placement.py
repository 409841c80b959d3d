"""Controllers for a mechanism that moves like one mass: PID by pole placement, and notch filters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import check_number
from ..errors import ModelError, heard, warn
from ..linear.linearize import Linearization
from ..model.model import Model, as_model
from ..numerical_limits import POSITION_OUTPUT
from .state_space import to_statespace

if TYPE_CHECKING:
    import control


def one_mass(plant: Any) -> tuple[float, float, float]:
    """Mass, damping and stiffness between input and position output of a state space of two states.

    y = 1/(m s^2 + d s + k) u has the determinant k/m and the trace -d/m of A, and 1/m = C A B, where C B = 0; D is left
    out. ModelError for more states or signals, or an output that is no position or does not move.
    """
    if plant.nstates != 2 or plant.ninputs != 1 or plant.noutputs != 1:
        raise ModelError(
            f"The plant has {plant.nstates} states, {plant.ninputs} inputs and {plant.noutputs} outputs, but poles are"
            " placed for one motion, one input and one output. Give fm.to_statespace(model, modes=1), and name `input`"
            " and `output` if there are several."
        )
    a, b, c = (np.asarray(part) for part in (plant.A, plant.B, plant.C))
    # y = (rate s + inverse)/(s^2 + ..) u: damping of the omitted modes adds a small rate.
    rate = (c @ b).item()
    inverse = (c @ a @ b).item() - float(np.trace(a)) * rate
    fast = max(np.sqrt(abs(float(np.linalg.det(a)))), abs(float(np.trace(a))))
    if abs(rate) * fast > POSITION_OUTPUT * abs(inverse) or (rate and not inverse):
        raise ModelError(f"Output '{plant.output_labels[0]}' is no position. Name an `output` that is a position.")
    if inverse == 0:
        raise ModelError(f"Input '{plant.input_labels[0]}' does not move output '{plant.output_labels[0]}'.")
    mass = 1 / inverse
    return mass, -mass * float(np.trace(a)), mass * float(np.linalg.det(a))


def _moved(plant: Any) -> Any:
    """The states of a plant that its input reaches; others belong to other inputs."""
    import control

    a, reached = np.asarray(plant.A) != 0, np.any(np.asarray(plant.B), axis=1)
    for _ in range(len(a)):
        reached = reached | np.any(a[:, reached], axis=1)
    if not np.any(reached) or np.all(reached):
        return plant
    selection = np.ix_(reached, reached)
    names: Any = {"inputs": plant.input_labels, "outputs": plant.output_labels}
    return control.StateSpace(plant.A[selection], plant.B[reached], plant.C[:, reached], plant.D, **names)


def pid(
    model: Model | Linearization | control.StateSpace,
    bandwidth: float,
    *,
    damping: float = 0.7,
    slow: float = 0.5,
    fast: float = 4.0,
    input: str | None = None,
    output: str | None = None,
) -> control.StateSpace:
    """Return a PID controller with filter that places all poles of its loop with one moving mass.

    The plant is one motion, m q'' + d q' + k q = u: a rigid body or the lowest mode of the mechanism. With C(s) = (kd
    s^2 + kp s + ki)/(s (T s + 1)) the loop has four poles. The four numbers of the controller place them at (s^2 + 2
    zeta w s + w^2)(s + slow w)(s + fast w), with w = 2 pi bandwidth. Check the whole model by :func:`closed_loop`.

    Args:
        model: Mechanism or its linearisation, whose lowest mode is used; or a state space of one motion.
        bandwidth: Undamped frequency of the pair of poles [Hz].
        damping: Damping ratio zeta of this pair [-].
        slow: Real pole of the integrator divided by w [-]; 0 for a PD controller, without integrator.
        fast: Real pole of the filter divided by w [-]. A larger value loses less phase at the crossover and passes more
            noise.
        input, output: Names of the model's signals, if it has several.

    Returns:
        ``control.StateSpace`` that reads reference - y, with the names of the model. Its states are the integrator
        (none if ``slow`` is 0) and the filter.

    Raises:
        ModelError: An input or output is unknown, the output is no position, or the plant has more than one motion.
        ValueError: Numbers are out of range, or the plant is damped more than the wanted poles.

    Warns:
        FlexmbWarning: At the bandwidth the output follows the modes that are left out more than the lowest mode.

    Source:
        THEORY.md 14, eq. (14.43), by comparing coefficients.
    """
    import control

    check_number("bandwidth", bandwidth, above=0)
    check_number("damping", damping, above=0)
    check_number("slow", slow, least=0)
    check_number("fast", fast, above=0)
    plant: Any = model
    quantities = None
    if not isinstance(model, control.StateSpace):
        model = model if isinstance(model, Linearization) else as_model(model, "control.pid")
        quantities = [[part.quantity for part in signal.terms] for signal in model.labels.outputs]
        with heard():
            plant = to_statespace(model, modes=1)
    to, y_index = (
        _chosen(name, list(names), kind)
        for name, names, kind in ((input, plant.input_labels, "input"), (output, plant.output_labels, "output"))
    )
    names: Any = {"inputs": [plant.output_labels[y_index]], "outputs": [plant.input_labels[to]]}
    for quantity in quantities[y_index] if quantities else ():
        if quantity not in ("position", "deformation"):
            raise ModelError(
                f"Output '{plant.output_labels[y_index]}' measures a quantity '{quantity}'. Name an `output` that is a"
                " position, a deformation, or a sensor of only positions and deformations."
            )
    m, d, k = one_mass(_moved(plant[y_index, to]))
    w = 2 * np.pi * bandwidth
    # Not the dynamic stiffness, which vanishes at the frequency of the lowest mode.
    if abs(plant.D[y_index, to]) * max(abs(k), abs(m) * w**2) > 1:
        warn(
            f"At {bandwidth:g} Hz the modes that this controller neglects move '{plant.output_labels[y_index]}' more"
            f" than the lowest mode. Between input and output, the lowest mode is a mass of {m:.4g} (SI units). Name an"
            " input and an output that move with the lowest mode."
        )
    a3, a2, a1, a0 = np.real(np.polymul([1, 2 * damping * w, w**2], np.polymul([1, slow * w], [1, fast * w])))[1:]
    if a3 * m - d == 0 or (m - d / a3) / m <= 0:
        raise ValueError(
            f"The plant alone has more damping ({d / m:.4g} 1/s) than all wanted poles together ({a3:.4g} 1/s). Give a"
            " higher `bandwidth` or a larger `fast`."
        )
    filtered = m / (a3 * m - d)
    kd, kp, ki = m * filtered * a2 - d - k * filtered, m * filtered * a1 - k, m * filtered * a0
    # Partial fractions of the controller: ki/s, a gain, and the filter's.
    gain, lag = kd / filtered, (kp - ki * filtered - kd / filtered) / filtered
    controller = control.StateSpace(np.diag([0.0, -1 / filtered]), [[1.0], [1.0]], [[ki, lag]], [[gain]], **names)
    return controller if slow > 0 else control.StateSpace([[-1 / filtered]], [[1.0]], [[lag]], [[gain]], **names)


def _chosen(name: str | None, names: list[str], kind: str) -> int:
    """Place of an input or output by its name."""
    if name is None:
        if len(names) > 1:
            raise ModelError(f"The model has several {kind}s. Name one as `{kind}`, of {', '.join(names)}.")
        return 0
    label = str(name).replace(".", " ")
    if label not in names:
        raise ModelError(f"Argument `{kind}` names '{name}', which is no {kind} of the model: {', '.join(names)}.")
    return names.index(label)


def notch(frequency: float, depth: float = 0.1, width: float = 1.0) -> control.TransferFunction:
    """Return a filter that lowers the gain at one frequency, where a resonance would make a loop unstable.

    N(s) = (s^2 + depth width w s + w^2)/(s^2 + width w s + w^2): its gain is ``depth`` at w = 2 pi frequency and 1 far
    from w. A depth above 1 gives a peak. A product in python-control loses the names, so give them again:
    ``control.ss(pid * fm.control.notch(120.0), inputs=pid.input_labels, outputs=pid.output_labels)``.

    Args:
        frequency: Centre of the notch [Hz].
        depth: Gain at the centre [-].
        width: Distance between the frequencies of half power (of a deep notch), divided by the centre [-].

    Returns:
        ``control.TransferFunction``.

    Raises:
        ValueError: A number is not positive.

    Source:
        THEORY.md 14, eq. (14.44).
    """
    import control

    for name, value in (("frequency", frequency), ("depth", depth), ("width", width)):
        check_number(name, value, above=0)
    w = 2 * np.pi * frequency
    return control.TransferFunction([1, depth * width * w, w**2], [1, width * w, w**2])
