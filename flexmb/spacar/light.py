"""The SPACAR Light interface as functions, so that a script can be translated line by line."""

import warnings as python_warnings
from typing import Any

import numpy as np

from ..control.state_space import to_statespace
from ..errors import AnalysisError, ModelError
from ..linear.damping import damped
from ..linear.linearize import Linearization, linearize
from ..model.model import Model
from .light_checks import check_script
from .light_fields import Script, field_value, read_script
from .light_fields import Struct as Struct
from .light_fields import StructArray as StructArray
from .light_model import build_script
from .light_results import LightResults as LightResults

# Stiffness and mass below this many units of round-off indicate wrong units.
TINY_STIFFNESS, TINY_MASS = 15, 150


def spacar_light(
    nodes: Any, elements: Any = None, nprops: Any = None, eprops: Any = None, opt: Any = None
) -> LightResults:
    """Analyse a mechanism that is described like in a SPACAR Light script.

    Names and meanings are the same as in SPACAR Light. Fields of nodes are fix, fix_pos, fix_orien, fix_x .., fix_warp,
    force, moment, displ_x .., rot_x .., rot (loads also with _initial), mass, mominertia, transfer_in and transfer_out.
    Fields of element sets are elems, emod, smod, dens, cshape, dim, orien, nbeams, flex, warping, cw and type. Options
    are gravity, loadsteps, rls, transfer, calcbuck, calccompl, showinputonly and silent. Fields for pictures have no
    effect; a warning names them.

    Initial loads rise first, from zero to their value in ``loadsteps`` steps (10); then the other loads rise. Gravity
    rises with the initial loads; without initial loads gravity acts fully from the start.

    Differences from SPACAR Light:

    - rot_x and rot prescribe the angle itself, past full turns.
    - Buckling multipliers keep their sign.
    - Reaction moments are right at turned nodes.
    - With transfer the mechanism may be loaded; the state space belongs to the last step.
    - Elements with ``warping`` share the warping of a node. Warping is zero where the rotation is fixed, at fix_warp,
      and where a rigid element or a hinge is joined. One beam is exact for a constant torque.
    - The axis of an element of type "hinge" is its orien.
    - ``silent`` leaves out warnings, not checks.

    Args:
        nodes: Positions, one row per node, (n, 3) [m]; or the whole script in a Struct or a dictionary with the fields
            coordinates, connect, nprops, eprops and optionally opt.
        elements: Numbers from 1 of the nodes of each element, (m, 2).
        nprops: Properties of nodes: a StructArray, a dictionary by number, or a list that begins with node 1.
        eprops: Properties of element sets in the same forms.
        opt: Options: a dictionary or a Struct.

    Returns:
        LightResults, with results under the names of SPACAR Light, the Model and its Builder.

    Raises:
        ModelError: A field is unknown or wrong; the message has one line per field, by node, element or set.
        MechanismError: The mechanism is under-constrained, or over-constrained beyond possible releases.
        AnalysisError: A load step has no equilibrium.
    """
    script = read_script(nodes, elements, nprops, eprops, opt)
    check_script(script)
    builder, model, releases = build_script(script)
    factors: list[tuple[float, float]] = []
    linearizations: list[Linearization] = []
    if not script.opt.get("showinputonly"):
        factors = load_steps(script)
        for i, (initial, increment) in enumerate(factors, 1):
            linearizations.append(_linearize(model, i, len(factors), initial, increment))
    light = LightResults(script, builder, model, releases, factors, linearizations)
    if linearizations:
        light.warnings += _suspicions(light)
        if script.opt.get("transfer"):
            light.statespace = to_statespace(_damped(linearizations[-1], *script.opt["transfer"][1:]))
    if not script.opt.get("silent"):
        for text in light.warnings:
            python_warnings.warn(text, stacklevel=2)
    return light


def spacar_light_model(
    nodes: Any, elements: Any = None, nprops: Any = None, eprops: Any = None, opt: Any = None
) -> Model:
    """Return the mechanism of a SPACAR Light script, for derivatives, batches and flexmb's own functions.

    Every number of the script may be traced. Traced node positions need ``opt.rls``, such as the ``overconstraints``
    that :func:`spacar_light` returns for concrete numbers.

    Args:
        nodes: See :func:`spacar_light`.
        elements: See :func:`spacar_light`.
        nprops: See :func:`spacar_light`.
        eprops: See :func:`spacar_light`.
        opt: See :func:`spacar_light`.

    Returns:
        Model. Node 3 is "n3"; the beams of element 2 are "e2.1", "e2.2" and so on.

    Raises:
        ModelError: See :func:`spacar_light`.
        MechanismError: See :func:`spacar_light`.
    """
    script = read_script(nodes, elements, nprops, eprops, opt)
    check_script(script)
    return build_script(script)[1]


def load_steps(script: Script) -> list[tuple[float, float]]:
    """Factors of the initial and of the incremental loads at every step: initial loads rise first, then the others."""
    fields = [name for properties in script.nprops.values() for name in properties]
    moving = [name for name in fields if name.startswith(("force", "moment", "displ", "rot"))]
    initial, increment = (any(("_initial" in name) is is_initial for name in moving) for is_initial in (True, False))
    steps = field_value(script.opt, "opt", "loadsteps")
    rising = np.linspace(0.0, 1.0, steps).tolist() if steps > 1 else [1.0]
    factors = [(s, 0.0) for s in rising] if initial else []
    if increment:
        factors += [(1.0, s) for s in (rising[1:] if initial and steps > 1 else rising)]
    return factors or [(1.0, 0.0)]


def _linearize(model: Model, step: int, steps: int, initial: float, increment: float) -> Linearization:
    try:
        return linearize(model, load_factor=initial, increment=0.0 if model.parameters.increment is None else increment)
    except AnalysisError as fault:
        at = f"At load step {step} of {steps}, initial loads times {initial:.3g} and the others times {increment:.3g}: "
        hint = " fm.path(fm.spacar.spacar_light_model(..)) continues past such a point."
        raise AnalysisError(fault.code, at + str(fault) + hint) from None


def _suspicions(light: LightResults) -> list[str]:
    """Warnings that the numbers suggest."""
    texts = []
    first, eps = light.linearizations[0].matrices, np.finfo(float).eps
    for name, matrix, tiny in (("stiffness", first.K0, TINY_STIFFNESS), ("mass", first.M0, TINY_MASS)):
        largest = np.max(np.abs(np.asarray(matrix)), initial=0.0)
        if light.ndof and largest < tiny * eps:
            texts.append(f"The {name} of every degree of freedom is below {tiny * eps:.0e}: check the units.")
    unstable = [i for i in range(light.freq.shape[1]) if np.any(light.freq[:, i] < 0)]
    if unstable:
        texts.append(f"From load step {unstable[0] + 1} on, a motion has no stiffness left: it may have buckled.")
    return texts


def _damped(lin: Linearization, ratio: float = 0.0) -> Linearization:
    """The same with a damping ratio in every mode and without other damping."""
    if ratio == 0.0:
        return lin
    if not lin.matrices.symmetric:
        raise ModelError("opt.transfer: a damping ratio needs normal modes, which do not exist with moments in space.")
    return damped(lin, ratio=ratio, elements=False)
