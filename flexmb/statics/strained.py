"""Whether a mechanism is put where its elements are stressed though they need not be; on the host."""

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

# Elastic energy so many times as large as need be is pointed out: shapes that elements take by and by are within it.
NEEDLESS = 30.0
# Deformations below this share of the extent, or of a radian, are round-off.
ROUND_OFF = 1e-12
# Deformations that begin at zero and would relax most are named, so many of them.
NAMED = 3


def needless_strain(
    model: Model, e: Float[np.ndarray, "n_e"], kept: Bool[np.ndarray, "n_q"]
) -> tuple[float, float, list[str]] | None:
    """Elastic energy of deformations, the least there is with some of them kept, and which would relax most.

    Args:
        model: Mechanism.
        e: Deformations, (n_e,) [m, rad].
        kept: Which degrees of freedom stay as they are, coordinates first, (n_q,) bool.

    Returns:
        Both energies [J], and names; None where it is not asked: of large mechanisms, of laws that are not linear, and
        where elements are free of stress at others than zero.

    Source:
        Least squares in the motions of the undeformed mechanism (THEORY.md 4 and 8), so that of small deformations
        alone the numbers are right.
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
    found = constraints(model)
    motions, _ = motions_of(model, found)
    changes = found.jacobian @ motions
    x_dof, e_dof = np.asarray(topology.x.dof), np.asarray(topology.e.dof)
    rows = np.concatenate([motions[x_dof], changes[e_dof]])[kept]
    _, sizes, right = np.linalg.svd(rows, full_matrices=True)
    free = changes @ right[int(np.sum(sizes > 1e-9)) :].T / found.rows[:, None]
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
    """Warn where degrees of freedom that are zero keep elements from taking the shape that strains them least.

    Args:
        model: Mechanism.
        e: Deformations, (n_e,) [m, rad].
        where: When it has them, as the begin of a sentence.
        remedy: What to do.
    """
    # What round-off makes of turning far is no strain.
    extent = np.max(np.asarray(sizes_of(model.topology, model.parameters)), initial=0.0)
    e = np.where(np.abs(e) > ROUND_OFF * max(extent, 1.0), e, 0.0)
    dof = np.asarray(model.topology.e.dof)
    kept = np.concatenate([np.ones(len(model.topology.x.dof), bool), e[dof] != 0])
    found = None if np.all(kept) else needless_strain(model, e, kept)
    if found is not None and found[0] > NEEDLESS * found[1]:
        energy, least, names = found
        warn(
            f"{where} elements hold {short(energy)} J, of which {short(least)} J would do: degrees of freedom that are"
            f" zero there, as {listed(names)}, make others stretch. {remedy}"
        )


def warn_of_stressed_start(model: Model, remedy: str) -> None:
    """Warn where elements that are free of stress in another shape are stressed as the nodes were placed.

    Args:
        model: Mechanism, without start values.
        remedy: What to do.
    """
    strain = model.parameters.strain
    if strain is not None and is_concrete(strain) and np.any(np.asarray(strain)):
        warn(
            "The motion starts where the nodes were placed, where elements are stressed that are free of stress in"
            f" another shape (strain, imperfection). {remedy}"
        )
