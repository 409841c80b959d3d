"""Linearised equations of motion about the static equilibrium."""

import re
from typing import Any, ClassVar, Generic, NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..arguments import check_whole, computed, is_concrete
from ..compilation.compile import unguarded
from ..compilation.record import Record, static
from ..compilation.threads import one_thread
from ..display import Result, States, Summary, listed, short
from ..math.element_matrices import AssembledEquations, ElementMatrices, SparseMatrices, by_coordinates
from ..math.linear_solver import DENSE as DENSE_SOLVER
from ..math.linear_solver import SPARSE, LinearSolver
from ..mechanics.inertia import InertialLoad, mass_matrix, mass_pieces
from ..mechanics.loads import LoadFactors, lacks_potential, load_factors_of, scaled_loads
from ..mechanics.prepared import kernel
from ..mechanics.residual import State, state
from ..mechanics.stress_resultants import depends_on_rates, element_damping, strain_of, stress_tangents
from ..model.by_name import ByName, node_motions
from ..model.model import Labels, Model, as_determined, as_model
from ..model.topology import Parameters, Topology
from ..results import RESULTS, check, collect, or_nan, outcome_text
from ..statics.coarse import warn_of_coarse
from ..statics.equilibrium import Equilibrium, check_stiffness
from ..statics.solve import acting_at, solve_state
from ..statics.solver_choice import asked_solver
from ..statics.sparse import sparse_equilibrium
from ..statics.stable import collect_unstable
from ..statics.tangent import by_deformations, element_matrices

# Matrices in the degrees of freedom; a large mechanism has none.
DENSE = ("M0", "C0", "D0", "K0", "N0", "G0", "K", "DFx", "DFe", "S", "S_d")


class Rates(Record):
    """Motion of a linearised state, and rates of the transfer functions along it.

    Attributes:
        xd: Velocities of the nodal coordinates [1/s].
        xdd: Their accelerations [1/s^2].
        DFx_d, DFx_dd: First and second rate of DFx.
        DFe_d, DFe_dd: First and second rate of DFe.
    """

    xd: Float[Array, "n_x"]
    xdd: Float[Array, "n_x"]
    DFx_d: Float[Array, "n_x n_q"]
    DFx_dd: Float[Array, "n_x n_q"]
    DFe_d: Float[Array, "n_e n_q"]
    DFe_dd: Float[Array, "n_e n_q"]


class Matrices(Result, Record):
    """Linearised equations M0 qdd + (C0 + D0) qd + (K0 + N0 + G0) q = DFx^T f - DFe^T sigma, with numbers only.

    Attributes:
        M0: Mass, (n_q, n_q).
        C0: Velocity matrix of the inertia forces, (n_q, n_q); zero about a state at rest.
        D0: Damping, (n_q, n_q).
        K0: Structural stiffness, (n_q, n_q).
        N0: Dynamic stiffness, (n_q, n_q); zero about a state at rest.
        G0: Geometric stiffness of stress resultants, constraint forces and loads, (n_q, n_q).
        DFx: First-order transfer function of the coordinates, (n_x, n_q).
        DFe: First-order transfer function of the deformations, (n_e, n_q).
        S: Stiffness of the elements, tangent if it is not constant, (n_e, n_e).
        S_d: Damping of the elements, likewise, (n_e, n_e).
        x: Nodal coordinates of the state, (n_x,) [m, rad, -].
        e: Deformations there, (n_e,) [m, rad].
        sigma: Stress resultants there, (n_e,) [N, N m].
        felt: Gravity and inertial load there, distributed along the elements.
        reactions: Forces of the supports there, (n_x,) [N, N m].
        external: Loads except weight, plus reactions, there, (n_x,) [N, N m].
        iterations: Newton iterations of the equilibrium.
        result: Code of RESULTS.
        symmetric: Whether loads and laws have a potential, so that the stiffness is symmetric.
        moving: Motion of the state; None at rest.
        factors: Factors of the two sets of loads there.
        turning: Matrix from coordinates to nodal forces of moments that are functions of time, (n_x, n_x), or None.
    """

    M0: Float[Array, "n_q n_q"]
    C0: Float[Array, "n_q n_q"]
    D0: Float[Array, "n_q n_q"]
    K0: Float[Array, "n_q n_q"]
    N0: Float[Array, "n_q n_q"]
    G0: Float[Array, "n_q n_q"]
    DFx: Float[Array, "n_x n_q"]
    DFe: Float[Array, "n_e n_q"]
    S: Float[Array, "n_e n_e"]
    S_d: Float[Array, "n_e n_e"]
    x: Float[Array, "n_x"]
    e: Float[Array, "n_e"]
    sigma: Float[Array, "n_e"]
    felt: InertialLoad
    reactions: Float[Array, "n_x"]
    external: Float[Array, "n_x"]
    iterations: Int[Array, ""]
    result: Int[Array, ""]
    symmetric: bool = static()
    moving: Rates | None = None
    factors: LoadFactors | None = None
    turning: Float[Array, "n_x n_x"] | None = None

    @property
    def K(self) -> Float[Array, "*states n_q n_q"]:
        """Total stiffness K0 + N0 + G0."""
        return computed(lambda _, *parts: sum(parts), self.K0, self.N0, self.G0)


class LargeMatrices(Record):
    """Linearised equations of a large mechanism at rest, element by element; other attributes as in :class:`Matrices`.

    Attributes:
        elements: In all coordinates, with multipliers of the constraints.
        solver: Solver of these equations.
    """

    elements: ElementMatrices
    x: Float[Array, "n_x"]
    e: Float[Array, "n_e"]
    sigma: Float[Array, "n_e"]
    felt: InertialLoad
    reactions: Float[Array, "n_x"]
    external: Float[Array, "n_x"]
    iterations: Int[Array, ""]
    result: Int[Array, ""]
    factors: LoadFactors
    symmetric: bool = static()
    solver: LinearSolver = static(default=SPARSE)
    moving: ClassVar[None] = None


T = TypeVar("T")


class _Of(Generic[T]):
    """Descriptor of a result: an attribute of its ``matrices`` under the same name."""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name
        # ``help`` prints the description of the matrix.
        match = re.search(rf"^ +{name}: (.*(?:\n {{12}}.*)*)", Matrices.__doc__ or "", re.M)
        self.__doc__ = " ".join(match.group(1).split()) if match else None

    def __get__(self, result: Any, owner: type) -> T:
        descriptor: Any = self
        if result is None:
            return descriptor
        if self.name in DENSE and isinstance(result.matrices, LargeMatrices):
            raise AttributeError(
                f"The linearisation of a large mechanism has no {self.name}, a matrix in the degrees of freedom. Use"
                " its sparse() for K, C, M and D in the coordinates, or give fm.linearize(model, sparse=False)."
            )
        return getattr(result.matrices, self.name)

    def __set__(self, result: Any, value: Any) -> None:
        raise AttributeError(f"{self.name} cannot be changed: it is {self.name} of .matrices.")


class AboutState:
    """Base class of results with the matrices of one or several states: ``lin.K0`` is ``lin.matrices.K0``."""

    M0 = _Of[Float[Array, "*states n_q n_q"]]()
    C0 = _Of[Float[Array, "*states n_q n_q"]]()
    D0 = _Of[Float[Array, "*states n_q n_q"]]()
    K0 = _Of[Float[Array, "*states n_q n_q"]]()
    N0 = _Of[Float[Array, "*states n_q n_q"]]()
    G0 = _Of[Float[Array, "*states n_q n_q"]]()
    K = _Of[Float[Array, "*states n_q n_q"]]()
    DFx = _Of[Float[Array, "*states n_x n_q"]]()
    DFe = _Of[Float[Array, "*states n_e n_q"]]()
    S = _Of[Float[Array, "*states n_e n_e"]]()
    S_d = _Of[Float[Array, "*states n_e n_e"]]()
    x = _Of[Float[Array, "*states n_x"]]()
    e = _Of[Float[Array, "*states n_e"]]()
    sigma = _Of[Float[Array, "*states n_e"]]()
    felt = _Of[InertialLoad]()
    reactions = _Of[Float[Array, "*states n_x"]]()
    external = _Of[Float[Array, "*states n_x"]]()
    iterations = _Of[Int[Array, "*states"]]()
    symmetric = _Of[bool]()
    moving = _Of[Rates | None]()


class Linearization(ByName, AboutState, Result, Record):
    """Linearised equations of motion about the equilibrium of a model.

    The attributes of :class:`Matrices` are attributes of this object too (``lin.K0``). A large mechanism needs
    no degrees of freedom. Its equations are in all coordinates: ``lin.elements`` and ``lin.sparse()``.

    Attributes:
        matrices: The numbers: :class:`Matrices`, or :class:`LargeMatrices`.
        model: Mechanism of these equations.
    """

    matrices: Any
    model: Model
    result = _Of[Int[Array, "*states"]]()
    elements = _Of[ElementMatrices]()
    solver = _Of[LinearSolver]()
    one_axis = "x"

    @property
    def large(self) -> bool:
        """Whether the equations are in all coordinates, element by element."""
        return isinstance(self.matrices, LargeMatrices)

    @property
    def labels(self) -> Labels:
        """Names."""
        return self.model.labels

    def sparse(self) -> SparseMatrices:
        """Return SciPy's sparse matrices of M v'' + C v' + K v + D^T m = f, D v = 0, for the coordinates v that move.

        Returns:
            K, C, M, (n, n), and the constraints D, (h, n) [SI]. The coordinates are ``lin.elements.free``. The
                multipliers m are changes of the stress resultants ``lin.elements.held``.

        Raises:
            TypeError: Under a trace, or for a linearisation in degrees of freedom.
        """
        if not self.large:
            raise TypeError("This linearisation has no sparse matrices. Give fm.linearize(model, sparse=True).")
        if not is_concrete(self.elements):
            raise TypeError("Sparse matrices need concrete numbers. Use them outside jax.jit and jax.grad.")
        return AssembledEquations(jax.tree.map(np.asarray, self.elements)).apart()

    def at_time(self, number: int) -> "Linearization":
        """Return the linearised equations at one time of a motion, from :func:`flexmb.motion.linearize_motion`.

        Args:
            number: Number of the time, from 0; negative from the end.

        Raises:
            ValueError, IndexError: This is the linearisation of one state; there are fewer times.
        """
        if self.large or self.matrices.M0.ndim == 2:
            raise ValueError("This is the linearisation of one state: it has no times to choose from.")
        count, chosen = self.matrices.M0.shape[0], check_whole("number", number)
        if not -count <= chosen < count:
            raise IndexError(f"There are {count} times, numbered from 0. Number {chosen} is none of them.")
        return Linearization(jax.tree.map(lambda a: computed(lambda _, a: a[chosen], a), self.matrices), self.model)

    @property
    def condition(self) -> float:
        """Condition number of the stiffness, scaled to a diagonal of ones; infinite if singular.

        A condition number of 10^n costs n digits in the derivatives of the equilibrium and of all later results.

        Source:
            Van der Sluis (1969), Numerische Mathematik 14, 14: near the smallest condition number in any units.
        """
        k = np.asarray(self.K)
        scale = np.sqrt(np.maximum(np.abs(np.diag(k)), np.finfo(float).tiny))
        return float(np.linalg.cond(k / scale[:, None] / scale)) if len(k) else 1.0

    def states(self) -> States:
        """Return the state of the linearisation."""
        return States(self.model, self.x)

    def summary(self) -> Summary:
        """Return outcome, largest displacement, and diagonals of mass and stiffness (sizes for a large mechanism)."""
        model, names = self.model, self.labels.x
        positions = [i for i, entry in enumerate(names) if entry.kind == "position"]
        moved = np.asarray(self.x - model.parameters.reference)[positions]
        rows = {"result": outcome_text(self.result)}
        displaced = {"largest displacement": f"{short(np.max(np.abs(moved), initial=0.0))} m"}
        if self.large:
            moving, constraints = self.elements.unknowns
            rows |= {"coordinates that move": str(moving), "constraints": str(constraints)}
            return Summary("Linearization about an equilibrium, element by element", rows | displaced, "mechanism")
        furthest = f", {names[positions[np.argmax(np.abs(moved))]]} is displaced most" if np.any(moved) else ""
        rows |= {"degrees of freedom": str(self.M0.shape[0])} | displaced
        rows["diagonal of M0"] = listed(np.diag(np.asarray(self.M0)))
        rows["diagonal of K0 + N0 + G0"] = listed(np.diag(np.asarray(self.K)))
        about = "an equilibrium" if self.moving is None else "a motion"
        freedoms = listed(model.q_labels) if names else "without names"
        return Summary(f"Linearization about {about}: {freedoms}{furthest}", rows, "mechanism")


class Stressed(NamedTuple):
    """Coordinates, stress resultants, gravity and motion, and deformations, of one state or of several in front."""

    x: Float[Array, "*states n_x"]
    sigma: Float[Array, "*states n_e"]
    felt: InertialLoad
    e: Float[Array, "*states n_e"]


class ManyStates:
    """Base class of a path and a motion, results with many states that questions can be about.

    Attributes:
        by_sparse: Whether states are linearised element by element.
    """

    by_sparse: ClassVar[bool] = False

    def states(self) -> States:
        """The states in their order."""
        raise NotImplementedError

    def linearization(self, step: int | None = None, time: float | None = None) -> Linearization:
        """Linearised equations about one state, by its number or time [s]; by default the last."""
        raise NotImplementedError

    def linearizations(self) -> Linearization:
        """Linearised equations of all states, states as first axis."""
        raise NotImplementedError

    def factors(self, step: int) -> LoadFactors:
        """Load factors of one state, for a path only."""
        raise NotImplementedError

    def stressed(self) -> Stressed:
        """Data from which the stress of all states is computed."""
        raise NotImplementedError


def matrices(topology: Topology, parameters: Parameters, target: LoadFactors) -> Matrices:
    """Equilibrium under loads with these factors, and linearisation; part of compiled kernels."""
    at, _, result, iterations, _ = solve_state(topology, parameters, target)
    return matrices_at(topology, parameters, target, at, iterations, result)


def matrices_at(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    at: State,
    iterations: Int[Array, ""],
    result: Int[Array, ""],
) -> Matrices:
    """Linearisation about a state in equilibrium, with the iterations and code of its solution."""
    z, dfe = at.transfer.DFx, at.transfer.DFe
    mass = z.T @ mass_matrix(topology, parameters, at.x) @ z
    damping = element_damping(topology, parameters)
    if depends_on_rates(topology):
        loads = scaled_loads(parameters, factors)
        _, damping = stress_tangents(topology, parameters, loads, at.S, damping, at.e)
    at_rest = jnp.zeros_like(mass)
    felt, reactions, external = acting_at(topology, parameters, at)
    k0, g0 = at.K0, at.G0
    finite = jnp.all(jnp.isfinite(mass)) & jnp.all(jnp.isfinite(k0)) & jnp.all(jnp.isfinite(g0))
    result = jnp.where((result == RESULTS.successful) & ~finite, RESULTS.not_finite, result)
    return Matrices(
        M0=(mass + mass.T) / 2,
        C0=at_rest,
        D0=dfe.T @ damping @ dfe,
        K0=k0 if lacks_potential(topology) else (k0 + k0.T) / 2,
        N0=at_rest,
        G0=g0 if lacks_potential(topology) else (g0 + g0.T) / 2,
        DFx=z,
        DFe=dfe,
        S=at.S,
        S_d=damping,
        x=at.x,
        e=at.e,
        sigma=at.sigma,
        felt=felt,
        reactions=reactions,
        external=external,
        iterations=iterations,
        result=result.astype(jnp.int32),
        symmetric=not lacks_potential(topology),
        factors=LoadFactors(*(jnp.asarray(factor, float) for factor in factors)),
    )


_matrices = kernel(matrices)


@kernel
def moving_element_matrices(
    topology: Topology,
    parameters: Parameters,
    factors: LoadFactors,
    x: Float[Array, "n_x"],
    e: Float[Array, "n_e"],
    sigma: Float[Array, "n_e"],
) -> ElementMatrices:
    """Matrices of all elements about a state at rest (THEORY.md 7, eq. (7.15); 6, eq. (6.2) and (6.3))."""
    at_rest, _ = element_matrices(topology, parameters, factors, x, jax.lax.stop_gradient(e), sigma, e)
    strain = strain_of(topology, parameters, scaled_loads(parameters, factors), e)
    viscous = by_deformations(topology, parameters, strain, at_rest.constraints, "damping")
    damping = by_coordinates(at_rest.constraints, viscous)
    return at_rest._replace(damping=damping, mass=mass_pieces(topology, parameters, x), viscous=viscous)


def about_state(model: Model, factors: LoadFactors, at: Any, solver: LinearSolver = SPARSE) -> Linearization:
    """Linearised equations about a known state at rest, element by element.

    ``at`` are the attributes of :class:`LargeMatrices` between ``elements`` and ``factors``.
    """
    factors = LoadFactors(*(jnp.asarray(factor, float) for factor in factors))
    elements = moving_element_matrices(model.topology, model.parameters, factors, *at[:3])
    symmetric = not lacks_potential(model.topology)
    return Linearization(LargeMatrices(elements, *at, factors=factors, symmetric=symmetric, solver=solver), model)


@one_thread()
def linearized_by_elements(
    model: Model, target: LoadFactors, throw: bool = True, solver: LinearSolver = SPARSE
) -> Linearization:
    """Linearised equations about the equilibrium of a large mechanism, element by element."""
    equilibrium, unstable = sparse_equilibrium(model.topology, model.parameters, target)
    if is_concrete(unstable) and unstable:
        collect(RESULTS.unstable_state)
    check_stiffness(model, equilibrium[-1], throw)
    warn_of_coarse(model, equilibrium[1])
    return about_state(model, target, or_nan(equilibrium, equilibrium[-1], throw), solver)


def linearized_by_freedoms(model: Model, target: LoadFactors, throw: bool) -> Linearization:
    """Linearised equations about the equilibrium, in the degrees of freedom."""
    m: Matrices = _matrices(model.topology, model.parameters, target)
    check_stiffness(model, m.result, throw)
    collect_unstable([m.K0, m.G0], m.K0, m.symmetric)
    warn_of_coarse(model, m.e)
    return Linearization(or_nan(m, m.result, throw), model)


@kernel
def _matrices_of(
    topology: Topology, parameters: Parameters, factors: LoadFactors, x: Float[Array, "n_x"], near: Float[Array, "n_e"]
):
    """Matrices about a state that has been found."""
    zero = jnp.zeros((), jnp.int32)
    return matrices_at(topology, parameters, factors, state(topology, parameters, factors, x, near), zero, zero)


def linearized_about(model: Model, at: Equilibrium, function: str, solver: LinearSolver | None = None) -> Linearization:
    """Linearised equations about an equilibrium: by elements with a ``solver``, else in the degrees of freedom."""
    if at.asked_of is None or at.factors is None or not is_concrete(model.parameters):
        raise TypeError(
            f"Argument `at` of fm.{function} is an Equilibrium without its model and loads, such as inside jax.jit and"
            f" jax.grad, or after it was stored. Give fm.{function}(fm.linearize(model)), with the same loads."
        )
    check(at.result, True, f"Argument `at` of fm.{function} is this equilibrium, which was not found.")
    asked_model, factors = at.asked_of, at.factors
    if solver is not None:
        state_at = at.x, at.e, at.sigma, at.felt, at.reactions, at.external, at.iterations, at.result
        return about_state(asked_model, factors, state_at, solver)
    asked_model = as_determined(asked_model, function)
    return Linearization(_matrices_of(asked_model.topology, asked_model.parameters, factors, at.x, at.e), asked_model)


@unguarded
def linearize(
    model: Model,
    *,
    load_factor: float = 1.0,
    increment: float | None = None,
    throw: bool = True,
    sparse: bool | None = None,
    solver: str | LinearSolver | None = None,
) -> Linearization:
    """Return the linearised equations of motion about the static equilibrium under the constant loads.

    Args:
        model: Mechanism; differentiable in ``model.parameters``.
        load_factor: Factor of the loads, () [-].
        increment: Factor of the incremental loads, () [-]; zero by default.
        throw: Raise if the equilibrium fails; otherwise the code is in ``result``.
        sparse: Return equations in all coordinates, element by element, for a mechanism of thousands of elements. The
            model needs no degrees of freedom; see :func:`flexmb.equilibrium`. Modes, compliance, stress, responses and
            a state space of few modes accept these equations.
        solver: "sparse" or a :class:`flexmb.math.linear_solver.LinearSolver` for these equations and for the analyses
            that use them; "dense" for the equations in the degrees of freedom.

    Returns:
        Linearization with the equilibrium x, e, sigma, the matrices M0, C0, D0, K0, N0, G0, (n_q, n_q) [SI], and the
        transfer functions DFx (n_x, n_q) and DFe (n_e, n_q). With ``sparse``, its method ``sparse()`` returns the
        matrices instead.

    Raises:
        AnalysisError: The equilibrium was not found or the configuration is singular.
        ValueError: A factor is not finite, or there are no incremental loads.

    Warns:
        FlexmbWarning: There are incremental loads, and ``increment`` is not given.
        CoarseWarning: A beam is bent or twisted too far for the accuracy of one beam, or stretched by more than 1 %.

    Source:
        THEORY.md 6, eq. (6.2) and (6.3); K0 = DFe^T S DFe, G0 from the Hessian of the Lagrangian projected with DFx.
    """
    chosen = asked_solver(sparse, solver) or DENSE_SOLVER
    (as_determined if chosen == DENSE_SOLVER else as_model)(model, "linearize")
    target = load_factors_of(model, load_factor, increment, "linearize")
    if chosen == DENSE_SOLVER:
        return linearized_by_freedoms(model, target, throw)
    return linearized_by_elements(model, target, throw, chosen)


class Shapes(ByName, AboutState):
    """Base class of modes. Methods by name return values of the state about which the mechanism vibrates or buckles.

    Attributes:
        shapes: Modes in the coordinates, one a column, (n_x, n).
        lin: Linearization that they belong to.
    """

    shapes: Float[Array, "n_x n"]
    lin: Any

    @property
    def matrices(self) -> Any:
        """Linearised equations of the state."""
        return self.lin.matrices

    @property
    def labels(self) -> Labels:
        """Names."""
        return self.lin.labels

    def shape(self, node: str, component: str | None = None) -> Float[Array, "modes n"]:
        """Return the motion of a node in each mode.

        Args:
            node: Name of the node, or "name.rotation" for its rotation alone.
            component: One component: "x", "y", "z", "phi", "rx", "ry" or "rz".

        Returns:
            Displacements, then rotations about global axes if the node has a rotation, (modes, n), or (modes,) for one
                component. Modes of vibration [1/sqrt(kg), rad/(m sqrt(kg))], of buckling [-].
        """
        return node_motions(self.labels, self.lin.x, self.shapes, node, component)
