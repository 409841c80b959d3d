"""Geometric transfer functions: how all coordinates and deformations follow from the degrees of freedom."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..compilation.compile import traced_once
from ..math.indices import accumulate, put
from ..math.linear import Factors, factorise
from ..model.topology import Topology

# From this number of entries of DFe on, products skip its rows of zeros and of the identity.
MANY = 1000


class Transfer(NamedTuple):
    """First-order transfer functions at a configuration, and factors of A = dD^{o,m}/dx_dep.

    Attributes:
        DFx: Derivative of the nodal coordinates by q.
        DFe: Derivative of the deformations by q.
        factors: LU factors of A. Rows: FIXED, PRESCRIBED and DOF deformations; columns: DEPENDENT coordinates.
        regular: Whether A can be trusted.
        rows: DOF and DEPENDENT deformations if most are DOF: all other rows of DFe are zero. Otherwise None.
    """

    DFx: Float[Array, "n_x n_q"]
    DFe: Float[Array, "n_e n_q"]
    factors: Factors
    regular: Bool[Array, ""]
    rows: tuple[Int[Array, "n_dof"], Int[Array, "n_dep"]] | None = None

    def between(self, stiffness: Float[Array, "n_e n_e"]) -> Float[Array, "n_q n_q"]:
        """DFe^T S DFe."""
        if self.rows is None:
            return self.DFe.T @ stiffness @ self.DFe
        dof, dependent = self.rows
        first, follow = self.DFe.shape[1] - dof.shape[0], self.DFe[dependent]
        of_dof, of_dependent = stiffness[dof], stiffness[dependent]
        product = follow.T @ (of_dependent[:, dependent] @ follow)
        product = product.at[:, first:].add(follow.T @ of_dependent[:, dof])
        return product.at[first:].add(of_dof[:, dependent] @ follow).at[first:, first:].add(of_dof[:, dof])


@traced_once
def transfer(topology: Topology, jacobian: Float[Array, "n_e n_x"]) -> Transfer:
    """Transfer functions by implicit differentiation of D(x) = e: DFx = -A^-1 dD/dq-part, DFe = D_x DFx.

    Source: THEORY.md 4, eq. (4.3); tutorial WA 1239 (2012), ch. 1 and reference [10] there.
    """
    rows, dependent = topology.e.given, topology.x.dependent
    held = jacobian[rows]
    factors = factorise(held[:, dependent])
    by_coordinates = -held[:, topology.x.dof]
    n_held, n_dof = rows.shape[0], topology.e.dof.shape[0]
    by_deformations = jnp.eye(n_held, n_dof, k=-(n_held - n_dof)) if n_dof else jnp.zeros((n_held, 0))
    solved = factors.solve(jnp.concatenate([by_coordinates, by_deformations], axis=1))
    n_coordinates = topology.x.dof.shape[0]
    dfx = put(jnp.zeros((topology.n_x, topology.n_q)), dependent, solved)
    dfx = put(dfx, topology.x.dof, jnp.eye(n_coordinates, topology.n_q))
    free, n_e = topology.e.dependent, topology.n_e
    if n_e * topology.n_q < MANY or 2 * (n_e - n_dof) > n_e:
        return Transfer(dfx, jacobian @ dfx, factors, factors.regular())
    dfe = put(jnp.zeros((n_e, topology.n_q)), topology.e.dof, jnp.eye(n_dof, topology.n_q, k=n_coordinates))
    dfe = put(dfe, free, jacobian[free] @ dfx)
    return Transfer(dfx, dfe, factors, factors.regular(), (topology.e.dof, free))


def multipliers(
    topology: Topology,
    tangent: Transfer,
    jacobian: Float[Array, "n_e n_x"],
    sigma: Float[Array, "n_e"],
    force: Float[Array, "n_x"],
) -> Float[Array, "n_e"]:
    """Stress resultants with multipliers at FIXED and PRESCRIBED deformations, whose entries in ``sigma`` are ignored.

    They balance the forces on the DEPENDENT coordinates, A^T s = f - D_x^T sigma there. At an equilibrium the part of s
    of DOF deformations vanishes. Source: THEORY.md 5, eq. (5.5).
    """
    fixed = topology.e.held
    sigma = put(sigma, fixed, 0.0)
    out_of_balance = (force - jacobian.T @ sigma)[topology.x.dependent]
    solved = tangent.factors.solve_transposed(out_of_balance)
    return put(sigma, fixed, solved[: fixed.shape[0]])


def correction(
    topology: Topology, tangent: Transfer, excess: Float[Array, "n_e"], shift: Float[Array, "n_x"]
) -> Float[Array, "n_x"]:
    """Change of x that removes, to first order, an excess of held deformations; THEORY.md 4, eq. (4.2).

    Args:
        excess: Deformations minus their wanted values; DEPENDENT entries are ignored.
        shift: Change already decided of other coordinates, whose effect ``excess`` includes.
    """
    right = -excess[topology.e.given]
    return accumulate(shift, topology.x.dependent, tangent.factors.solve(right))
