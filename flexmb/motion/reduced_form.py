"""Equations of motion in the degrees of freedom; Newton's method computes the other coordinates."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..compilation.compile import jit_beside_options
from ..compilation.record import Record
from ..math.linear import factorise, is_positive_definite
from ..mechanics.deformation import deformation_jacobian
from ..mechanics.inertia import mass_matrix
from ..model.topology import coordinate_scales
from .coordinates_form import CoordinatesForm
from .element_forces import Moving
from .moving_matrices import dynamic_balance, moving_matrices, state_at_rates
from .protocol import MotionState, Tangent, WholeMotion, by_time


class ReducedForm(Record):
    """Equations of motion M(q) q_ddot + h(q, q_dot) = DFx^T f - DFe^T sigma.

    Constraints hold in each evaluation, so nothing drifts. At a dead point the degrees of freedom do not determine the
    other coordinates, and the form fails. The memory stores coordinates and deformations, where Newton's method starts.

    Attributes:
        form: The same equations in all coordinates.
        sizes: Sizes that make the degrees of freedom pure numbers [m, -].
    """

    form: CoordinatesForm
    sizes: Float[Array, "n_q"]

    @property
    def states(self) -> int:
        """Number of states of a controller."""
        return 0

    @property
    def size(self) -> int:
        """Number of degrees of freedom."""
        return self.sizes.shape[0]

    @property
    def unknowns(self) -> int:
        """Number of second rates."""
        return self.size

    def regular(self, by_z: Float[Array, "n_q n_q"]):
        """Whether all motions carry mass."""
        return is_positive_definite(by_z)

    def state_of(
        self, x: Float[Array, "n_x"], xd: Float[Array, "n_x"], near: Float[Array, "n_e"] | None
    ) -> MotionState:
        """State of nodal coordinates."""
        top, parameters = self.form.topology, self.form.parameters
        guess = jnp.zeros(top.n_e) if near is None else near
        e, jacobian = deformation_jacobian(top, parameters, x, guess)
        moved = (x - parameters.reference)[top.x.dof]
        q = jnp.concatenate([moved, e[top.e.dof]])
        qd = jnp.concatenate([xd[top.x.dof], (jacobian @ xd)[top.e.dof]])
        return MotionState(q / self.sizes, qd / self.sizes, jnp.concatenate([x, e]))

    def placed(self, t: Float[Array, ""], u: Float[Array, "n_q"], memory: Float[Array, "k"]):
        """All coordinates and deformations at degrees of freedom u, from the guess in the memory."""
        n_x = self.form.topology.n_x
        return self.form.placed(self.form.whole(t), u * self.sizes, memory[:n_x], memory[n_x:])

    def everything(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "n_q"]) -> Moving:
        """State of motion in all coordinates; z are the second rates over their sizes."""
        x, last_strain = self.placed(t, state.u, state.memory)
        return state_at_rates(self.form, t, x, state.w * self.sizes, z * self.sizes, last_strain)

    def residual(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "n_q"]):
        """Forces out of balance along the degrees of freedom (THEORY.md 5, eq. (5.3))."""
        return dynamic_balance(self.form, t, self.everything(t, state, z)).residual * self.sizes

    def tangent(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "n_q"]) -> Tangent:
        """Derivatives of the residual (THEORY.md 6, eq. (6.1))."""
        at, _ = moving_matrices(self.form, t, self.everything(t, state, z))
        by_u, by_w, by_z = (self.sizes[:, None] * m * self.sizes for m in (at.K, at.C0 + at.D0, at.M0))
        by_t = by_time(self, t, state, z) if self.form.driven else None
        return Tangent(by_u, by_w, by_z, by_t)

    @jit_beside_options
    def acceleration(self, t: Float[Array, ""], state: MotionState):
        """Second rates of the degrees of freedom over their sizes, and whether all motions carry mass."""
        moving = self.everything(t, state, jnp.zeros(self.size))
        at = dynamic_balance(self.form, t, moving)
        along = at.tangent.DFx
        mass = along.T @ mass_matrix(self.form.topology, self.form.parameters, moving.x) @ along
        mass = self.sizes[:, None] * mass * self.sizes
        return factorise(mass).solve(-at.residual * self.sizes), self.regular(mass) & at.tangent.regular

    def gap(self, t: Float[Array, ""], state: MotionState):
        """No constraints have multipliers."""
        return jnp.zeros(0)

    def rate_of_memory(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "n_q"]):
        """Rates of coordinates and deformations."""
        x, v, _, last_strain = self.everything(t, state, jnp.zeros(self.size))
        _, jacobian = deformation_jacobian(self.form.topology, self.form.parameters, x, last_strain)
        return jnp.concatenate([v, jacobian @ v])

    def settle(self, t: Float[Array, ""], state: MotionState, mass: Float[Array, "n n"] | None = None) -> MotionState:
        """State with its memory updated; constraints always hold."""
        return state._replace(memory=jnp.concatenate(self.placed(t, state.u, state.memory)))

    def whole_motion(self, t: Float[Array, ""], state: MotionState) -> WholeMotion:
        """Coordinates, velocities and deformations of a state; no inputs."""
        x, v, _, last_strain = self.everything(t, state, jnp.zeros(self.size))
        return WholeMotion(x, v, last_strain, jnp.zeros(0))


def reduced_form(form: CoordinatesForm) -> ReducedForm:
    """Equations of motion in the degrees of freedom of a model."""
    top = form.topology
    sizes = jax.lax.stop_gradient(coordinate_scales(top, form.parameters))[top.x.dof]
    return ReducedForm(form, jnp.concatenate([sizes, jnp.ones(top.e.dof.shape[0])]))
