"""Compliance of a mechanism at its nodes, about the static equilibrium."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..arguments import check_flag, computed, is_concrete, undifferentiated
from ..compilation.compile import jit, unguarded
from ..elements.nodes import ROTATION3
from ..errors import AnalysisError, warn
from ..math.indices import put
from ..math.linear import diagonal_of, factorise, unit_scale
from ..math.linear_solver import LinearSolver
from ..math.rotation import LBAR, lbar, rotation_matrix
from ..model.model import Model
from ..numerical_limits import HELD_COMPLIANCE, NEGATIVE_WORK
from ..results import RESULTS, check, collect, or_nan
from ..statics.equilibrium import Equilibrium
from ..statics.solver_choice import asked_solver
from .about import Where, asked_about, linearized
from .linearize import Linearization, ManyStates, Matrices
from .loose import free_motions, moving_names, naming_culprit, takes_part
from .sparse_solve import sparse_solution


def _rates(coordinates: Float[Array, "n"]) -> Float[Array, "m n"]:
    """Matrix from rates of a node's coordinates to its velocity or angular velocity about global axes."""
    return 2 * lbar(coordinates) if coordinates.shape[0] == ROTATION3.size else jnp.eye(coordinates.shape[0])


def rates_on_host(coordinates: np.ndarray) -> np.ndarray:
    """:func:`_rates` of a position, an angle or a rotation, on the host."""
    n = coordinates.shape[0]
    return 2 * LBAR @ coordinates if n == ROTATION3.size else np.eye(n)


@unguarded
def compliance(
    model: Model | Linearization,
    node: str,
    *,
    local: bool = False,
    sparse: bool | None = None,
    solver: str | LinearSolver | None = None,
    at: Equilibrium | Linearization | ManyStates | None = None,
    step: int | None = None,
    time: float | None = None,
    increment: float | None = None,
) -> Float[Array, "n n"]:
    """Return the displacements and rotations of a node under unit forces and moments on this node.

    Args:
        model: Mechanism, or its linearisation.
        node: Name of the node. The compliance includes its position and, if the node has one, its rotation.
        local: Use axes that turn with the node instead of global axes; the node needs a rotation.
        sparse: Use sparse matrices in all coordinates; the model needs no degrees of freedom. See
            :func:`flexmb.equilibrium`. By default the size of the model decides.
        solver: "sparse", "dense", or a LinearSolver in place of sparse factors, as for :func:`flexmb.frequencies`.
        at, step, time, increment: State, as for :func:`flexmb.frequencies`.

    Returns:
        u = C f with u = (displacements, rotations) and f = (forces, moments): (3, 3) in the plane, (6, 6) in space,
        or the node's own coordinates if it has no rotation [m/N, rad/N, m/(N m), rad/(N m)].

    Raises:
        KeyError: The node is unknown.
        ValueError: ``local`` for a node without a rotation.
        AnalysisError: singular_stiffness if the node moves in a motion without stiffness. With dense matrices, other
            nodes still have a compliance.

    Warns:
        FlexmbWarning: The state is not stable, and forces on the node excite an unstable motion.

    Source:
        THEORY.md 7, eq. (7.5): (K0 + N0 + G0)^-1 through DFx; rotations by omega = 2 Lbar d(lambda)/dt.
    """
    check_flag("local", local)
    where, chosen = Where(at, step, time, increment), asked_solver(sparse, solver)
    lin = asked_about(model, "compliance", where, chosen)
    labels = lin.labels
    parts = labels.parts(node)
    if local and not any(labels.x[labels.coordinates(part)[0]].kind == "rotation" for part in parts):
        raise ValueError(f"Node '{node}' has no rotation, so it has no local axes. Leave `local` out.")
    places = tuple(np.array(labels.coordinates(part)) for part in parts)
    displacements = sum(labels.x[place[0]].kind != "rotation" for place in places for _ in place)
    if lin.large:
        try:
            flexibility = compliance_of_large(lin, places, local)
            _warn_of_instability(flexibility, node, displacements)
            return flexibility
        except AnalysisError:
            if chosen is not None or lin is model or lin is at:
                raise
        # Dense matrices find nodes that take no part in free motions.
        lin = linearized(model, "compliance", where=where)
    flexibility, jacobian, result = _compliance(lin.matrices, places, local=local)
    if is_concrete(known := undifferentiated((lin, jacobian, result))) and int(known[2]) == RESULTS.singular_stiffness:
        return _beside_free_motions(lin, jacobian, node, known)
    check(result, True)
    _warn_of_instability(flexibility, node, displacements)
    return or_nan(flexibility, result)


def _warn_of_instability(flexibility: Float[Array, "n n"], node: str, displacements: int) -> None:
    """Warn if forces do negative work on a node, which they do not in a stable state."""
    if not is_concrete(flexibility):
        return
    sizes = np.sqrt(np.abs(np.diag(np.asarray(flexibility))))
    # Directions that rigid parts hold have a compliance of round-off, of either sign. Displacements come first.
    turns = np.arange(len(sizes)) >= displacements
    largest = [np.max(sizes[turns == part], initial=0.0) for part in (False, True)]
    moves = sizes > HELD_COMPLIANCE * np.where(turns, *largest[::-1])
    scaled = np.asarray(flexibility)[np.ix_(moves, moves)] / np.outer(sizes[moves], sizes[moves])
    symmetric = np.allclose(scaled, scaled.T, rtol=0, atol=NEGATIVE_WORK)
    if symmetric and np.min(np.linalg.eigvalsh(scaled), initial=0.0) < -NEGATIVE_WORK:
        collect(RESULTS.unstable_state)
        warn(
            f"The state is not stable: forces on node '{node}' do negative work, and frequencies are negative or"
            " imaginary. Follow the path to a stable state by fm.path, or lower the load."
        )


def _beside_free_motions(lin: Linearization, jacobian: Any, node: str, known: Any) -> Float[Array, "n n"]:
    """Compliance of a node whose directions, ``jacobian``, must take part in no free motion of ``known`` numbers."""
    m, at = known[0].matrices, np.asarray(known[1])
    flexibility, free, springs = free_motions(m)
    if np.any(takes_part(at, free)):
        moving = moving_names(known[0].model, np.asarray(m.DFx) @ free)
        raise AnalysisError(
            "singular_stiffness",
            f"The compliance of node '{node}' is unbounded: it takes part in a motion without stiffness: {moving}."
            " Support or stiffen that motion.",
        )
    if is_concrete(lin):
        return jnp.asarray(at @ flexibility @ at.T)
    # Springs on the free motions leave the rest as it is, and differentiable.
    return jacobian @ jnp.linalg.solve(lin.matrices.K + springs @ springs.T, jacobian.T)


def _directions(x: Float[Array, "n_x"], parts: tuple[Int[Array, "_n"], ...], local: bool) -> list[Float[Array, "m n"]]:
    """Displacements and rotations of a node by the coordinates of each of its parts."""
    rows = [_rates(x[part]) for part in parts]
    if local:
        rotation = x[parts[-1]]
        if rotation.shape[0] == ROTATION3.size:
            return [rotation_matrix(rotation).T @ row for row in rows]
        if len(parts) == 2:
            c, s = jnp.cos(rotation[0]), jnp.sin(rotation[0])
            rows[0] = jnp.array([[c, s], [-s, c]]) @ rows[0]
    return rows


def compliance_of_large(lin: Linearization, parts: tuple[Any, ...], local: bool = False) -> Float[Array, "n n"]:
    """Compliance by sparse factors."""
    forces = _unit_forces(lin.x, parts, lin.elements.free, lin.elements.held, local=local)
    with naming_culprit(lin):
        moved = sparse_solution(lin.elements, forces, solver=lin.solver)
    return computed(lambda _, forces, moved: forces.T @ moved, forces, moved)


@jit
def _unit_forces(
    x: Float[Array, "n_x"], parts: tuple[Any, ...], free: Int[Array, "n"], held: Int[Array, "h"], *, local: bool
) -> Float[Array, "n_and_h r"]:
    """Unit forces along displacements and about rotations, on the coordinates that move, and zeros for multipliers."""
    pairs = zip(_directions(x, parts, local), parts, strict=True)
    along = jnp.concatenate([put(jnp.zeros((x.shape[0], len(row))), part, row.T) for row, part in pairs], axis=1)
    return jnp.concatenate([along[free], jnp.zeros((held.shape[0], along.shape[1]))])


def compliance_of(m: Matrices, parts: tuple[Int[Array, "_n"], ...], local: bool):
    """Compliance, the node's directions by the degrees of freedom, and code of RESULTS."""
    rows = _directions(m.x, parts, local)
    jacobian = jnp.concatenate([row @ m.DFx[part] for row, part in zip(rows, parts, strict=True)])
    # Scale each degree of freedom by the stiffnesses at it, to find free motions.
    meeting = diagonal_of(jnp.abs(m.DFe).T @ jnp.abs(m.S) @ jnp.abs(m.DFe)) + jnp.abs(diagonal_of(m.K))
    scale = jax.lax.stop_gradient(unit_scale(meeting))
    factors = factorise(m.K * scale[:, None] * scale)
    result = jnp.where(factors.regular(), RESULTS.successful, RESULTS.singular_stiffness)
    scaled = jacobian * scale
    return scaled @ factors.solve(scaled.T), jacobian, result.astype(jnp.int32)


_compliance = jit(compliance_of)


def directional_compliance(
    model: Model | Linearization,
    *,
    at: Equilibrium | Linearization | ManyStates | None = None,
    step: int | None = None,
    time: float | None = None,
    increment: float | None = None,
) -> dict[str, np.ndarray]:
    """Return the displacement of each node along each axis under a unit force along that axis.

    Args:
        model: Mechanism, or its linearisation.
        at, step, time, increment: State, as for :func:`flexmb.frequencies`.

    Returns:
        Array by name of the node. A position has one value for each coordinate [m/N]. A rotation in space has three
        values, about the global axes; a rotation in the plane has one [rad/(N m)]. A value is infinite if its
        direction takes part in a motion without stiffness.

    Raises:
        TypeError: Numbers are traced.

    Warns:
        FlexmbWarning: A motion has no stiffness.

    Source:
        Diagonal of DFx (K0 + N0 + G0)^-1 DFx^T, with rotations by omega = 2 Lbar d(lambda)/dt.
    """
    lin = linearized(model, "directional_compliance", where=Where(at, step, time, increment))
    if not is_concrete(lin.matrices):
        raise TypeError(
            "fm.linear.directional_compliance needs a model of known numbers. Use fm.compliance of one node inside"
            " jax.jit, jax.grad and jax.vmap."
        )
    x, dfx = np.asarray(lin.matrices.x), np.asarray(lin.matrices.DFx)
    flexibility, free, _ = free_motions(lin.matrices)
    if free.shape[1]:
        warn(f"The compliance is unbounded in motions without stiffness: {moving_names(lin.model, dfx @ free)}.")
    by_node = {}
    for node in dict.fromkeys(entry.of for entry in lin.labels.x):
        indices = lin.labels.coordinates(node)
        rows = rates_on_host(x[indices]) @ dfx[indices]
        values = np.einsum("ij,jk,ik->i", rows, flexibility, rows)
        by_node[node] = np.where(takes_part(rows, free), np.inf, values)
    return by_node
