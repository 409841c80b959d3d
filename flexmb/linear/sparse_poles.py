"""Slowest poles of large mechanisms, by sparse factors and Arnoldi iterations.

With p = lambda M v beside v, the inverse of a shifted pencil maps (v, p) to (v, p)/(lambda - s): poles nearest to s are
its largest values. Motions without mass have no p, so that their poles at infinity are zeros.
"""

import contextlib
from typing import Any

import numpy as np
from jaxtyping import Complex

from ..errors import AnalysisError
from ..math.by_deformations import forces, refined_solution, softness
from ..math.element_matrices import AssembledEquations, ElementMatrices
from ..math.linear import uneven
from ..math.linear_solver import SPARSE, LinearSolver
from ..numerical_limits import FIRST_SHIFT, MASSLESS_SHARE, TRUE_POLE
from ..results import RESULTS
from ..statics.solver_choice import MANY, refuse_all
from .sparse_spectrum import FEW, GROWTH, SEARCHES, check_converged, explained_failures, orthonormal_allowed
from .spectrum import MAX_SHIFTS, any_grows, in_order, is_real, slowest

MORE = 2
# Poles sought beside known ones.
BESIDE = 4
# Largest number of restarts; converging iterations need ten.
RESTARTS = 100
# Number of eigenvalues that decide whether a state is steady.
STEADY = 8
# Iterations of the power method for the unit of time, of which the order of size counts.
TURNS = 8


class _ShiftedPoles:
    """(v, p) to (v, p)/(lambda - s), of 2 n numbers, in units in which masses and rates are about one.

    Attributes:
        shift: s [1/s].
        motions: Number of motions that constraints leave.
        regular: Whether it exists.
    """

    def __init__(self, assembled: AssembledEquations, shift: float, solver: LinearSolver):
        self.shift, self.n, self.size, self.solver = shift, assembled.n, 2 * assembled.n, solver
        self._damping, self._mass, self._elements = assembled.damping, assembled.mass, assembled.elements
        tangent = assembled.at(shift**2, shift)
        self._rest = tangent.shape[0] - assembled.n
        self.motions, self._tangent = assembled.n - self._rest, tangent
        self._factors = solver.factored(assembled.elements, mass=shift**2, damping=shift)
        self.regular = self._factors.regular
        if not self.regular:
            return
        masses, stiff = self._mass.diagonal(), np.abs(tangent.diagonal()[: self.n])
        fastest = np.max(stiff[masses > 0] / masses[masses > 0], initial=0.0) or 1.0
        # A force without mass is no p, and would not map to zero at once.
        self._heavy = masses != 0
        size = masses + stiff / fastest
        self._scale = 1 / np.sqrt(np.where(size > 0, size, np.max(size, initial=0.0) or 1.0))
        self._unit = 1.0
        sizes = self._elements.sizes[self._elements.free]
        self._soft = softness(self._factors.solve, sizes, tangent.shape[0], float)
        try:
            self._unit = 1 / (np.sqrt(self._slowness(self._mass)) + self._slowness(self._damping) or 1.0)
        except AnalysisError:
            # Round-off hides a pole next to the shift.
            self.regular = False

    def __call__(self, z: np.ndarray) -> np.ndarray:
        """Of vectors (2 n,) or (2 n, k)."""
        scale = self._scale if z.ndim == 1 else self._scale[:, None]
        heavy = self._heavy if z.ndim == 1 else self._heavy[:, None]
        v, p = scale * z[: self.n], self._unit * heavy * z[self.n :] / scale
        moved = -self._moved(p + self._damping @ v + self.shift * (self._mass @ v))
        return np.concatenate([moved / scale, scale * (self._mass @ (v + self.shift * moved)) / self._unit])

    def moved_by(self, matrix: Any, v: np.ndarray) -> np.ndarray:
        """Motions under the forces of a matrix on motions v, (n,), in these units."""
        return self._moved(matrix @ (self._scale * v)) / self._scale

    def allowed(self) -> np.ndarray:
        """Orthonormal basis of all (v, p) that constraints leave."""
        import scipy.sparse

        scale = scipy.sparse.diags_array(np.concatenate([self._scale, np.ones(self._rest)]))
        basis = orthonormal_allowed(scale @ self._tangent @ scale, self.n) if self._rest else np.eye(self.n)
        across = self._scale[:, None]
        p, sizes, _ = np.linalg.svd(across * (self._mass @ (across * basis)), full_matrices=False)
        p = p[:, sizes > MASSLESS_SHARE * self.n * np.max(sizes, initial=0.0)]
        return np.block([[basis, np.zeros((self.n, p.shape[1]))], [np.zeros_like(basis), p]])

    def _moved(self, loads: np.ndarray) -> np.ndarray:
        right = np.concatenate([loads, np.zeros((self._rest, *loads.shape[1:]))])

        def exact(z: np.ndarray):
            return forces(self._elements, z, s=self.shift)

        sizes = self._elements.sizes[self._elements.free]
        motions = refined_solution(exact, self._factors.solve, right.reshape(len(right), -1), sizes, soft=self._soft)
        return motions[: self.n].reshape(loads.shape)

    def _slowness(self, matrix: Any) -> float:
        """Norm of the shifted flexibility times a matrix."""
        size, v = 0.0, uneven(self.n)
        for _ in range(TURNS):
            v = self.moved_by(matrix, v)
            size = float(np.linalg.norm(v))
            if not size > 0:
                return 0.0
            v = v / size
        return size


def poles_of_sparse(whole: AssembledEquations, count: int, solver: LinearSolver = SPARSE) -> Complex[np.ndarray, "n"]:
    """Solutions of lambda^2 M v + lambda C v + K v + D^T m = 0, D v = 0 nearest to zero, ordered by |Im| [rad/s].

    ``count`` of them, one more if the last is one of a complex pair, fewer if there are fewer; K and C may be
    unsymmetric.

    Source:
        THEORY.md 7, eq. (7.3) and (7.20); implicitly restarted Arnoldi method of ARPACK (Lehoucq, Sorensen, Yang 1998).
    """
    at = _regular(whole, solver)
    every = 2 * at.motions
    if not every:
        return np.zeros(0, complex)
    refuse_all(count, every, "poles", 2 * MANY)
    if at.shift > 0 and whole.mass.count_nonzero() + whole.damping.count_nonzero():
        # Such a small shift leaves few digits for poles far above it.
        at = _better(at, whole, _poles_near_shift(at, count)[0])
    values, wrong = _complete(at, count)
    if wrong > TRUE_POLE:
        at = _better(at, whole, values)
        values, wrong = _complete(at, count)
    check_converged(wrong, "poles", TRUE_POLE)
    return in_order(slowest(values, count))


class _Undamped:
    """v to K^-1 M v under the constraints, in units in which masses are about one; its values are 1/w^2."""

    def __init__(self, at: _ShiftedPoles, mass: Any):
        self.size, self._at, self._mass = at.n, at, mass

    def __call__(self, v: np.ndarray) -> np.ndarray:
        """Of a vector (n,)."""
        return self._at.moved_by(self._mass, v)


def is_steady(elements: ElementMatrices) -> bool:
    """Whether the eigenvalues nearest to zero are real and positive; with damping, whether poles decay."""
    import jax

    assembled = AssembledEquations(jax.tree.map(np.asarray, elements))
    at = _ShiftedPoles(assembled, 0.0, SPARSE)
    if not at.regular:
        return False
    if assembled.damping.count_nonzero():
        with contextlib.suppress(AnalysisError):
            return not any_grows(poles_of_sparse(assembled, 2 * STEADY), 10 * TRUE_POLE)
        # Without convergence, the undamped equations decide.
        assembled = AssembledEquations(jax.tree.map(np.asarray, elements._replace(damping=[], viscous=[])))
        at = _ShiftedPoles(assembled, 0.0, SPARSE)
    if at.motions <= FEW:
        values = -(poles_of_sparse(assembled, 2 * STEADY) ** 2)
    else:
        # Without damping there are half as many values in half as many unknowns; copies do not matter.
        inverse, _ = _searched(_Undamped(at, assembled.mass), np.zeros((at.n, 0)), STEADY, 0)
        values = 1 / inverse[np.abs(inverse) > MASSLESS_SHARE * at.n * np.max(np.abs(inverse), initial=0.0)]
    return bool(np.all(is_real(values) & (np.real(values) > 0)))


def _regular(assembled: AssembledEquations, solver: LinearSolver) -> _ShiftedPoles:
    """Shifted by the smallest shift that makes it regular: zero, unless a motion meets no stiffness."""
    at = _ShiftedPoles(assembled, 0.0, solver)
    if at.regular:
        return at
    stiff = np.max(np.abs(assembled.at().diagonal()[: assembled.n]), initial=0.0) or 1.0
    heavy, viscous = (np.max(np.abs(m.diagonal()), initial=0.0) for m in (assembled.mass, assembled.damping))
    first = np.sqrt(FIRST_SHIFT * stiff / heavy) if heavy > 0 else FIRST_SHIFT * stiff / viscous if viscous > 0 else 0.0
    for i in range(MAX_SHIFTS if first > 0 else 0):
        at = _ShiftedPoles(assembled, float(first * GROWTH**i), solver)
        if at.regular:
            return at
    raise AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)


def _better(at: _ShiftedPoles, assembled: AssembledEquations, poles: np.ndarray) -> _ShiftedPoles:
    """Shifted by the slowest pole that is not zero beside the previous shift."""
    sizes = np.abs(poles)
    sizes = sizes[sizes > at.shift]
    better = _ShiftedPoles(assembled, float(np.min(sizes)), at.solver) if len(sizes) else at
    return better if better.regular else at


def _complete(at: _ShiftedPoles, count: int) -> tuple[np.ndarray, float]:
    """All poles up to some distance from zero, at least ``count`` if there are, and their largest residual."""
    every, pole_count = 2 * at.motions, min(count + MORE, 2 * at.motions)
    while True:
        poles, wrong, smallest_inverse = _poles_near_shift(at, pole_count)
        # All poles within this radius of zero are nearer to the shift than those not found.
        radius = np.inf if smallest_inverse == 0 or pole_count == every else 1 / smallest_inverse - at.shift
        sure = np.abs(poles) <= radius * (1 + TRUE_POLE)
        if np.sum(sure) >= count or pole_count == every:
            return poles[sure], float(np.max(wrong[sure], initial=0.0))
        pole_count = min(2 * pole_count, every)


def _poles_near_shift(at: _ShiftedPoles, count: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Poles nearest to the shift, residuals of their motions, and the smallest of their inverse distances."""
    every = at.motions <= FEW or 3 * count >= 2 * at.motions
    basis = at.allowed() if every else _all_copies(at, count)
    image = at(basis)
    small = basis.T @ image
    inverse, shares = np.linalg.eig(small)
    order = np.argsort(-np.abs(inverse), kind="stable")
    inverse, shares = inverse[order], shares[:, order]
    finite = np.abs(inverse) > MASSLESS_SHARE * len(basis) * np.max(np.abs(inverse), initial=0.0)
    smallest_inverse = 0.0 if np.sum(finite) < count else float(np.abs(inverse[count - 1]))
    finite &= np.abs(inverse) >= smallest_inverse
    inverse, shares = inverse[finite], shares[:, finite]
    # A basis of all motions leaves out only forces that move nothing.
    residual = 0 * basis if every else image - basis @ small
    wrong = np.linalg.norm(residual @ shares, axis=0) / np.abs(inverse)
    return at.shift + 1 / inverse, wrong, smallest_inverse


def _all_copies(at: _ShiftedPoles, count: int) -> np.ndarray:
    """Orthonormal basis of the motions of the ``count`` largest values with all copies, as in Lanczos."""
    basis, least = np.zeros((2 * at.n, 0)), 0.0
    for i in range(SEARCHES):
        values, vectors = _searched(at, basis, count if i == 0 else BESIDE, i)
        if i > 0 and np.max(np.abs(values), initial=0.0) <= least * (1 + TRUE_POLE):
            return basis
        more = np.concatenate([vectors.real, vectors.imag], axis=1)
        for _ in range(2):
            more = more - basis @ (basis.T @ more)
        left_vectors, sizes, _ = np.linalg.svd(more, full_matrices=False)
        basis = np.concatenate([basis, left_vectors[:, sizes > TRUE_POLE * np.max(sizes, initial=0.0)]], axis=1)
        sizes = np.sort(np.abs(np.linalg.eigvals(basis.T @ at(basis))))[::-1]
        least = max(sizes[min(count, len(sizes)) - 1], MASSLESS_SHARE * len(basis) * sizes[0])
    raise AnalysisError(RESULTS.not_converged.name, RESULTS.not_converged.message)


def _searched(at: _ShiftedPoles | _Undamped, basis: np.ndarray, count: int, number: int) -> tuple[Any, Any]:
    """Largest values and vectors outside a basis of known ones."""
    import scipy.sparse.linalg

    linalg: Any = scipy.sparse.linalg

    def beside(z: np.ndarray):
        z = np.ravel(z)
        z = at(z - basis @ (basis.T @ z))
        return z - basis @ (basis.T @ z)

    operator = linalg.LinearOperator((at.size, at.size), matvec=beside, dtype=float)
    # No mechanism has a mode orthogonal to these uneven entries.
    start = beside(at(at(np.cos((number + 1) * np.arange(at.size) ** 2 + number))))
    if not np.linalg.norm(start) > 0:
        return np.zeros(0), np.zeros((at.size, 0))
    how = {"k": count, "v0": start / np.linalg.norm(start), "tol": TRUE_POLE * 1e-4, "maxiter": RESTARTS}
    with explained_failures():
        try:
            return linalg.eigs(operator, **how)
        except linalg.ArpackNoConvergence as fault:
            # Round-off may keep the last digits from settling; residuals are checked later.
            if len(fault.eigenvalues) < count:
                raise
            return fault.eigenvalues, fault.eigenvectors
