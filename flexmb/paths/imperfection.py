"""Mechanisms that are made a little bent: by their buckling modes, and without stress."""

import dataclasses
from collections.abc import Mapping

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import check_number, check_whole, shown
from ..compilation.compile import jit
from ..errors import AnalysisError
from ..linear.buckling import Buckling, buckling
from ..math.element_matrices import Whole
from ..math.indices import put
from ..math.sparse import SparseFactors
from ..mechanics.centreline import curves_of
from ..mechanics.deformation import deformation_jacobian
from ..mechanics.extent import sizes_of
from ..mechanics.loads import LoadFactors
from ..model.model import Model
from ..model.parameters import Loads, Parameters
from ..model.topology import Topology
from ..results import RESULTS, check, or_nan
from ..statics.configuration import configure
from ..statics.tangent import at_state, unknowns
from .stepper import scales_increment

# Displacements of points are measured by a motion of this share of the extent, forth and back.
SMALL = 1e-4
# Along an element; quarters and halves are among them.
PLACES = np.linspace(0.0, 1.0, 33)
# Newton's method for the state next to one that constraints do not allow.
CORRECTIONS = 20
TOLERANCE = 1e-13


@jit
def _deformations(
    topology: Topology,
    parameters: Parameters,
    x: Float[Array, "n_x"],
    e: Float[Array, "n_e"],
    motion: Float[Array, "n_x"],
):
    """Deformations and degrees of freedom where the undeformed mechanism is moved along a motion of x, and a code."""
    _, jacobian = deformation_jacobian(topology, parameters, x, e)
    q = jnp.concatenate([motion[topology.x.dof], (jacobian @ motion)[topology.e.dof]])
    _, _, bent, result = configure(topology, parameters, q, jnp.zeros_like(q))
    return bent, q, result


def largest_displacement(model: Model, x: Float[Array, "n_x"], motion: Float[Array, "n_x"]) -> float:
    """Largest displacement of a point of the mechanism in a small motion, along its elements too, () [m].

    Args:
        x: State that the motion is about, (n_x,) [m, rad, -].
        motion: Change of the coordinates, (n_x,) [m, rad, -].

    Source:
        Central difference, whose error is the square of the step.
    """
    at, reference = np.asarray(x), np.asarray(model.parameters.reference)
    size = np.max(np.abs(motion) / sizes_of(model.topology, model.parameters), initial=0.0)
    if not size > 0:
        return 0.0
    step = np.asarray(motion) * (SMALL / size)
    largest = 0.0
    for block, properties in zip(model.topology.blocks, model.parameters.properties, strict=True):
        ends = [curves_of(block, properties, reference, state, PLACES) for state in (at + step, at - step)]
        moved = np.linalg.norm(ends[0] - ends[1], axis=-1)
        largest = max(largest, float(np.max(moved, initial=0.0)) / 2)
    return largest * size / SMALL


def _allowed_state(model: Model, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The allowed state next to one given, distances in extents and radians, by sparse factors.

    Args:
        x: State in which constraints need not hold, (n_x,) [m, rad, -].

    Returns:
        Coordinates, (n_x,) [m, rad, -], and deformations, (n_e,) [m, rad].

    Raises:
        AnalysisError: out_of_reach, or singular_configuration.

    Source:
        Newton's method on dx / sizes^2 + D^T m = 0, D(x + dx) = 0.
    """
    import scipy.sparse

    topology, parameters = model.topology, model.parameters
    free, _, held = (np.asarray(i) for i in unknowns(topology))
    sizes, x, zero = np.asarray(sizes_of(topology, parameters)), np.array(x), np.zeros(topology.n_e)
    metric, nothing = scipy.sparse.diags_array(1 / sizes[free] ** 2), np.zeros(len(free))
    for _ in range(CORRECTIONS):
        elements, e = at_state(topology, parameters, LoadFactors(0.0, 0.0), *jax.device_put((x, zero, zero)))
        if len(held) == 0:
            return x, np.asarray(e)
        e, rows = np.asarray(e), Whole(jax.tree.map(np.asarray, elements)).constraints
        factors = SparseFactors(scipy.sparse.block_array([[metric, rows.T], [rows, None]]))
        if not factors.regular:
            raise AnalysisError(RESULTS.singular_configuration.name, RESULTS.singular_configuration.message)
        change = factors.solve(np.concatenate([nothing, -e[held]]))[: len(free)]
        x[free] += change
        if np.max(np.abs(change) / sizes[free]) < TOLERANCE:
            return x, e
    raise AnalysisError(RESULTS.out_of_reach.name, RESULTS.out_of_reach.message)


def bent_by_modes(model: Model, imperfection: Mapping[int, float], sparse: bool = False) -> Model:
    """The mechanism bent by its buckling modes, free of stress.

    The modes are those of linear buckling about the state at which a path begins, under the loads that grow along it.
    Stress is that of deformations less those of the bent shape, which are found where the constraints hold. They do not
    grow with the load. Start values are counted from the bent shape, in which a motion starts without any; by sparse
    factors the mechanism is given none, and a motion that is not told where to begin says so.

    Args:
        imperfection: Largest displacement of each mode, by its number from 1 [m]; where it is positive, the position
            that changes most in the mode grows.
        sparse: Whether by sparse factors, of a mechanism that needs no degrees of freedom.

    Raises:
        TypeError: It is no mapping of numbers to lengths.
        ValueError: There are not so many modes; a mode moves no point.
        AnalysisError: As for ``buckling``; out_of_reach where there is no such shape.
    """
    if not isinstance(imperfection, Mapping):
        raise TypeError(
            f"Argument `imperfection` must be lengths by mode, such as {{1: 1e-6}}, not {shown(imperfection)}."
        )
    for number, length in imperfection.items():
        check_whole("imperfection", number, 1)
        check_number(f"imperfection[{number}]", length)
    if not imperfection:
        return model
    growing = _growing_from_zero(model)
    found = buckling(growing, count=max(map(int, imperfection)), sparse=sparse)
    motion = sum(length * _unit_motion(found, int(number)) for number, length in imperfection.items())
    start = model.parameters.start
    topology = model.topology
    if sparse:
        x, bent = _allowed_state(model, np.asarray(model.parameters.reference + motion))
        moved = x - np.asarray(model.parameters.reference)
        q = np.concatenate([moved[np.asarray(topology.x.dof)], bent[np.asarray(topology.e.dof)]])
        # Where nothing else is said, a large mechanism may have none.
        start = None if start is None else (q + start[0], start[1])
    else:
        unloaded = dataclasses.replace(model.parameters, loads=Loads(), increment=None, strain=None)
        bent, q, result = _deformations(model.topology, unloaded, found.lin.x, found.lin.e, motion)
        check(result, True)
        bent = or_nan(bent, result)
        start = (q, jnp.zeros_like(q)) if start is None else (q + start[0], start[1])
    # What is held is no strain but by round-off.
    bent, before = put(jnp.asarray(bent), topology.e.held, 0.0), model.parameters.strain
    strain = bent if before is None else bent + before
    return dataclasses.replace(model, parameters=dataclasses.replace(model.parameters, strain=strain, start=start))


def _growing_from_zero(model: Model) -> Model:
    """The same where all loads grow, as incremental ones: its modes are those of the unloaded mechanism.

    What a path is asked about often bears no load factor of 1, and so has no modes there. Where some loads are
    incremental, the others are there from the begin.
    """
    own, top = model.parameters, model.topology
    if scales_increment(top, own):
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
        parameters=dataclasses.replace(own, loads=Loads(), increment=own.loads),
    )


def _unit_motion(found: Buckling, number: int) -> Float[np.ndarray, "n_x"]:
    """A buckling mode whose largest displacement is 1 m, and in which the position that changes most grows."""
    count = found.shapes.shape[1]
    if number > count:
        raise ValueError(f"Argument `imperfection` asks for buckling mode {number}, but under these loads are {count}.")
    shape = np.asarray(found.shapes)[:, number - 1]
    largest = largest_displacement(found.lin.model, found.lin.x, found.shapes[:, number - 1])
    if not largest > 0:
        raise ValueError(f"Argument `imperfection` is a length, but buckling mode {number} moves no point.")
    model = found.lin.model
    sizes = np.abs(shape) / np.asarray(sizes_of(model.topology, model.parameters))
    positions = np.zeros(len(shape))
    positions[np.asarray(model.topology.axes)] = 1.0
    moved = sizes * positions if np.any(sizes * positions > SMALL * sizes.max()) else sizes
    # The first of several that change alike, as both ends of a column turn.
    first = int(np.argmax(moved > (1 - 1e-6) * moved.max()))
    return shape / (largest * np.sign(shape[first]))
