"""Equations of large mechanisms in compiled code: the host factors and solves the sparse matrix of all elements."""

import functools
import hashlib
from collections import deque
from typing import Any
from weakref import WeakValueDictionary

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Float, Inexact, Int

from ..compilation.host import call_host
from ..compilation.record import Record, static
from ..errors import AnalysisError
from ..math.indices import scatter_vector
from ..math.sparse import SparseFactors, SparsePattern, on_host_thread
from ..model.topology import Block, Topology

# Number of stored factors: two of a step, and the factors of the projection onto the constraints.
MOST_FACTORS = 4


class Places:
    """Places of the entries of element matrices in the sparse matrix, on the host, with the last factors.

    The thread of the host creates and frees factors. Any thread may solve with them.

    Attributes:
        count: Number of unknowns.
        too_large: Whether memory did not suffice for factors.
    """

    def __init__(self, unknowns: list[np.ndarray], count: int):
        """Find the places from the unknowns of each block, (elements, k). The number ``count`` marks no unknown."""
        self._unknowns = unknowns
        every = [np.where(indices < count, indices, -1) for indices in (*unknowns, np.arange(count)[:, None])]
        self._pattern = SparsePattern((count, count), [(indices, indices) for indices in every])
        self._kept: deque[tuple[np.ndarray, SparseFactors]] = deque(maxlen=MOST_FACTORS)
        self.count, self.too_large = count, False

    def __reduce__(self):
        """Return arguments from which another process finds the places, without factors."""
        return _places, (self._unknowns, self.count)

    def _asdict(self) -> dict[str, Any]:
        """Return the contents on which a cached trace depends."""
        return {"unknowns": self._unknowns, "count": self.count}

    def solution(self, entries: Any, right: Any, transposed: bool = False) -> np.ndarray:
        """Return the solution of the equations or of the transposed equations; NaN if singular.

        ``entries`` contains the entries of all element matrices, then the diagonal.
        """
        entries, right = np.asarray(entries), np.asarray(right)
        try:
            factors = self._known(entries) or on_host_thread(self._factored, entries)
        except AnalysisError:
            self.too_large = True
            return np.full_like(right, np.nan)
        if not factors.regular:
            return np.full_like(right, np.nan)
        solution, fits = factors.answer(right, transposed, refine=False)
        return solution if fits else on_host_thread(factors.solve, right, transposed)

    def _known(self, entries: np.ndarray) -> SparseFactors | None:
        for known, factors in list(self._kept):
            if known.dtype == entries.dtype and np.array_equal(known, entries):
                return factors
        return None

    def _factored(self, entries: np.ndarray) -> SparseFactors:
        factors = self._pattern.factored(self._pattern.matrix([entries]))
        self.too_large = False
        self._kept.appendleft((entries.copy(), factors))
        return factors


class SparseOrder(Record):
    """Unknowns of a mechanism, coordinates and multipliers, for elements that may join any unknowns.

    Attributes:
        unknowns: Coordinates of each element of the moving blocks, then its deformations if some are held.
        holds: Whether some deformations of each of these blocks are held.
        places: Places of the entries of the element matrices.
    """

    unknowns: tuple[Int[Array, "elements k"], ...]
    holds: tuple[bool, ...] = static()
    places: Places = static()

    def solved(
        self,
        pieces: tuple[Inexact[Array, "elements k k"], ...],
        diagonal: Inexact[Array, "unknowns"],
        right: Inexact[Array, "unknowns"],
        transposed: bool = False,
    ):
        """Return the solution of the equations or of the transposed equations, in the order of the unknowns.

        The host keeps the factors of the last matrices.
        """
        like = jax.ShapeDtypeStruct(right.shape, right.dtype)
        solution = functools.partial(self.places.solution, transposed=True) if transposed else self.places.solution
        return call_host(solution, like, jnp.concatenate([*(piece.reshape(-1) for piece in pieces), diagonal]), right)

    def product(self, pieces: tuple[Array, ...], change: Float[Array, "unknowns"]) -> Float[Array, "unknowns"]:
        """Return the product of the sum of element matrices and a change of the unknowns."""
        padded = jnp.append(change, 0.0)
        every = zip(self.unknowns, pieces, strict=True)
        products = [(places, jnp.sum(matrices * padded[places][:, None, :], axis=2)) for places, matrices in every]
        return scatter_vector(padded.shape[0], products)[:-1]


def solution(
    order: SparseOrder,
    pieces: tuple[Float[Array, "elements k k"], ...],
    diagonal: Float[Array, "unknowns"],
    right: Float[Array, "unknowns"],
) -> Float[Array, "unknowns"]:
    """Return the solution, differentiable by element matrices, diagonal and right-hand side."""
    known = lax.stop_gradient((pieces, diagonal))

    def product(z: Float[Array, "unknowns"]):
        return order.product(pieces, z) + diagonal * z

    def solve(transposed: bool):
        return lambda _, right: order.solved(*known, right, transposed)

    return lax.custom_linear_solve(product, right, solve(False), transpose_solve=solve(True))


def order_of(topology: Topology) -> SparseOrder:
    """Return the unknowns of a mechanism and the places of its matrices. Equal structures share the result.

    Unknowns, (elements, k), are free coordinates, then multipliers if some deformations are held. The number of all
    unknowns marks an entry without unknown.
    """
    free, constrained = np.asarray(topology.x.free), np.asarray(topology.e.held)
    n, count = len(free), len(free) + len(constrained)
    of_x, of_e = np.full(topology.n_x, count), np.full(topology.n_e, count)
    of_x[free], of_e[constrained] = np.arange(n), n + np.arange(len(constrained))
    unknowns, holds = [], []
    for block in moving_blocks(topology):
        x, e = np.asarray(block.x), np.asarray(block.e)
        e_unknowns = of_e[e if "deformation" in block.companions else e[:, :0]]
        holds.append(bool(np.any(e_unknowns < count)))
        unknowns.append(np.concatenate([of_x[x], e_unknowns], axis=1) if holds[-1] else of_x[x])
    return SparseOrder(tuple(jax.device_put(unknowns)), tuple(holds), _places(unknowns, count))


def moving_blocks(topology: Topology) -> list[Block]:
    """Return the blocks whose elements deform or have mass, in the order of :class:`SparseOrder`."""
    return [
        block
        for block in topology.blocks
        if ("deformation" in block.companions and block.e.shape[1]) or "inertia" in block.companions
    ]


# Equal structures share places and compiled code while at least one of them is in use.
_known: WeakValueDictionary[bytes, Places] = WeakValueDictionary()


def _places(unknowns: list[np.ndarray], count: int) -> Places:
    hasher = hashlib.blake2b(repr((count, [indices.shape for indices in unknowns])).encode(), digest_size=16)
    for indices in unknowns:
        hasher.update(indices.astype(np.int64).tobytes())
    places = _known.get(hasher.digest())
    if places is None:
        places = _known[hasher.digest()] = Places(unknowns, count)
    return places
