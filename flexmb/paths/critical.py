"""Critical values, null vectors and critical points along a path."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..math.indices import put
from ..math.linear import factorise, uneven
from ..mechanics.deformation import zero_strain
from ..mechanics.loads import lacks_potential
from ..mechanics.residual import State, state
from ..model.topology import Parameters, Topology
from ..numerical_limits import FREE_STIFFNESS, LARGEST_ALIKE, SOFT_SIGN
from ..results import RESULTS
from ..statics.solve import solve_state
from .stepper import (
    Direction,
    Plane,
    Point,
    Scale,
    begins_undeformed,
    direction_of,
    factors_at,
    load_response,
    scale_of,
    tangent_at,
    unit,
)


class CriticalPoint(NamedTuple):
    """A state with a singular stiffness.

    Attributes:
        load_factor: Load factor, () [-].
        kind: "limit": the load turns back; "bifurcation": another branch crosses.
        x: Nodal coordinates, (n_x,) [m, rad, -].
        phi: Motion without stiffness, in the coordinates, (n_x,). Its largest entry is one extent of the mechanism, or
            one radian.
        uncertainty: Largest error of the load factor, () [-]. Zero if flexmb found the state itself; otherwise half of
            the change between the nearest states on either side.
    """

    load_factor: float
    kind: str
    x: Float[np.ndarray, "n_x"]
    phi: Float[np.ndarray, "n_x"]
    uncertainty: float = 0.0

    def __repr__(self) -> str:
        within = f" within {self.uncertainty:.2g}" if self.uncertainty else ""
        return f"CriticalPoint: {self.kind} at load factor {self.load_factor:.5g}{within}, x and phi {np.shape(self.x)}"


def critical_values(topology: Topology, at: State, sizes: Float[Array, "n_x"]) -> Float[Array, "n_q"]:
    """Values, ascending if symmetric [N m], that change sign one at a time where the stiffness is singular.

    Symmetric: all eigenvalues of (K, Z^T Z) with Z = DFx in extents and radians, continuous along a path (Sylvester's
    law of inertia); the lowest are solved from the flexibility, with full relative accuracy. Unsymmetric: the smallest
    modulus with the sign of the determinant; the rest is infinite.
    """
    z = at.transfer.DFx / sizes[:, None]
    k = at.K0 + at.G0
    lower = jnp.linalg.cholesky(z.T @ z)
    flexibility = lower.T @ factorise(k).solve(lower)
    if lacks_potential(topology):
        sign, _ = jnp.linalg.slogdet(k)
        largest = jnp.max(jnp.abs(jnp.linalg.eigvals(flexibility)), initial=0.0)
        lowest = jnp.where(jnp.isfinite(largest) & (sign != 0), sign / largest, 0.0)
        return put(jnp.full(topology.n_q, jnp.inf), jnp.arange(min(1, topology.n_q)), lowest)
    half = jax.lax.linalg.triangular_solve(lower, (k + k.T) / 2, left_side=True, lower=True)
    stiffness = jax.lax.linalg.triangular_solve(lower, half.T, left_side=True, lower=True)
    regular = jnp.all(jnp.isfinite(flexibility))
    soft = jnp.linalg.eigvalsh(jnp.where(regular, (flexibility + flexibility.T) / 2, jnp.eye(topology.n_q)))
    stiff = jnp.linalg.eigvalsh((stiffness + stiffness.T) / 2)
    soft, stiff = soft[jnp.argsort(-jnp.abs(soft))], stiff[jnp.argsort(jnp.abs(stiff))]
    # Beside a nearly singular motion the flexibility does not show the sign of stiff motions.
    known = regular & (jnp.abs(soft) > SOFT_SIGN * jnp.max(jnp.abs(soft), initial=0.0))
    return jnp.sort(jnp.where(known, 1 / jnp.where(known, soft, 1.0), stiff))


def null_vectors(
    topology: Topology,
    at: State,
    sizes: Float[Array, "n_x"],
    shift: Float[Array, ""],
    beside: Float[Array, "n_q"] | None = None,
) -> tuple[Float[Array, "n_q"], Float[Array, "n_q"]]:
    """Right and left null vector phi, psi of a nearly singular stiffness, by inverse iteration with (K + shift Z^T Z).

    The largest entry of DFx phi is 1 in extents and radians. ``shift`` is small beside other eigenvalues, so that an
    exact zero does no harm. The vectors are normal to another null vector ``beside``.
    """
    z = at.transfer.DFx / sizes[:, None]
    metric = z.T @ z
    factors = factorise(at.K0 + at.G0 + shift * metric)
    start = z.T @ uneven(topology.n_x, 1, jnp)

    def normalised(v: Float[Array, "n_q"]):
        if beside is not None:
            square = beside @ metric @ beside
            v = v - beside * (beside @ metric @ v) / jnp.where(square > 0, square, 1.0)
        motion = z @ v
        largest = jnp.max(jnp.abs(motion), initial=0.0)
        first = jnp.argmax(jnp.abs(motion) > (1 - LARGEST_ALIKE) * largest)
        return v / motion[first]

    def turn(_: Array, pair: tuple[Array, Array]):
        phi, psi = pair
        return normalised(factors.solve(metric @ phi)), normalised(factors.solve_transposed(metric @ psi))

    begin = normalised(factors.solve(start)), normalised(factors.solve_transposed(start))
    return jax.lax.fori_loop(0, 4, turn, begin)


def begin_path(topology: Topology, parameters: Parameters) -> tuple[Point, Direction, Scale, State, Int[Array, ""]]:
    """Point, unit tangent with rising load, scale and state at load factor zero, and a code of RESULTS."""
    zero = jnp.array(0.0)
    factors = factors_at(parameters, zero)
    if not begins_undeformed(topology, parameters):
        at, last_strain, result, *_ = solve_state(topology, parameters, factors)
        x, last_strain = jax.lax.stop_gradient((at.x, last_strain))
    else:
        x, last_strain, result = parameters.reference, zero_strain(topology), jnp.zeros((), jnp.int32)
    at = state(topology, parameters, factors, x, last_strain)
    point = Point(x, last_strain, at.e, zero, jnp.zeros(0))
    regular = at.transfer.regular
    result = jnp.where((result == RESULTS.successful) & ~regular, RESULTS.singular_configuration, result)
    onto, by_load = load_response(topology, parameters, at)
    tangent = tangent_at(at, onto, by_load, Plane(jnp.zeros(topology.n_x), jnp.array(1.0)))
    # A hanging body has no stiffness without stress: motions without stiffness do not move at first.
    dq = -jnp.linalg.pinv(at.K0 + at.G0, rtol=FREE_STIFFNESS) @ by_load
    resting = direction_of(at, onto + at.transfer.DFx @ dq, jnp.array(1.0))
    finite = jnp.all(jnp.isfinite(tangent.x))
    tangent = jax.tree.map(lambda a, b: jnp.where(finite, a, b), tangent, resting)
    scale = scale_of(topology, parameters, tangent)
    return point, unit(scale, tangent), scale, at, result.astype(jnp.int32)
