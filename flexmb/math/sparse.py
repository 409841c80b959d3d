"""Sparse matrices whose pattern is found once, and their factors, on the host."""

import contextlib
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from ..errors import AnalysisError
from ..results import RESULTS
from .dissection import dissected
from .linear import uneven

# Where `sparse` is left out, mechanisms of so many coordinates and more are solved by sparse factors. Static loads on a
# rack take as long by dense matrices at 170 coordinates, four times as long at 270, twenty-five times at 500.
LARGE = 300
# Pivots this much smaller than the largest, of a matrix scaled to entries of one, are round-off.
SINGULAR = 1e-14
# A diagonal entry is a pivot where it is this share of the largest in its column. It may be small where stiffnesses are
# far apart; rows that change places would fill the factors.
DIAGONAL = 1e-8
# What a solution leaves, beside the matrix times it and the right-hand side; where more is left, rows change places.
BACKWARD = 1e-10
# Stiffness of its own, of the largest, that every coordinate has where factors stand beside those of what is singular.
BESIDE = 1e-13
# How much stiffer than all else constraints are that springs stand for: critical values change by its inverse.
FIRM = 1e4
# Rounds that make the entries of a matrix alike.
ROUNDS = 8
# Another order of elimination is looked for at so many factors of one pattern, where they have so many entries for each
# unknown: of a mesh of 1000 planar beams it is found in 0.09 s, and factors then take 8 ms in place of 21.
OFTEN, FULL = 3, 64
_host = ThreadPoolExecutor(1)


def on_host_thread(function: Callable[..., Any], *arguments: Any) -> Any:
    """Result of a function that factors, called by compiled code, which calls the host in any thread.

    SciPy's SuperLU gives memory back in the thread alone that took it: all such functions run in one, one after the
    other. They do not call each other through this.

    Args:
        function: Function that calls nothing of JAX.
        arguments: Its arguments, arrays those of NumPy.
    """
    return _host.submit(function, *arguments).result()


class SparsePattern:
    """Where the entries of element matrices lie in a sparse matrix of the whole, found once for a structure.

    Attributes:
        size: Shape of the whole.
        slots: For each entry of the element matrices, one piece after the other, its number among the stored entries of
            the whole; that of those left out is one beyond the last.
        columns: Where each column begins among the stored entries, (size[1] + 1,).
        rows: Row of each stored entry, (stored,).
        ordering: Order of elimination, (size[1],), once a square matrix has been factored.
    """

    def __init__(self, size: tuple[int, int], places: Sequence[tuple[Any, Any]]):
        """Find the pattern.

        Args:
            size: Shape of the whole.
            places: Of each piece, row indices (elements, r) and column indices (elements, c); entries with a negative
                index are left out.
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
        """Stored entries of the sum of element matrices, (stored,).

        Args:
            pieces: Matrices (elements, r, c), as the pattern was told of.
        """
        flat = [np.asarray(matrices).ravel() for matrices in pieces]
        given: Any = np.concatenate(flat) if flat else np.zeros(0)
        parts = (given.real, given.imag) if np.iscomplexobj(given) else (given,)
        real, *imag = (np.bincount(self.slots, part, len(self.rows) + 1)[: len(self.rows)] for part in parts)
        return real + 1j * imag[0] if imag else real

    def matrix(self, pieces: Sequence[Any]) -> Any:
        """Sum of element matrices, sparse by columns; arguments as for :meth:`entries`."""
        import scipy.sparse

        return scipy.sparse.csc_array((self.entries(pieces), self.rows, self.columns), shape=self.size)

    def factors(self, matrix: Any) -> "SparseFactors":
        """Factors of a square matrix of this pattern, in the order of elimination that the first of them found.

        Those of the last matrix are kept: a derivative asks for them again.
        """
        last, data = self._last, matrix.data
        # Complex ones of equal numbers are others: they solve for complex right-hand sides.
        if last is None or last[0].dtype != data.dtype or not np.array_equal(last[0], data):
            last = self._last = matrix.data, self.factored(matrix)
        return last[1]

    def factored(self, matrix: Any) -> "SparseFactors":
        """As :meth:`factors`, and none kept; of a pattern that comes often, in an order that fills less, if any.

        Args:
            matrix: As of :meth:`matrix`, with all entries of the pattern where it has them.
        """
        # Another thread may find another one meanwhile.
        ordering = self.ordering
        factors = SparseFactors(self._ordered(matrix, ordering), ordering, ordered=True)
        self._times += 1
        if self._times == OFTEN and not factors.by_rows and factors.fill > FULL * self.size[0]:
            # What memory does not suffice for is no better.
            with contextlib.suppress(AnalysisError, MemoryError):
                other = SparseFactors(matrix, dissected(matrix))
                if other.regular and not other.by_rows and other.fill < factors.fill:
                    factors = other
        self.ordering = factors.ordering
        return factors

    def _ordered(self, matrix: Any, ordering: np.ndarray | None) -> Any:
        """Matrix with rows and columns in an order of elimination, whose places are found once for an order."""
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
        taken, rows, columns = places
        return scipy.sparse.csc_array((matrix.data[taken], rows, columns), shape=self.size)


class SparseFactors:
    """Sparse factors of a matrix of symmetric pattern, rows and columns scaled alike.

    Attributes:
        ordering: The order of elimination, (n,), or None where the matrix is singular and none was given.
        regular: Whether the factors can be trusted.
        by_diagonal: Whether they can because entries of the diagonal were made one, see :func:`equilibrating`.
        by_rows: Whether rows may have changed places.
        negative: Number of negative eigenvalues of a symmetric matrix; None where rows changed places, so that pivots
            tell no sign.

    Source:
        Sylvester's law of inertia, for the negative pivots on the diagonal.
    """

    def __init__(
        self, matrix: Any, ordering: np.ndarray | None = None, on_diagonal: bool = False, ordered: bool = False
    ):
        """Factor a matrix.

        Args:
            matrix: Square, sparse.
            ordering: Order of elimination, such as that of the factors of a matrix of the same pattern, (n,); None:
                one is found by minimum degree, of columns alone where the diagonal has zeros.
            on_diagonal: Whether pivots are looked for on a diagonal with zeros too: multipliers come after what they
                constrain in the ordering.
            ordered: Whether rows and columns of the matrix stand in the ordering already.

        Raises:
            AnalysisError: out_of_memory.
        """
        import scipy.sparse

        matrix = matrix if isinstance(matrix, scipy.sparse.csc_array) else scipy.sparse.csc_array(matrix)
        matrix = matrix if ordered or ordering is None else matrix[ordering][:, ordering]
        # SuperLU would sort the indices below, and not these entries.
        matrix.sort_indices()
        largest = np.zeros(matrix.shape[0])
        with np.errstate(invalid="ignore"):
            np.maximum.at(largest, matrix.indices, np.abs(matrix.data))
        largest = np.sqrt(largest)
        self._order, self.ordering = ordering, ordering
        self.regular = self._scaled(matrix, 1 / np.where(largest > 0, largest, 1.0), on_diagonal)
        self.by_diagonal = False
        if not self.regular and np.all(np.isfinite(matrix.data)):
            # One round of scaling leaves rigid bodies and stiff beams in small units far apart; and all rounds the
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
        """Factor a matrix whose rows and columns are multiplied by a scale; whether the factors can be trusted."""
        import scipy.sparse

        self._scale = scale
        self._factors: Any = None
        # Not as a product of sparse matrices, which drops entries that are zero here and may not be in the next matrix.
        columns = np.repeat(scale, np.diff(matrix.indptr))
        data = matrix.data * scale[matrix.indices] * columns
        self._matrix = scipy.sparse.csc_array((data, matrix.indices, matrix.indptr), shape=matrix.shape)
        # Of multipliers the diagonal is zero. Rows that change places meanwhile fill an order that counts on
        # the diagonal: a mesh of 1900 spatial beams takes 4.4 s, in an order of columns 0.1 s.
        self.by_rows = not on_diagonal and bool(np.any(matrix.diagonal() == 0))
        by = "COLAMD" if self.by_rows else "MMD_AT_PLUS_A"
        if not self._factor(by if self._order is None else "NATURAL"):
            return False
        if self._order is None:
            self.ordering = np.argsort(self._factors.perm_c)
        # Small pivots on the diagonal make others large.
        return self._with_good_pivots() or (self._change_rows() and self._with_good_pivots())

    @property
    def fill(self) -> int:
        """Number of entries of the factors."""
        return self._factors.nnz if self._factors is not None else 0

    @property
    def sign(self) -> int:
        """Sign of the determinant of a regular matrix, symmetric or not: that of its pivots, and of all exchanges."""
        odd = int(np.sum(self._pivots < 0)) + sum(
            _exchanges(order) for order in (self._factors.perm_r, self._factors.perm_c)
        )
        return -1 if odd % 2 else 1

    def _with_good_pivots(self) -> bool:
        sizes = np.abs(self._pivots)
        return bool(np.all(np.isfinite(sizes)) and np.min(sizes, initial=1.0) > SINGULAR * np.max(sizes, initial=0.0))

    def _change_rows(self) -> bool:
        """Factor once more, each pivot the largest in its column; whether that is new and succeeded."""
        if self.by_rows:
            return False
        self.by_rows = True
        return self._factor("COLAMD")

    def _factor(self, by: str) -> bool:
        """Factor the scaled matrix, its columns ordered as SuperLU calls it; whether it succeeded."""
        import scipy.sparse.linalg

        how: dict[str, Any] = {"diag_pivot_thresh": DIAGONAL, "options": {"SymmetricMode": True}}
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
        """Solution of A z = right, (n,) or (n, cases), with one step of refinement.

        Args:
            right: Right-hand sides, (n,) or (n, cases).
            transposed: Whether of A^T z = right.
        """
        found, fits = self.answer(right, transposed)
        return found if fits or not self._change_rows() else self.solve(right, transposed)

    def answer(self, right: np.ndarray, transposed: bool = False, refine: bool = True) -> tuple[np.ndarray, bool]:
        """As :meth:`solve`, by these factors as they are, and whether the solution fits.

        Args:
            right: Right-hand sides, (n,) or (n, cases).
            transposed: Whether of A^T z = right.
            refine: Whether it is corrected once, for as much time again; corrections by Newton need not be.
        """
        right = np.asarray(right)
        scale = self._scale if right.ndim == 1 else self._scale[:, None]
        matrix, way = (self._matrix.T, "T") if transposed else (self._matrix, "N")
        wanted = scale * (right if self._order is None else right[self._order])
        z = self._factors.solve(wanted, way)
        rest = wanted - matrix @ z
        if refine:
            z = z + self._factors.solve(rest, way)
            rest = wanted - matrix @ z
        left = np.max(np.abs(rest), initial=0.0)
        beside = np.max(np.abs(z), initial=0.0) + np.max(np.abs(wanted), initial=0.0)
        z = scale * z
        if self._order is not None:
            whole = np.empty_like(z)
            whole[self._order] = z
            z = whole
        return z, bool(left <= BACKWARD * beside)


def unresisted(tangent: Any, n: int) -> np.ndarray | None:
    """A motion that a singular [[K, D^T], [D, 0]] does not resist, the largest entry 1; None where D repeats itself.

    Args:
        tangent: Sparse, (n + h, n + h).
        n: Size of K.

    Source:
        Inverse iterations beside it, where every motion meets a share BESIDE of the largest stiffness.
    """
    import scipy.sparse

    some = np.zeros(tangent.shape[0])
    some[:n] = BESIDE * (np.max(np.abs(tangent.diagonal()[:n]), initial=0.0) or 1.0)
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
    """Number of exchanges of two that make a permutation: of each cycle one less than are in it."""
    import scipy.sparse
    from scipy.sparse.csgraph import connected_components

    n = len(order)
    moves = scipy.sparse.csr_array((np.ones(n), (np.arange(n), order)), shape=(n, n))
    return n - int(connected_components(moves, directed=False, return_labels=False))


def equilibrating(matrix: Any, by_diagonal: bool = False) -> np.ndarray:
    """Factors of rows and columns of a symmetric matrix, by which the largest entry of each becomes about one.

    Args:
        matrix: Sparse.
        by_diagonal: Whether entries of the diagonal become one, where there are any, and only the other rows are made
            alike: where stiffnesses are far below the constraints beside them, their share would be lost in round-off.

    Source:
        Ruiz (2001), A scaling algorithm to equilibrate both rows and columns norms in matrices, RAL-TR-2001-034.
    """
    coordinates = matrix.tocoo()
    (rows, columns), sizes = coordinates.coords, np.abs(coordinates.data)
    diagonal = np.abs(matrix.diagonal()) if by_diagonal else np.zeros(matrix.shape[0])
    kept = diagonal > 0
    scale = 1 / np.sqrt(np.where(kept, diagonal, 1.0))
    for _ in range(ROUNDS):
        largest = np.zeros(len(scale))
        np.maximum.at(largest, rows, sizes * scale[rows] * scale[columns])
        scale = scale / np.sqrt(np.where((largest > 0) & ~kept, largest, 1.0))
    return scale


def negative_where_held(tangent: Any, factored: SparseFactors, n: int) -> int | None:
    """Number of negative eigenvalues of a symmetric K where constraints D v = 0 hold; None where pivots do not tell it.

    Args:
        tangent: Sparse, regular [[K, D^T], [D, 0]], (n + h, n + h).
        factored: Its factors.
        n: Size of K.

    Source:
        Sylvester's law of inertia: with h constraints there are h negative pivots more than there are such eigenvalues.
        Where rows change places in the factors: [[K + g D^T D, t D^T], [t D, 0]] is congruent to [[K, D^T], [D, 0]], as
        adding g/2 D^T times the last rows to the first ones shows, and the same for columns. Coordinates that only
        constraints hold have a stiffness in it, and where the largest entry of each row has been made one all entries
        are alike, whatever the units, with g = t = 1. Multipliers are
        eliminated after all that they constrain. Where rows change places there too: K + g D^T D, which has so many
        negative eigenvalues at least, and no more for a g large enough (Finsler's lemma).
    """
    import scipy.sparse

    rest, order = tangent.shape[0] - n, factored.ordering
    if factored.negative is not None:
        return factored.negative - rest
    if order is None or rest == 0:
        return None
    alike = scipy.sparse.diags_array(equilibrating(tangent, factored.by_diagonal))
    tangent = (alike @ tangent @ alike).tocsc()
    stiffness, rows = tangent[:n, :n], tangent[n:, :n]
    stiff = rows.T @ rows
    whole = scipy.sparse.block_array([[stiffness + stiff, rows.T], [rows, None]]).tocsc()
    place = np.empty(len(order))
    place[order] = np.arange(len(order))
    joined = rows.tocoo()
    of, columns = joined.coords
    np.maximum.at(place, n + of, place[columns] + 0.5)
    negative = SparseFactors(whole, np.argsort(place, kind="stable"), on_diagonal=True).negative
    return SparseFactors(stiffness + FIRM * stiff).negative if negative is None else negative - rest
