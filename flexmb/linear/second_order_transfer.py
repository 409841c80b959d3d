"""Second-order geometric transfer functions about a linearised state."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..display import kind_of
from ..mechanics.deformation import correction, deformation_jacobian, transfer
from ..mechanics.prepared import kernel
from ..model.topology import Parameters, Topology
from .about import linearized
from .linearize import Linearization, Matrices


@kernel
def _second_transfer(topology: Topology, parameters: Parameters, m: Matrices):
    last_strain = jax.lax.stop_gradient(m.e)
    _, jacobian = deformation_jacobian(topology, parameters, m.x, last_strain)
    tangent = transfer(topology, jacobian)

    def along(i: Float[Array, "n_x"], j: Float[Array, "n_x"]):
        def once(x: Float[Array, "n_x"]):
            _, d = deformation_jacobian(topology, parameters, x, last_strain)
            return d @ i

        return jax.jvp(once, (m.x,), (j,))[1]

    columns = m.DFx.T
    bend = jax.vmap(jax.vmap(along, (None, 0)), (0, None))(columns, columns)

    def second(curved: Float[Array, "n_e"]):
        dx = correction(topology, tangent, curved, jnp.zeros(topology.n_x))
        return dx, curved + jacobian @ dx

    d2x, d2e = jax.vmap(jax.vmap(second))(bend)
    return jnp.moveaxis(d2x, -1, 0), jnp.moveaxis(d2e, -1, 0)


def second_transfer(lin: Linearization) -> tuple[Float[Array, "n_x n_q n_q"], Float[Array, "n_e n_q n_q"]]:
    """Return the second-order geometric transfer functions about the linearised state.

    Args:
        lin: Linearization.

    Returns:
        D2Fx, (n_x, n_q, n_q), and D2Fe, (n_e, n_q, n_q) [unit of x or e / (unit of q)^2].

    Raises:
        TypeError: `lin` is no Linearization.

    Source:
        Second derivative of D(F(q)) = e: D_x D2Fx = -(D2D DFx) DFx on the constrained deformations, THEORY.md 4, eq.
        (4.4).
    """
    if not isinstance(lin, Linearization):
        raise TypeError(
            f"fm.linear.second_transfer needs a Linearization, not {kind_of(lin)}. Give fm.linearize(model)."
        )
    linearized(lin, "second_transfer")
    return _second_transfer(lin.model.topology, lin.model.parameters, lin.matrices)
