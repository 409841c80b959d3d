"""State space in modal amplitudes scaled by their energy, so that slow and fast motions have similar size."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..linear.spectrum import shift_to_definite
from ..math.linear import factorise, pencil
from ..numerical_limits import BOUNDED_ROUND_OFF, MASSLESS_SHARE, NEGLIGIBLE_TERM
from .second_order_form import SecondOrder


class EnergyForm(NamedTuple):
    """z' = A z + B u, y = C z + D u with the energy |z|^2/2 of a stable mechanism at rest.

    ``rough``: outputs that depend on rates of inputs or on drift, which these matrices do not include.
    """

    A: Float[Array, "z z"]
    B: Float[Array, "z n_u"]
    C: Float[Array, "n_y z"]
    D: Float[Array, "n_y n_u"]
    rough: Bool[Array, "n_y n_u"]


def energy_form(system: SecondOrder, orders: tuple[int, ...]) -> EnergyForm:
    """State space of a second-order form, whose inputs are p or its derivatives of ``orders``; differentiable.

    The states are z = (w, sqrt(mu) w') of the amplitudes w of modes scaled to a stiffness of one, with masses mu. For
    an input p that moves held coordinates, such as a floor, they are relative to the motion at rest. Motions without
    mass follow the inputs immediately, and their damping is left out. Their states decay; no input acts on them and no
    output depends on them (THEORY.md 14, eq. (14.34)).
    """
    symmetric = (system.K + system.K.T) / 2
    shift, _, _ = shift_to_definite(symmetric, system.M)
    # The equations hold in any basis: it is not differentiated.
    mu, basis = jax.lax.stop_gradient(pencil(system.M, symmetric + shift * system.M))
    massive = mu > MASSLESS_SHARE * len(mu) * jnp.max(mu, initial=0.0)
    there, absent = massive.astype(float), (~massive).astype(float)
    scale = jnp.where(massive, 1 / jnp.sqrt(jnp.where(massive, mu, 1.0)), 0.0)
    mass, damping, stiffness = (basis.T @ matrix @ basis for matrix in system[:3])
    b = jnp.stack([basis.T @ matrix for matrix in system[3:6]])
    c = jnp.stack([matrix @ basis for matrix in system[6:9]])
    d = jnp.stack([system.D0, system.D1, system.D2])
    # Smaller effects on motions without mass are round-off: the squares of all effects add up to the flexibility at
    # rest.
    b = jnp.where(massive[:, None] | (jnp.abs(b) > NEGLIGIBLE_TERM * jnp.linalg.norm(b, axis=1, keepdims=True)), b, 0.0)
    c = jnp.where(massive | (jnp.abs(c) > NEGLIGIBLE_TERM * jnp.linalg.norm(c, axis=2, keepdims=True)), c, 0.0)
    if any(orders):
        size, terms = jnp.abs(basis), [jnp.abs(matrix) for matrix in system[:9]]
        sizes = (
            jnp.stack([size.T @ matrix @ size for matrix in terms[2::-1]]),
            jnp.stack([size.T @ matrix for matrix in terms[3:6]]),
            jnp.stack([matrix @ size for matrix in terms[6:9]]),
        )
        b, d, adrift, noted = _beside_what_follows(b, c, d, (stiffness, damping, mass), orders, sizes)
    else:
        adrift, noted = jnp.zeros(d.shape[1:], bool), jnp.sum(jnp.abs(d), axis=0)
    # Motions without mass follow the other motions and the forces immediately.
    rigid = factorise(absent[:, None] * stiffness * absent + jnp.diag(there))

    def follows(right: Float[Array, "n k"], solve: Callable[..., Any]):
        return absent[:, None] * solve(absent[:, None] * right)

    onto = jnp.diag(there) - follows(stiffness * there, rigid.solve)
    from_left = jnp.diag(there) - follows(stiffness.T * there, rigid.solve_transposed)
    direct = follows(b[0], rigid.solve)
    k, rate = from_left.T @ stiffness @ onto, from_left.T @ damping @ onto
    inertia = factorise(scale[:, None] * mass * scale + jnp.diag(absent))

    def accelerated(force: Float[Array, "n k"]):
        return scale[:, None] * inertia.solve(scale[:, None] * force)

    b = jnp.einsum("ji,kju->kiu", from_left, b)
    moved = accelerated(b[2])
    force, push = b[0] - k @ moved, b[1] - rate @ moved
    jump = accelerated(push)
    lower = jnp.concatenate([-inertia.solve(scale[:, None] * k), -inertia.solve(scale[:, None] * rate * scale)], axis=1)
    still = jnp.diag(absent / jnp.sqrt(jnp.max(mu)))
    upper = jnp.concatenate([-still, jnp.diag(scale)], axis=1)
    n = len(mu)
    lower = lower - jnp.concatenate([jnp.zeros((n, n)), still], axis=1)
    driven = inertia.solve(scale[:, None] * (force - rate @ jump))
    position, velocity, acceleration = c @ onto
    sensed = jnp.concatenate([position, velocity * scale], axis=1) + (acceleration * scale) @ lower
    terms = [position @ moved, c[0] @ direct, velocity @ jump, (acceleration * scale) @ driven, d[0]]
    passed, sizes = sum(terms), sum(jnp.abs(term) for term in terms[:-1]) + noted
    rates = velocity @ moved + acceleration @ jump + d[1], acceleration @ moved + d[2]
    allowed = jnp.abs(velocity) @ jnp.abs(moved) + jnp.abs(acceleration) @ (jnp.abs(jump) + jnp.abs(moved)) + noted
    rough = adrift | jnp.any(jnp.abs(jnp.stack(rates)) > NEGLIGIBLE_TERM * allowed, axis=0)
    passed = jnp.where(jnp.abs(passed) > NEGLIGIBLE_TERM * sizes, passed, 0.0)
    return EnergyForm(jnp.concatenate([upper, lower]), jnp.concatenate([jump, driven]), sensed, passed, rough)


def _beside_what_follows(
    b: Float[Array, "3 n n_u"],
    c: Float[Array, "3 n_y n"],
    d: Float[Array, "3 n_y n_u"],
    parts: tuple[Array, ...],
    orders: tuple[int, ...],
    sizes: tuple[Array, ...],
):
    """Effects on the motion beside the motion at rest, for inputs that are rates, by powers of the rate.

    q = q' + r p with K r = B0: B1 - C r and B2 - M r remain, and outputs include C0 r + D0 and so on. If a floor moves
    everything as one body, B1 - C r and C0 r + D0 are zero but for round-off. The round-off is bounded by
    ``sizes`` of the terms of (K, C, M), b and c in the degrees of freedom. The round-off of r is bounded by K r - B0
    times the inverse of K, here one.

    Returns b and d by u and its rates, whether outputs drift, and sizes of their terms.
    """
    factors = factorise(parts[0])
    is_rate = np.array([order > 0 for order in orders])
    follows = jnp.where(is_rate & factors.regular(), factors.solve(jnp.where(is_rate, b[0], 0.0)), 0.0)
    follows = jnp.where(jnp.isfinite(follows), follows, 0.0)
    by_parts, by_inputs, by_outputs = sizes
    size = jnp.abs(follows)
    unsure = by_parts[0] @ size + by_inputs[0]

    def left(total: Array, moved: Array, terms: Array, beside: Array):
        allowed = NEGLIGIBLE_TERM * (jnp.abs(moved) @ size + jnp.abs(beside))
        return jnp.where(jnp.abs(total) > allowed + BOUNDED_ROUND_OFF * (terms + jnp.abs(moved) @ unsure), total, 0.0)

    moved = jnp.stack(parts)
    b = left(b - moved @ follows, moved, by_parts @ size + by_inputs, b)
    noted = jnp.abs(c) @ size + jnp.abs(d)
    seen = left(c @ follows + d, c, by_outputs @ size, d)
    rank = np.asarray(orders)
    drifts = jnp.zeros(d.shape[1:], bool)
    for k in range(2):
        late = rank > k
        # Everything that the motion moves drifts with it.
        drifts = drifts | (late & ((seen[k] != 0) | jnp.any(b[k] != 0, axis=0)))
    power = np.add.outer(np.arange(3), rank)
    every = np.arange(len(rank))
    shifted = [jnp.concatenate([m, jnp.zeros_like(m)])[power, :, every].transpose(0, 2, 1) for m in (b, seen)]
    return *shifted, drifts, jnp.sum(noted, axis=0)
