"""Equations of any large mechanism inside compiled code: element matrices go to the host, whose factors answer."""

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
from ..math.sparse import SparseFactors, SparsePattern, on_host_thread
from ..model.topology import Topology
from .levels import WIDE, Levels, is_elastic, levels_of, moving_blocks, product_of, unknowns_of

# Factors of so many matrices are kept: two of a step, and those that bring back onto the constraints.
MOST = 4
# What a solution is found from: BlockFactors of levels, or the entries that the host factors.
Factors = Any


class Places:
    """Where the entries of element matrices lie in those of the whole, on the host, with the last factors.

    Factors are made in the thread of the host, and go there when others come; they answer in any thread.

    Attributes:
        count: Number of unknowns.
        too_large: Whether the memory did not suffice for factors.
    """

    def __init__(self, unknowns: list[np.ndarray], count: int):
        """Find them.

        Args:
            unknowns: Of each block, those of its elements, (elements, k); ``count`` for none.
            count: Number of unknowns.
        """
        self._unknowns = unknowns
        every = [np.where(own < count, own, -1) for own in (*unknowns, np.arange(count)[:, None])]
        self._pattern = SparsePattern((count, count), [(own, own) for own in every])
        self._kept: deque[tuple[np.ndarray, SparseFactors]] = deque(maxlen=MOST)
        self.count, self.too_large = count, False

    def __reduce__(self):
        """What another process finds them from; factors stay here."""
        return _places, (self._unknowns, self.count)

    def _asdict(self) -> dict[str, Any]:
        """What a trace depends on, that is kept."""
        return {"unknowns": self._unknowns, "count": self.count}

    def solution(self, entries: Any, right: Any, transposed: bool = False) -> np.ndarray:
        """Solution of the equations, not finite where they are singular.

        Args:
            entries: Of the element matrices, one after the other, then those of the diagonal.
            right: Right-hand side, (unknowns,).
            transposed: Whether of the transposed equations.
        """
        entries, right = np.asarray(entries), np.asarray(right)
        try:
            factors = self._known(entries) or on_host_thread(self._factored, entries)
        except AnalysisError:
            self.too_large = True
            return np.full_like(right, np.nan)
        if not factors.regular:
            return np.full_like(right, np.nan)
        found, fits = factors.answer(right, transposed, refine=False)
        return found if fits else on_host_thread(factors.solve, right, transposed)

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
    """Unknowns, of coordinates and multipliers, of a mechanism whose elements may join any of them.

    Attributes:
        unknowns: Of each element of the blocks that move: its coordinates, then its deformations where some are held.
        holds: Whether deformations of each such block are held.
        places: Where the entries of the element matrices lie.
    """

    unknowns: tuple[Int[Array, "elements k"], ...]
    holds: tuple[bool, ...] = static()
    places: Places = static()

    def factors(self, pieces: tuple[Array, ...], diagonal: Array | None = None) -> Inexact[Array, "entries"]:
        """What the sum of element matrices is factored from, once a solution is asked for.

        Args:
            pieces: Of each block that moves, (elements, k, k), by ``unknowns``.
            diagonal: Added at the unknowns, (unknowns,).
        """
        if diagonal is None:
            diagonal = jnp.zeros(self.places.count, pieces[0].dtype)
        return jnp.concatenate([*(of.reshape(-1) for of in pieces), diagonal])

    def solved(self, factors: Inexact[Array, "entries"], right: Inexact[Array, "unknowns"], transposed: bool = False):
        """Solution, in the order of the unknowns, or that of the transposed equations."""
        like = jax.ShapeDtypeStruct(right.shape, right.dtype)
        solution = functools.partial(self.places.solution, transposed=True) if transposed else self.places.solution
        return call_host(solution, like, factors, right)

    def product(self, pieces: tuple[Array, ...], change: Float[Array, "unknowns"]) -> Float[Array, "unknowns"]:
        """Product of the sum of element matrices with a change of the unknowns."""
        return product_of(self.unknowns, pieces, change)


@jax.custom_jvp
def solution(
    order: Levels | SparseOrder,
    factors: Factors,
    pieces: tuple[Float[Array, "elements k k"], ...],
    diagonal: Float[Array, "unknowns"],
    right: Float[Array, "unknowns"],
) -> Float[Array, "unknowns"]:
    """Solution of the equations, differentiable in element matrices, diagonal and right-hand side.

    Args:
        order: Of the unknowns.
        factors: Of the element matrices and the diagonal.
        pieces: Of each block that moves.
        diagonal: Added at the unknowns.
        right: Right-hand side.
    """
    del pieces, diagonal
    return order.solved(factors, right)


@solution.defjvp
def _solution_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    order, factors, pieces, diagonal, _ = primals
    z = solution(*primals)
    *_, by_pieces, by_diagonal, by_right = tangents

    def product(z: Float[Array, "unknowns"]):
        return order.product(pieces, z) + diagonal * z

    def solve(transposed: bool):
        return lambda _, right: order.solved(factors, right, transposed)

    left = by_right - order.product(by_pieces, z) - by_diagonal * z
    return z, lax.custom_linear_solve(product, left, solve(False), transpose_solve=solve(True))


def order_of(topology: Topology) -> "Levels | SparseOrder":
    """Order in which the equations of a large mechanism are solved: along a chain, or as the host finds it.

    In levels rows cannot change places, as they must where there are multipliers.
    """
    levels = levels_of(topology, WIDE) if is_elastic(topology) else None
    return sparse_order_of(topology) if levels is None else levels


def sparse_order_of(topology: Topology) -> SparseOrder:
    """Unknowns of a mechanism and where its matrices have entries, on the host; found once for equal structures."""
    moving = moving_blocks(topology)
    unknowns, holds, count = unknowns_of(topology, moving)
    return SparseOrder(tuple(jax.device_put(unknowns)), holds, _places(unknowns, count))


# As long as one of them is in use, equal structures share it and the code that was compiled with it.
_known: WeakValueDictionary[bytes, Places] = WeakValueDictionary()


def _places(unknowns: list[np.ndarray], count: int) -> Places:
    told = hashlib.blake2b(repr((count, [own.shape for own in unknowns])).encode(), digest_size=16)
    for own in unknowns:
        told.update(own.astype(np.int64).tobytes())
    found = _known.get(told.digest())
    if found is None:
        found = _known[told.digest()] = Places(unknowns, count)
    return found
