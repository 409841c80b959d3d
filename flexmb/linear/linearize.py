"""Linearised equations of motion about the static equilibrium."""

import re
from typing import Any, ClassVar, Generic, Literal, NamedTuple, TypeVar, overload

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..arguments import check_flag, check_whole, computed, is_concrete, require_double_precision
from ..compilation.compile import unguarded
from ..compilation.record import Record, static
from ..display import Result, States, Summary, listed, short
from ..mechanics.blocks import kernel
from ..mechanics.deformation import deformation_jacobian
from ..mechanics.inertia import Felt, mass_matrix
from ..mechanics.loads import LoadFactors, lacks_potential, scaled_loads
from ..mechanics.residual import State
from ..mechanics.stress_resultants import depends_on_rates, element_damping, stress_tangents
from ..mechanics.transfer import correction, transfer
from ..model.by_name import ByName
from ..model.model import Labels, Model, as_determined, as_model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS, check, or_nan, told
from ..statics.coarse import warn_of_coarse
from ..statics.equilibrium import check_stiffness, load_factors_of
from ..statics.solve import external_of, reactions_of, solve_state
from ..statics.stable import collect_unstable
from .sparse_linearize import SparseLinearization, sparse_linearization


class Rates(Record):
    """Motion of a state that is linearised about, and how fast the transfer functions change along it.

    Attributes:
        xd: Velocities of the nodal coordinates, (n_x,) [1/s].
        xdd: Their accelerations, (n_x,) [1/s^2].
        DFx_d: Rate of DFx, (n_x, n_q).
        DFx_dd: Second rate of DFx, (n_x, n_q).
        DFe_d: Rate of DFe, (n_e, n_q).
        DFe_dd: Second rate of DFe, (n_e, n_q).
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
        S: Stiffness of the elements, tangent where it is not constant, (n_e, n_e).
        S_d: Damping of the elements likewise, (n_e, n_e).
        x: Nodal coordinates at the equilibrium, (n_x,).
        e: Deformations there, (n_e,).
        sigma: Stress resultants there, (n_e,).
        felt: Gravity and motion there, which act along the elements.
        reactions: Forces of the supports there, (n_x,).
        external: Forces from outside there, loads but weight and the supports' together, (n_x,).
        iterations: Newton iterations of the equilibrium.
        result: Code of RESULTS.
        symmetric: Whether the stiffness is symmetric by the nature of the loads.
        moving: How the state moves; None where it is at rest.
        factors: Of the two sets of loads there.
        turning: Nodal forces by coordinates, of moments that are functions of time, (n_x, n_x); None without them.
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
    felt: Felt
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
        """Whole stiffness K0 + N0 + G0."""
        return computed(lambda _, *parts: sum(parts), self.K0, self.N0, self.G0)


T = TypeVar("T")


class _Of(Generic[T]):
    """An attribute of ``matrices`` that the result which holds them has too, by the same name."""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name
        # What ``help`` says of it is what is said of the matrix.
        told = re.search(rf"^ +{name}: (.*(?:\n {{12}}.*)*)", Matrices.__doc__ or "", re.M)
        self.__doc__ = " ".join(told.group(1).split()) if told else None

    def __get__(self, result: Any, owner: type) -> T:
        own: Any = self
        return own if result is None else getattr(result.matrices, self.name)

    def __set__(self, result: Any, value: Any) -> None:
        raise AttributeError(f"{self.name} is not to be changed: it is {self.name} of .matrices.")


class AboutState:
    """Base class of results with the matrices of one state, or of several in front: ``lin.K0`` is ``lin.matrices.K0``.

    Attributes:
        matrices: The numbers.
    """

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
    felt = _Of[Felt]()
    reactions = _Of[Float[Array, "*states n_x"]]()
    external = _Of[Float[Array, "*states n_x"]]()
    iterations = _Of[Int[Array, "*states"]]()
    symmetric = _Of[bool]()
    moving = _Of[Rates | None]()


class Linearization(ByName, AboutState, Result, Record):
    """Linearised equations of motion about the equilibrium of a model.

    The matrices and states of :class:`Matrices` are attributes of this object too (``lin.K0``).

    Attributes:
        matrices: The numbers.
        model: The mechanism they belong to.
    """

    matrices: Matrices
    model: Model
    result = _Of[Int[Array, "*states"]]()
    one_axis = "x"

    @property
    def labels(self) -> Labels:
        """Names."""
        return self.model.labels

    def at_time(self, number: int) -> "Linearization":
        """Linearised equations at one of the times of a motion, of what :func:`flexmb.motion.linearize_motion` gives.

        Args:
            number: Which, from 0; from the end where negative.

        Raises:
            ValueError: This is the linearisation of one state.
            IndexError: There are not so many times.
        """
        if self.matrices.M0.ndim == 2:
            raise ValueError("This linearisation is that of one state: it has no times to choose from.")
        count, chosen = self.matrices.M0.shape[0], check_whole("number", number)
        if not -count <= chosen < count:
            raise IndexError(f"There are {count} times, numbered from 0, and {chosen} is none of them.")
        return Linearization(jax.tree.map(lambda a: computed(lambda _, a: a[chosen], a), self.matrices), self.model)

    instant = at_time

    @property
    def condition(self) -> float:
        """Condition number of the stiffness, each degree of freedom in a unit of its own that makes its stiffness one.

        The derivatives of the equilibrium, and of all that follows from it, are solutions with this matrix: they lose
        as many digits as it has. Infinite where the stiffness is singular.

        Source:
            Van der Sluis (1969), Numerische Mathematik 14, 14: near the least that any units give.
        """
        k = np.asarray(self.matrices.K)
        scale = np.sqrt(np.maximum(np.abs(np.diag(k)), np.finfo(float).tiny))
        return float(np.linalg.cond(k / scale[:, None] / scale)) if len(k) else 1.0

    def states(self) -> States:
        """The state that the equations are about."""
        return States(self.model, self.x)

    def summary(self) -> Summary:
        """Outcome, largest displacement and the diagonals of mass and stiffness."""
        model, count = self.model, self.M0.shape[0]
        positions = [i for i, entry in enumerate(self.labels.x) if entry.kind == "position"]
        moved = np.asarray(self.x - model.parameters.reference)[positions]
        furthest = f", {self.labels.x[positions[np.argmax(np.abs(moved))]]} is displaced most" if np.any(moved) else ""
        rows = {
            "result": told(self.result),
            "degrees of freedom": str(count),
            "largest displacement": f"{short(np.max(np.abs(moved), initial=0.0))} m",
            "diagonal of M0": listed(np.diag(np.asarray(self.M0))),
            "diagonal of K0 + N0 + G0": listed(np.diag(np.asarray(self.K))),
        }
        about = "an equilibrium" if self.moving is None else "a motion"
        named = listed(model.q_labels) if self.labels.x else "without names"
        return Summary(f"Linearization about {about}: {named}{furthest}", rows, "mechanism")


class Stressed(NamedTuple):
    """What stress is computed from, of one state or of several in front.

    Attributes:
        x: Nodal coordinates, (states, n_x) [m, rad, -].
        sigma: Stress resultants, (states, n_e) [N, N m].
        felt: Gravity and motion, which act along the elements.
        e: Deformations, (states, n_e) [m, rad].
    """

    x: Float[Array, "*states n_x"]
    sigma: Float[Array, "*states n_e"]
    felt: Felt
    e: Float[Array, "*states n_e"]


class ManyStates:
    """Base class of a path and a motion: results with many states, each of which questions can be asked about.

    Attributes:
        by_sparse: Whether states are linearised by sparse matrices.
    """

    by_sparse: ClassVar[bool] = False

    def states(self) -> States:
        """The states, one after the other."""
        raise NotImplementedError

    def linearization(self, step: int | None = None, time: float | None = None) -> Linearization | SparseLinearization:
        """Linearised equations of motion about one state; the last unless given.

        Args:
            step: Number of the state, from 0.
            time: Time of a state of a motion [s].
        """
        raise NotImplementedError

    def linearizations(self) -> Linearization:
        """Linearised equations of all states, which stand in front."""
        raise NotImplementedError

    def factors(self, step: int) -> LoadFactors:
        """Load factors of one state, of a path alone."""
        raise NotImplementedError

    def stressed(self) -> Stressed:
        """What the stress of all states is computed from."""
        raise NotImplementedError


def matrices(topology: Topology, parameters: Parameters, target: LoadFactors) -> Matrices:
    """Equilibrium and linearisation in one; part of the compiled kernels.

    Args:
        target: Load factors of the equilibrium.

    Returns:
        Matrices.
    """
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
    """Linearisation about a state that is in equilibrium.

    Args:
        factors: Load factors of the state.
        iterations: What the equilibrium took.
        result: Its code of RESULTS.

    Returns:
        Matrices.
    """
    z, dfe = at.transfer.DFx, at.transfer.DFe
    mass = z.T @ mass_matrix(topology, parameters, at.x) @ z
    damping = element_damping(topology, parameters)
    if depends_on_rates(topology):
        loads = scaled_loads(parameters, factors)
        _, damping = stress_tangents(topology, parameters, loads, at.S, damping, at.e)
    at_rest = jnp.zeros_like(mass)
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
        felt=Felt(at.gravity),
        reactions=reactions_of(topology, at),
        external=external_of(topology, parameters, at),
        iterations=iterations,
        result=result.astype(jnp.int32),
        symmetric=not lacks_potential(topology),
        factors=LoadFactors(*(jnp.asarray(factor, float) for factor in factors)),
    )


_matrices = kernel(matrices)


class Where(NamedTuple):
    """Which state of a mechanism a public function is asked about; where all is None, the equilibrium.

    Attributes:
        at: Linearization, Path or Motion of the model; where no stiffness is asked for, also an Equilibrium.
        step: Number of a state of a path or a motion.
        time: Time of a state of a motion [s].
        increment: Factor of the incremental loads of an equilibrium [-].
    """

    at: Any = None
    step: int | None = None
    time: float | None = None
    increment: float | None = None

    def refuse(self, function: str, *, given: bool = False) -> None:
        """Refuse what does not go together.

        Args:
            given: Whether the function is given a linearisation in place of a model.

        Raises:
            ValueError: ``step`` or ``time`` without a path or a motion; or two states at once.
        """
        for name, value in (("step", self.step), ("time", self.time)):
            if value is not None and not isinstance(self.at, ManyStates):
                raise ValueError(f"Argument `{name}` of fm.{function} goes with at=, a path or a motion.")
        stated = "at=" if self.at is not None else "a linearisation" if given else ""
        if self.increment is not None and stated:
            raise ValueError(f"Argument `increment` of fm.{function} does not go with {stated}, which has its loads.")
        if given and self.at is not None:
            raise ValueError(
                f"fm.{function} is given a linearisation and `at`: give the model and `at`, or that alone."
            )

    def linearization(self, model: Model, function: str) -> Linearization:
        """Linearised equations about the state that ``at`` says, dense.

        Raises:
            TypeError: ``at`` is none, or is linearised by sparse matrices.
            ValueError: As for :meth:`state`.
        """
        found = self.state(model, function)
        if isinstance(found, SparseLinearization):
            instead = "fm.path(model, sparse=False)" if self.at is not found else "fm.linearize(model)"
            raise TypeError(f"fm.{function} takes no sparse linearisation: give {instead}, which is dense.")
        return found

    def state(self, model: Model, function: str) -> Linearization | SparseLinearization:
        """Linearised equations about the state that ``at`` says.

        Raises:
            TypeError: ``at`` is none.
            ValueError: ``at`` has many states and none is named, or is of another model.
        """
        at = self.at
        if isinstance(at, ManyStates):
            states = at.states()
            if self.step is None and self.time is None:
                also = ", or its time=" if states.kind == "motion" else ""
                raise ValueError(
                    f"Argument `at` of fm.{function} is a {type(at).__name__} with {len(states.x)} states: say which by"
                    f" step=, such as step=-1 for the last{also}."
                )
            at = at.linearization(self.step, self.time)
        if not isinstance(at, Linearization | SparseLinearization):
            raise TypeError(
                f"Argument `at` of fm.{function} must be a Path, a Motion or a Linearization of the model, not"
                f" {'an' if type(at).__name__[0] in 'AEIO' else 'a'} {type(at).__name__}."
            )
        check_state(at, model, function)
        return at


# Numbers of a material that no state depends on.
BEARS = frozenset({"strength", "fatigue"})


def _key(of: Any) -> str:
    return str(getattr(of, "name", getattr(of, "key", "")))


def check_state(at: Any, model: Model, function: str) -> None:
    """Refuse a state of another model, as far as its names or numbers that are known tell.

    Loads and strains may differ: those of a path's steps and of its imperfections do.

    Args:
        at: What has ``labels``, and may have a ``model``, or tell which one it was ``asked_of``.
        model: What a function is asked about.
        function: Its name.

    Raises:
        ValueError: Another model.
    """
    own = getattr(at, "model", None) or getattr(at, "asked_of", None)
    if own is model:
        return
    labels = model.labels
    if (at.labels.x, at.labels.elements) != (labels.x, labels.elements):
        raise ValueError(f"Argument `at` of fm.{function} is of another model: its nodes or elements have other names.")
    if own is None:
        return
    numbers = [(one.parameters.reference, one.parameters.properties) for one in (own, model)]
    if not is_concrete(numbers):
        return
    (one, shape), (other, wanted) = (jax.tree_util.tree_flatten_with_path(of) for of in numbers)
    pairs = [(a, b) for (path, a), (_, b) in zip(one, other, strict=False) if not BEARS.intersection(map(_key, path))]
    if shape != wanted or any(not np.array_equal(*pair, equal_nan=True) for pair in pairs):
        raise ValueError(
            f"Argument `at` of fm.{function} is of a model with other dimensions: ask about that model, or find the"
            " state of this one."
        )


def linearized(
    given: Model | Linearization | SparseLinearization,
    function: str,
    throw: bool = True,
    where: Where | None = None,
) -> Linearization:
    """What a public function of a model or of its linearisation is asked about.

    Args:
        given: Model, which is linearised about its equilibrium or stands at a state of a path or a motion; or
            Linearization, which passes.
        where: Which state.

    Raises:
        TypeError: It is neither.
        ValueError: It is a linearisation along a motion, at many times; or arguments do not go together.
        AnalysisError: The equilibrium was not found.
    """
    require_double_precision()
    where = where or Where()
    where.refuse(function, given=isinstance(given, Linearization))
    if isinstance(given, SparseLinearization):
        raise TypeError(f"fm.{function} takes no sparse linearisation: give fm.linearize(model), which is dense.")
    if where.at is not None:
        given = where.linearization(as_model(given, function), function)
    if not isinstance(given, Linearization):
        model = as_determined(given, function)
        return _linearized(model, load_factors_of(model, 1.0, where.increment, function), throw)
    if given.matrices.M0.ndim > 2:
        raise ValueError(
            f"fm.{function} takes the linearisation of one state, and this one is along a motion, at"
            f" {len(given.matrices.M0)} times: give lin.at_time(0)."
        )
    if is_concrete(given.matrices.result):
        check(given.matrices.result, throw)
    return given


@overload
def linearize(
    model: Model,
    *,
    load_factor: float = 1.0,
    increment: float | None = None,
    throw: bool = True,
    sparse: Literal[False] = False,
) -> Linearization: ...


@overload
def linearize(
    model: Model,
    *,
    load_factor: float = 1.0,
    increment: float | None = None,
    throw: bool = True,
    sparse: Literal[True],
) -> SparseLinearization: ...


@unguarded
def linearize(
    model: Model,
    *,
    load_factor: float = 1.0,
    increment: float | None = None,
    throw: bool = True,
    sparse: bool = False,
) -> Linearization | SparseLinearization:
    """Linearised equations of motion about the static equilibrium under the constant loads.

    Args:
        model: Mechanism; differentiable in ``model.parameters``.
        load_factor: Factor of the loads, () [-].
        increment: Factor of the incremental loads, () [-]; zero unless given.
        throw: Raise where the equilibrium fails; otherwise the code is in ``result``.
        sparse: Of a mechanism of thousands of elements, which needs no degrees of freedom: the equations in all
            coordinates, element by element, of which modes, compliance, stress, responses and a state space of few
            modes are asked as of dense ones. See :func:`flexmb.equilibrium` for what it takes.

    Returns:
        Linearization with M0, C0, D0, K0, N0, G0, (n_q, n_q) [SI], the transfer functions DFx (n_x, n_q) and
        DFe (n_e, n_q), and the equilibrium x, e, sigma; or SparseLinearization, whose ``sparse()`` are matrices.

    Raises:
        AnalysisError: The equilibrium was not found or the configuration is singular.
        ValueError: A factor is not finite, or there are no incremental loads.

    Warns:
        FlexmbWarning: There are incremental loads, and ``increment`` is not given.
        CoarseWarning: A beam is bent or twisted further than one beam is right for, or stretched by more than 1 %.

    Source:
        THEORY.md 6, eq. (6.2) and (6.3); K0 = DFe^T S DFe, G0 from the Hessian of the Lagrangian projected with DFx.
    """
    check_flag("sparse", sparse)
    (as_model if sparse else as_determined)(model, "linearize")
    target = load_factors_of(model, load_factor, increment, "linearize")
    return sparse_linearization(model, target, throw) if sparse else _linearized(model, target, throw)


def _linearized(model: Model, target: LoadFactors, throw: bool) -> Linearization:
    m: Matrices = _matrices(model.topology, model.parameters, target)
    check_stiffness(model, m.result, throw)
    collect_unstable([m.K0, m.G0], m.K0, m.symmetric)
    warn_of_coarse(model, m.e)
    return Linearization(or_nan(m, m.result, throw), model)


@kernel
def _second_transfer(topology: Topology, parameters: Parameters, m: Matrices):
    near = jax.lax.stop_gradient(m.e)
    _, jacobian = deformation_jacobian(topology, parameters, m.x, near)
    tangent = transfer(topology, jacobian)

    def along(i: Float[Array, "n_x"], j: Float[Array, "n_x"]):
        def once(x: Float[Array, "n_x"]):
            _, d = deformation_jacobian(topology, parameters, x, near)
            return d @ i

        return jax.jvp(once, (m.x,), (j,))[1]

    columns = m.DFx.T
    bend = jax.vmap(jax.vmap(along, (None, 0)), (0, None))(columns, columns)

    def second(curved: Float[Array, "n_e"]):
        dx = correction(topology, tangent, curved, jnp.zeros(topology.n_x))
        return dx, curved + jacobian @ dx

    d2x, d2e = jax.vmap(jax.vmap(second))(bend)
    return jnp.moveaxis(d2x, -1, 0), jnp.moveaxis(d2e, -1, 0)


def second_transfer(
    lin: Linearization,
) -> tuple[Float[Array, "n_x n_q n_q"], Float[Array, "n_e n_q n_q"]]:
    """Second-order geometric transfer functions about the linearised state.

    Args:
        lin: Linearization.

    Returns:
        D2Fx, (n_x, n_q, n_q), and D2Fe, (n_e, n_q, n_q) [their units over those of q twice].

    Raises:
        TypeError: It is no Linearization.

    Source:
        Second derivative of D(F(q)) = e: D_x D2Fx = -(D2D DFx) DFx on the held deformations,
        THEORY.md 4, eq. (4.4).
    """
    if not isinstance(lin, Linearization):
        raise TypeError(
            f"fm.linear.second_transfer takes a Linearization, not a {type(lin).__name__}: give fm.linearize(model)."
        )
    linearized(lin, "second_transfer")
    return _second_transfer(lin.model.topology, lin.model.parameters, lin.matrices)
