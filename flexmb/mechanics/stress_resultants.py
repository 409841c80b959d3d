"""Stress resultants: stiffness, damping and laws of the elements, assembled; forces and moments in their sections."""

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..compilation.compile import jit, traced_once
from ..elements.element import NONLINEAR
from ..math.indices import scatter_matrix, scatter_vector
from ..model.topology import Block, Loads, Parameters, Topology
from .blocks import each_block, heat_sizes
from .inertia import InertialLoad, fall
from .staged import derivative


def stiffness_pieces(
    topology: Topology, parameters: Parameters, companion: str = "stiffness"
) -> list[tuple[Array, Array, Array]]:
    """Stiffness of each block's elements, with row and column indices."""
    return [
        (block.e, block.e, jax.vmap(function)(parameters.reference[block.x], *arguments))
        for block, function, *arguments in each_block(topology, parameters, companion)
    ]


@jit
def known_stiffness_pieces(topology: Topology, parameters: Parameters) -> list[tuple[Array, Array, Array]]:
    """As :func:`stiffness_pieces`, compiled as one program."""
    return stiffness_pieces(topology, parameters)


def stress_of_strain(topology: Topology, parameters: Parameters, strain: Float[Array, "n_e"]) -> Float[Array, "n_e"]:
    """Stiffness times deformations, block by block."""
    element_stresses = [
        (rows, jnp.einsum("eij,ej->ei", matrices, strain[columns]))
        for rows, columns, matrices in stiffness_pieces(topology, parameters)
    ]
    return scatter_vector(topology.n_e, element_stresses)


@traced_once
def element_stiffness(topology: Topology, parameters: Parameters) -> Float[Array, "n_e n_e"]:
    """Block-diagonal stiffness S between deformations and stress resultants."""
    return scatter_matrix((topology.n_e, topology.n_e), stiffness_pieces(topology, parameters))


@traced_once
def element_damping(topology: Topology, parameters: Parameters) -> Float[Array, "n_e n_e"]:
    """Block-diagonal damping S_d between deformation rates and stress resultants."""
    return scatter_matrix((topology.n_e, topology.n_e), stiffness_pieces(topology, parameters, "damping"))


def is_nonlinear(topology: Topology) -> bool:
    """Whether an element has an energy, a dissipation or a law; known before tracing."""
    return any(not set(NONLINEAR).isdisjoint(block.companions) for block in topology.blocks)


def is_nonlinear_at_rest(topology: Topology) -> bool:
    """As :func:`is_nonlinear`, at rest in the undeformed mechanism, where an energy of third order has no effect."""
    return any(map(has_law, topology.blocks))


def has_law(block: Block) -> bool:
    """Whether elements of a block have a dissipation, a law, or an energy that is not of third order."""
    return not {"dissipation", "law"}.isdisjoint(block.companions) or (
        "energy" in block.companions and not block.element.third_order
    )


def depends_on_rates(topology: Topology) -> bool:
    """Whether an element has a dissipation or a law; known before tracing."""
    return any(not {"dissipation", "law"}.isdisjoint(block.companions) for block in topology.blocks)


def _stress_of_energy(energy: Callable[..., Any], e: Float[Array, "n"], ed: Float[Array, "n"], *arguments: Any):
    return jax.grad(lambda e: energy((e,), *arguments))(e)


def _stress_of_dissipation(dissipation: Callable[..., Any], e: Array, ed: Float[Array, "n"], *arguments: Any):
    return jax.grad(lambda ed: dissipation((e, ed), *arguments))(ed)


def _stress_of_law(law: Callable[..., Any], e: Float[Array, "n"], ed: Float[Array, "n"], *arguments: Any):
    return law((e, ed), *arguments)


def _nonlinear_stress(topology: Topology, parameters: Parameters):
    """Blocks with a nonlinear companion, its stress ``f(e_el, ed_el, *arguments_el)``, and the stacked arguments.

    In between: numbers of the arguments that the stress depends on: (0,) for an energy, else (0, 1).
    """
    stresses = {"energy": _stress_of_energy, "dissipation": _stress_of_dissipation, "law": _stress_of_law}
    for companion, stress in stresses.items():
        for block, function, *arguments in each_block(topology, parameters, companion):
            yield block, functools.partial(stress, function), (0,) if companion == "energy" else (0, 1), arguments


@traced_once
def nonlinear_stress(
    topology: Topology, parameters: Parameters, e: Float[Array, "n_e"], ed: Float[Array, "n_e"]
) -> Float[Array, "n_e"]:
    """Stress resultants of energies, dissipations and laws: dE/de + dR/ded + law."""
    element_stresses = [
        (block.e, jax.vmap(function)(e[block.e], ed[block.e], *arguments))
        for block, function, _, arguments in _nonlinear_stress(topology, parameters)
    ]
    return scatter_vector(topology.n_e, element_stresses)


def nonlinear_tangent_pieces(
    topology: Topology, parameters: Parameters, e: Float[Array, "n_e"], ed: Float[Array, "n_e"]
) -> tuple[list[tuple[Array, Array]], list[tuple[Array, Array, Array]], list[tuple[Array, Array, Array]]]:
    """:func:`nonlinear_stress` of each block with its indices, and its derivatives by e and by ed."""
    stress, tangents = [], ([], [])
    for block, function, counts, arguments in _nonlinear_stress(topology, parameters):
        matrices_by, sigma = jax.vmap(derivative(function, counts))(e[block.e], ed[block.e], *arguments)
        stress.append((block.e, sigma))
        for element_matrices, matrices in zip(tangents, matrices_by, strict=False):
            element_matrices.append((block.e, block.e, matrices))
    return stress, *tangents


@traced_once
def nonlinear_tangents(
    topology: Topology, parameters: Parameters, e: Float[Array, "n_e"], ed: Float[Array, "n_e"]
) -> tuple[Float[Array, "n_e"], Float[Array, "n_e n_e"], Float[Array, "n_e n_e"] | None]:
    """:func:`nonlinear_stress`, and its block-diagonal derivatives by e and by ed; None for ed without rates.

    Matrices are symmetric unless an element has a law.
    """
    stress, *tangents = nonlinear_tangent_pieces(topology, parameters, e, ed)
    by_e, by_ed = (scatter_matrix((topology.n_e, topology.n_e), element_matrices) for element_matrices in tangents)
    return scatter_vector(topology.n_e, stress), by_e, by_ed if depends_on_rates(topology) else None


@traced_once
def nonlinear_energy(topology: Topology, parameters: Parameters, e: Float[Array, "n_e"]) -> Float[Array, ""]:
    """Elastic energy of elements with a nonlinear energy [J]."""
    total = jnp.array(0.0)
    for block, energy, *arguments in each_block(topology, parameters, "energy"):
        total = total + jnp.sum(jax.vmap(energy)((e[block.e],), *arguments))
    return total


@traced_once
def thermal_deformations(
    topology: Topology, parameters: Parameters, temperature: Float[Array, "n_e _t"]
) -> Float[Array, "n_e"]:
    """Deformations of free elements under a change of temperature; FIXED deformations are held at these values.

    Source: THEORY.md 2, eq. (2.31) to (2.33); temperature as in :class:`flexmb.model.topology.Loads`.
    """
    element_deformations = []
    for block, function, *arguments in each_block(topology, parameters, "thermal"):
        element_temperature = temperature[block.e[:, 0]]
        change = (element_temperature[:, :2], element_temperature[:, 2:])[: len(heat_sizes(block.element))]
        element_deformations.append((block.e, jax.vmap(function)(change, *arguments)))
    return scatter_vector(topology.n_e, element_deformations)


def free_deformations(topology: Topology, parameters: Parameters, loads: Loads) -> Float[Array, "n_e"] | None:
    """Deformations without stress, from initial strains and temperature; None: zero."""
    if loads.temperature is None:
        return parameters.strain
    warm = thermal_deformations(topology, parameters, loads.temperature)
    return warm if parameters.strain is None else warm + parameters.strain


def strain_of(topology: Topology, parameters: Parameters, loads: Loads, e: Float[Array, "n_e"]) -> Float[Array, "n_e"]:
    """Deformations minus the stress-free ones."""
    free = free_deformations(topology, parameters, loads)
    return e if free is None else e - free


def stress_of_loads(
    topology: Topology, parameters: Parameters, loads: Loads, stiffness: Float[Array, "n_e n_e"]
) -> Float[Array, "n_e"] | None:
    """Stress resultants of loads at constant deformations: prestress, less relief by temperature; None: zero.

    Source: derivative of THEORY.md 5, eq. (5.4) by the loads. ``stiffness`` is the tangent.
    """
    if loads.temperature is None:
        return loads.prestress
    relieved = -stiffness @ thermal_deformations(topology, parameters, loads.temperature)
    return relieved if loads.prestress is None else relieved + loads.prestress


def stress_resultants(
    topology: Topology,
    parameters: Parameters,
    loads: Loads,
    stiffness: Float[Array, "n_e n_e"],
    e: Float[Array, "n_e"],
    ed: Float[Array, "n_e"] | None = None,
) -> Float[Array, "n_e"]:
    """Stress resultants S (e - free) + nonlinear ones + prestress, without constant damping; ``ed`` None: at rest.

    Source: THEORY.md 5, eq. (5.4).
    """
    strain = strain_of(topology, parameters, loads, e)
    sigma = stiffness @ strain
    if is_nonlinear(topology):
        sigma = sigma + nonlinear_stress(topology, parameters, strain, jnp.zeros_like(e) if ed is None else ed)
    return _prestressed(sigma, loads)


def _prestressed(sigma: Float[Array, "n_e"], loads: Loads) -> Float[Array, "n_e"]:
    return sigma if loads.prestress is None else sigma + loads.prestress


def stress_tangents(
    topology: Topology,
    parameters: Parameters,
    loads: Loads,
    stiffness: Float[Array, "n_e n_e"],
    damping: Float[Array, "n_e n_e"] | None,
    e: Float[Array, "n_e"],
    ed: Float[Array, "n_e"] | None = None,
) -> tuple[Float[Array, "n_e n_e"], Any]:
    """Derivatives S and S_d of the stress resultants by deformations and rates; S_d None without damping."""
    if not is_nonlinear(topology):
        return stiffness, damping
    at_rest = jnp.zeros_like(e) if ed is None else ed
    _, by_e, by_ed = nonlinear_tangents(topology, parameters, strain_of(topology, parameters, loads, e), at_rest)
    if by_ed is not None:
        damping = by_ed if damping is None else damping + by_ed
    return stiffness + by_e, damping


def stress_and_tangent(
    topology: Topology,
    parameters: Parameters,
    loads: Loads,
    stiffness: Float[Array, "n_e n_e"],
    e: Float[Array, "n_e"],
) -> tuple[Float[Array, "n_e"], Float[Array, "n_e n_e"]]:
    """Stress resultants at rest, and the tangent stiffness; THEORY.md 5, eq. (5.4)."""
    strain = strain_of(topology, parameters, loads, e)
    sigma = stiffness @ strain
    if is_nonlinear(topology):
        nonlinear, by_e, _ = nonlinear_tangents(topology, parameters, strain, jnp.zeros_like(e))
        sigma, stiffness = sigma + nonlinear, stiffness + by_e
    return _prestressed(sigma, loads), stiffness


def block_resultants(
    topology: Topology,
    parameters: Parameters,
    x: Float[Array, "n_x"],
    sigma: Float[Array, "n_e"],
    felt: InertialLoad,
    places: Float[Array, "places"],
) -> list[Float[Array, "elements places 6"]]:
    """Forces and moments in cross-sections, (elements, places, 6) [N, N m] per block with the companion ``resultants``.

    ``sigma`` includes multipliers of FIXED deformations; places go from 0 at the first end of an element to 1.
    """
    resultants = []
    inertias = {id(block): arguments for block, *arguments in each_block(topology, parameters, "inertia")}
    for block, function, ref, properties in each_block(topology, parameters, "resultants"):
        extra: dict[str, Any] = {"sigma": sigma[block.e]}
        if block.element.feels_fall:
            acts = id(block) in inertias
            extra["fall"] = fall(topology, felt, x, block, *inertias[id(block)]) if acts else None
        at_places = jax.vmap(functools.partial(_at_place, function), (None, None, None, None, 0))
        resultants.append(jax.vmap(at_places, (0, 0, 0, 0, None))(x[block.x], ref, properties, extra, places))
    return resultants


def _at_place(
    function: Callable[..., Any], x: Any, ref: Array, properties: Any, extra: dict[str, Any], place: Float[Array, ""]
) -> Float[Array, "6"]:
    return function(x, ref, properties, place=place, **extra)
