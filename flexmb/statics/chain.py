"""Equilibrium of long chains: linear equations by blocks in the order of the chain, all turns in one program."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..arguments import is_concrete
from ..math.block_tridiagonal import parts_of
from ..math.element_matrices import ElementMatrices
from ..math.indices import put
from ..math.linear import uneven
from ..mechanics.blocks import kernel, scatter_vector
from ..mechanics.levels import WIDE, Levels, bordered, levels_of, moving_blocks
from ..mechanics.loads import LoadFactors
from ..model.model import Model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS
from .search import LinearEquations, Search, corrected, linear_equations, start

# A trial force of one at each stiffness moves a regular mechanism less, and is met by what it moves but for this share.
FAR, UNMET = 1e13, 1e-3


# From so many coordinates and so many links on a chain is solved in its order: its program takes a third of the time of
# dense matrices, and up to a second longer to compile, which two short chains side by side do not pay back.
LONG, LINKS = 120, 20


def is_long_chain(model: Model) -> bool:
    """Whether a model of known numbers is solved in the order of a chain though not so large as to be sparse."""
    if model.topology.n_x < LONG or not is_concrete(model):
        return False
    levels = chain_of(model.topology)
    return levels is not None and levels.place.shape[1] > LINKS


def chain_of(topology: Topology) -> Levels | None:
    """Order of the unknowns of a chain, on the host; None where elements join otherwise, or loads follow the motion."""
    if not is_concrete(topology) or any("force" in block.companions for block in topology.blocks):
        return None
    return levels_of(topology, WIDE)


class Pivots(NamedTuple):
    """What tells the signs of the eigenvalues of a symmetric tangent.

    Attributes:
        negative: Number of negative pivots within the parts of a chain.
        joints: Inverse of what is left of the joints between them, (r, r).
    """

    negative: Int[Array, ""]
    joints: Float[Array, "r r"]


@kernel
def balanced_chain(
    topology: Topology, parameters: Parameters, target: LoadFactors, levels: Levels
) -> tuple[Search, Pivots]:
    """The end of the search; where it found none, factors on the host, which exchange rows, may still.

    Args:
        levels: Order of the unknowns.

    Returns:
        Search, and the pivots of its last turn.
    """

    def turn(carry: tuple[Search, Pivots]) -> tuple[Search, Pivots]:
        s, _ = carry
        equations, still = linear_equations(topology, parameters, target, s)
        z, regular, pivots = _solved(topology, levels, equations)
        why = jnp.where(regular, RESULTS.successful, RESULTS.singular_stiffness)
        s = corrected(topology, parameters, target, s, equations, jnp.where(regular, z, jnp.nan), why, still)
        return s, pivots

    width, parts = levels.place.shape[0], parts_of(levels.place.shape[1])[0]
    none = Pivots(jnp.array(0), jnp.zeros((width * parts,) * 2))
    return jax.lax.while_loop(lambda carry: ~carry[0].finished, turn, (start(topology, parameters), none))


def pivots_tell_unstable_chain(topology: Topology, pivots: Pivots) -> bool:
    """Whether more pivots of a symmetric stiffness are negative than constraints make so, by round-off perhaps."""
    joints = np.asarray(pivots.joints)
    if not np.all(np.isfinite(joints)):
        # Nothing is loaded, and no stiffness was asked for.
        return False
    # Metres and radians are made alike, which changes no sign.
    scale = 1 / np.sqrt(np.maximum(np.max(np.abs(joints), axis=1), np.finfo(float).tiny))
    joints = joints * np.outer(scale, scale)
    negative = int(pivots.negative) + int(np.sum(np.linalg.eigvalsh((joints + joints.T) / 2) < 0))
    return negative > len(topology.e.held)


def _solved(
    topology: Topology, levels: Levels, equations: LinearEquations
) -> tuple[Float[Array, "m 2"], Bool[Array, ""], Pivots]:
    """Solution of the linear equations, whether their matrix is regular, and its pivots.

    Blocks are eliminated without an exchange of rows. What constraints hold is therefore made about as stiff as what
    bears on it, D^T c D z beside K z and D^T c g beside the forces, which changes no solution of D z = g.
    """
    n, n_x = topology.x.free.shape[0], topology.n_x
    # The equations have the coordinates that move in ascending order.
    back = jnp.argsort(jnp.argsort(topology.x.free))
    moves = put(jnp.zeros(n_x), topology.x.free, 1.0)
    held = put(jnp.zeros(topology.n_e), topology.e.held, 1.0)
    blocks = moving_blocks(topology)
    squares = _squares(blocks, equations.elements)
    diagonals = [(b.x, jnp.diagonal(of, axis1=1, axis2=2)) for b, of in zip(blocks, squares, strict=True)]
    stiffness = jnp.abs(scatter_vector(n_x, diagonals)) * moves
    rows = iter(equations.elements.constraints)
    pieces, firm = [], []
    excess = put(jnp.zeros((topology.n_e, 2)), topology.e.held, equations.right[n:])
    forces = put(jnp.zeros((n_x, 2)), jnp.sort(topology.x.free), equations.right[:n])
    for block, square, holds in zip(blocks, squares, levels.holds, strict=True):
        if "deformation" in block.companions and block.e.shape[1]:
            own = next(rows)[2] * held[block.e][:, :, None]
            size = jnp.sum(own**2 * moves[block.x][:, None, :], axis=2)
            bears = jnp.max(stiffness[block.x], axis=1)[:, None]
            c = jnp.where(size > 0, bears / jnp.where(size > 0, size, 1.0), 0.0)
            if holds:
                square = square + jnp.einsum("eki,ek,ekj->eij", own, c, own)
                pulled = jnp.einsum("eki,ek,ekm->eim", own, c, excess[block.e])
                forces = forces + jax.vmap(lambda p, b=block: scatter_vector(n_x, [(b.x, p)]), 2, 1)(pulled)
                square = bordered(square, own, own.mT)
                firm.append((block.e, c))
        pieces.append(square)
    pieces, firmness = tuple(pieces), scatter_vector(topology.n_e, firm)
    diagonals = [
        (b.x, jnp.diagonal(of, axis1=1, axis2=2)[:, : b.x.shape[1]]) for b, of in zip(blocks, pieces, strict=True)
    ]
    stiffness = jnp.abs(scatter_vector(n_x, diagonals))
    right = jnp.concatenate([forces[topology.x.free], equations.right[n:]])
    root = jnp.sqrt(jnp.concatenate([stiffness[topology.x.free], 1 / firmness[topology.e.held]]))
    factors = levels.factors(pieces)
    every = jnp.concatenate([right, (uneven(right.shape[0], 1, jnp) * root)[:, None]], axis=1)
    z = jax.vmap(lambda one: levels.solved(factors, one), 1, 1)(every)
    left = (levels.product(pieces, z[:, 2]) - every[:, 2]) / root
    met = jnp.max(jnp.abs(left), initial=0.0) < UNMET
    near = jnp.max(jnp.abs(z[:, 2] * root), initial=0.0) < FAR
    pivots = Pivots(factors.negative, factors.joints)
    return jnp.concatenate([z[:n, :2][back], z[n:, :2]]), met & near, pivots


def _squares(blocks: list[Any], elements: ElementMatrices) -> list[Array]:
    """Stiffness of the elements of each block that moves, by its coordinates: of deformations, and of weight."""
    structural, curved = ((own for *_, own in pieces) for pieces in (elements.structural, elements.curved))
    deforming = [b for b in blocks if "deformation" in b.companions and b.e.shape[1]]
    falls = len(elements.curved) > len(deforming)
    bending = [next(curved) for _ in deforming]
    found = []
    for block in blocks:
        count, size = np.shape(block.x)
        square = jnp.zeros((count, size, size))
        if "deformation" in block.companions and block.e.shape[1]:
            square = square + next(structural, 0.0) + bending.pop(0)
        if falls and "inertia" in block.companions:
            square = square + next(curved)
        found.append(square)
    return found
