"""Element matrices with row and column indices: products with vectors, the assembled sparse matrix, and its factors."""

import hashlib
from collections import OrderedDict
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Inexact

from ..compilation.compile import jit
from .indices import accumulate
from .sparse import SparseFactors, SparsePattern

# Structures whose patterns are kept.
MOST_PATTERNS = 8

# Row indices (elements, r), column indices (elements, c) and matrices (elements, r, c).
BlockMatrices = list[tuple[Any, Any, Any]]


class ElementMatrices(NamedTuple):
    """Linearised equations of a mechanism in all its coordinates, element by element.

    Attributes:
        structural: Elements' own stiffness, in pieces by coordinates.
        curved: Stiffness from stress resultants and loads, likewise.
        damping: Likewise; empty without damping.
        mass: Likewise.
        loss: Structural stiffness times loss factors, likewise.
        constraints: Derivatives of all deformations by the coordinates, in pieces; rows of held ones are constraints.
        elastic: Stress resultants by deformations, in pieces that lie as the constraints do; zero for held ones.
        viscous: Stress resultants by rates of the deformations, likewise; empty without damping.
        lossy: Elastic times loss factors, likewise; empty unless asked for.
        free: Coordinates that move, (n,).
        held: Deformations that are held, (h,).
        sizes: Sizes of the coordinates, for scaling, (n_x,) [m, -].
        kept: One for each deformation that is not held, else zero, (n_e,).
    """

    structural: BlockMatrices
    curved: BlockMatrices
    damping: BlockMatrices
    mass: BlockMatrices
    loss: BlockMatrices
    constraints: BlockMatrices
    elastic: BlockMatrices
    viscous: BlockMatrices
    lossy: BlockMatrices
    free: Any
    held: Any
    sizes: Any
    kept: Any

    @property
    def stiffness(self) -> BlockMatrices:
        """All of the tangent: elements, stress resultants and loads."""
        return [*self.structural, *self.curved]

    @property
    def unknowns(self) -> tuple[int, int]:
        """Numbers of free coordinates and of constraints."""
        return self.free.shape[0], self.held.shape[0]


def matrix_times(pieces: BlockMatrices, vectors: Any, *, size: int) -> Any:
    """Product of a matrix in pieces with ``size`` rows, and vectors as columns; by NumPy for NumPy's arrays."""
    if not all(isinstance(array, np.ndarray) for array in (vectors, *(matrices for *_, matrices in pieces))):
        return _times(pieces, vectors, size=size)
    product = np.zeros((size, vectors.shape[1]), vectors.dtype)
    for rows, columns, matrices in pieces:
        np.add.at(product, rows, matrices @ vectors[columns])
    return product


@jit
def _times(pieces: BlockMatrices, vectors: Inexact[Array, "n k"], *, size: int) -> Inexact[Array, "size k"]:
    product: Any = jnp.zeros((size, vectors.shape[1]), vectors.dtype)
    for rows, columns, matrices in pieces:
        product = accumulate(
            product, rows, jnp.einsum("eij,ejk->eik", matrices.astype(vectors.dtype), vectors[columns])
        )
    return product


def times_transposed(pieces: BlockMatrices, vectors: Any, *, size: int) -> Any:
    """Product of the transposed matrix and vectors; see :func:`matrix_times`."""
    return matrix_times(_turned(pieces), vectors, size=size)


def _turned(element_matrices: BlockMatrices) -> BlockMatrices:
    return [(columns, rows, matrices.mT) for rows, columns, matrices in element_matrices]


def transposed(elements: ElementMatrices) -> ElementMatrices:
    """The same with everything but mass and constraints transposed; without a potential these are unsymmetric."""
    names = ("structural", "curved", "damping", "loss", "elastic", "viscous", "lossy")
    return elements._replace(**{name: _turned(getattr(elements, name)) for name in names})


def by_coordinates(constraints: BlockMatrices, pieces: BlockMatrices) -> BlockMatrices:
    """Element matrices by coordinates, D^T A D, from constraints D and matrices A by deformations, or none."""
    return [
        (columns, columns, d.mT @ a @ d) for (_, columns, d), (*_, a) in zip(constraints, pieces, strict=bool(pieces))
    ]


def quadratic_form(pieces: BlockMatrices, left: Any, right: Any) -> Any:
    """Quadratic form left^T A right, (a, b), of a matrix in pieces."""
    return left.T @ matrix_times(pieces, right, size=left.shape[0])


class SparseMatrices(NamedTuple):
    """Sparse equations of the free coordinates by NumPy: M v'' + C v' + K v + D^T m = f, D v = 0 [SI]."""

    K: Any
    C: Any
    M: Any
    D: Any


class AssembledEquations:
    """Sparse equations of the free coordinates and the multipliers, in one pattern for all matrices.

    Attributes:
        n: Number of free coordinates.
        elements: Element matrices.
    """

    def __init__(self, elements: ElementMatrices):
        """Add up element matrices, arrays of NumPy."""
        self.n, h = elements.unknowns
        self.elements = elements
        self._size = self.n + h
        self._pattern = _pattern_of(elements)
        start, data = 0, []
        for element_matrices in [*_groups(elements), _turned(elements.constraints)]:
            entries = np.concatenate([np.zeros(0), *(np.ravel(matrices) for *_, matrices in element_matrices)])
            slots = self._pattern.slots[start : start + len(entries)]
            data.append(np.bincount(slots, entries, len(self._pattern.rows) + 1)[:-1])
            start += len(entries)
        self._s, self._g, self._c, self._m, self._l = data[:5]
        self._k, self._d = self._s + self._g, data[5] + data[6]

    def _matrix(self, data: np.ndarray) -> Any:
        import scipy.sparse

        return scipy.sparse.csc_array((data, self._pattern.rows, self._pattern.columns), shape=(self._size,) * 2)

    def at(self, mass: float = 0.0, damping: float = 0.0) -> Any:
        """Matrix [[K + a M + b C, D^T], [D, 0]]."""
        data = self._k + self._d
        for factor, values in ((mass, self._m), (damping, self._c)):
            data = data + factor * values if factor else data
        return self._matrix(data)

    def at_frequency(self, s: complex) -> Any:
        """Matrix [[K + s C + s^2 M + i L, D^T], [D, 0]] at one s = i w."""
        return self._matrix(self._k + s * self._c + s**2 * self._m + 1j * self._l + self._d)

    def factors(self, matrix: Any) -> SparseFactors:
        """Factors of a matrix of this pattern, in the order of elimination that the first factors found."""
        return self._pattern.factors(matrix)

    def bordered(self, matrix: Any, border: np.ndarray) -> Any:
        """Matrix of :meth:`at` with free motions, (n, k), to which the solution is to be orthogonal."""
        import scipy.sparse

        zeros = np.zeros((self._size - self.n, border.shape[1]))
        columns = scipy.sparse.csc_array(np.concatenate([border, zeros]))
        return scipy.sparse.block_array([[matrix, columns], [columns.T, None]], format="csc")

    @property
    def structural(self) -> Any:
        """Matrix [[S, D^T], [D, 0]] of the elements' own stiffness alone."""
        return self._matrix(self._s + self._d)

    @property
    def curved(self) -> Any:
        """Stiffness of the free coordinates from stress resultants and loads, (n, n)."""
        return self._matrix(self._g)[: self.n, : self.n]

    @property
    def constraints(self) -> Any:
        """D of the free coordinates, (h, n)."""
        return self._matrix(self._d)[self.n :, : self.n]

    def independent(self) -> bool:
        """Whether the held deformations are independent, so that the multipliers are determined."""
        import scipy.sparse

        ones = (np.arange(self._size) < self.n).astype(float)
        return SparseFactors(self._matrix(self._d) + scipy.sparse.diags_array(ones)).regular

    @property
    def mass(self) -> Any:
        """M of the free coordinates, (n, n)."""
        return self._matrix(self._m)[: self.n, : self.n]

    @property
    def damping(self) -> Any:
        """C of the free coordinates, (n, n)."""
        return self._matrix(self._c)[: self.n, : self.n]

    def apart(self) -> SparseMatrices:
        """All four matrices, without stored zeros."""
        stiffness = self._matrix(self._k)[: self.n, : self.n]
        parts = SparseMatrices(stiffness, self.damping, self.mass, self.constraints)
        for matrix in parts:
            matrix.eliminate_zeros()
        return parts


def _groups(elements: ElementMatrices) -> list[BlockMatrices]:
    return [elements.structural, elements.curved, elements.damping, elements.mass, elements.loss, elements.constraints]


_known: OrderedDict[bytes, SparsePattern] = OrderedDict()


def _pattern_of(elements: ElementMatrices) -> SparsePattern:
    """Places of all entries, kept for other models whose elements join the same nodes in the same roles."""
    hasher, seen = hashlib.blake2b(digest_size=16), []
    groups = _groups(elements)
    places = [[(rows, columns) for rows, columns, _ in element_matrices] for element_matrices in groups]
    for array in (elements.free, elements.held, *(index for group in places for pair in group for index in pair)):
        # Most index arrays occur several times.
        same = next((i for i, known in enumerate(seen) if np.array_equal(known, array)), None)
        hasher.update(repr((array.shape, array.dtype, same)).encode())
        if same is None:
            hasher.update(np.ascontiguousarray(array).tobytes())
        seen.append(array)
    hasher.update(repr([len(group) for group in places]).encode())
    key = hasher.digest()
    pattern = _known.pop(key, None) or _sparse_pattern(elements, places)
    _known[key] = pattern
    if len(_known) > MOST_PATTERNS:
        _known.popitem(last=False)
    return pattern


def _sparse_pattern(elements: ElementMatrices, places: list[list[tuple[Any, Any]]]) -> SparsePattern:
    n, h = elements.unknowns
    of_x, of_e = np.full(len(elements.sizes), -1), np.full(len(elements.kept), -1)
    of_x[elements.free], of_e[elements.held] = np.arange(n), n + np.arange(h)
    inner = [(of_x[rows], of_x[columns]) for group in places[:-1] for rows, columns in group]
    rows = [(of_e[rows], of_x[columns]) for rows, columns in places[-1]]
    return SparsePattern((n + h, n + h), [*inner, *rows, *((c, r) for r, c in rows)])
