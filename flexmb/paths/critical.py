"""Stability along a path, and its critical points."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..math.indices import put
from ..math.linear import factorise, uneven
from ..mechanics.deformation import zero_near
from ..mechanics.loads import lacks_potential
from ..mechanics.residual import State, state
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS
from ..statics.solve import solve_state
from .stepper import (
    Direction,
    Plane,
    Point,
    Ramp,
    Scale,
    begins_undeformed,
    direction_of,
    load_response,
    ramp_of,
    scale_of,
    tangent_at,
    unit,
)


class CriticalPoint(NamedTuple):
    """A state at which the stiffness is singular.

    Attributes:
        load_factor: Load factor there, () [-].
        kind: "limit": the load turns back; "bifurcation": another branch crosses.
        x: Nodal coordinates, (n_x,) [m, rad, -].
        phi: Motion that meets no stiffness, in the coordinates, its largest entry 1 (extents, radians), (n_x,).
        uncertainty: By how much the load factor may be off at most, () [-]: zero where the state itself was found;
            otherwise half of what it changes between the states on either side, the nearest that were found.
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
    """Values that change sign, one at a time, where the stiffness is singular, and are continuous along a path.

    Symmetric: all eigenvalues of (K, Z^T Z) with Z = DFx in extents and radians, the lowest solved from the side of the
    flexibility, which knows them to full relative accuracy. Unsymmetric: the smallest modulus with the
    sign of the determinant; the rest is infinite.

    Args:
        sizes: What changes of x are measured against, (n_x,) [m, rad].

    Returns:
        (n_q,) [N m], ascending if symmetric.

    Source:
        Sylvester's law of inertia; det K as the product of its eigenvalues.
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
    # Beside a nearly singular motion the flexibility no longer knows the sign of the stiff ones.
    known = regular & (jnp.abs(soft) > 1e-8 * jnp.max(jnp.abs(soft), initial=0.0))
    return jnp.sort(jnp.where(known, 1 / jnp.where(known, soft, 1.0), stiff))


def null_vectors(
    topology: Topology,
    at: State,
    sizes: Float[Array, "n_x"],
    shift: Float[Array, ""],
    beside: Float[Array, "n_q"] | None = None,
) -> tuple[Float[Array, "n_q"], Float[Array, "n_q"]]:
    """Right and left null vector of a nearly singular stiffness, by inverse iteration.

    Args:
        at: State near a critical point.
        sizes: What changes of x are measured against, (n_x,) [m, rad].
        shift: Small beside the other eigenvalues of (K, Z^T Z), so that an exact zero does no harm, () [N m].
        beside: Another null vector, to which these are normal, or zero, (n_q,) [m, rad].

    Returns:
        phi and psi, (n_q,) [m, rad], the largest entry of DFx phi 1 in extents and radians, positive if first.

    Source:
        Inverse iteration with (K + shift Z^T Z).
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
        first = jnp.argmax(jnp.abs(motion) > (1 - 1e-6) * largest)
        return v / motion[first]

    def turn(_: Array, pair: tuple[Array, Array]):
        phi, psi = pair
        return normalised(factors.solve(metric @ phi)), normalised(factors.solve_transposed(metric @ psi))

    begin = normalised(factors.solve(start)), normalised(factors.solve_transposed(start))
    return jax.lax.fori_loop(0, 4, turn, begin)


def begin_path(
    topology: Topology, parameters: Parameters
) -> tuple[Ramp, Point, Direction, Scale, State, Int[Array, ""]]:
    """State at load factor zero and the direction in which the path leaves it.

    Returns:
        Ramp, point, unit tangent with rising load, scale, state, code of RESULTS.
    """
    ramp = ramp_of(topology, parameters)
    zero = jnp.array(0.0)
    if not begins_undeformed(topology, parameters):
        at, near, result, *_ = solve_state(topology, parameters, ramp.at(zero))
        x, near = jax.lax.stop_gradient((at.x, near))
    else:
        x, near, result = parameters.reference, zero_near(topology), jnp.zeros((), jnp.int32)
    at = state(topology, parameters, ramp.at(zero), x, near)
    point = Point(x, near, at.e, zero, jnp.zeros(0))
    regular = at.transfer.regular
    result = jnp.where((result == RESULTS.successful) & ~regular, RESULTS.singular_configuration, result)
    rising = Plane(jnp.zeros(topology.n_x), jnp.array(1.0))
    tangent = tangent_at(topology, parameters, ramp, at, rising)
    # Without stress a hanging body has no stiffness: what meets none is taken not to move at first.
    onto, by_load = load_response(topology, parameters, ramp, at)
    dq = -jnp.linalg.pinv(at.K0 + at.G0, rtol=1e-13) @ by_load
    resting = direction_of(at, onto + at.transfer.DFx @ dq, jnp.array(1.0))
    finite = jnp.all(jnp.isfinite(tangent.x))
    tangent = jax.tree.map(lambda a, b: jnp.where(finite, a, b), tangent, resting)
    scale = scale_of(topology, parameters, tangent)
    return ramp, point, unit(scale, tangent), scale, at, result.astype(jnp.int32)
