"""Linearised equations about a state of motion, in the degrees of freedom."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from ..linear.linearize import Matrices, Rates
from ..math.indices import put
from ..mechanics.deformation import Transfer, correction, deformation_curvature, multipliers, transfer
from ..mechanics.inertia import InertialLoad, weight_stiffness
from ..mechanics.loads import LoadFactors, load_stiffness
from ..results import RESULTS
from .coordinates_form import AllCoordinates, CoordinatesForm
from .element_forces import Moving, acting_forces, deformations_and_slopes, force_derivatives


def dependent_changes(form: CoordinatesForm, tangent: Transfer, rows: Float[Array, "n_e k"]) -> Float[Array, "n_x k"]:
    """Changes of the DEPENDENT coordinates that cancel changes of the held deformations at constant q."""
    top = form.topology
    change = tangent.factors.solve(-rows[top.e.given])
    return jnp.zeros((top.n_x, rows.shape[1])).at[top.x.dependent].set(change)


class DynamicBalance(NamedTuple):
    """Stress resultants, nodal forces minus inertia forces, D_x and transfer functions at a state of motion."""

    sigma: Float[Array, "n_e"]
    force: Float[Array, "n_x"]
    jacobian: Float[Array, "n_e n_x"]
    tangent: Transfer

    @property
    def residual(self) -> Float[Array, "n_q"]:
        """Force out of balance along each degree of freedom."""
        return self.tangent.DFe.T @ self.sigma - self.tangent.DFx.T @ self.force


def dynamic_balance(form: CoordinatesForm, t: Float[Array, ""], moving: Moving) -> DynamicBalance:
    """Forces at a state of motion, multipliers from DEPENDENT coordinates (THEORY.md 5, eq. (5.2) and (5.5))."""
    top = form.topology
    _, jacobian = deformations_and_slopes(form.elements, moving.x, moving.near)
    tangent = transfer(top, jacobian)
    nothing = jnp.zeros(form.held.shape[0])
    acting = acting_forces(form.elements, moving, form.falling, form.stress_of(t, nothing))
    # Loads and inertia forces, without stress.
    force = form.applied(t, moving.x) - acting.force + jacobian.T @ acting.sigma
    return DynamicBalance(multipliers(top, tangent, jacobian, acting.sigma, force), force, jacobian, tangent)


def moving_matrices(form: CoordinatesForm, t: Float[Array, ""], moving: Moving) -> tuple[Matrices, Float[Array, "n_q"]]:
    """Linearised equations about a state of motion, and the force out of balance (THEORY.md 6, eq. (6.4) and (6.5)).

    For dx = DFx dq the velocities change by DFx dqd + DFx_d dq with DFx_d = -A^-1 (D_xx v) DFx. The accelerations
    change by DFx dqdd + 2 DFx_d dqd + DFx_dd dq with DFx_dd = -A^-1 (d(e_ddot)/dx DFx + 2 (D_xx v) DFx_d).
    """
    top, parameters = form.topology, form.parameters
    x, v, a, last_strain = moving
    at = dynamic_balance(form, t, moving)
    tangent, z, sigma, jacobian = at.tangent, at.tangent.DFx, at.sigma, at.jacobian
    drive = form.drive(t)
    factors = LoadFactors(1.0, drive.increment)
    by_x = force_derivatives(form.elements, moving, None, lambda e, ed: sigma)
    curvature = deformation_curvature(top, parameters, x, last_strain, sigma)
    rates = by_x.ed @ z
    turning = dependent_changes(form, tangent, rates)
    second = by_x.edd @ z + 2 * by_x.ed @ turning
    by_q = dependent_changes(form, tangent, second)
    loads = load_stiffness(top, parameters, factors, x)
    if drive.turning is not None:
        loads = loads + drive.turning
    if form.gravity is not None:
        loads = loads + weight_stiffness(top, parameters, x, form.gravity)
    n0 = z.T @ ((by_x.by_x - curvature) @ z + by_x.by_v @ turning + by_x.mass @ by_q)
    dfe = tangent.DFe
    constrained = top.x.held
    stiffness, damping = form.tangents_at(t, x, v, last_strain)
    rate_of_dfe = rates + jacobian @ turning
    n0 = n0 + dfe.T @ damping @ rate_of_dfe
    m0, k0, c0 = z.T @ by_x.mass @ z, dfe.T @ stiffness @ dfe, z.T @ (by_x.by_v @ z + 2 * by_x.mass @ turning)
    g0 = z.T @ (curvature - loads) @ z
    finite = jnp.all(jnp.isfinite(m0)) & jnp.all(jnp.isfinite(k0 + n0 + g0)) & jnp.all(jnp.isfinite(c0))
    # Without mass the acceleration is unknown, and with it all that follows.
    result = jnp.where(finite, RESULTS.successful, RESULTS.singular_mass)
    result = jnp.where(tangent.regular, result, RESULTS.singular_configuration)
    reactions = put(jnp.zeros(top.n_x), constrained, (jacobian.T @ sigma - at.force)[constrained])
    matrices = Matrices(
        M0=m0,
        C0=c0,
        D0=dfe.T @ damping @ dfe,
        K0=k0,
        N0=n0,
        G0=g0,
        DFx=z,
        DFe=dfe,
        S=stiffness,
        S_d=damping,
        x=x,
        e=last_strain,
        sigma=sigma,
        felt=InertialLoad(form.gravity, v, a),
        reactions=reactions,
        external=form.applied(t, x) + reactions,
        iterations=jnp.zeros((), jnp.int32),
        result=result.astype(jnp.int32),
        symmetric=False,
        moving=Rates(v, a, turning, by_q, rate_of_dfe, second + jacobian @ by_q),
        factors=LoadFactors(jnp.ones(()), jnp.asarray(drive.increment, float)),
        turning=drive.turning,
    )
    return matrices, at.residual


def rates_at(
    form: CoordinatesForm,
    given: AllCoordinates,
    tangent: Transfer,
    jacobian: Float[Array, "n_e n_x"],
    qd: Float[Array, "n_q"],
    speed: float | Float[Array, ""] = 1.0,
) -> Float[Array, "n_x"]:
    """Velocities of all coordinates at rates qd of the degrees of freedom; `speed` scales prescribed rates."""
    still = jnp.zeros(form.topology.n_e)
    return tangent.DFx @ qd + speed * _following(form, tangent, jacobian, given.v, given.ed, still)


def _following(
    form: CoordinatesForm, tangent: Transfer, jacobian: Array, moved: Array, prescribed: Array, convective: Array
):
    """Change of all coordinates when prescribed ones change at constant degrees of freedom."""
    excess = put(jnp.zeros(form.topology.n_e), form.held, -prescribed) + jacobian @ moved + convective
    return correction(form.topology, tangent, excess, moved)


def state_at_rates(
    form: CoordinatesForm,
    t: Float[Array, ""],
    x: Float[Array, "n_x"],
    qd: Float[Array, "n_q"],
    qdd: Float[Array, "n_q"],
    near: Float[Array, "n_e"],
    speed: float | Float[Array, ""] = 1.0,
) -> Moving:
    """State of motion at rates of the degrees of freedom; `speed` scales prescribed rates."""
    top = form.topology
    prescribed = form.whole(t)
    _, jacobian = deformations_and_slopes(form.elements, x, near)
    tangent = transfer(top, jacobian)
    v = rates_at(form, prescribed, tangent, jacobian, qd, speed)
    still, nothing = jnp.zeros(top.n_x), jnp.zeros(form.held.shape[0])
    kin = acting_forces(form.elements, Moving(x, v, still, near), None, form.stress_of(t, nothing)).kinematics
    driven = _following(form, tangent, jacobian, speed**2 * prescribed.a, speed**2 * prescribed.edd, kin.edd)
    a = tangent.DFx @ qdd + driven
    return Moving(x, v, a, near)
