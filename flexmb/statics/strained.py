"""Warnings of elements that are stressed more than the position of the mechanism needs."""

import numpy as np
from jaxtyping import Bool, Float

from ..arguments import is_concrete
from ..checks.mobility import constraints, motions_of
from ..display import listed, short
from ..errors import warn
from ..math.sparse import LARGE
from ..mechanics.extent import sizes_of
from ..mechanics.stress_resultants import is_nonlinear, known_stiffness_pieces
from ..model.model import Model
from ..numerical_limits import NEEDLESS_ENERGY, STRAIN_ROUND_OFF

# Number of deformations that are named, beginning with the largest change.
NAMED = 3


def needless_strain(
    model: Model, e: Float[np.ndarray, "n_e"], kept: Bool[np.ndarray, "n_q"]
) -> tuple[float, float, list[str]] | None:
    """Elastic energy, its minimum with some degrees of freedom kept, and names of the deformations that would relax.

    None for large mechanisms, nonlinear laws, and elements with stress-free deformations. By least squares in the
    motions of the undeformed mechanism (THEORY.md 4 and 8), exact only for small deformations.
    """
    topology, parameters = model.topology, model.parameters
    shaped = parameters.strain is not None or parameters.loads.temperature is not None
    if topology.n_x > LARGE or is_nonlinear(topology) or shaped or not np.any(e):
        return None
    roots = np.zeros((topology.n_e, topology.n_e))
    for at, _, own in known_stiffness_pieces(topology, parameters):
        values, turned = np.linalg.eigh(np.asarray(own))
        blocks = np.sqrt(np.maximum(values, 0.0))[:, :, None] * np.swapaxes(turned, 1, 2)
        place = np.asarray(at)
        roots[place[:, :, None], place[:, None, :]] += blocks
    energy = 0.5 * float(np.sum((roots @ e) ** 2))
    if not energy > 0:
        return None
    held = constraints(model)
    motions, _ = motions_of(model, held)
    changes = held.jacobian @ motions
    x_dof, e_dof = np.asarray(topology.x.dof), np.asarray(topology.e.dof)
    rows = np.concatenate([motions[x_dof], changes[e_dof]])[kept]
    _, sizes, right = np.linalg.svd(rows, full_matrices=True)
    free = changes @ right[int(np.sum(sizes > 1e-9)) :].T / held.rows[:, None]
    weighted = roots @ free
    scale = np.linalg.norm(weighted, axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    relaxing = np.linalg.lstsq(weighted / scale, -(roots @ e), rcond=1e-13)[0] / scale
    relaxed = e + free @ relaxing
    least = 0.5 * float(np.sum((roots @ relaxed) ** 2))
    moved = np.abs(relaxed - e)[e_dof] * np.sqrt(np.sum(roots[:, e_dof] ** 2, axis=0))
    order = [i for i in np.argsort(-moved) if not kept[len(x_dof) + i]]
    return energy, least, [str(model.labels.e[e_dof[i]]) for i in order[:NAMED]]


def warn_of_needless_strain(model: Model, e: Float[np.ndarray, "n_e"], where: str, remedy: str) -> None:
    """Warn if zero degrees of freedom keep elements from their least strained shape; ``where`` begins the sentence."""
    # Round-off of large turns is no strain.
    extent = np.max(np.asarray(sizes_of(model.topology, model.parameters)), initial=0.0)
    e = np.where(np.abs(e) > STRAIN_ROUND_OFF * max(extent, 1.0), e, 0.0)
    dof = np.asarray(model.topology.e.dof)
    kept = np.concatenate([np.ones(len(model.topology.x.dof), bool), e[dof] != 0])
    needless = None if np.all(kept) else needless_strain(model, e, kept)
    if needless is not None and needless[0] > NEEDLESS_ENERGY * needless[1]:
        energy, least, names = needless
        warn(
            f"{where} elements store {short(energy)} J, but {short(least)} J would suffice: degrees of freedom that are"
            f" zero there, such as {listed(names)}, make others stretch. {remedy}"
        )


def warn_of_stressed_start(model: Model, remedy: str) -> None:
    """Warn if elements with another stress-free shape are stressed where the nodes were placed."""
    strain = model.parameters.strain
    if strain is not None and is_concrete(strain) and np.any(np.asarray(strain)):
        warn(
            "The motion starts where the nodes were placed. There, elements are stressed that are free of stress in"
            f" another shape (strain, imperfection). {remedy}"
        )
