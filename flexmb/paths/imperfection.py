"""Mechanisms bent by their buckling modes, free of stress."""

import dataclasses
from collections.abc import Mapping

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_number, check_whole, short_repr
from ..compilation.compile import jit
from ..errors import AnalysisError
from ..linear.buckling import Buckling, buckling
from ..math.element_matrices import AssembledEquations
from ..math.indices import put
from ..math.sparse import SparseFactors
from ..mechanics.centreline import curves_of
from ..mechanics.deformation import deformation_jacobian
from ..mechanics.loads import LoadFactors
from ..model.model import Model
from ..model.topology import Loads, Parameters, Topology, coordinate_scales
from ..numerical_limits import ALLOWED_STATE, LARGEST_ALIKE, SMALL_MOTION
from ..results import RESULTS, check, or_nan
from ..statics.configuration import configure
from ..statics.solver_choice import up_to
from ..statics.tangent import at_state, unknowns

# Places along an element, quarters and halves included.
PLACES = np.linspace(0.0, 1.0, 33)
# Newton iterations to the allowed state next to a given one.
CORRECTIONS = 20


@jit
def _deformations(
    topology: Topology,
    parameters: Parameters,
    x: Float[Array, "n_x"],
    e: Float[Array, "n_e"],
    motion: Float[Array, "n_x"],
):
    """Deformations, degrees of freedom and code after a motion of x from the undeformed mechanism."""
    _, jacobian = deformation_jacobian(topology, parameters, x, e)
    q = jnp.concatenate([motion[topology.x.dof], (jacobian @ motion)[topology.e.dof]])
    _, _, bent, result = configure(topology, parameters, q, jnp.zeros_like(q))
    return bent, q, result


def largest_displacement(model: Model, x: Float[Array, "n_x"], motion: Float[Array, "n_x"]) -> float:
    """Largest displacement of a point of the mechanism, also along its elements, in a small motion [m].

    By a central difference, whose error is the square of the step.
    """
    at, reference = np.asarray(x), np.asarray(model.parameters.reference)
    size = np.max(np.abs(motion) / coordinate_scales(model.topology, model.parameters), initial=0.0)
    if not size > 0:
        return 0.0
    step = np.asarray(motion) * (SMALL_MOTION / size)
    largest = 0.0
    for block, properties in zip(model.topology.blocks, model.parameters.properties, strict=True):
        ends = [curves_of(block, properties, reference, state, PLACES) for state in (at + step, at - step)]
        moved = np.linalg.norm(ends[0] - ends[1], axis=-1)
        largest = max(largest, float(np.max(moved, initial=0.0)) / 2)
    return largest * size / SMALL_MOTION


def _allowed_state(model: Model, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates and deformations of the allowed state next to x, by sparse factors; or out_of_reach.

    Newton's method on dx / sizes^2 + D^T m = 0, D(x + dx) = 0: distances in extents and radians.
    """
    import scipy.sparse

    topology, parameters = model.topology, model.parameters
    free, _, constrained = (np.asarray(i) for i in unknowns(topology))
    sizes, x, zero = np.asarray(coordinate_scales(topology, parameters)), np.array(x), np.zeros(topology.n_e)
    metric, nothing = scipy.sparse.diags_array(1 / sizes[free] ** 2), np.zeros(len(free))
    for _ in range(CORRECTIONS):
        elements, e = at_state(topology, parameters, LoadFactors(0.0, 0.0), *jax.device_put((x, zero, zero)))
        if len(constrained) == 0:
            return x, np.asarray(e)
        e, rows = np.asarray(e), AssembledEquations(jax.tree.map(np.asarray, elements)).constraints
        factors = SparseFactors(scipy.sparse.block_array([[metric, rows.T], [rows, None]]))
        if not factors.regular:
            raise AnalysisError(RESULTS.singular_configuration.name, RESULTS.singular_configuration.message)
        change = factors.solve(np.concatenate([nothing, -e[constrained]]))[: len(free)]
        x[free] += change
        if np.max(np.abs(change) / sizes[free]) < ALLOWED_STATE:
            return x, e
    raise AnalysisError(RESULTS.out_of_reach.name, RESULTS.out_of_reach.message)


def bent_by_modes(model: Model, imperfection: Mapping[int, float], sparse: bool = False) -> Model:
    """The mechanism bent by its buckling modes, free of stress.

    The modes are those of linear buckling about the state at which a path begins, under the growing loads. Stress
    follows from the deformations minus the deformations of the bent shape. The bent shape satisfies the constraints.
    Its deformations do not grow with the load. Start values are counted from the bent shape, where a motion starts by
    default. With sparse factors there is no start, and a motion without ``initial`` raises.

    Args:
        imperfection: Largest displacement of each mode, by its number from 1 [m]; if positive, the position that
            changes most in the mode grows.
        sparse: Whether to use sparse factors, without degrees of freedom.
    """
    if not isinstance(imperfection, Mapping):
        raise TypeError(
            f"Argument `imperfection` must be lengths by mode, such as {{1: 1e-6}}, not {short_repr(imperfection)}."
        )
    for number, length in imperfection.items():
        check_whole("imperfection", number, 1)
        check_number(f"imperfection[{number}]", length)
    if not imperfection:
        return model
    growing = _growing_from_zero(model)
    # An error names a mode that does not exist.
    count = up_to(max(map(int, imperfection)), growing) if sparse else None
    buckled = buckling(growing, count=count, sparse=sparse)
    motion = sum(length * _unit_motion(buckled, int(number)) for number, length in imperfection.items())
    start = model.parameters.start
    topology = model.topology
    if sparse:
        x, bent = _allowed_state(model, np.asarray(model.parameters.reference + motion))
        moved = x - np.asarray(model.parameters.reference)
        q = np.concatenate([moved[np.asarray(topology.x.dof)], bent[np.asarray(topology.e.dof)]])
        # A large mechanism has a start only if the builder names one.
        start = None if start is None else (q + start[0], start[1])
    else:
        unloaded = dataclasses.replace(model.parameters, loads=Loads(), increment=None, strain=None)
        bent, q, result = _deformations(model.topology, unloaded, buckled.lin.x, buckled.lin.e, motion)
        check(result, True)
        bent = or_nan(bent, result)
        start = (q, jnp.zeros_like(q)) if start is None else (q + start[0], start[1])
    # Held deformations are no strain, but for round-off.
    bent, before = put(jnp.asarray(bent), topology.e.held, 0.0), model.parameters.strain
    strain = bent if before is None else bent + before
    return dataclasses.replace(model, parameters=dataclasses.replace(model.parameters, strain=strain, start=start))


def _growing_from_zero(model: Model) -> Model:
    """The model with all loads incremental. Its modes are the modes of the unloaded mechanism.

    A path often cannot reach a load factor of 1, and has no modes there. If some loads are incremental, the others act
    from the begin.
    """
    parameters, top = model.parameters, model.topology
    if parameters.increment is not None:
        return model
    blocks = tuple(
        block
        if block.element.force is None
        else dataclasses.replace(block, options=(*block.options, ("incremental", True)))
        for block in top.blocks
    )
    return dataclasses.replace(
        model,
        topology=dataclasses.replace(top, blocks=blocks),
        parameters=dataclasses.replace(parameters, loads=Loads(), increment=parameters.loads),
    )


def _unit_motion(buckled: Buckling, number: int) -> Float[np.ndarray, "n_x"]:
    """A buckling mode with a largest displacement of 1 m, in which the position that changes most grows."""
    count = buckled.shapes.shape[1]
    if number > count:
        raise ValueError(f"Argument `imperfection` names buckling mode {number}, but under these loads are {count}.")
    shape = np.asarray(buckled.shapes)[:, number - 1]
    largest = largest_displacement(buckled.lin.model, buckled.lin.x, buckled.shapes[:, number - 1])
    if not largest > 0:
        raise ValueError(f"Argument `imperfection` is a length, but buckling mode {number} moves no point.")
    model = buckled.lin.model
    sizes = np.abs(shape) / np.asarray(coordinate_scales(model.topology, model.parameters))
    positions = np.zeros(len(shape))
    positions[np.asarray(model.topology.axes)] = 1.0
    moved = sizes * positions if np.any(sizes * positions > SMALL_MOTION * sizes.max()) else sizes
    # The first of several that change alike, as both ends of a column turn.
    first = int(np.argmax(moved > (1 - LARGEST_ALIKE) * moved.max()))
    return shape / (largest * np.sign(shape[first]))
