"""Whether an equilibrium is stable, and a word where it is not; on the host, of known numbers."""

from typing import Any

import numpy as np
from jaxtyping import Array, Float

from ..checks.mobility import shares
from ..errors import warn
from ..math.element_matrices import Whole
from ..math.sparse import negative_where_held
from ..model.model import Model

# A stiffness is negative below this share of the structural stiffness in the same motion, or, where nothing elastic
# resists, below this share of the largest: nearer to zero a state is critical, or the sign is one of round-off.
SHARE, ROUND_OFF = 1e-6, 1e-10
# Larger differences of K from its transpose, of entries scaled to one, are those of loads without potential.
SYMMETRIC = 1e-9
# So many motions are named, by the largest of their coordinates.
NAMED, LARGEST = 2, 3


def unstable_motions(
    stiffness: Float[Array, "n n"], structural: Float[Array, "n n"], symmetric: bool
) -> Float[np.ndarray, "n k"]:
    """Motions of the degrees of freedom, one a column, in which a stiffness is negative.

    Args:
        stiffness: K = K0 + G0, of known numbers.
        structural: K0.
        symmetric: Whether all loads have a potential. Where some have none, a negative determinant alone tells that
            a state is not stable, and the motions are those of real negative eigenvalues.
    """
    k, k0 = np.asarray(stiffness), np.asarray(structural)
    own = np.sqrt(np.maximum(np.abs(np.diag(k)), np.abs(np.diag(k0))))
    scale = 1 / np.where(own > 0, own, 1.0)
    k, k0 = k * np.outer(scale, scale), k0 * np.outer(scale, scale)
    if not np.all(np.isfinite(k)):
        return np.zeros((len(scale), 0))
    if symmetric or np.allclose(k, k.T, rtol=0, atol=SYMMETRIC):
        k = (k + k.T) / 2
        try:
            np.linalg.cholesky(k)
            return np.zeros((len(scale), 0))
        except np.linalg.LinAlgError:
            values, motions = np.linalg.eigh(k)
    else:
        if np.linalg.slogdet(k)[0] >= 0:
            return np.zeros((len(scale), 0))
        every, motions = np.linalg.eig(k)
        real = np.abs(every.imag) < ROUND_OFF * np.max(np.abs(every))
        values, motions = every.real[real], motions.real[:, real]
    resisting = np.abs(np.einsum("ik,ij,jk->k", motions, k0, motions))
    negative = values < -np.maximum(SHARE * resisting, ROUND_OFF * np.max(np.abs(values), initial=0.0))
    return scale[:, None] * motions[:, negative]


def is_unstable(elements: Any, symmetric: bool) -> bool:
    """Whether a stiffness in all coordinates is negative in some motion that the constraints allow.

    Args:
        elements: Element matrices, with arrays of NumPy.
        symmetric: As for :func:`unstable_motions`.
    """
    whole = Whole(elements)
    tangent = whole.at()
    factored = whole.factors(tangent)
    if not factored.regular:
        return False
    if symmetric:
        return bool(negative_where_held(tangent, factored, whole.n))
    multipliers = tangent.shape[0] - whole.n
    return factored.sign * (-1) ** multipliers < 0


def warn_of_unstable(model: Model, motions: Float[np.ndarray, "n_x k"] | None = None) -> None:
    """Say that an equilibrium is not stable.

    Args:
        model: Mechanism.
        motions: In which its stiffness is negative, in all coordinates, where they are known.
    """
    told = ""
    if motions is not None:
        largest = [motion / (np.max(np.abs(motion)) or 1.0) for motion in motions.T[:NAMED]]
        named = [", ".join(f"{s.of}.{s.symbol}" for s in shares(one, model.labels.x)[:LARGEST]) for one in largest]
        more = ", .." if motions.shape[1] > NAMED else ""
        told = f" in {motions.shape[1]} motion{'s' * (motions.shape[1] > 1)} ({'; '.join(named)}{more})"
    warn(
        f"The equilibrium is not stable: its stiffness is negative{told}. No mechanism stays there by itself: lower the"
        " load, or follow the way to a stable state by fm.path(model, switch=True)."
    )
