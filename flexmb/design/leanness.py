"""Check whether a model is too lean for a question."""

from collections.abc import Sequence

import jax
import numpy as np

from ..build.restrict import can_be_tied, with_released
from ..compilation.threads import one_thread
from ..display import among
from ..elements import planar, spatial
from ..errors import ModelError
from ..linear.linearize import linearize
from ..mechanics.blocks import companion_of
from ..model.model import Model
from ..numerical_limits import NEAR_BAND
from .deviation import deviation, response
from .lean import check_question

# First root of cosh(z) cos(z) = 1, for a beam with both ends held.
CLAMPED = 4.730040744862704


@one_thread()
def too_lean(model: Model, *, bandwidth: float, tolerance: float = 0.01, nodes: Sequence[str] = ()) -> tuple[str, ...]:
    """Return the reasons why a model is too lean for a question; empty if there are none.

    flexmb checks two reasons: FIXED deformations with a known stiffness, which it releases all at once, and SPACAR
    beams that vibrate between their ends.

    Args:
        model: Mechanism.
        bandwidth: Highest frequency of the question [Hz].
        tolerance: Relative error to allow.
        nodes: Nodes whose compliance matters, beside inputs and outputs.

    Returns:
        Reasons, each with a remedy.

    Raises:
        ModelError: ``model`` is no Model, bandwidth or tolerance is not positive and finite, or a node does not exist.
        AnalysisError: The equilibrium of the model, or of the model with released deformations, fails or is unstable.

    Source:
        Vibrations with both ends clamped, beside static shapes: Craig, Bampton (1968), AIAA Journal 6, 1313. The
        distance to the band is our choice.
    """
    if not isinstance(model, Model):
        raise ModelError(f"Argument `model` must be a Model, not {type(model).__name__}.")
    check_question(model, bandwidth, tolerance, nodes)
    lin = linearize(model)
    reasons = []
    stiffness = np.diag(np.asarray(lin.matrices.S))
    fixed = [i for i in np.asarray(model.topology.e.fixed).tolist() if stiffness[i] > 0 and can_be_tied(model)[i]]
    if fixed:
        fuller = linearize(with_released(model, fixed))
        worst = deviation(response(fuller, nodes), response(lin, nodes), bandwidth)
        names = among(str(model.labels.e[i]) for i in fixed)
        if worst.worst > tolerance:
            says = "adds a vibration to the band" if np.isinf(worst.worst) else f"changes it by {worst.worst:.2g}"
            reasons.append(f"{names} are FIXED; a release {says}: release them (RLSE, `released=`).")
    reasons += [
        f"Beam '{name}' vibrates between its ends at {hertz:.4g} Hz, near the band: divide it into two or more, or use"
        " a spectral beam."
        for name, hertz in _own_vibrations(model)
        if hertz < NEAR_BAND * bandwidth
    ]
    return tuple(reasons)


def _own_vibrations(model: Model) -> list[tuple[str, float]]:
    """First natural frequency of each SPACAR beam with both ends held, by name [Hz]."""
    frequencies = []
    for block, properties in zip(model.topology.blocks, model.parameters.properties, strict=True):
        if block.element.usual not in (planar.beam, spatial.beam) or "stiffness" not in block.companions:
            continue
        section = jax.vmap(lambda s: s.rigidity())(companion_of(block, properties, "stiffness")[1]["section"])
        nodes = np.asarray(model.parameters.reference)[np.asarray(block.x)]
        size = model.labels.dimension
        # Nodes of a beam: position and rotation of one end, then of the other.
        second = block.splits[1]
        length = np.linalg.norm(nodes[:, second : second + size] - nodes[:, :size], axis=1)
        bending = np.array([section.EIy] if size == 2 else [section.EIy, section.EIz])
        softest = np.min(np.where(bending > 0, bending, np.inf), axis=0)
        mass = np.broadcast_to(np.asarray(section.mass), length.shape)
        with np.errstate(divide="ignore"):
            hertz = (CLAMPED / length) ** 2 * np.sqrt(softest / mass) / (2 * np.pi)
        names = [model.labels.e[row[0]].of for row in np.asarray(block.e)]
        frequencies += [(n, float(f)) for n, f in zip(names, hertz, strict=True) if np.isfinite(f)]
    return frequencies
