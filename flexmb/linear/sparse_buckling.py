"""Load multipliers of large mechanisms about their equilibrium, by sparse factors, and their derivatives."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit
from ..compilation.threads import one_thread
from ..errors import AnalysisError, ModelError
from ..math.derivative import jvp_of_varied
from ..math.indices import put
from ..math.sparse import SparseFactors
from ..mechanics.blocks import kernel
from ..mechanics.deformation import deformations
from ..mechanics.extent import sizes_of
from ..mechanics.loads import LoadFactors, nodal_forces, scaled_loads
from ..mechanics.stress_resultants import strain_of
from ..model.model import Model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS
from ..statics.solve import held_values
from ..statics.sparse import (
    Balanced,
    balanced,
    refuse_traced,
    refuse_what_is_not_sparse,
    second_variation,
)
from ..statics.tangent import Assembled, assemble, elastic_stress, stiffness_rows, unknowns
from .lanczos import BEFORE, FEW, AllowedMotions, changed, check_modes, eigenvalues_beside, more_below, with_all_copies
from .linearize import Linearization
from .sparse_linearize import SparseLinearization
from .sparse_spectrum import asks_for_all

# Multipliers beyond this many times the smallest are called unbounded: the load does not act in that motion.
UNBOUNDED = 1e9
# So are those that the round-off of a stress would give: that of a deformation beside what the whole mechanism's extent
# would make of it, and that of a constraint force beside the largest of the forces that it balances.
ROUND_OFF = 1e-15
# Stiffness of an element below zero by more than this share is negative.
NEGATIVE = 1e-9


class _Buckled(NamedTuple):
    """Load multipliers of a constrained mechanism in all its coordinates.

    Attributes:
        values: By magnitude, infinite where unbounded, (count,) [-].
        motions: Of the coordinates that move, one a column, (n, count).
        multipliers: Those of the constraints in these motions, (h, count).
        geometric: v^T G v of each, (count,).
    """

    values: np.ndarray
    motions: np.ndarray
    multipliers: np.ndarray
    geometric: np.ndarray


@jax.custom_jvp
def _load_multipliers(
    topology: Topology, parameters: Parameters, factors: LoadFactors, at: Balanced, count: Array
) -> Float[Array, "k"]:
    refuse_traced(parameters, factors, at)
    return jnp.asarray(_about(topology, parameters, factors, at, count.shape[0]).values)


def _about(topology: Topology, parameters: Parameters, factors: LoadFactors, at: Balanced, count: int) -> _Buckled:
    """Smallest multipliers about a state; what stays and what is scaled as in :func:`.buckling.scaled_stiffness`."""
    near = deformations(topology, parameters, at.x, at.near)
    stiffness = np.asarray(_stiffness(topology, parameters, factors, near))
    _refuse_negative(topology, stiffness)
    held = unknowns(topology)[2]
    sigma = put(elastic_stress(topology, parameters, factors, near), held, at.multipliers)
    found = assemble(topology, parameters, factors, at.x, near, sigma)
    structural = found.structural
    n = found.geometric.shape[0]
    moved = np.asarray(sizes_of(topology, parameters))
    if parameters.increment is None:
        stays, scaled = structural, found.geometric
    else:
        if abs(found.geometric).max() > 0:
            _refuse_unstable(structural, found.geometric)
        stays = found.tangent
        added, moved = _of_increment(topology, parameters, factors, at.x, near, found)
        sigma, only = jnp.asarray(added), LoadFactors(0.0, 1.0)
        scaled = assemble(topology, parameters, only, at.x, near, sigma).geometric
    wrong = _round_off(topology, parameters, found, stiffness, np.asarray(sigma), moved)
    noise = assemble(topology, parameters, LoadFactors(0.0, 0.0), at.x, near, wrong).geometric
    return _smallest(stays, scaled, noise, min(count, n - (stays.shape[0] - n)))


@kernel
def _stiffness(topology: Topology, parameters: Parameters, factors: LoadFactors, e: Array) -> Array:
    """Rows of the elements' tangent stiffnesses at deformations."""
    strain = strain_of(topology, parameters, scaled_loads(parameters, factors), e)
    return stiffness_rows(topology, parameters, strain)


def _of_increment(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    x: Float[Array, "n_x"],
    e: Float[Array, "n_e"],
    found: Assembled,
) -> tuple[np.ndarray, np.ndarray]:
    """Stresses that the incremental loads add to first order, (n_e,), and the displacements, (n_x,).

    About this state itself: under the same loads there may be others.
    """
    free, fast, held = (np.asarray(i) for i in unknowns(topology))
    moving, growing, force = (np.asarray(of) for of in _by_increment(topology, parameters, factors, x))
    stretched, moved = np.zeros(topology.n_e), np.zeros(topology.n_x)
    stretched[held], moved[fast] = growing[held], moving[fast]
    stress = np.array(_stress_by_increment(topology, parameters, factors, e, stretched))
    stress[held] = 0.0
    right = np.concatenate([(force - found.jacobian.T @ stress)[free], growing[held]])
    if len(fast):
        right = right - found.coupling @ moving[fast]
    factored = found.factors()
    if not factored.regular:
        raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)
    solved = factored.solve(right)
    moved[free] = solved[: len(free)]
    sigma = np.array(_stress_by_increment(topology, parameters, factors, e, found.jacobian @ moved))
    sigma[held] = solved[len(free) :]
    return sigma, moved


@kernel
def _by_increment(topology: Topology, parameters: Parameters, factors: LoadFactors, x: Float[Array, "n_x"]):
    """Changes of what is held, x and e, and of nodal forces with the factor of the incremental loads."""

    def at(increment: Float[Array, ""]):
        own = LoadFactors(factors.initial, increment)
        return *held_values(topology, parameters, own), nodal_forces(topology, parameters, own, x)

    return jax.jvp(at, (jnp.asarray(factors.increment, float),), (jnp.ones(()),))[1]


@kernel
def _stress_by_increment(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    e: Float[Array, "n_e"],
    change: Float[Array, "n_e"],
):
    """Change of the elements' stress with that factor where deformations change too."""

    def at(increment: Float[Array, ""], e: Float[Array, "n_e"]):
        return elastic_stress(topology, parameters, LoadFactors(factors.initial, increment), e)

    return jax.jvp(at, (jnp.asarray(factors.increment, float), e), (jnp.ones(()), change))[1]


def _round_off(
    topology: Topology, parameters: Parameters, found: Assembled, stiffness: Any, sigma: np.ndarray, moved: np.ndarray
) -> np.ndarray:
    """What stress resultants are wrong by, as :func:`.buckling.scaled_stiffness` has it, (n_e,) [N, N m]."""
    rows, sizes = abs(found.jacobian), np.asarray(sizes_of(topology, parameters))
    largest = np.max(sizes * (rows.T @ np.abs(sigma)), initial=0.0)
    reach = rows.multiply(sizes).max(axis=1).toarray().ravel()
    stretched, elastic = rows @ np.abs(moved), np.zeros(topology.n_e)
    for at, own in _of_blocks(topology, stiffness):
        elastic[at] = np.einsum("eij,ej->ei", np.abs(own), stretched[at])
    return ROUND_OFF * (elastic + np.divide(largest, reach, out=np.zeros_like(reach), where=reach > 0))


def _operator(stays: Any, n: int) -> tuple[Any, Any]:
    """Factors of the stiffness that stays, and motions under forces as ARPACK asks for them."""
    import scipy.sparse.linalg

    factored = SparseFactors(stays)
    if not factored.regular:
        raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)

    def moved(force: np.ndarray):
        return factored.solve(np.concatenate([np.ravel(force), np.zeros(stays.shape[0] - n)]))[:n]

    linalg: Any = scipy.sparse.linalg
    return factored, linalg.LinearOperator((n, n), matvec=moved, dtype=float)


def _refuse_unstable(structural: Any, geometric: Any) -> None:
    """Raise where the preload is beyond a buckling load of its own: K0 + G0 is not positive definite."""
    import scipy.sparse.linalg

    n, linalg = geometric.shape[0], scipy.sparse.linalg
    factored, moved = _operator(structural, n)
    left = 2 * n - structural.shape[0]
    if left <= FEW:
        most = AllowedMotions(structural, factored, n).largest(-geometric, left)[0]
    else:
        start = moved.matvec(np.cos(np.arange(n) ** 2))
        most = linalg.eigsh(-geometric, k=1, M=structural[:n, :n], Minv=moved, v0=start, which="LA", tol=1e-6)[0]
    if np.max(most, initial=0.0) >= 1:
        raise AnalysisError(RESULTS.unstable.name, RESULTS.unstable.message)


def _smallest(stays: Any, scaled: Any, noise: Any, count: int) -> _Buckled:
    """Multipliers of smallest size: -G v = (1/lambda) K v in the motions that the constraints leave.

    Source:
        THEORY.md 7, eq. (7.4), by the Lanczos method of ARPACK in the inner product of the stiffness that stays.
    """
    import scipy.sparse
    import scipy.sparse.linalg

    n = scaled.shape[0]
    factored, moved = _operator(stays, n)
    stiffness, rest = stays[:n, :n], stays.shape[0] - n
    if abs(scaled).max() == 0:
        return _Buckled(np.full(count, np.inf), np.zeros((n, count)), np.zeros((rest, count)), np.zeros(count))
    if n - rest <= max(FEW, 3 * count):
        try:
            inverse, motions = AllowedMotions(stays, factored, n).largest(-scaled, count)
        except np.linalg.LinAlgError:
            raise AnalysisError(RESULTS.unstable.name, RESULTS.unstable.message) from None
    else:

        def search(values: np.ndarray, known: np.ndarray, start: np.ndarray):
            how = {"which": "LM", "tol": 1e-13}
            return eigenvalues_beside(
                -scaled, stiffness, moved.matvec, (values, known), count, moved.matvec(start), **how
            )

        def passed_over(inverse: np.ndarray):
            if abs(inverse[-1]) <= abs(inverse[0]) / UNBOUNDED:
                return False
            limit = (1 - BEFORE) / abs(inverse[-1])
            wide = scipy.sparse.block_diag([limit * scaled, scipy.sparse.csr_array((rest, rest))])
            sides = [(stays + side * wide).tocsc() for side in (1.0, -1.0)]
            found = [int(np.sum(side * inverse > 1 / limit)) for side in (1.0, -1.0)]
            return any(more_below(matrix, n, own) for matrix, own in zip(sides, found, strict=True))

        inverse, motions = with_all_copies(search, passed_over, lambda inverse: -np.abs(inverse), (n, count))
    order = np.argsort(-np.abs(inverse))
    inverse, motions = inverse[order], motions[:, order]
    size = np.einsum("ij,ij->j", motions, stiffness @ motions)
    false = np.abs(np.einsum("ij,ij->j", motions, noise @ motions)) / size
    bounded = np.abs(inverse) > np.maximum(np.max(np.abs(inverse)) / UNBOUNDED, false)
    values = np.where(bounded, 1 / np.where(bounded, inverse, 1.0), np.inf)
    # Once more, for the multipliers too: K v + D^T m = -lambda G v.
    forces = np.vstack([-(scaled @ motions) / np.where(bounded, inverse, 1.0), np.zeros((rest, count))])
    full = np.stack([factored.solve(force) for force in forces.T], axis=1)
    check_modes(changed((full[:n] - motions)[:, bounded], motions[:, bounded], stiffness), "load multipliers")
    return _Buckled(values, motions, full[n:], np.einsum("ij,ij->j", motions, scaled @ motions))


@jit
def _quotient(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    at: Balanced,
    near: Float[Array, "n_e"],
    motion: Float[Array, "n"],
    multipliers: Float[Array, "h"],
    value: Float[Array, ""],
) -> Float[Array, ""]:
    """Second variation of the Lagrangian along a mode, its stresses scaled, whose derivative gives the multiplier's."""
    elastic, geometric, rates = second_variation(topology, parameters, factors, at, near, motion)
    return elastic + value * geometric + 2 * multipliers @ rates


@_load_multipliers.defjvp
def _load_multipliers_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    topology, parameters, factors, at, count = primals
    if parameters.increment is not None:
        raise NotImplementedError(
            "Load multipliers of incremental loads by sparse factors have no derivative: scale all loads, or leave"
            " `sparse` out."
        )
    found = _about(topology, parameters, factors, at, count.shape[0])
    near = deformations(topology, parameters, at.x, at.near)
    bounded = np.isfinite(found.values)
    values = np.where(bounded, found.values, 0.0)

    def all_modes(parameters: Parameters, factors: LoadFactors, at: Balanced):
        return jnp.stack(
            [
                _quotient(topology, parameters, factors, at, near, *(jnp.asarray(v) for v in mode))
                for mode in zip(found.motions.T, found.multipliers.T, values, strict=True)
            ]
        )

    _, change = jvp_of_varied(all_modes, primals[1:4], tangents[1:4])
    slope = np.where(bounded, -1 / np.where(bounded, found.geometric, 1.0), 0.0)
    return jnp.asarray(found.values), slope * change


@one_thread()
def sparse_multipliers(
    model: Model, target: LoadFactors, count: int, about: Linearization | SparseLinearization | None = None
) -> Float[Array, "k"]:
    """Load multipliers of smallest size about the equilibrium by sparse factors, (count,) or fewer [-].

    Args:
        model: As for :func:`sparse_equilibrium`.
        target: Load factors there.
        about: Another state with these loads, of a path; None: the equilibrium.

    Raises:
        ModelError: See :func:`refuse_what_is_not_sparse`, too large a count, or an element of negative stiffness.
        AnalysisError: singular_stiffness, not_converged, or unstable under the preload.

    Source:
        THEORY.md 7, eq. (7.4), with multipliers in place of degrees of freedom.
    """
    topology, parameters = model.topology, model.parameters
    refuse_what_is_not_sparse(topology)
    free, _, held = unknowns(topology)
    every = len(free) - len(held)
    if asks_for_all(count, every):
        raise ModelError(
            f"Argument `count` = {count}: sparse matrices give few of the {every} load multipliers, not all. Ask for"
            " fewer, or give sparse=False and a model with degrees of freedom."
        )
    if about is None:
        at = balanced(topology, parameters, target)
    else:
        at = Balanced(about.x, about.sigma[held], about.e)
    # The number is handed on as a shape, which stays known.
    return _load_multipliers(topology, parameters, target, at, jnp.zeros(min(count, every)))


def _of_blocks(topology: Topology, stiffness: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Numbers of the deformations, (elements, k), and stiffnesses of the elements of each block, (elements, k, k)."""
    places = [np.asarray(b.e) for b in topology.blocks if "deformation" in b.companions and b.e.shape[1]]
    return [(at, stiffness[at][:, :, : at.shape[1]]) for at in places]


def _refuse_negative(topology: Topology, stiffness: np.ndarray) -> None:
    """Raise where an element's stiffness is negative: the method's inner product relies on it."""
    for _, matrices in _of_blocks(topology, stiffness):
        own = np.linalg.eigvalsh(matrices)
        if np.any(own[:, 0] < -NEGATIVE * np.abs(own[:, -1])):
            raise ModelError(
                "An element has a negative stiffness, which load multipliers by sparse factors cannot take."
            )
