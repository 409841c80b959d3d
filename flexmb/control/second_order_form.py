"""The linearised mechanism in second-order form, with all that its inputs do and its outputs measure."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import is_concrete, library_of
from ..compilation.compile import jit
from ..linear.linearize import Linearization, Matrices
from ..mechanics.blocks import kernel
from ..mechanics.signals import (
    DEFORMATION_ORDERS,
    ORDERS,
    along_coordinates,
    combined,
    input_row,
    rotation_row,
    terms_of,
)
from ..model.model import Signal
from ..model.parameters import Parameters
from ..model.topology import Topology
from .held import Held, held_by, held_of, moved_by, with_held

# A sum of terms is round-off below this share of their sizes.
ROUND_OFF = 1e-12


class SecondOrder(NamedTuple):
    """M q'' + C q' + K q = B0 p + B1 p' + B2 p'',  y = C0 q + C1 q' + C2 q'' + D0 p + D1 p' + D2 p''.

    p is the input u itself, but of an input that is the velocity or the acceleration of what is held the displacement:
    u is its derivative of the order ``orders`` says. In the frequency domain, with s = i w, of input j:
    q = (s^2 M + s C + K)^-1 (B0 + s B1 + s^2 B2)[:, j] u_j / s^orders[j].

    Attributes:
        M, C, K: Mass, damping and stiffness of the degrees of freedom, (n_q, n_q) [SI].
        B0, B1, B2: What acts on them by p and its rates, (n_q, n_u).
        C0, C1, C2: Outputs by the degrees of freedom and their rates, (n_y, n_q).
        D0, D1, D2: Outputs by p and its rates, (n_y, n_u).
        orders: Of which derivative of p each input is, 0, 1 or 2, (n_u,); plain numbers.
        moves: Which inputs move what is held, rather than being forces, (n_u,); plain booleans.
    """

    M: Float[Array, "*t n_q n_q"]
    C: Float[Array, "*t n_q n_q"]
    K: Float[Array, "*t n_q n_q"]
    B0: Float[Array, "*t n_q n_u"]
    B1: Float[Array, "*t n_q n_u"]
    B2: Float[Array, "*t n_q n_u"]
    C0: Float[Array, "*t n_y n_q"]
    C1: Float[Array, "*t n_y n_q"]
    C2: Float[Array, "*t n_y n_q"]
    D0: Float[Array, "*t n_y n_u"]
    D1: Float[Array, "*t n_y n_u"]
    D2: Float[Array, "*t n_y n_u"]
    orders: np.ndarray
    moves: np.ndarray

    def at(self, s: complex) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """K, B, C and D at one s = i w of a form of one state: u does C K^-1 B + D.

        Args:
            s: i w [rad/s]; not zero where an input is a velocity or an acceleration.

        Returns:
            (n_q, n_q), (n_q, n_u), (n_y, n_q) and (n_y, n_u), complex.
        """
        k, c, m, b0, b1, b2, *rest = (np.asarray(of) for of in (self.K, self.C, self.M, *self[3:12]))
        c0, c1, c2, d0, d1, d2 = rest
        by_u = s ** -self.orders.astype(float)
        forces, through = (b0 + s * b1 + s**2 * b2) * by_u, (d0 + s * d1 + s**2 * d2) * by_u
        return k + s * c + s**2 * m, forces, c0 + s * c1 + s**2 * c2, through

    def __repr__(self) -> str:
        return "SecondOrder: " + ", ".join(f"{name} {np.shape(own)}" for name, own in self._asdict().items())


def second_order(lin: Linearization) -> SecondOrder:
    """Second-order form of a linearised mechanism, for the model's named inputs and outputs.

    Args:
        lin: Linearization; that along a motion has the times in front. Differentiable in the model's parameters.

    Returns:
        SecondOrder.

    Source:
        THEORY.md 14, eq. (14.1) to (14.4): what is held is a freedom of its own in the equations about the state, the
        constraint forces in their stiffness, and the columns of what moves it go to the right.
    """
    model, m = lin.model, lin.matrices
    inputs, outputs = (tuple(s.without_name() for s in some) for some in model.signals())
    held = held_by((*terms_of(inputs), *terms_of(outputs)))
    whole = _with_held(model.topology, model.parameters, m, held=held, times=m.M0.ndim > 2) if held else m
    weights = model.parameters.weights
    if is_concrete((m, weights)) and m.M0.ndim == 2:
        # For sizes that come but once, where compiling takes longer than computing.
        numbers: Any = jax.tree.map(np.asarray, (m, whole, weights))
        plain: Any = np
        found = _about_state(numbers[0], numbers[1], numbers[2], inputs, outputs, held, plain)
    else:
        found = _second_order(m, whole, weights, inputs=inputs, outputs=outputs, held=held)
    orders, moves = orders_of(inputs)
    return SecondOrder(*found, orders=orders, moves=moves)


def orders_of(inputs: tuple[Signal, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Of which derivative of a displacement each input is, and which move what is held."""
    orders = [s.terms[0].order for s in inputs]
    return np.array([order or 0 for order in orders], int), np.array([order is not None for order in orders], bool)


@kernel
def _with_held(topology: Topology, parameters: Parameters, m: Matrices, *, held: tuple[Held, ...], times: bool):
    def one(m: Matrices):
        return with_held(topology, parameters, m, held)

    return jax.vmap(one)(m) if times else one(m)


@jit
def _second_order(
    m: Matrices,
    whole: Matrices,
    weights: Any,
    *,
    inputs: tuple[Signal, ...],
    outputs: tuple[Signal, ...],
    held: tuple[Held, ...],
) -> Any:
    def one(m: Matrices, whole: Matrices):
        return _about_state(m, whole, weights, inputs, outputs, held, jnp)

    return jax.vmap(one)(m, whole) if m.M0.ndim > 2 else one(m, whole)


def _about_state(
    m: Matrices,
    whole: Matrices,
    weights: Any,
    inputs: tuple[Signal, ...],
    outputs: tuple[Signal, ...],
    held: tuple[Held, ...],
    xp: Any,
) -> tuple[Any, ...]:
    """The twelve matrices of one state, by NumPy or by jax.numpy."""
    n = m.M0.shape[0]
    causes, sensed = terms_of(inputs), terms_of(outputs)
    parts = (whole.K, whole.C0 + whole.D0, whole.M0)
    motions = moved_by(causes, held)
    columns = [input_row(s, whole.x, whole.DFx, whole.DFe) if s.order is None else None for s in causes]
    forces = stacked(columns, n + len(held), xp).T
    by_p = [-part[:n, n:] @ motions for part in parts]
    by_p[0] = by_p[0] + forces[:n]
    rows = [_output_rows(s, whole, held, parts, forces, causes) for s in sensed]
    by_w = [stacked([of[k] for of in rows], n + len(held), xp) for k in range(3)]
    through = [row[:, n:] @ motions for row in by_w]
    through[0] = through[0] + stacked([of[3] for of in rows], len(causes), xp)
    by_q = [row[:, :n] for row in by_w]
    by_p, by_q, through = mixed(inputs, outputs, weights, by_p, by_q, through)
    return m.M0, m.C0 + m.D0, m.K, *by_p, *by_q, *through


def mixed(
    inputs: tuple[Signal, ...], outputs: tuple[Signal, ...], weights: Any, by_p: Any, by_q: Any, through: Any
) -> tuple[list[Any], list[Any], list[Any]]:
    """What inputs do and outputs measure, of what their terms do and measure.

    Args:
        inputs: Inputs.
        outputs: Outputs.
        weights: Of the terms of both, or None where each has but one.
        by_p: What acts, by the terms of the inputs, (n, terms) each.
        by_q: Terms of the outputs by the freedoms, (terms, n) each.
        through: And by those of the inputs, (terms, terms) each.
    """
    if weights is None:
        return by_p, by_q, through
    mix, read = combined(inputs, weights[0]).T, combined(outputs, weights[1])
    found = [of @ mix for of in by_p], [read @ of for of in by_q], [read @ of @ mix for of in through]
    by, of = abs(mix), abs(read)
    sizes = [abs(b) @ by for b in by_p], [of @ abs(c) for c in by_q], [of @ abs(d) @ by for d in through]
    # A floor that moves as a whole deforms nothing: what its points do cancels but for round-off.
    return jax.tree.map(_exact, found, sizes)


def _exact(total: Any, size: Any) -> Any:
    """Nothing where terms of a size cancel but for round-off; derivatives stay."""
    known = jax.lax.stop_gradient(total)
    small = abs(known) <= ROUND_OFF * jax.lax.stop_gradient(size)
    return library_of(small).where(small, total - known, total)


def stacked(rows: list[Any], size: int, xp: Any = jnp) -> Any:
    """Rows below each other, zero where one is None."""
    none = xp.zeros(size)
    return xp.stack([none if row is None else row for row in rows]) if rows else xp.zeros((0, size))


def adding_to(s: Signal, causes: tuple[Signal, ...]) -> np.ndarray:
    """Which inputs are a stress that adds to the one that an output measures, (inputs,): one or zero."""
    return np.array([float(u.quantity == "stress" and u.index == s.index and u.order is None) for u in causes])


def _output_rows(
    s: Signal,
    m: Matrices,
    held: tuple[Held, ...],
    parts: tuple[Any, ...],
    forces: Float[Array | np.ndarray, "w terms"],
    causes: tuple[Signal, ...],
) -> tuple[Any, ...]:
    """Derivatives of an output by the freedoms, their rates and second rates, None where there is none, and by inputs.

    Along a motion the rate of DFx q is DFx qd + DFx_d q, and a rotation's axes turn: of omega = 2 Lbar(lambda)
    d(lambda)/dt the change is 2 Lbar(lambda) of the rate's less 2 Lbar(d(lambda)/dt) of the parameters'.

    Args:
        m: Equations with what is held.
        held: What it is.
        parts: Their stiffness, damping and mass.
        forces: What inputs do along the freedoms, (w, terms).
        causes: Inputs.
    """
    moving = m.moving
    if s.held and s.quantity in ("reaction", "stress"):
        # What is put on a deformation from outside is less its stress resultant.
        own, sign = m.M0.shape[0] - len(held) + held.index(held_of(s)), -1 if s.of_element else 1
        return (*(sign * part[own] for part in parts), -sign * forces[own])
    if s.quantity == "stress":
        rates = m.S_d[s.index]
        by_q = m.S[s.index] @ m.DFe
        passed = adding_to(s, causes)
        return (by_q if moving is None else by_q + rates @ moving.DFe_d), rates @ m.DFe, None, passed
    of_e = s.quantity.startswith("deformation")
    place = {**ORDERS, **DEFORMATION_ORDERS}[s.quantity]
    own, row = (np.array([s.index]), np.ones(1)) if of_e else along_coordinates(s, m.x)
    along = row @ (m.DFe if of_e else m.DFx)[own]
    if place == 0 or moving is None:
        return (*(along if i == place else None for i in range(3)), None)
    first, second = (moving.DFe_d, moving.DFe_dd) if of_e else (moving.DFx_d, moving.DFx_dd)
    turning = jnp.zeros_like(along)
    if s.axis is not None:
        rates = moving.xd if place == 1 else moving.xdd
        turning = rotation_row(rates[own], s.axis, s.local) @ m.DFx[own]
    if place == 1:
        return row @ first[own] - turning, along, None, None
    return row @ second[own] - turning, 2 * row @ first[own], along, None
