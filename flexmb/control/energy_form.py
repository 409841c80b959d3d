"""State space in modal amplitudes scaled by their energy, in which slow and fast motions are of one size."""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ..linear.spectrum import shift_to_definite
from ..math.linear import factorise, pencil
from ..numerical_limits import MASSLESS_SHARE
from .second_order_form import SecondOrder

# What is left of a sum is nothing below this share of its terms, or of what round-off may make of them.
NOTHING, ROUND_OFF = 1e-9, 1e-14


class EnergyForm(NamedTuple):
    """z' = A z + B u, y = C z + D u, in which |z|^2/2 is the energy of a mechanism at rest that is stable.

    Attributes:
        A: (2 n, 2 n) [1/s].
        B: (2 n, n_u).
        C: (n_y, 2 n).
        D: (n_y, n_u).
        rough: Where outputs depend on the rates of inputs or on what has drifted away, so that they are not known by
            these matrices alone, (n_y, n_u).
    """

    A: Float[Array, "z z"]
    B: Float[Array, "z n_u"]
    C: Float[Array, "n_y z"]
    D: Float[Array, "n_y n_u"]
    rough: Bool[Array, "n_y n_u"]


def energy_form(system: SecondOrder, orders: tuple[int, ...]) -> EnergyForm:
    """State space of a second-order form, whose inputs are p or its derivatives of ``orders``, (n_u,); differentiable.

    The states are z = (w, sqrt(mu) w') of the amplitudes w of modes scaled to a stiffness of one, with masses mu. Along
    with what moves by an input p, such as a floor, they are relative to how it follows at rest. Motions without mass
    follow at once, their damping left out; their states decay by themselves, and nothing moves or measures them.

    Source:
        THEORY.md 14, eq. (14.34).
    """
    symmetric = (system.K + system.K.T) / 2
    shift, _, _ = shift_to_definite(symmetric, system.M)
    # Of whichever basis the equations hold, so that it is not differentiated.
    mu, basis = jax.lax.stop_gradient(pencil(system.M, symmetric + shift * system.M))
    massive = mu > MASSLESS_SHARE * len(mu) * jnp.max(mu, initial=0.0)
    there, absent = massive.astype(float), (~massive).astype(float)
    scale = jnp.where(massive, 1 / jnp.sqrt(jnp.where(massive, mu, 1.0)), 0.0)
    mass, damping, stiffness = (basis.T @ of @ basis for of in (system.M, system.C, system.K))
    b = jnp.stack([basis.T @ of for of in (system.B0, system.B1, system.B2)])
    c = jnp.stack([of @ basis for of in (system.C0, system.C1, system.C2)])
    d = jnp.stack([system.D0, system.D1, system.D2])
    # What acts on motions without mass, or is seen of them, by less than this beside all is round-off: the squares of
    # all add up to the flexibility at rest.
    b = jnp.where(massive[:, None] | (jnp.abs(b) > NOTHING * jnp.linalg.norm(b, axis=1, keepdims=True)), b, 0.0)
    c = jnp.where(massive | (jnp.abs(c) > NOTHING * jnp.linalg.norm(c, axis=2, keepdims=True)), c, 0.0)
    if any(orders):
        size, own = jnp.abs(basis), [jnp.abs(of) for of in system[:12]]
        sizes = (
            jnp.stack([size.T @ of @ size for of in (own[2], own[1], own[0])]),
            jnp.stack([size.T @ of for of in own[3:6]]),
            jnp.stack([of @ size for of in own[6:9]]),
        )
        b, d, adrift, noted = _beside_what_follows(b, c, d, (stiffness, damping, mass), orders, sizes)
    else:
        adrift, noted = jnp.zeros(d.shape[1:], bool), jnp.sum(jnp.abs(d), axis=0)
    # Motions without mass follow the others, and forces, at once.
    rigid = factorise(absent[:, None] * stiffness * absent + jnp.diag(there))

    def follows(right: Float[Array, "n k"], solve: Callable[..., Any]):
        return absent[:, None] * solve(absent[:, None] * right)

    onto = jnp.diag(there) - follows(stiffness * there, rigid.solve)
    from_left = jnp.diag(there) - follows(stiffness.T * there, rigid.solve_transposed)
    direct = follows(b[0], rigid.solve)
    k, own = from_left.T @ stiffness @ onto, from_left.T @ damping @ onto
    inertia = factorise(scale[:, None] * mass * scale + jnp.diag(absent))

    def accelerated(force: Float[Array, "n k"]):
        return scale[:, None] * inertia.solve(scale[:, None] * force)

    b = jnp.einsum("ji,kju->kiu", from_left, b)
    moved = accelerated(b[2])
    force, push = b[0] - k @ moved, b[1] - own @ moved
    jump = accelerated(push)
    lower = jnp.concatenate([-inertia.solve(scale[:, None] * k), -inertia.solve(scale[:, None] * own * scale)], axis=1)
    still = jnp.diag(absent / jnp.sqrt(jnp.max(mu)))
    upper = jnp.concatenate([-still, jnp.diag(scale)], axis=1)
    n = len(mu)
    lower = lower - jnp.concatenate([jnp.zeros((n, n)), still], axis=1)
    driven = inertia.solve(scale[:, None] * (force - own @ jump))
    position, velocity, acceleration = c @ onto
    sensed = jnp.concatenate([position, velocity * scale], axis=1) + (acceleration * scale) @ lower
    terms = [position @ moved, c[0] @ direct, velocity @ jump, (acceleration * scale) @ driven, d[0]]
    passed, sizes = sum(terms), sum(jnp.abs(term) for term in terms[:-1]) + noted
    rates = velocity @ moved + acceleration @ jump + d[1], acceleration @ moved + d[2]
    allowed = jnp.abs(velocity) @ jnp.abs(moved) + jnp.abs(acceleration) @ (jnp.abs(jump) + jnp.abs(moved)) + noted
    rough = adrift | jnp.any(jnp.abs(jnp.stack(rates)) > NOTHING * allowed, axis=0)
    passed = jnp.where(jnp.abs(passed) > NOTHING * sizes, passed, 0.0)
    return EnergyForm(jnp.concatenate([upper, lower]), jnp.concatenate([jump, driven]), sensed, passed, rough)


def _beside_what_follows(
    b: Float[Array, "3 n n_u"],
    c: Float[Array, "3 n_y n"],
    d: Float[Array, "3 n_y n_u"],
    parts: tuple[Array, ...],
    orders: tuple[int, ...],
    sizes: tuple[Array, ...],
):
    """Of inputs that are rates, what acts on the motion beside that which follows at rest, by powers of the rate.

    q = q' + r p with K r = B0: what is left acts by B1 - C r and B2 - M r, and outputs take C0 r + D0 and so on. Where
    a floor moves all that it holds as one body, B1 - C r and C0 r + D0 are zero but for round-off. That of the terms is
    bounded by ``sizes`` of the terms of (K, C, M), b and c in the degrees of freedom; that of r by K r - B0 times the
    inverse of K, here one.

    Returns:
        b and d by u and its rates, (3, n, n_u) and (3, n_y, n_u); whether outputs drift, and sizes of their terms,
        (n_y, n_u).
    """
    factors = factorise(parts[0])
    is_rate = np.array([order > 0 for order in orders])
    follows = jnp.where(is_rate & factors.regular(), factors.solve(jnp.where(is_rate, b[0], 0.0)), 0.0)
    follows = jnp.where(jnp.isfinite(follows), follows, 0.0)
    by_parts, by_inputs, by_outputs = sizes
    size = jnp.abs(follows)
    unsure = by_parts[0] @ size + by_inputs[0]

    def left(total: Array, moved: Array, of: Array, beside: Array):
        allowed = NOTHING * (jnp.abs(moved) @ size + jnp.abs(beside))
        return jnp.where(jnp.abs(total) > allowed + ROUND_OFF * (of + jnp.abs(moved) @ unsure), total, 0.0)

    moved = jnp.stack(parts)
    b = left(b - moved @ follows, moved, by_parts @ size + by_inputs, b)
    noted = jnp.abs(c) @ size + jnp.abs(d)
    seen = left(c @ follows + d, c, by_outputs @ size, d)
    rank = np.asarray(orders)
    drifts = jnp.zeros(d.shape[1:], bool)
    for k in range(2):
        late = rank > k
        # What has drifted is felt by all that the motion moves.
        drifts = drifts | (late & ((seen[k] != 0) | jnp.any(b[k] != 0, axis=0)))
    power = np.add.outer(np.arange(3), rank)
    every = np.arange(len(rank))
    shifted = [jnp.concatenate([of, jnp.zeros_like(of)])[power, :, every].transpose(0, 2, 1) for of in (b, seen)]
    return *shifted, drifts, jnp.sum(noted, axis=0)
