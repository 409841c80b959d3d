"""Nodal forces of the constant loads at a configuration, and their derivative."""

import dataclasses
import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..arguments import as_floats, check_number, is_concrete
from ..errors import ModelError, warn
from ..math.indices import scatter_matrix, scatter_vector
from ..model.model import Model
from ..model.topology import Loads, Parameters, Topology
from .blocks import each_block
from .inertia import weight, weight_stiffness


class LoadFactors(NamedTuple):
    """Factors of the two sets of loads.

    Attributes:
        initial: For ``Parameters.loads`` and load elements.
        increment: For ``Parameters.increment`` and load elements with the option ``incremental``.
    """

    initial: Float[Array, ""] | float
    increment: Float[Array, ""] | float


def load_factors(load_factor: float = 1.0, increment: float = 0.0) -> LoadFactors:
    """Load factors as strongly typed scalars for compiled kernels."""
    return LoadFactors(as_floats(load_factor), as_floats(increment))


def load_factors_of(model: Model, load_factor: float, increment: float | None, function: str) -> LoadFactors:
    """Load factors of a public function, with a warning if incremental loads are left out by default."""
    check_number("load_factor", load_factor)
    if increment is None:
        warn_of_increment(model, function)
        return load_factors(load_factor, 0.0)
    check_number("increment", increment)
    if model.parameters.increment is None and is_concrete(increment) and increment != 0:
        raise ModelError("The model has no incremental loads for `increment` to scale. Give them increment=True.")
    return load_factors(load_factor, increment)


# Part of the warning about incremental loads.
LEAVES_OUT = "leaves out the incremental loads of the model"
# Advice for functions without the argument `increment`.
_INSTEAD = {
    "configuration": "This is right for the start of a motion with `increment`. Otherwise build them without"
    " increment=True, or give fm.equilibrium(model, increment=1.0)",
    "damped": "Give fm.linearize(model, increment=1.0), or increment=0.0 there for this state",
    "motion.steady_motion": "Build them without increment=True to include them",
    "frequency_like": "Follow modes by fm.linear.follow_modes(fm.modes(model, increment=0.0), ..)",
    "state_matrices": "Give fm.linearize(model, increment=1.0), or increment=0.0 there for this state",
    "stiffness": "Give fm.linearize(model, increment=1.0), or increment=0.0 there for this state",
    "simulate": "Give increment=lambda t: 1.0 for all of them, increment=lambda t: 0.0 for none",
    "save_fmu": "Build them without increment=True to include them",
    "trajectory.inverse_dynamics": "Build them without increment=True to include them",
    "to_nonlinear_system": "Build them without increment=True to include them",
}


def warn_of_increment(model: Model, function: str) -> None:
    """Warn that incremental loads are left out, except for models under a trace."""
    if model.parameters.increment is not None and is_concrete(model):
        usual = "Give increment=1.0 for the state under all of them, increment=0.0 for this state"
        warn(
            f"fm.{function} {LEAVES_OUT}: its result belongs to the state without them."
            f" {_INSTEAD.get(function, usual)}."
        )


def scaled_loads(parameters: Parameters, factors: LoadFactors) -> Loads:
    """Sum of the two sets of loads, each times its factor; None where neither set has the load.

    Prescribed values do not ramp from zero but from the undeformed mechanism: the caller scales differences.
    """
    first = jax.tree.map(lambda a: factors.initial * a, parameters.loads)
    if parameters.increment is None:
        return first
    second = jax.tree.map(lambda a: factors.increment * a, parameters.increment)
    fields = {}
    for field in dataclasses.fields(Loads):
        a, b = getattr(first, field.name), getattr(second, field.name)
        fields[field.name] = b if a is None else a if b is None else a + b
    return Loads(**fields)


def without_gravity(parameters: Parameters, *, increment: bool = False) -> Parameters:
    """Parameters without the gravity of the constant loads, and of the incremental loads if ``increment``."""
    changed = dataclasses.replace(parameters, loads=dataclasses.replace(parameters.loads, gravity=None))
    if not increment or changed.increment is None:
        return changed
    return dataclasses.replace(changed, increment=dataclasses.replace(changed.increment, gravity=None))


def has_loads(topology: Topology, parameters: Parameters) -> bool:
    """Whether the mechanism has loads or initial strains; known before tracing."""
    sets = (parameters.loads, parameters.increment, parameters.strain)
    return bool(jax.tree.leaves(sets)) or any(block.element.force is not None for block in topology.blocks)


def is_idle(topology: Topology, parameters: Parameters, factors: LoadFactors) -> Bool[Array, ""] | bool:
    """Whether all loads and initial strains are zero."""
    if any(block.element.force is not None for block in topology.blocks):
        return False
    numbers = jax.tree.leaves((scaled_loads(parameters, factors), parameters.strain))
    return jnp.all(jnp.array([jnp.all(number == 0) for number in numbers]))


def lacks_potential(topology: Topology) -> bool:
    """Whether a load or law has no potential, so that tangents are not symmetric; known before tracing.

    At rest, the law of a single deformation has a potential.
    """
    laws = any("law" in block.companions and block.e.shape[1] > 1 for block in topology.blocks)
    return laws or any(block.element.force is not None for block in topology.blocks)


def _load_elements(topology: Topology, parameters: Parameters, factors: LoadFactors):
    """Blocks with a load, the scaled load of one element, and its stacked arguments."""
    for block, function, *arguments in each_block(topology, parameters, "force"):
        incremental = dict(block.options).get("incremental", False)
        factor = factors.increment if incremental else factors.initial
        yield block, functools.partial(_scaled, factor, function), arguments


def _scaled(factor: Float[Array, ""] | float, function: Callable[..., Any], *arguments: Any) -> Array:
    return factor * function(*arguments)


def nodal_forces(
    topology: Topology, parameters: Parameters, factors: LoadFactors, x: Float[Array, "n_x"]
) -> Float[Array, "n_x"]:
    """Nodal forces of all constant loads, dual to x; THEORY.md 5."""
    loads = scaled_loads(parameters, factors)
    force = jnp.zeros(topology.n_x) if loads.force is None else loads.force
    if loads.gravity is not None:
        force = force + weight(topology, parameters, x, loads.gravity)
    element_forces = [
        (block.x, jax.vmap(function)(x[block.x], *arguments))
        for block, function, arguments in _load_elements(topology, parameters, factors)
    ]
    return force + scatter_vector(topology.n_x, element_forces) if element_forces else force


def load_pieces(
    topology: Topology, parameters: Parameters, factors: LoadFactors, x: Float[Array, "n_x"]
) -> list[tuple[Array, Array, Array]]:
    """Derivatives of the forces of each block's load elements, with row and column indices."""
    return [
        (block.x, block.x, jax.vmap(jax.jacfwd(function))(x[block.x], *arguments))
        for block, function, arguments in _load_elements(topology, parameters, factors)
    ]


def load_stiffness(
    topology: Topology, parameters: Parameters, factors: LoadFactors, x: Float[Array, "n_x"]
) -> Float[Array, "n_x n_x"]:
    """Derivative of :func:`nodal_forces`; not symmetric for moments about fixed axes."""
    loads = scaled_loads(parameters, factors)
    matrix = scatter_matrix((topology.n_x, topology.n_x), load_pieces(topology, parameters, factors, x))
    if loads.gravity is not None:
        matrix = matrix + weight_stiffness(topology, parameters, x, loads.gravity)
    return matrix
