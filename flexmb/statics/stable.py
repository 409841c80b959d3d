"""Stability of an equilibrium, and the warning of an unstable one."""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..checks.mobility import shares
from ..compilation.compile import jit
from ..errors import warn
from ..math.by_deformations import energies, motions_from_free
from ..math.element_matrices import AssembledEquations, ElementMatrices
from ..math.linear import diagonal_of, uneven
from ..math.sparse import negative_under_constraints
from ..model.model import Model
from ..numerical_limits import DEPENDENT_VECTOR, NEGATIVE_SHARE, STIFFNESS_ROUND_OFF, SYMMETRIC_STIFFNESS
from ..results import RESULTS, collect, collects

# Steps of Lanczos' method.
STEPS = 30
# Number of motions and coordinates named in a warning.
NAMED, LARGEST = 2, 3


def unstable_motions(
    stiffness: Float[Array, "n n"], structural: Float[Array, "n n"], symmetric: bool
) -> Float[np.ndarray, "n k"]:
    """Motions of the degrees of freedom, one a column, in which a stiffness K0 + G0 of known numbers is negative.

    ``symmetric``: all loads have a potential. Without a potential, only a negative determinant shows
    instability, and the motions belong to real negative eigenvalues.
    """
    k, k0 = np.asarray(stiffness), np.asarray(structural)
    sizes = np.sqrt(np.maximum(np.abs(np.diag(k)), np.abs(np.diag(k0))))
    scale = 1 / np.where(sizes > 0, sizes, 1.0)
    k, k0 = k * np.outer(scale, scale), k0 * np.outer(scale, scale)
    if not np.all(np.isfinite(k)):
        return np.zeros((len(scale), 0))
    if symmetric or np.allclose(k, k.T, rtol=0, atol=SYMMETRIC_STIFFNESS):
        k = (k + k.T) / 2
        try:
            np.linalg.cholesky(k)
            return np.zeros((len(scale), 0))
        except np.linalg.LinAlgError:
            values, motions = np.linalg.eigh(k)
    else:
        if np.linalg.slogdet(k)[0] >= 0:
            return np.zeros((len(scale), 0))
        eigenvalues: Any = np.linalg.eig(k)
        every, motions = eigenvalues
        real = np.abs(every.imag) < STIFFNESS_ROUND_OFF * np.max(np.abs(every))
        values, motions = every.real[real], motions.real[:, real]
    resisting = np.abs(np.einsum("ik,ij,jk->k", motions, k0, motions))
    negative = values < -np.maximum(
        NEGATIVE_SHARE * resisting, STIFFNESS_ROUND_OFF * np.max(np.abs(values), initial=0.0)
    )
    return scale[:, None] * motions[:, negative]


@jit
def is_negative(stiffness: Float[Array, "n n"], structural: Float[Array, "n n"], *, symmetric: bool) -> Bool[Array, ""]:
    """Whether there are :func:`unstable_motions`, in compiled code."""
    sizes = jnp.sqrt(jnp.maximum(jnp.abs(diagonal_of(stiffness)), jnp.abs(diagonal_of(structural))))
    scale = 1 / jnp.where(sizes > 0, sizes, 1.0)
    scale = scale[:, None] * scale
    if not symmetric:
        return jnp.linalg.slogdet(stiffness * scale)[0] < 0
    # Positive except for critical motions and round-off.
    more = NEGATIVE_SHARE * structural * scale + STIFFNESS_ROUND_OFF * jnp.eye(sizes.shape[0])
    return ~jnp.all(jnp.isfinite(jnp.linalg.cholesky(stiffness * scale + more)))


def collect_unstable(parts: Sequence[Float[Array, "n n"]], structural: Float[Array, "n n"], symmetric: bool) -> None:
    """Add the code of an unstable state if codes are collected; ``parts`` sum up to the stiffness."""
    if collects():
        unstable = is_negative(*jax.lax.stop_gradient((sum(parts), structural)), symmetric=symmetric)
        collect(jnp.where(unstable, RESULTS.unstable_state, RESULTS.successful))


def pivots_tell_unstable(elements: ElementMatrices, symmetric: bool) -> bool:
    """Whether a stiffness in all coordinates has more negative pivots than constraints, or pivots are inconclusive."""
    assembled = AssembledEquations(elements)
    tangent = assembled.at()
    factored = assembled.factors(tangent)
    if not factored.regular:
        return False
    if symmetric:
        return negative_under_constraints(tangent, factored, assembled.n) != 0
    return factored.sign * (-1) ** (tangent.shape[0] - assembled.n) < 0


def has_negative_motion(elements: ElementMatrices) -> bool:
    """Whether an allowed motion is found in which a symmetric stiffness K is negative.

    Lanczos' method for the least eigenvalue 1/mu of K v = mu S v. S is the structural stiffness with the sizes of the
    other parts on its diagonal: almost all values are 1, so that a few steps find a negative one. The motion's energy
    is computed from deformations, with little round-off.
    """
    import scipy.sparse

    assembled = AssembledEquations(elements)
    n, factored = assembled.n, assembled.factors(assembled.at())
    if not factored.regular:
        return False
    metric = abs(assembled.structural[:n, :n].diagonal()) * STIFFNESS_ROUND_OFF + abs(assembled.curved).sum(axis=1)
    metric = assembled.structural[:n, :n] + scipy.sparse.diags_array(metric)

    def flexed(motion: np.ndarray) -> np.ndarray:
        return factored.solve(np.concatenate([metric @ motion, np.zeros(assembled.elements.unknowns[1])]))[:n]

    basis, images = np.zeros((n, 0)), np.zeros((n, 0))
    motion = flexed(uneven(n, 1) * elements.sizes[elements.free])
    for _ in range(min(n, STEPS)):
        for _ in range(2):
            motion = motion - basis @ (basis.T @ (metric @ motion))
        size = motion @ (metric @ motion)
        if size < -NEGATIVE_SHARE * (np.abs(motion) @ (abs(metric) @ np.abs(motion))):
            # With an element of negative stiffness, S is no norm of motions: pivots decide.
            return True
        if not size > 0 or (images.shape[1] and size < DEPENDENT_VECTOR * images[:, -1] @ (metric @ images[:, -1])):
            break
        basis = np.concatenate([basis, motion[:, None] / np.sqrt(size)], axis=1)
        motion = flexed(basis[:, -1])
        images = np.concatenate([images, motion[:, None]], axis=1)
    if not basis.shape[1]:
        return False
    between = basis.T @ (metric @ images)
    values, shares = np.linalg.eigh((between + between.T) / 2)
    softest = images @ shares[:, 0]
    elastic = float(energies(elements, motions_from_free(elements, softest[:, None]))[0])
    curved = float(softest @ (assembled.curved @ softest))
    return bool(values[0] < 0 and elastic + curved < -NEGATIVE_SHARE * (abs(elastic) + abs(curved)))


def is_unstable(elements: ElementMatrices, symmetric: bool) -> bool:
    """Whether a stiffness in all coordinates is negative in some allowed motion."""
    return pivots_tell_unstable(elements, symmetric) and (not symmetric or has_negative_motion(elements))


def warn_of_unstable(model: Model, motions: Float[np.ndarray, "n_x k"] | None = None) -> None:
    """Warn that an equilibrium is not stable, with the motions of negative stiffness if they are known."""
    collect(RESULTS.unstable_state)
    note = ""
    if motions is not None:
        largest = [motion / (np.max(np.abs(motion)) or 1.0) for motion in motions.T[:NAMED]]
        named = [", ".join(f"{s.of}.{s.symbol}" for s in shares(m, model.labels.x)[:LARGEST]) for m in largest]
        more = ", .." if motions.shape[1] > NAMED else ""
        note = f" in {motions.shape[1]} motion{'s' * (motions.shape[1] > 1)} ({'; '.join(named)}{more})"
    warn(
        f"The equilibrium is not stable: its stiffness is negative{note}. No mechanism stays there by itself. Lower the"
        " load, or follow the path to a stable state by fm.path(model, switch=True)."
    )
