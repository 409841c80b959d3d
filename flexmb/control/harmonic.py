"""Responses by frequency: sums over modes, or solutions at each frequency by dense or sparse factors."""

import dataclasses
import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Complex, Float

from ..arguments import as_known, library_of
from ..compilation.compile import jit
from ..linear.linearize import Linearization, Matrices
from ..linear.sparse_solve import call_on_host
from ..linear.spectrum import shift_to_definite
from ..math.by_deformations import forces, refined_solution, saddle_product
from ..math.element_matrices import AssembledEquations, ElementMatrices
from ..math.linear import diagonal_of, pencil, unit_scale
from ..numerical_limits import (
    BOUNDED_ROUND_OFF,
    COUPLED_MODES,
    RESONANCE_HIT,
    RESONANT_SOLUTION,
    ROUND_OFF,
    SAME_MODE,
    TURN_OF_MODES,
)
from ..results import RESULTS
from .second_order_form import SecondOrder, large_second_order, lossy_elements, second_order


def plain_arrays(whole: SecondOrder) -> tuple[SecondOrder, tuple[int, ...]]:
    """Second-order form with arrays only, and the orders of derivatives of the inputs."""
    none = np.zeros(0)
    return whole._replace(orders=none, moves=none), tuple(int(order) for order in whole.orders)


@jit
def response_by_freedoms(
    system: SecondOrder,
    lossy: tuple[SecondOrder, SecondOrder] | None,
    hertz: Float[Array, "n_f"],
    *,
    us: tuple[int, ...],
    ys: tuple[int, ...],
    orders: tuple[int, ...],
    by_modes: bool,
):
    """H(i 2 pi f) of inputs ``us`` and outputs ``ys``, (n_f, n_y, n_u), and a code of RESULTS.

    ``system`` and ``orders`` are from :func:`plain_arrays`, ``lossy`` from :func:`forms_with_losses`.
    """
    w = 2 * np.pi * hertz
    loss, polynomials = jnp.zeros_like(system.K), _polynomials(system, us, ys)
    if lossy is not None:
        # Geometric stiffness and inertia do not depend on the elements' stiffness; the difference is linear in it.
        of_loss = jax.tree.map(lambda a, b: a - b, *lossy)
        loss, lost = of_loss.K, _polynomials(of_loss, us, ys)
        polynomials = [part.at[0].add(1j * by_loss[0]) for part, by_loss in zip(polynomials, lost, strict=True)]
    by_inputs, by_outputs, through = polynomials
    parts = (system.M, system.C, system.K, loss)
    factors, definite = _modal_factors(*parts) if by_modes else (None, jnp.array(True))
    responses = _transfer(factors, w, parts, by_inputs, by_outputs) + _at(w, through)
    responses = _integrated(responses, w, np.asarray(orders)[np.array(us)])
    # A division by zero is infinite; all is NaN for a state that was not found.
    known = jnp.all(jnp.isfinite(system.M)) & jnp.all(jnp.isfinite(system.K))
    responses = jnp.where(jnp.isfinite(jnp.abs(responses)) | ~known, responses, jnp.inf + 0j)
    return responses, jnp.where(definite, RESULTS.successful, RESULTS.singular_stiffness).astype(jnp.int32)


def _integrated(responses: Complex[Array, "n_f n_y n_u"], w: Float[Array, "n_f"], orders: Any) -> Any:
    """Responses to inputs that are velocities or accelerations, from those to displacements."""
    for order in (1, 2):
        is_order = np.asarray(orders) == order
        if np.any(is_order):
            divided = responses / _powers(w)[order][:, None, None]
            responses = library_of((responses, w)).where(is_order, divided, responses)
    return responses


def forms_with_losses(lin: Linearization, losses: Float[Array, "n_e"]) -> tuple[SecondOrder, SecondOrder]:
    """Second-order forms with lossy stiffness and without; i times their difference is the loss."""
    m = lin.matrices
    lossy, k = _lossy(m, losses)
    none = {name: np.zeros(m.K0.shape) for name in ("M0", "C0", "D0", "K0", "N0", "G0")} | {"S_d": np.zeros(m.S.shape)}

    def form(**parts: Any):
        return plain_arrays(second_order(Linearization(dataclasses.replace(m, **{**none, **parts}), lin.model)))[0]

    return form(S=lossy, K0=k), form(S=np.zeros(m.S.shape))


@jit
def _lossy(m: Matrices, losses: Float[Array, "n_e"]):
    """Lossy stiffness of the elements and of the degrees of freedom."""
    lossy = (losses[:, None] * m.S + m.S * losses) / 2
    return lossy, m.DFe.T @ lossy @ m.DFe


def _polynomials(form: SecondOrder, us: tuple[int, ...], ys: tuple[int, ...]) -> list[Complex[Array, "3 i j"]]:
    """B, C and D of some inputs and outputs by powers of i w, from the lowest."""
    u, y = np.array(us), np.array(ys)
    b, c, d = (jnp.stack(form[first : first + 3]).astype(complex) for first in (3, 6, 9))
    return [b[:, :, u], c[:, y], d[:, y[:, None], u]]


def _powers(w: Float[Array, "*n_f"], count: int = 3) -> Complex[Array, "count *n_f"]:
    """Powers of i w, from the lowest."""
    turns = np.array([1, 1j, -1, -1j, 1])[:count].reshape(-1, *[1] * np.ndim(w))
    return library_of(w).stack([w**i for i in range(count)]).astype(complex) * turns


def _at(w: Float[Array, "n_f"], polynomial: Complex[Array, "3 i j"]) -> Complex[Array, "n_f i j"]:
    """Polynomial of i w."""
    return library_of((w, polynomial)).einsum("pf,pij->fij", _powers(w), polynomial)


def _modal_factors(
    m: Float[Array, "n n"], c: Float[Array, "n n"], k: Float[Array, "n n"], loss: Float[Array, "n n"]
) -> tuple[Any, Any]:
    """Undamped modes W with W^T (K + s M) W = 1, mass, damping and loss between them, and whether there are any.

    With this scale, motions without mass are modes of zero mass, and the sum includes the whole flexibility.
    """
    m, c, k, loss = (jax.lax.stop_gradient(part) for part in (m, c, k, loss))
    shift, _, definite, _ = shift_to_definite(k, m)
    mu, vectors = _refined(m, k + shift * m, *pencil(m, k + shift * m))
    damping, losses = vectors.T @ c @ vectors, vectors.T @ loss @ vectors
    return (mu, shift * mu, vectors, damping, losses), definite


def _refined(
    a: Float[Array, "n n"], b: Float[Array, "n n"], mu: Float[Array, "n"], vectors: Float[Array, "n n"]
) -> tuple[Any, Any]:
    """Eigenvalues and vectors of A w = mu B w after one Newton step, each accurate to its own round-off.

    Before, they are accurate to round-off of the largest mu, of the slowest mode. A second correction removes the
    square of the step from w_i^T B w_j (Ogita, Aishima (2018), Japan J. Industrial and Applied Mathematics 35, 1007,
    with B in place of the unit matrix).
    """
    of_a, of_b = vectors.T @ a @ vectors, vectors.T @ b @ vectors
    values = diagonal_of(of_a) / diagonal_of(of_b)
    gap = values[None, :] - values[:, None]
    separated = jnp.abs(gap) > SAME_MODE * jnp.maximum(jnp.abs(values)[None, :], jnp.abs(values)[:, None])
    turned = jnp.where(separated, (of_a - values[None, :] * of_b) / jnp.where(separated, gap, 1.0), 0.0)
    # Modes of one frequency may have any direction; they stay, like modes that round-off does not separate, as of
    # motions almost without mass.
    turned = jnp.where(jnp.maximum(jnp.abs(turned), jnp.abs(turned.T)) < TURN_OF_MODES, turned, 0.0)
    vectors = vectors + vectors @ turned
    # Remove faster modes from slow ones, the last, which moves these little; not the other way round.
    vectors = vectors - vectors @ jnp.triu(vectors.T @ b @ vectors, 1)
    of_a, of_b = jnp.sum(vectors * (a @ vectors), axis=0), jnp.sum(vectors * (b @ vectors), axis=0)
    return of_a / of_b, vectors / jnp.sqrt(of_b)


def _is_coupled(matrix: Float[Array, "n n"]) -> Any:
    sizes = jnp.abs(diagonal_of(matrix))
    allowed = COUPLED_MODES * jnp.sqrt(sizes[:, None] * sizes) + BOUNDED_ROUND_OFF * jnp.max(sizes, initial=0.0)
    return jnp.any((jnp.abs(matrix) > allowed) & ~np.eye(len(matrix), dtype=bool))


@jax.custom_jvp
def _transfer(
    factors: tuple[Array, ...] | None,
    w: Float[Array, "n_f"],
    parts: tuple[Array, ...],
    by_inputs: Complex[Array, "3 n_q n_u"] | tuple[Array],
    by_outputs: Complex[Array, "3 n_y n_q"] | tuple[Array],
) -> Complex[Array, "n_f n_y n_u"]:
    """C(i w) (-w^2 M + i w C + K + i L)^-1 B(i w), THEORY.md 14, eq. (14.30), by modes (14.31).

    Args:
        factors: From :func:`_modal_factors`; None for solutions in the degrees of freedom.
        parts: M, C, K and L.
        by_inputs: B by powers, (3, n_q, n_u), or a tuple with one matrix for each frequency, (n_f, n_q, n_u).
        by_outputs: C likewise.
    """
    if factors is None:
        m, c, k, loss = parts
        # Scale each freedom to a stiffness of one.
        diagonal = jnp.abs(diagonal_of(k))
        scale = unit_scale(diagonal)
        m, c, k, loss = (part * scale[:, None] * scale for part in (m, c, k, loss))
        units = scale.astype(complex)
        right, left = _expanded(w, by_inputs) * units[:, None], _expanded(w, by_outputs) * units
        return _solved_by_frequency(w, k, m, c, loss, right, left)
    mu, shifted, vectors, damping, losses = factors
    vectors = vectors.astype(complex)
    coupled = _is_coupled(damping) | _is_coupled(losses)

    def summed():
        return _sum_over_modes(w, factors, by_inputs, by_outputs)

    def solved():
        right, left = (_expanded(w, polynomial) for polynomial in (by_inputs, by_outputs))
        stiffness, mass = jnp.diag(1 - shifted), jnp.diag(mu)
        return _solved_by_frequency(w, stiffness, mass, damping, losses, vectors.T @ right, left @ vectors)

    return jax.lax.cond(coupled, solved, summed)


def _expanded(w: Float[Array, "n_f"], polynomial: Complex[Array, "3 i j"] | tuple[Array]):
    """One matrix for each frequency, of a polynomial or of such matrices."""
    return polynomial[0] if isinstance(polynomial, tuple) else _at(w, polynomial)


def _sum_over_modes(
    w: Float[Array, "n_f"],
    factors: tuple[Array, ...],
    by_inputs: Complex[Array, "3 n_q n_u"] | tuple[Array],
    by_outputs: Complex[Array, "3 n_y n_q"] | tuple[Array],
):
    mu, shifted, vectors, damping, losses = factors
    vectors = vectors.astype(complex)
    column = w[:, None]
    inverse = jax.lax.complex(1 - shifted - column**2 * mu, column * diagonal_of(damping) + diagonal_of(losses))
    hit = jnp.abs(inverse) <= RESONANCE_HIT * (1 + shifted + column**2 * mu)
    gains = jnp.where(hit, 0.0, 1 / jnp.where(hit, 1.0, inverse))
    if isinstance(by_inputs, tuple) or isinstance(by_outputs, tuple):
        right, left = vectors.T @ _expanded(w, by_inputs), _expanded(w, by_outputs) @ vectors
        return left @ (gains[:, :, None] * right)
    right, left = vectors.T @ by_inputs, by_outputs @ vectors
    # For each mode, output and input by powers of i w: one product of matrices sums over all modes.
    (_, n, n_u), n_y = right.shape, left.shape[1]
    shares = [jnp.zeros((n, n_y, n_u), complex)] * 5
    for i in range(3):
        for j in range(3):
            shares[i + j] = shares[i + j] + left[i].T[:, :, None] * right[j][:, None, :]
    flat = jnp.stack(shares).reshape(5, n, n_y * n_u)
    responses = jnp.sum(_powers(w, 5)[:, :, None] * (gains @ flat), axis=0)
    sizes = jnp.max(jnp.abs(flat), axis=0)
    takes_part = sizes > ROUND_OFF * jnp.max(sizes, axis=0, initial=0.0)
    unbounded = (hit.astype(float) @ takes_part.astype(float)) > 0
    return jnp.where(unbounded, jnp.inf + 0j, responses).reshape(len(w), n_y, n_u)


def _solved_by_frequency(
    w: Float[Array, "n_f"],
    k: Float[Array, "n n"],
    m: Float[Array, "n n"],
    c: Float[Array, "n n"],
    loss: Float[Array, "n n"],
    right: Complex[Array, "n_f n n_u"],
    left: Complex[Array, "n_f n_y n"],
):
    """Solutions at each frequency, one after the other: a batch of large LAPACK calls may never end on a CPU."""

    def at_frequency(at: tuple[Array, ...]):
        w, right, left = at
        return left @ jnp.linalg.solve(jax.lax.complex(k - w**2 * m, w * c + loss), right)

    return jax.lax.map(at_frequency, (w, right, left))


@_transfer.defjvp
def _transfer_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    """(14.32): with constant X = Z^-1 B and Y = C Z^-1, C X + Y (B - Z X) has the derivative of C Z^-1 B.

    No mode is differentiated.
    """
    factors, w, parts, by_inputs, by_outputs = primals
    n = parts[0].shape[0]
    every = (jnp.broadcast_to(jnp.eye(n, dtype=complex), (len(w), n, n)),)
    moved = _transfer(factors, w, parts, (_expanded(w, by_inputs),), every)
    adjoint = _transfer(factors, w, parts, every, (_expanded(w, by_outputs),))

    def balance(w: Any, parts: tuple[Array, ...], by_inputs: Any, by_outputs: Any):
        m, c, k, loss = (part.astype(complex) for part in parts)
        unity, s, s2 = (power[:, None, None] * moved for power in _powers(w))
        elastic = k @ unity + c @ s + m @ s2 + 1j * (loss @ moved)
        return _expanded(w, by_outputs) @ moved + adjoint @ (_expanded(w, by_inputs) - elastic)

    _, change = jax.jvp(balance, primals[1:], tangents[1:])
    return _expanded(w, by_outputs) @ moved, change


def response_by_elements(
    lin: Linearization, hertz: Float[Array, "n_f"], us: tuple[int, ...], ys: tuple[int, ...], losses: Any
) -> Any:
    """H(i 2 pi f) of a large mechanism, (n_f, n_y, n_u), infinite at an undamped resonance.

    THEORY.md 14, eq. (14.30), and its derivative (14.32), in the coordinates and multipliers of 7, eq. (7.15).
    """
    system, w = large_second_order(lin).of(us, ys), 2 * np.pi * as_known(hertz)
    elements, polynomials = system.elements, [part.astype(complex) for part in system[1:4]]
    if losses is not None:
        lossy = large_second_order(lin, lossy_elements(lin, losses)).of(us, ys)
        elements = elements._replace(loss=lossy.elements.stiffness, lossy=lossy.elements.elastic)
        polynomials = [part + 1j * loss.astype(complex) for part, loss in zip(polynomials, lossy[1:4], strict=True)]
    b, c, d = polynomials
    at_once = as_known(_transfer_by_elements(elements, w, b, c)) + _at(w, d)
    # Infinite responses at a resonance stay infinite after division; NaN stays NaN.
    with np.errstate(invalid="ignore"):
        responses = _integrated(at_once, w, system.orders)
        return library_of(at_once).where(library_of(at_once).isinf(abs(at_once)), np.inf + 0j, responses)


@jax.custom_jvp
def _transfer_by_elements(
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
    """Z^-1 B and Z^-T C^T at each frequency, of free coordinates and multipliers; or only C Z^-1 B, in less time.

    ``b`` and ``c`` are complex, by powers of i w. Returns (n_f, n + h, n_u + n_y), zero at an undamped resonance; or
    (n_f, n_y, n_u), infinite there.
    """
    like = jax.ShapeDtypeStruct(_shape(elements, w, b, c, only_responses), complex)
    return call_on_host(functools.partial(_solved_on_host, only_responses=only_responses), like, elements, w, b, c)


def _shape(elements: ElementMatrices, w: Any, b: Any, c: Any, only_responses: bool) -> tuple[int, int, int]:
    """Shape of the result of :func:`solutions`."""
    n_u, n_y = b.shape[2], c.shape[1]
    return (w.shape[0], n_y, n_u) if only_responses else (w.shape[0], sum(elements.unknowns), n_u + n_y)


def _solved_on_host(elements: ElementMatrices, w: np.ndarray, b: np.ndarray, c: np.ndarray, *, only_responses: bool):
    """:func:`solutions` of known numbers, by NumPy and SciPy alone."""
    shape = _shape(elements, w, b, c, only_responses)
    assembled, rows, answer = AssembledEquations(elements), sum(elements.unknowns), np.full(shape, np.inf + 0j)
    for i, s in enumerate(1j * w):
        powers = s ** np.arange(3)
        right = np.tensordot(powers, b, 1)[elements.free]
        left = np.tensordot(powers, c, 1)[:, elements.free]
        factors = assembled.factors(assembled.at_frequency(s))
        if not factors.regular:
            answer[i] = np.inf if only_responses else 0.0
            continue
        n_multipliers = rows - assembled.n
        moved = _solution(elements, factors, s, np.pad(right, ((0, n_multipliers), (0, 0))))
        if only_responses:
            answer[i] = left @ moved[: assembled.n]
            continue
        sensed = _solution(elements, factors, s, np.pad(left.T, ((0, n_multipliers), (0, 0))), transposed=True)
        answer[i] = np.concatenate([moved, sensed], axis=1)
    return answer


def _solution(elements: ElementMatrices, factors: Any, s: complex, right: np.ndarray, transposed: bool = False):
    """Solution of the equations at a frequency, by NumPy and SciPy alone."""

    def exact(z: np.ndarray):
        return forces(elements, z, transposed, s)

    sizes = elements.sizes[elements.free]
    return refined_solution(exact, lambda left: factors.solve(left, transposed), right, sizes, RESONANT_SOLUTION)


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

    def at_frequency(at: tuple[Array, Array]):
        s, (x, y) = lax.complex(jnp.zeros_like(at[0]), at[0]), jnp.split(at[1], [n_u], axis=1)
        powers = _powers(at[0])
        right = jnp.tensordot(powers, b, 1)[elements.free]
        left = jnp.tensordot(powers, c, 1)[:, elements.free]
        balance = saddle_product(elements, x, None, s)
        out_of_balance = jnp.concatenate([right - balance[:n], -balance[n:]])
        return left @ x[:n] + y.T @ out_of_balance

    return lax.map(at_frequency, (w, moved))


@_transfer_by_elements.defjvp
def _transfer_by_elements_jvp(primals: tuple[Any, ...], tangents: tuple[Any, ...]):
    """(14.32): with constant X = Z^-1 B and Y = Z^-T C^T, C X + Y^T (B - Z X) has the derivative of C Z^-1 B."""
    moved = solutions(*primals)
    responses, change = jax.jvp(lambda *numbers: _by_solutions(*numbers, moved), primals, tangents)
    regular = jnp.any(moved != 0, axis=(1, 2))[:, None, None] | ~jnp.any(primals[2])
    return jnp.where(regular, responses, jnp.inf + 0j), jnp.where(regular, change, 0j)
