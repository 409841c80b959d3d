"""Large mechanisms linearised about their equilibrium: element matrices, of which no whole is formed."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..arguments import is_concrete
from ..compilation.record import Record
from ..compilation.threads import one_thread
from ..display import Result, States, Summary, short
from ..math.element_matrices import ElementMatrices, SparseMatrices, Whole, by_coordinates
from ..mechanics.blocks import kernel
from ..mechanics.inertia import Felt, mass_pieces
from ..mechanics.loads import LoadFactors, lacks_potential, scaled_loads
from ..mechanics.stress_resultants import strain_of
from ..model.by_name import ByName
from ..model.model import Labels, Model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS, collect, or_nan, told
from ..statics.coarse import warn_of_coarse
from ..statics.equilibrium import check_stiffness
from ..statics.sparse import sparse_equilibrium
from ..statics.tangent import by_deformations, element_matrices

# Matrices in the degrees of freedom, which a large mechanism does not form.
DENSE = ("M0", "C0", "D0", "K0", "N0", "G0", "K", "DFx", "DFe", "S", "S_d")


class SparseLinearization(ByName, Result, Record):
    """Linearised equations of motion of a large mechanism about its equilibrium, in all coordinates.

    Modes, compliance, stress, responses and a state space of few modes are asked about it as about a
    :class:`Linearization`. It needs no degrees of freedom, and has no matrix in them.

    Attributes:
        elements: Linearised equations, element by element.
        x: Nodal coordinates at the equilibrium, (n_x,) [m, rad, -].
        e: Deformations there, (n_e,) [m, rad].
        sigma: Stress resultants there, (n_e,) [N, N m].
        felt: Gravity there, which acts along the elements.
        reactions: Forces of the supports there, (n_x,) [N, N m].
        external: Forces from outside there, loads but weight and the supports' together, (n_x,) [N, N m].
        iterations: Newton iterations of the equilibrium.
        result: Code of RESULTS.
        factors: Of the two sets of loads there.
        model: The mechanism they belong to.
    """

    elements: ElementMatrices
    x: Float[Array, "n_x"]
    e: Float[Array, "n_e"]
    sigma: Float[Array, "n_e"]
    felt: Felt
    reactions: Float[Array, "n_x"]
    external: Float[Array, "n_x"]
    iterations: Int[Array, ""]
    result: Int[Array, ""]
    factors: LoadFactors
    model: Model
    one_axis = "x"

    def __getattr__(self, name: str) -> Any:
        if name in DENSE:
            raise AttributeError(
                f"The linearisation of a large mechanism has no {name}, a matrix in the degrees of freedom: ask its"
                " sparse() for K, C, M and D in the coordinates, or give fm.linearize(model, sparse=False)."
            )
        raise AttributeError(f"A SparseLinearization has no {name}.")

    @property
    def matrices(self) -> "SparseLinearization":
        """What holds the state, as :class:`Linearization` has it: this object."""
        return self

    @property
    def labels(self) -> Labels:
        """Names."""
        return self.model.labels

    @property
    def symmetric(self) -> bool:
        """Whether the stiffness is symmetric by the nature of the loads and laws."""
        return not lacks_potential(self.model.topology)

    def sparse(self) -> SparseMatrices:
        """Matrices M v'' + C v' + K v + D^T m = f, D v = 0 of the coordinates v that move, as SciPy's sparse ones.

        Returns:
            K, C, M, (n, n), and the constraints D, (h, n) [SI]. The coordinates are ``lin.elements.free``; the
            multipliers m are changes of the stress resultants ``lin.elements.held``.

        Raises:
            TypeError: Under a trace.
        """
        if not is_concrete(self.elements):
            raise TypeError("Sparse matrices are those of concrete numbers: ask for them outside jax.jit and jax.grad.")
        return Whole(jax.tree.map(np.asarray, self.elements)).apart()

    def states(self) -> States:
        """The state that the equations are about."""
        return States(self.model, self.x)

    def summary(self) -> Summary:
        """Outcome, sizes and the largest displacement."""
        moving, constraints = self.elements.unknowns
        positions = np.array([entry.kind == "position" for entry in self.labels.x])
        moved = np.asarray(self.x - self.model.parameters.reference)[positions]
        rows = {
            "result": told(self.result),
            "coordinates that move": str(moving),
            "constraints": str(constraints),
            "largest displacement": f"{short(np.max(np.abs(moved), initial=0.0))} m",
        }
        return Summary("SparseLinearization about an equilibrium", rows, "mechanism")


@kernel
def moving_element_matrices(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    x: Float[Array, "n_x"],
    e: Float[Array, "n_e"],
    sigma: Float[Array, "n_e"],
) -> ElementMatrices:
    """Matrices of all elements about a state at rest, damping and mass among them.

    Args:
        topology: Structure, which needs no degrees of freedom.
        parameters: Numbers; differentiable.
        factors: Of the loads there.
        x: Nodal coordinates, (n_x,) [m, rad, -].
        e: Deformations, (n_e,) [m, rad].
        sigma: Stress resultants with all multipliers, (n_e,) [N, N m].

    Source:
        THEORY.md 7, eq. (7.15); 6, eq. (6.2) and (6.3), before they are projected.
    """
    found, _ = element_matrices(topology, parameters, factors, x, jax.lax.stop_gradient(e), sigma, e)
    strain = strain_of(topology, parameters, scaled_loads(parameters, factors), e)
    viscous = by_deformations(topology, parameters, strain, found.constraints, "damping")
    damping = by_coordinates(found.constraints, viscous)
    return found._replace(damping=damping, mass=mass_pieces(topology, parameters, x), viscous=viscous)


@one_thread()
def sparse_linearization(model: Model, target: LoadFactors, throw: bool = True) -> SparseLinearization:
    """Linearised equations about the static equilibrium, element by element.

    Args:
        model: As for :func:`flexmb.statics.sparse.sparse_equilibrium`.
        target: Load factors.
        throw: Raise where the equilibrium fails; otherwise the code is in ``result``.

    Raises:
        AnalysisError: singular_configuration, singular_stiffness or not_converged.
    """
    found, unstable = sparse_equilibrium(model.topology, model.parameters, target)
    if is_concrete(unstable) and unstable:
        collect(RESULTS.unstable_state)
    check_stiffness(model, found[-1], throw)
    warn_of_coarse(model, found[1])
    return about_state(model, target, *or_nan(found, found[-1], throw))


def about_state(
    model: Model,
    factors: LoadFactors,
    x: Float[Array, "n_x"],
    e: Float[Array, "n_e"],
    sigma: Float[Array, "n_e"],
    felt: Felt,
    reactions: Float[Array, "n_x"],
    external: Float[Array, "n_x"],
    iterations: Array,
    result: Array,
) -> SparseLinearization:
    """Linearised equations about a state at rest that has been found, element by element.

    Args:
        factors: Load factors there; what follows is as :class:`SparseLinearization` has it.
    """
    factors = LoadFactors(*(jnp.asarray(factor, float) for factor in factors))
    elements = moving_element_matrices(model.topology, model.parameters, factors, x, e, sigma)
    return SparseLinearization(elements, x, e, sigma, felt, reactions, external, iterations, result, factors, model)
