"""Equilibrium and lowest frequencies of large mechanisms: all coordinates, a multiplier a constraint, sparse factors.

The matrices are assembled and factored on the host; derivatives need only the work of stresses along given motions,
element by element, and solutions with the same factors.
"""

from typing import Any, NamedTuple

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..compilation.compile import jit
from ..compilation.threads import one_thread
from ..errors import AnalysisError, ModelError
from ..math.derivative import jvp_of_varied
from ..math.indices import put
from ..math.sparse import SparseFactors, sparse_matrix
from ..mechanics.blocks import scatter_vector
from ..mechanics.deformation import curvature_pieces, deformations, jacobian_pieces, zero_near
from ..mechanics.extent import sizes_of
from ..mechanics.inertia import Felt, kinetic_energy, mass_pieces, weight_pieces, work_of_weight
from ..mechanics.loads import LoadFactors, has_loads, lacks_potential, nodal_forces, scaled_loads
from ..mechanics.stress_resultants import is_nonlinear, stiffness_pieces, strain_of, stress_of_strain
from ..model.model import Model
from ..model.parameters import Parameters
from ..model.topology import Topology
from ..results import RESULTS
from .equilibrium import (
    CONTRACTION,
    LARGEST_STEP,
    MAX_ITERATIONS,
    SMALLEST_LOAD_STEP,
    STEP_TOLERANCE,
    Equilibrium,
    held_values,
)

# Share of the largest K/M that is added where K alone is singular.
SHIFT = 1e-8


class Balance(NamedTuple):
    """Equilibrium in all coordinates.

    Attributes:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        multipliers: Stress resultants of the held deformations, (h,) [N, N m].
        iterations: Newton iterations.
    """

    x: Float[Array, "n_x"]
    multipliers: Float[Array, "h"]
    iterations: Any = 0


def _unknowns(topology: Topology) -> tuple[Array, Array, Array]:
    """Coordinates that move, coordinates that do not, and deformations that are held."""
    return jnp.sort(topology.x.free), topology.x.held, topology.e.held


@jit
def _elastic_stress(topology: Topology, parameters: Parameters, factors: LoadFactors, e: Float[Array, "n_e"]):
    """Stress resultants of linear elements, without those of held deformations."""
    sigma = stress_of_strain(topology, parameters, strain_of(parameters, e))
    prestress = scaled_loads(parameters, factors).prestress
    return sigma if prestress is None else sigma + prestress


@jit
def _matrices(topology: Topology, parameters: Parameters, factors: LoadFactors, x, near, sigma, *, mass: bool = False):
    """Element matrices for the host, with nodal forces and the stress that deformations have there."""
    values, jacobian = jacobian_pieces(topology, parameters, x, near)
    e = scatter_vector(topology.n_e, values)
    gravity = scaled_loads(parameters, factors).gravity
    found = {
        "jacobian": jacobian,
        "stiffness": stiffness_pieces(topology, parameters),
        "curvature": curvature_pieces(topology, parameters, x, near, sigma),
        "weight": [] if gravity is None else weight_pieces(topology, parameters, x, gravity),
        "mass": mass_pieces(topology, parameters, x) if mass else [],
    }
    force = nodal_forces(topology, parameters, factors, x)
    return found, e, _elastic_stress(topology, parameters, factors, e), force


class _Assembled(NamedTuple):
    """Tangent in the unknowns, and what belongs to it."""

    tangent: Any
    coupling: Any
    mass: Any
    jacobian: Any
    e: np.ndarray
    sigma: np.ndarray
    force: np.ndarray


def _assemble(topology, parameters, factors, x, near, sigma, mass: bool = False) -> _Assembled:
    import scipy.sparse

    found, e, elastic, force = _matrices(
        topology, parameters, factors, *(jnp.asarray(v) for v in (x, near, sigma)), mass=mass
    )
    n_x, n_e = topology.n_x, topology.n_e
    free, fast, held = (np.asarray(i) for i in _unknowns(topology))
    d = sparse_matrix((n_e, n_x), found["jacobian"])
    keep = np.ones(n_e)
    keep[held] = 0.0
    kept = scipy.sparse.diags_array(keep)
    s = kept @ sparse_matrix((n_e, n_e), found["stiffness"]) @ kept
    k = d.T @ s @ d + sparse_matrix((n_x, n_x), found["curvature"]) - sparse_matrix((n_x, n_x), found["weight"])
    rows = d[held]
    tangent = scipy.sparse.block_array([[k[free][:, free], rows[:, free].T], [rows[:, free], None]])
    coupling = scipy.sparse.vstack([k[free][:, fast], rows[:, fast]])
    m = sparse_matrix((n_x, n_x), found["mass"])[free][:, free] if mass else None
    return _Assembled(tangent.tocsc(), coupling, m, d, *(np.asarray(v) for v in (e, elastic * keep, force)))


def _singular() -> AnalysisError:
    return AnalysisError(RESULTS.singular_stiffness.name, RESULTS.singular_stiffness.message)


def _concrete(*trees) -> None:
    if any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves(trees)):
        raise TypeError("The sparse path runs on the host: call it outside jax.jit and jax.vmap; jax.grad applies.")


@jax.custom_jvp
def _balance(topology: Topology, parameters: Parameters, target: LoadFactors) -> Balance:
    """Newton's method with the stress of the iterate's own deformations in the tangent (see residual.iterate)."""
    _concrete(parameters, target)
    free, fast, held = (np.asarray(i) for i in _unknowns(topology))
    if not has_loads(topology, parameters):
        return Balance(parameters.reference, jnp.zeros(len(held)), jnp.zeros((), jnp.int32))
    sizes = np.asarray(sizes_of(topology, parameters))[free]
    start = np.asarray(parameters.reference), np.zeros(topology.n_e), np.zeros(len(held))
    reached, step, done, iterations, regular = 0.0, 1.0, start, 0, True
    while reached < 1.0:
        load = min(reached + step, 1.0)
        factors = LoadFactors(*(load * jnp.asarray(f, float) for f in target))
        wanted_x, wanted_e = (np.asarray(v) for v in held_values(topology, parameters, factors))
        (x, strained, multipliers), before, solved = done, np.inf, False
        near = done[1]
        for _ in range(MAX_ITERATIONS):
            iterations += 1
            sigma = np.array(_elastic_stress(topology, parameters, factors, jnp.asarray(strained)))
            sigma[held] = multipliers
            at = _assemble(topology, parameters, factors, x, near, sigma)
            shift = wanted_x[fast] - x[fast]
            right = np.concatenate([(at.force - at.jacobian.T @ at.sigma)[free], wanted_e[held] - at.e[held]])
            factored = SparseFactors(at.tangent)
            regular = factored.regular
            if not regular:
                break
            z = factored.solve(right - at.coupling @ shift)
            size = np.max(np.abs(z[: len(free)]) / sizes, initial=0.0)
            if not size < LARGEST_STEP or (size / before > CONTRACTION and size > STEP_TOLERANCE**0.5):
                break
            change = np.zeros(topology.n_x)
            change[free], change[fast] = z[: len(free)], shift
            x, multipliers, before = x + change, z[len(free) :], size
            near = strained = at.e + at.jacobian @ change
            if size < STEP_TOLERANCE:
                solved = True
                break
        if solved:
            reached, done, step = load, (x, strained, multipliers), min(2 * step, 1.0)
            continue
        step /= 4
        if step < SMALLEST_LOAD_STEP:
            if not regular:
                raise _singular()
            raise AnalysisError(RESULTS.not_converged.name, RESULTS.not_converged.message)
    return Balance(jnp.asarray(done[0]), jnp.asarray(done[2]), jnp.asarray(iterations, jnp.int32))


@jit
def _residual(topology: Topology, parameters: Parameters, factors: LoadFactors, near, at: Balance):
    """Forces out of balance at the coordinates that move, and excess of the held deformations."""
    free, fast, held = _unknowns(topology)
    wanted_x, wanted_e = held_values(topology, parameters, factors)
    x = put(at.x, fast, wanted_x[fast])
    e, pull = jax.vjp(lambda x: deformations(topology, parameters, x, near), x)
    sigma = put(_elastic_stress(topology, parameters, factors, e), held, at.multipliers)
    force = pull(sigma)[0] - nodal_forces(topology, parameters, factors, x)
    return jnp.concatenate([force[free], (e - wanted_e)[held]])


@_balance.defjvp
def _balance_jvp(primals, tangents):
    topology, parameters, factors = primals
    solved = _balance(topology, parameters, factors)
    near = deformations(topology, parameters, solved.x, zero_near(topology))
    free, fast, held = _unknowns(topology)

    def equations(parameters, factors):
        return _residual(topology, parameters, factors, near, solved)

    _, change = jvp_of_varied(equations, primals[1:], tangents[1:])
    _, moved = jvp_of_varied(lambda *numbers: held_values(topology, *numbers)[0][fast], primals[1:], tangents[1:])
    sigma = put(_elastic_stress(topology, parameters, factors, near), held, solved.multipliers)
    factored = SparseFactors(_assemble(topology, parameters, factors, solved.x, near, sigma).tangent)

    def matvec(z):
        def along(x, multipliers):
            return _residual(topology, parameters, factors, near, Balance(x, multipliers))

        direction = put(jnp.zeros(topology.n_x), free, z[: free.shape[0]]), z[free.shape[0] :]
        return jax.jvp(along, solved[:2], direction)[1]

    def solve(_, right):
        shape = jax.ShapeDtypeStruct(right.shape, right.dtype)
        return jax.pure_callback(factored.solve, shape, right, vmap_method="sequential")

    z = jax.lax.custom_linear_solve(matvec, -change, solve, symmetric=True)
    dx = put(put(jnp.zeros(topology.n_x), free, z[: free.shape[0]]), fast, moved)
    no_change: Any = np.zeros((), jax.dtypes.float0)
    return solved, Balance(dx, z[free.shape[0] :], no_change)


class _Spectrum(NamedTuple):
    values: np.ndarray
    motions: np.ndarray
    multipliers: np.ndarray


def _spectrum(topology, parameters, factors, x, near, sigma, count: int) -> _Spectrum:
    """Lowest eigenvalues, by Lanczos iterations with the factors of the constrained stiffness."""
    import scipy.sparse
    import scipy.sparse.linalg

    linalg: Any = scipy.sparse.linalg
    at = _assemble(topology, parameters, factors, x, near, sigma, mass=True)
    n, total = at.mass.shape[0], at.tangent.shape[0]
    if count >= n - (total - n):
        raise ModelError(f"Argument `count` = {count}: the sparse path gives few of many frequencies. Leave it out.")
    ratio = at.tangent.diagonal()[:n].max() / at.mass.diagonal().max()
    shift, factored = 0.0, SparseFactors(at.tangent)
    if not factored.regular:
        shift = SHIFT * ratio
        padded = scipy.sparse.block_diag([shift * at.mass, scipy.sparse.csr_array((total - n, total - n))])
        factored = SparseFactors((at.tangent + padded).tocsc())
        if not factored.regular:
            raise _singular()

    def inverse(right):
        return factored.solve(np.concatenate([np.ravel(right), np.zeros(total - n)]))[:n]

    operator = linalg.LinearOperator((n, n), matvec=inverse, dtype=float)
    first = inverse(at.mass @ np.cos(np.arange(n) ** 2))
    values, motions = linalg.eigsh(
        at.mass, k=count, M=at.mass, sigma=-shift, OPinv=operator, v0=first, which="LM", tol=1e-13
    )
    order = np.argsort(values)
    values, motions = values[order], motions[:, order]
    motions = motions / np.sqrt(np.einsum("ij,ij->j", motions, at.mass @ motions))
    # Once more, for the multipliers too: K v + D^T m = (w^2 + s) M v.
    full = np.stack(
        [
            factored.solve(np.concatenate([(w + shift) * (at.mass @ v), np.zeros(total - n)]))
            for w, v in zip(values, motions.T, strict=True)
        ],
        axis=1,
    )
    return _Spectrum(values, motions, full[n:])


@jax.custom_jvp
def _eigenvalues(
    topology: Topology, parameters: Parameters, factors: LoadFactors, at: Balance, count: Array
) -> Float[Array, "k"]:
    _concrete(parameters, factors, at)
    return jnp.asarray(_at_balance(topology, parameters, factors, at, count).values)


def _at_balance(topology, parameters, factors, at: Balance, count) -> _Spectrum:
    near = deformations(topology, parameters, at.x, zero_near(topology))
    held = _unknowns(topology)[2]
    sigma = put(_elastic_stress(topology, parameters, factors, near), held, at.multipliers)
    return _spectrum(topology, parameters, factors, at.x, near, sigma, count.shape[0])


@jit
def _rayleigh(topology, parameters, factors, at: Balance, near, motion, multipliers, value) -> Float[Array, ""]:
    """Second variation of the Lagrangian along a mode, whose derivative is that of the eigenvalue."""
    free, _, held = _unknowns(topology)
    phi = put(jnp.zeros(topology.n_x), free, motion)

    def rates(x):
        return jax.jvp(lambda x: deformations(topology, parameters, x, near), (x,), (phi,))

    (e, first), (_, second) = jax.jvp(rates, (at.x,), (phi,))
    sigma = put(_elastic_stress(topology, parameters, factors, e), held, at.multipliers)
    stress = put(stress_of_strain(topology, parameters, first), held, 0.0)
    total = first @ stress + sigma @ second + 2 * multipliers @ first[held]
    gravity = scaled_loads(parameters, factors).gravity
    if gravity is not None:

        def slope(x):
            return jax.jvp(lambda x: work_of_weight(topology, parameters, x, gravity), (x,), (phi,))[1]

        total = total - jax.jvp(slope, (at.x,), (phi,))[1]
    return total - 2 * value * kinetic_energy(topology, parameters, at.x, phi)


@_eigenvalues.defjvp
def _eigenvalues_jvp(primals, tangents):
    topology, parameters, factors, at, count = primals
    found = _at_balance(topology, parameters, factors, at, count)
    near = deformations(topology, parameters, at.x, zero_near(topology))

    def all_modes(parameters, factors, at):
        return jnp.stack(
            [
                _rayleigh(topology, parameters, factors, at, near, *(jnp.asarray(v) for v in mode))
                for mode in zip(found.motions.T, found.multipliers.T, found.values, strict=True)
            ]
        )

    _, change = jvp_of_varied(all_modes, primals[1:4], tangents[1:4])
    return jnp.asarray(found.values), change


def refuse_what_is_not_sparse(model: Model) -> None:
    """Raise where the sparse path has no equations.

    Args:
        model: Mechanism.

    Raises:
        ModelError: Loads that follow a body, moments about fixed axes, or elements with a law or an energy.
    """
    if lacks_potential(model.topology) or is_nonlinear(model.topology):
        raise ModelError(
            "The sparse path takes dead loads, gravity and elements of constant stiffness: no moments about fixed axes"
            " in space, loads that follow a body, laws or energies. Leave `sparse` out."
        )


@one_thread()
def sparse_equilibrium(model: Model, target: LoadFactors) -> Equilibrium:
    """Static equilibrium by sparse factors.

    Args:
        model: Mechanism, which needs no degrees of freedom (``Builder.build(check=False)``).
        target: Load factors.

    Raises:
        ModelError: See :func:`refuse_what_is_not_sparse`.
        AnalysisError: singular_stiffness or not_converged.
    """
    refuse_what_is_not_sparse(model)
    topology, parameters = model.topology, model.parameters
    at = _balance(topology, parameters, target)
    e, sigma, felt, reactions = _quantities(topology, parameters, target, at)
    return Equilibrium(at.x, e, sigma, felt, reactions, at.iterations, jnp.zeros((), jnp.int32), model.labels)


@jit
def _quantities(topology: Topology, parameters: Parameters, factors: LoadFactors, at: Balance):
    """Deformations, stress resultants and reactions of an equilibrium."""
    _, fast, held = _unknowns(topology)
    e, pull = jax.vjp(lambda x: deformations(topology, parameters, x, zero_near(topology)), at.x)
    sigma = put(_elastic_stress(topology, parameters, factors, e), held, at.multipliers)
    force = pull(sigma)[0] - nodal_forces(topology, parameters, factors, at.x)
    felt = Felt(scaled_loads(parameters, factors).gravity)
    return e, sigma, felt, put(jnp.zeros(topology.n_x), fast, force[fast])


@one_thread()
def sparse_eigenvalues(model: Model, target: LoadFactors, count: int) -> Float[Array, "k"]:
    """Lowest eigenvalues about the equilibrium by sparse factors, (count,) [rad^2/s^2].

    Args:
        model: As for :func:`sparse_equilibrium`.
        target: Load factors.
        count: How many.

    Raises:
        ModelError: See :func:`refuse_what_is_not_sparse`, or too large a count.
        AnalysisError: singular_stiffness or not_converged.

    Source:
        Shift-inverted Lanczos method of ARPACK; THEORY.md 6 with multipliers in place of degrees of freedom.
    """
    refuse_what_is_not_sparse(model)
    at = _balance(model.topology, model.parameters, target)
    # The number is handed on as a shape, which stays known.
    return _eigenvalues(model.topology, model.parameters, target, at, jnp.zeros(count))
