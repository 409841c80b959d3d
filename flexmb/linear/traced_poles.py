"""Poles of traced numbers, computed on the host, with derivatives from left and right vectors."""

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float, Int

from ..compilation.host import call_host
from ..errors import AnalysisError
from ..math.by_deformations import saddle_product
from ..math.element_matrices import AssembledEquations, ElementMatrices
from ..math.linear import uneven, unit_scale
from ..numerical_limits import (
    BESIDE_POLE,
    FREE_STIFFNESS,
    MEETING_POLES,
    REPEATED_EIGENVALUE,
    SEMIDEFINITE,
    SOLVED_BY_VECTOR,
)
from ..results import RESULTS
from .sparse_poles import poles_of_sparse
from .sparse_solve import NOTHING, call_on_host
from .sparse_spectrum import refuse_negative_masses
from .spectrum import masses_of_motions, poles_of

# Iterations for the vectors of a pole.
TURNS = 3


def _differentiable(find: Callable[[Any, Any], Any], balance: Callable[..., Any]) -> Callable[[Any, Any], Any]:
    """Poles of equations, with first derivatives, and a code; the length of the second argument is their number.

    Args:
        find: Poles, code, left and right vectors for which w^H (2 s M + C) v = 1.
        balance: w^H (s^2 M + s C + K) v of equations, poles, left and right vectors.
    """

    @jax.custom_jvp
    def with_vectors(equations: Any, count: Array):
        return find(equations, count)

    @with_vectors.defjvp
    def _refused(*_: Any) -> Any:
        raise NotImplementedError(
            "Poles have first derivatives, and no second ones. Leave out second_order, or jax.hessian."
        )

    @jax.custom_jvp
    def poles(equations: Any, count: Array):
        return with_vectors(equations, count)[:2]

    @poles.defjvp
    def _changes(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
        values, code, left_vectors, right_vectors = with_vectors(*primals)
        _, change = jax.jvp(
            lambda matrices: balance(matrices, values, left_vectors, right_vectors), (primals[0],), (tangents[0],)
        )
        return (values, code), (-change, np.zeros((), jax.dtypes.float0))

    return poles


def traced_poles(
    k: Float[Array, "n n"], c: Float[Array, "n n"], m: Float[Array, "n n"], count: int
) -> tuple[Complex[Array, "count"], Int[Array, ""]]:
    """The ``count`` poles nearest to zero, differentiable (THEORY.md 10, eq. (10.4)), and a code of RESULTS.

    Ordered by |Im| [rad/s], NaN if there are fewer. Derivatives are NaN for poles that meet with one vector, as in
    critical damping or of a free motion; for a repeated pole, sums over its copies have correct derivatives. Codes:
    not_finite; singular_mass: fewer poles, or a negative mass; singular_stiffness: a motion without mass, stiffness and
    damping.
    """
    # The number is a shape, which stays known under a trace.
    return _of_matrices((k, c, m), np.zeros(count))


def _poles_on_host(matrices: Any, count: Array) -> Any:
    k, n = count.shape[0], len(matrices[0])
    vectors = jax.ShapeDtypeStruct((k, n), complex)
    like = jax.ShapeDtypeStruct((k,), complex), jax.ShapeDtypeStruct((), np.int32), vectors, vectors
    return call_host(functools.partial(_with_vectors, count=k), like, *matrices)


def _balance(matrices: Any, values: Any, left_vectors: Any, right_vectors: Any) -> Any:
    k, c, m = (
        jnp.einsum("in,nm,im->i", jnp.conj(left_vectors), matrix.astype(complex), right_vectors) for matrix in matrices
    )
    return k + values * c + values**2 * m


_of_matrices = _differentiable(_poles_on_host, _balance)


def _with_vectors(k: Any, c: Any, m: Any, *, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Poles, a code, and their left and right vectors, each a row, for which w^H (2 lambda M + C) v = 1."""
    k, c, m = map(np.asarray, (k, c, m))
    values = np.full(count, NOTHING)
    left_vectors, right_vectors = (np.full((count, len(k)), NOTHING) for _ in range(2))
    code = RESULTS.successful if np.all(np.isfinite([k, c, m])) else RESULTS.not_finite
    if code is RESULTS.successful:
        every = poles_of(k, c, m)
        # Those nearest to zero, in their order.
        nearest = np.sort(np.argsort(np.abs(every), kind="stable")[:count])
        values[: len(nearest)] = every[nearest]
        for place, pole in enumerate(nearest):
            left_vectors[place], right_vectors[place] = _vectors(k, c, m, every, int(pole))
        if len(nearest) < count or (len(m) and masses_of_motions(m)[0][0] < -SEMIDEFINITE):
            code = RESULTS.singular_mass
        elif _is_undetermined(k, c, m, every):
            code = RESULTS.singular_stiffness
    return values, np.array(code, np.int32), left_vectors, right_vectors


def _is_undetermined(k: np.ndarray, c: np.ndarray, m: np.ndarray, poles: np.ndarray) -> bool:
    """Whether a motion has neither mass, stiffness nor damping, so that any number is a pole."""
    sizes = np.abs(poles[poles != 0])
    s = np.exp(0.7j) * (np.median(sizes) if len(sizes) else 1.0)
    size = np.abs(s) ** 2 * np.abs(np.diag(m)) + np.abs(s) * np.abs(np.diag(c)) + np.abs(np.diag(k))
    scale = unit_scale(size)
    singular_values = np.linalg.svd((s**2 * m + s * c + k) * scale[:, None] * scale, compute_uv=False)
    return bool(len(singular_values)) and bool(singular_values[-1] <= FREE_STIFFNESS * len(k))


def _vectors(k: np.ndarray, c: np.ndarray, m: np.ndarray, poles: np.ndarray, number: int) -> tuple[Any, Any]:
    """Left and right vector of a pole; NaN if it has no derivative."""
    value = poles[number]
    same = np.flatnonzero(np.abs(poles - value) <= REPEATED_EIGENVALUE * np.abs(value))
    middle, many = np.mean(poles[same]), len(same)
    # Scale degrees of freedom so that their equations are of one size.
    size = np.abs(middle) ** 2 * np.abs(np.diag(m)) + np.abs(middle) * np.abs(np.diag(c)) + np.abs(np.diag(k))
    scale = unit_scale(size)
    k, c, m = (matrix * scale[:, None] * scale for matrix in (k, c, m))
    if many > len(k):
        return np.nan, np.nan
    u, sizes, v = np.linalg.svd(middle**2 * m + middle * c + k)
    u, v, change = u[:, -many:], v[-many:].conj().T, 2 * middle * m + c
    meeting = u.conj().T @ change @ v
    least, change_norm = np.linalg.svd(meeting, compute_uv=False)[-1], np.linalg.norm(change, 2)
    if sizes[-many] > SOLVED_BY_VECTOR or not least > MEETING_POLES * change_norm:
        return np.nan, np.nan
    u = u @ np.linalg.inv(meeting).conj().T
    column = int(np.flatnonzero(same == number)[0])
    return scale * u[:, column], scale * v[:, column]


def poles_of_elements(elements: ElementMatrices, count: int) -> Complex[Array, "count"]:
    """:func:`.poles_of_sparse` of traced element matrices, differentiable (THEORY.md 10, eq. (10.4)).

    Derivatives are NaN for poles that meet or are repeated. Raises singular_mass too; under a trace an error of JAX.
    """
    return _of_elements(elements, np.zeros(count))[0]


def _sparse_poles_on_host(elements: ElementMatrices, count: Array) -> Any:
    k, rows = count.shape[0], sum(elements.unknowns)
    like = jax.ShapeDtypeStruct((k,), complex), *[jax.ShapeDtypeStruct((k, rows), complex)] * 2
    values, left_vectors, right_vectors = call_on_host(functools.partial(_poles_near_zero, count=k), like, elements)
    return values, jnp.zeros((), jnp.int32), left_vectors, right_vectors


def _balance_by_elements(elements: ElementMatrices, values: Any, left_vectors: Any, right_vectors: Any) -> Any:
    def of_pole(s: Any, y: Any, z: Any):
        return jnp.sum(y * saddle_product(elements, z[:, None], None, s)[:, 0])

    return jax.vmap(of_pole)(values, left_vectors, right_vectors)


_of_elements = _differentiable(_sparse_poles_on_host, _balance_by_elements)


def _poles_near_zero(elements: ElementMatrices, *, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Poles nearest to zero with their left and right motions and multipliers, by NumPy and SciPy alone."""
    assembled = AssembledEquations(elements)
    refuse_negative_masses(assembled)
    every = poles_of_sparse(assembled, count + 1)
    nearest = np.sort(np.argsort(np.abs(every), kind="stable")[:count])
    if len(nearest) < count:
        raise AnalysisError(RESULTS.singular_mass.name, RESULTS.singular_mass.message)
    vectors = [_motions(assembled, every, int(number)) for number in nearest]
    left_vectors, right_vectors = (np.array([pair[side] for pair in vectors]) for side in range(2))
    return every[nearest], left_vectors, right_vectors


def _motions(assembled: AssembledEquations, poles: np.ndarray, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Left and right vector of a pole with multipliers, y^T (2 s M + C) z = 1; NaN if it shares them."""
    s = poles[number]
    shifted = s + BESIDE_POLE * (np.abs(s) or np.max(np.abs(poles)) or 1.0)
    rows, change = sum(assembled.elements.unknowns), 2 * s * assembled.mass + assembled.damping
    factors = assembled.factors(assembled.at_frequency(shifted))
    nothing = np.full(rows, NOTHING), np.full(rows, NOTHING)
    if not factors.regular or np.sum(np.abs(poles - s) <= REPEATED_EIGENVALUE * np.abs(s)) > 1:
        return nothing
    pair = []
    for transposed in (True, False):
        by, z = change.T if transposed else change, np.zeros(rows, complex)
        loads = uneven(assembled.n).astype(complex)
        for _ in range(TURNS):
            z = factors.solve(np.pad(loads, (0, rows - assembled.n))[:, None], transposed)[:, 0]
            largest = np.max(np.abs(z))
            if not largest > 0:
                return nothing
            z = z / largest
            loads = by @ z[: assembled.n]
        pair.append(z)
    left_vector, right_vector = pair
    terms = left_vector[: assembled.n] * (change @ right_vector[: assembled.n])
    if not np.abs(np.sum(terms)) > MEETING_POLES * np.sum(np.abs(terms)):
        return nothing
    return left_vector / np.sum(terms), right_vector
