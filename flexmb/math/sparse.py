"""Sparse matrices whose pattern is found once, and their factors, by SciPy on the host."""

import contextlib
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from ..errors import AnalysisError
from ..numerical_limits import BACKWARD_ERROR, DIAGONAL_PIVOT, NEGLIGIBLE_PIVOT, SUPPORTED
from ..results import RESULTS
from .dissection import dissected
from .linear import uneven

# Stiffness of the springs that replace constraints, over the largest other stiffness: critical values change by the
# inverse.
FIRM = 1e4
# Rounds of equilibration of a matrix.
ROUNDS = 8
# Another order of elimination is tried at the third factorisation of one pattern, if factors have more entries per
# unknown than this: for a mesh of 1000 planar beams this takes 0.09 s and cuts factors from 21 to 8 ms.
OFTEN, FULL = 3, 64
_host = ThreadPoolExecutor(1)


def on_host_thread(function: Callable[..., Any], *arguments: Any) -> Any:
    """Result of a function that factors and calls nothing of JAX, run in the one thread of the host.

    Compiled code calls the host in any thread, but SciPy's SuperLU frees memory only in the thread that allocated it.
    Such functions must not call each other through this one.
    """
    return _host.submit(function, *arguments).result()


class SparsePattern:
    """Places of the entries of element matrices in a sparse matrix, found once for a structure.

    Attributes:
        size: Shape of the sparse matrix.
        slots: For each entry of the element matrices, piece after piece, its number among the stored entries; entries
            that are left out have the number one past the last.
        columns: Start of each column among the stored entries, (size[1] + 1,).
        rows: Row of each stored entry, (stored,).
        ordering: Order of elimination, (size[1],), once a square matrix has been factored.
    """

    def __init__(self, size: tuple[int, int], places: Sequence[tuple[Any, Any]]):
        """Find the pattern from row indices (elements, r) and column indices (elements, c) of each piece.

        Entries with a negative index are left out.
        """
        keys = [np.zeros(0, np.int64)]
        for rows, columns in places:
            r, c = (np.asarray(indices, np.int64) for indices in (rows, columns))
            key = c[:, None, :] * size[0] + r[:, :, None]
            keys.append(np.where((c[:, None, :] < 0) | (r[:, :, None] < 0), -1, key).ravel())
        stored, slots = np.unique(np.concatenate(keys), return_inverse=True)
        if len(stored) and stored[0] < 0:
            stored, slots = stored[1:], np.where(slots == 0, len(stored) - 1, slots - 1)
        self.size = size
        self.slots = slots.astype(np.int32)
        self.rows = (stored % max(size[0], 1)).astype(np.int32)
        self.columns = np.searchsorted(stored, np.arange(size[1] + 1) * size[0]).astype(np.int32)
        self.ordering: np.ndarray | None = None
        self._last: tuple[np.ndarray, SparseFactors] | None = None
        self._times = 0
        self._places: tuple[Any, ...] = (None,)

    def entries(self, pieces: Sequence[Any]) -> np.ndarray:
        """Stored entries of the sum of element matrices, (elements, r, c) in the order of ``places``."""
        flat = [np.asarray(matrices).ravel() for matrices in pieces]
        values: Any = np.concatenate(flat) if flat else np.zeros(0)
        parts = (values.real, values.imag) if np.iscomplexobj(values) else (values,)
        real, *imag = (np.bincount(self.slots, part, len(self.rows) + 1)[: len(self.rows)] for part in parts)
        return real + 1j * imag[0] if imag else real

    def matrix(self, pieces: Sequence[Any]) -> Any:
        """Sum of element matrices, sparse by columns; see :meth:`entries`."""
        import scipy.sparse

        return scipy.sparse.csc_array((self.entries(pieces), self.rows, self.columns), shape=self.size)

    def factors(self, matrix: Any) -> "SparseFactors":
        """Factors of a square matrix of this pattern. The last factors are stored, since derivatives use them again."""
        last, data = self._last, matrix.data
        # Complex matrices of equal numbers differ: they solve for complex right-hand sides.
        if last is None or last[0].dtype != data.dtype or not np.array_equal(last[0], data):
            last = self._last = matrix.data, self.factored(matrix)
        return last[1]

    def factored(self, matrix: Any) -> "SparseFactors":
        """Factors of a square matrix of this pattern, in the known order of elimination or a better one."""
        # Another thread may meanwhile find another ordering.
        ordering = self.ordering
        factors = SparseFactors(self._ordered(matrix, ordering), ordering, ordered=True)
        self._times += 1
        if self._times == OFTEN and not factors.by_rows and factors.fill > FULL * self.size[0]:
            # An order that exceeds the memory is no better.
            with contextlib.suppress(AnalysisError, MemoryError):
                other = SparseFactors(matrix, dissected(matrix))
                if other.regular and not other.by_rows and other.fill < factors.fill:
                    factors = other
        self.ordering = factors.ordering
        return factors

    def _ordered(self, matrix: Any, ordering: np.ndarray | None) -> Any:
        """Matrix in an order of elimination; the permutation of its entries is found once per order."""
        import scipy.sparse

        if ordering is None:
            return matrix
        known, *places = self._places
        if known is not ordering:
            numbers = np.arange(1, len(self.rows) + 1)
            numbered = scipy.sparse.csc_array((numbers, self.rows, self.columns), shape=self.size)
            numbered = numbered[ordering][:, ordering]
            numbered.sort_indices()
            places = [numbered.data - 1, numbered.indices, numbered.indptr]
            self._places = ordering, *places
        permutation, rows, columns = places
        return scipy.sparse.csc_array((matrix.data[permutation], rows, columns), shape=self.size)


class SparseFactors:
    """Sparse factors of a matrix of symmetric pattern, with the same scale for rows and columns.

    Attributes:
        ordering: Order of elimination, (n,), or None for a singular matrix without a given order.
        regular: Whether the factors can be trusted.
        by_diagonal: Whether this needed unit entries on the diagonal, see :func:`equilibrating`.
        by_rows: Whether rows may have changed places.
        negative: Number of negative eigenvalues of a symmetric matrix, by Sylvester's law of inertia; None if rows
            changed places.
    """

    def __init__(
        self, matrix: Any, ordering: np.ndarray | None = None, on_diagonal: bool = False, ordered: bool = False
    ):
        """Factor a square sparse matrix.

        Args:
            ordering: Order of elimination; None: found by minimum degree, by columns alone if the diagonal has zeros.
            on_diagonal: Whether to take pivots from a diagonal with zeros too: in the ordering, multipliers follow the
                coordinates that they constrain.
            ordered: Whether the matrix is already in this order.

        Raises:
            AnalysisError: out_of_memory.
        """
        import scipy.sparse

        matrix = matrix if isinstance(matrix, scipy.sparse.csc_array) else scipy.sparse.csc_array(matrix)
        matrix = matrix if ordered or ordering is None else matrix[ordering][:, ordering]
        # SuperLU would sort the indices later, without these entries.
        matrix.sort_indices()
        largest = np.zeros(matrix.shape[0])
        with np.errstate(invalid="ignore"):
            np.maximum.at(largest, matrix.indices, np.abs(matrix.data))
        largest = np.sqrt(largest)
        self._order, self.ordering = ordering, ordering
        self.regular = self._scaled(matrix, 1 / np.where(largest > 0, largest, 1.0), on_diagonal)
        self.by_diagonal = False
        if not self.regular and np.all(np.isfinite(matrix.data)):
            # One round of scaling leaves rigid bodies and stiff beams in small units far apart. All rounds leave the
            # stiffnesses of a mechanism of micrometres far below its constraints.
            for self.by_diagonal in (False, True):
                self.regular = self._scaled(matrix, equilibrating(matrix, self.by_diagonal), on_diagonal)
                if self.regular:
                    break
            self.by_diagonal = self.by_diagonal and self.regular
        self.negative: int | None = None
        if self._factors is not None and np.array_equal(self._factors.perm_r, self._factors.perm_c):
            self.negative = int(np.sum(self._pivots < 0))

    def _scaled(self, matrix: Any, scale: np.ndarray, on_diagonal: bool) -> bool:
        """Factor a matrix with scaled rows and columns; whether the factors can be trusted."""
        import scipy.sparse

        self._scale = scale
        self._factors: Any = None
        # A product of sparse matrices would drop entries that are zero here and may not be in the next matrix.
        columns = np.repeat(scale, np.diff(matrix.indptr))
        data = matrix.data * scale[matrix.indices] * columns
        self._matrix = scipy.sparse.csc_array((data, matrix.indices, matrix.indptr), shape=matrix.shape)
        # Multipliers have a zero diagonal. Rows that change places fill the factors in an order made for the diagonal:
        # a mesh of 1900 spatial beams takes 4.4 s, in an order of columns 0.1 s.
        self.by_rows = not on_diagonal and bool(np.any(matrix.diagonal() == 0))
        by = "COLAMD" if self.by_rows else "MMD_AT_PLUS_A"
        if not self._factor(by if self._order is None else "NATURAL"):
            return False
        if self._order is None:
            self.ordering = np.argsort(self._factors.perm_c)
        # Small pivots on the diagonal make other entries large.
        return self._with_good_pivots() or (self._change_rows() and self._with_good_pivots())

    @property
    def fill(self) -> int:
        """Number of entries of the factors."""
        return self._factors.nnz if self._factors is not None else 0

    @property
    def sign(self) -> int:
        """Sign of the determinant of a regular matrix, from its pivots and the exchanges of rows and columns."""
        odd = int(np.sum(self._pivots < 0)) + sum(
            _exchanges(order) for order in (self._factors.perm_r, self._factors.perm_c)
        )
        return -1 if odd % 2 else 1

    def _with_good_pivots(self) -> bool:
        sizes = np.abs(self._pivots)
        return bool(
            np.all(np.isfinite(sizes)) and np.min(sizes, initial=1.0) > NEGLIGIBLE_PIVOT * np.max(sizes, initial=0.0)
        )

    def _change_rows(self) -> bool:
        """Factor again with the largest pivot of each column, unless already done; whether it succeeded."""
        if self.by_rows:
            return False
        self.by_rows = True
        return self._factor("COLAMD")

    def _factor(self, by: str) -> bool:
        """Factor the scaled matrix in an order of columns that SuperLU names; whether it succeeded."""
        import scipy.sparse.linalg

        how: dict[str, Any] = {"diag_pivot_thresh": DIAGONAL_PIVOT, "options": {"SymmetricMode": True}}
        how = {} if self.by_rows else how
        try:
            self._factors = scipy.sparse.linalg.splu(self._matrix, permc_spec=by, **how)
        except MemoryError:
            raise AnalysisError(RESULTS.out_of_memory.name, RESULTS.out_of_memory.message) from None
        except RuntimeError:
            # Exactly singular.
            return False
        self._pivots = self._factors.U.diagonal()
        return True

    def solve(self, right: np.ndarray, transposed: bool = False) -> np.ndarray:
        """Solution of A z = right, or A^T z = right, (n,) or (n, cases), with one step of refinement."""
        solution, fits = self.answer(right, transposed)
        return solution if fits or not self._change_rows() else self.solve(right, transposed)

    def answer(self, right: np.ndarray, transposed: bool = False, refine: bool = True) -> tuple[np.ndarray, bool]:
        """As :meth:`solve`, without new factors, and whether the solution fits; ``refine`` doubles the time."""
        right = np.asarray(right)
        scale = self._scale if right.ndim == 1 else self._scale[:, None]
        matrix, way = (self._matrix.T, "T") if transposed else (self._matrix, "N")
        right_side = scale * (right if self._order is None else right[self._order])
        z = self._factors.solve(right_side, way)
        residual = right_side - matrix @ z
        if refine:
            z = z + self._factors.solve(residual, way)
            residual = right_side - matrix @ z
        largest_residual = np.max(np.abs(residual), initial=0.0)
        beside = np.max(np.abs(z), initial=0.0) + np.max(np.abs(right_side), initial=0.0)
        z = scale * z
        if self._order is not None:
            unordered = np.empty_like(z)
            unordered[self._order] = z
            z = unordered
        return z, bool(largest_residual <= BACKWARD_ERROR * beside)


def unresisted(tangent: Any, n: int) -> np.ndarray | None:
    """A motion (largest entry 1) without stiffness in a singular [[K, D^T], [D, 0]]; None if D is redundant.

    Source:
        Inverse iterations with springs of a negligible stiffness at every coordinate.
    """
    import scipy.sparse

    some = np.zeros(tangent.shape[0])
    some[:n] = SUPPORTED * (np.max(np.abs(tangent.diagonal()[:n]), initial=0.0) or 1.0)
    factored = SparseFactors((tangent + scipy.sparse.diags_array(some)).tocsc())
    if not factored.regular:
        return None
    z = uneven(tangent.shape[0])
    for _ in range(5):
        z[n:] = 0.0
        z = factored.solve(z)
        z /= z[np.argmax(np.abs(z[:n]))]
    return z[:n]


def _exchanges(order: np.ndarray) -> int:
    """Number of exchanges that make a permutation: the length of each cycle less one."""
    import scipy.sparse
    from scipy.sparse.csgraph import connected_components

    n = len(order)
    moves = scipy.sparse.csr_array((np.ones(n), (np.arange(n), order)), shape=(n, n))
    return n - int(connected_components(moves, directed=False, return_labels=False))


def equilibrating(matrix: Any, by_diagonal: bool = False) -> np.ndarray:
    """Scale of rows and columns of a symmetric sparse matrix that makes the largest entry of each about one.

    With ``by_diagonal``, nonzero entries of the diagonal become one and only the other rows are balanced: stiffnesses
    far below neighbouring constraints would be lost in round-off.

    Source:
        Ruiz (2001), A scaling algorithm to equilibrate both rows and columns norms in matrices, RAL-TR-2001-034.
    """
    coordinates = matrix.tocoo()
    (rows, columns), sizes = coordinates.coords, np.abs(coordinates.data)
    diagonal = np.abs(matrix.diagonal()) if by_diagonal else np.zeros(matrix.shape[0])
    positive = diagonal > 0
    scale = 1 / np.sqrt(np.where(positive, diagonal, 1.0))
    for _ in range(ROUNDS):
        largest = np.zeros(len(scale))
        np.maximum.at(largest, rows, sizes * scale[rows] * scale[columns])
        scale = scale / np.sqrt(np.where((largest > 0) & ~positive, largest, 1.0))
    return scale


def negative_under_constraints(tangent: Any, factored: SparseFactors, n: int) -> int | None:
    """Number of negative eigenvalues of a symmetric K subject to D v = 0; None if pivots do not determine it.

    Args:
        tangent: Sparse, regular [[K, D^T], [D, 0]], (n + h, n + h).
        factored: Its factors.
        n: Size of K.

    Source:
        Sylvester's law of inertia: h constraints add h negative pivots. If rows change places:
        [[K + g D^T D, t D^T], [t D, 0]] is congruent to [[K, D^T], [D, 0]], since adding g/2 D^T times the last rows to
        the first ones, and likewise for columns, turns one into the other. It gives stiffness to coordinates that only
        constraints hold. With the largest entry of each row scaled to one, g = t = 1 suits any units. Multipliers are
        eliminated after all that they constrain. If rows change places there too: K + g D^T D has at least as many
        negative eigenvalues, and equally many for g large enough (Finsler's lemma).
    """
    import scipy.sparse

    n_constraints, order = tangent.shape[0] - n, factored.ordering
    if factored.negative is not None:
        return factored.negative - n_constraints
    if order is None or n_constraints == 0:
        return None
    alike = scipy.sparse.diags_array(equilibrating(tangent, factored.by_diagonal))
    tangent = (alike @ tangent @ alike).tocsc()
    stiffness, rows = tangent[:n, :n], tangent[n:, :n]
    stiff = rows.T @ rows
    bordered = scipy.sparse.block_array([[stiffness + stiff, rows.T], [rows, None]]).tocsc()
    place = np.empty(len(order))
    place[order] = np.arange(len(order))
    joined = rows.tocoo()
    constraint, columns = joined.coords
    np.maximum.at(place, n + constraint, place[columns] + 0.5)
    negative = SparseFactors(bordered, np.argsort(place, kind="stable"), on_diagonal=True).negative
    return SparseFactors(stiffness + FIRM * stiff).negative if negative is None else negative - n_constraints
