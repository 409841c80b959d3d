"""Frequency responses of large mechanisms: a solution with sparse factors at each frequency, with derivatives."""

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Complex, Float

from ..arguments import as_known, library_of
from ..compilation.compile import jit
from ..linear.sparse_solve import on_host
from ..math.by_deformations import forces, product, refined
from ..math.element_matrices import ElementMatrices, Whole
from .sparse_second_order import SparseSecondOrder

# What round-off may leave of a solution near a resonance without damping.
NEAR_RESONANCE = 1e-3


def responses(system: SparseSecondOrder, lossy: SparseSecondOrder | None, w: Any) -> Any:
    """H(i w) of a large mechanism, before inputs that are rates are integrated.

    Args:
        system: Second-order form.
        lossy: What is lossy in it, as of :func:`.sparse_second_order.sparse_second_order`.
        w: Angular frequencies, (n_f,) [rad/s].

    Returns:
        (n_f, n_y, n_u), infinite where an undamped resonance is hit.

    Source:
        THEORY.md 14, eq. (14.30), and its derivative (14.32), in the coordinates and multipliers of 7, eq. (7.15).
    """
    elements, polynomials = system.elements, [part.astype(complex) for part in system[1:4]]
    if lossy is not None:
        elements = elements._replace(loss=lossy.elements.stiffness, lossy=lossy.elements.elastic)
        for part, own in zip(range(3), lossy[1:4], strict=True):
            polynomials[part] = polynomials[part] + 1j * own.astype(complex)
    b, c, d = polynomials
    found = as_known(_transfer(elements, w, b, c))
    return found + library_of((w, d)).einsum("pf,pij->fij", _powers(1j * w.astype(complex)), d)


@jax.custom_jvp
def _transfer(
    elements: ElementMatrices, w: Float[Array, "n_f"], b: Complex[Array, "3 n_x n_u"], c: Complex[Array, "3 n_y n_x"]
) -> Complex[Array, "n_f n_y n_u"]:
    """C(i w) Z^-1 B(i w)."""
    return solutions(elements, w, b, c, only_responses=True)


def solutions(
    elements: ElementMatrices,
    w: Any,
    b: Complex[Array, "3 n_x n_u"],
    c: Complex[Array, "3 n_y n_x"],
    *,
    only_responses: bool = False,
) -> Any:
    """Z^-1 B and Z^-T C^T at each frequency, of coordinates that move and multipliers, or responses alone.

    Args:
        elements: Element matrices.
        w: Angular frequencies, (n_f,) [rad/s].
        b: B by powers of i w, complex, (3, n_x, n_u).
        c: C likewise, (3, n_y, n_x).
        only_responses: C Z^-1 B alone, which costs less.

    Returns:
        (n_f, n + h, n_u + n_y), zero where an undamped resonance is hit; or (n_f, n_y, n_u), infinite there.
    """
    like = jax.ShapeDtypeStruct(_shape(elements, w, b, c, only_responses), complex)
    return on_host(functools.partial(_on_host, only_responses=only_responses), like, elements, w, b, c)


def _shape(elements: ElementMatrices, w: Any, b: Any, c: Any, only_responses: bool) -> tuple[int, int, int]:
    """Of what :func:`solutions` returns."""
    n_u, n_y = b.shape[2], c.shape[1]
    return (w.shape[0], n_y, n_u) if only_responses else (w.shape[0], sum(elements.unknowns), n_u + n_y)


def _on_host(elements: ElementMatrices, w: np.ndarray, b: np.ndarray, c: np.ndarray, *, only_responses: bool):
    """As :func:`solutions` of known numbers; NumPy and SciPy alone."""
    shape = _shape(elements, w, b, c, only_responses)
    whole, rows, answer = Whole(elements), sum(elements.unknowns), np.full(shape, np.inf + 0j)
    for i, s in enumerate(1j * w):
        powers = s ** np.arange(3)
        right = np.tensordot(powers, b, 1)[elements.free]
        left = np.tensordot(powers, c, 1)[:, elements.free]
        factors = whole.factors(whole.at_frequency(s))
        if not factors.regular:
            answer[i] = np.inf if only_responses else 0.0
            continue
        rest = rows - whole.n
        moved = _solved(elements, factors, s, np.pad(right, ((0, rest), (0, 0))))
        if only_responses:
            answer[i] = left @ moved[: whole.n]
            continue
        sensed = _solved(elements, factors, s, np.pad(left.T, ((0, rest), (0, 0))), transposed=True)
        answer[i] = np.concatenate([moved, sensed], axis=1)
    return answer


def _solved(elements: ElementMatrices, factors: Any, s: complex, right: np.ndarray, transposed: bool = False):
    """Solution of the equations at a frequency; NumPy and SciPy alone."""

    def exact(z: np.ndarray):
        return forces(elements, z, transposed, s)

    sizes = elements.sizes[elements.free]
    return refined(exact, lambda left: factors.solve(left, transposed), right, sizes, NEAR_RESONANCE)


def _powers(s: Any) -> Any:
    """The first three powers, (3, *f) of (*f,)."""
    library = library_of(s)
    return library.stack([library.ones_like(s), s, s**2])


@jit
def _by_solutions(
    elements: ElementMatrices,
    w: Float[Array, "n_f"],
    b: Complex[Array, "3 n_x n_u"],
    c: Complex[Array, "3 n_y n_x"],
    moved: Complex[Array, "n_f r k"],
) -> Complex[Array, "n_f n_y n_u"]:
    """C X + Y^T (B - Z X) at each frequency."""
    n, n_u = elements.unknowns[0], b.shape[2]

    def one(at: tuple[Array, Array]):
        s, (x, y) = lax.complex(jnp.zeros_like(at[0]), at[0]), jnp.split(at[1], [n_u], axis=1)
        powers = _powers(s)
        right = jnp.tensordot(powers, b, 1)[elements.free]
        left = jnp.tensordot(powers, c, 1)[:, elements.free]
        balance = product(elements, x, None, s)
        out_of_balance = jnp.concatenate([right - balance[:n], -balance[n:]])
        return left @ x[:n] + y.T @ out_of_balance

    return lax.map(one, (w, moved))


@_transfer.defjvp
def _transfer_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    """As (14.32): with X = Z^-1 B and Y = Z^-T C^T held, C X + Y^T (B - Z X) has the derivative of C Z^-1 B."""
    moved = solutions(*primals)
    found, change = jax.jvp(lambda *numbers: _by_solutions(*numbers, moved), primals, tangents)
    regular = jnp.any(moved != 0, axis=(1, 2))[:, None, None] | ~jnp.any(primals[2])
    return jnp.where(regular, found, jnp.inf + 0j), jnp.where(regular, change, 0j)
