"""Stress resultants: stiffness, damping and laws of the elements, assembled; forces and moments in their sections."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..compilation.compile import jit, traced_once
from ..elements.element import NONLINEAR
from ..model.parameters import Loads, Parameters
from ..model.topology import Block, Topology
from .blocks import each_block, heat_sizes, scatter_matrix, scatter_vector
from .inertia import Felt, fall


def stiffness_pieces(
    topology: Topology, parameters: Parameters, companion: str = "stiffness"
) -> list[tuple[Array, Array, Array]]:
    """Stiffness of each block's elements, with row and column indices."""
    pieces = []
    for block, function, ref, properties in each_block(topology, parameters, companion):
        pieces.append((block.e, block.e, jax.vmap(function)(parameters.reference[block.x], ref, properties)))
    return pieces


@jit
def known_stiffness_pieces(topology: Topology, parameters: Parameters) -> list[tuple[Array, Array, Array]]:
    """Stiffness of each block's elements where it is asked for by itself: one program, not one for each operation."""
    return stiffness_pieces(topology, parameters)


def stress_of_strain(topology: Topology, parameters: Parameters, strain: Float[Array, "n_e"]) -> Float[Array, "n_e"]:
    """Stiffness times deformations, block by block.

    Returns S strain, (n_e,) [N, N m]. Source: Each element's stiffness companion.
    """
    pieces = [
        (rows, jnp.einsum("eij,ej->ei", matrices, strain[columns]))
        for rows, columns, matrices in stiffness_pieces(topology, parameters)
    ]
    return scatter_vector(topology.n_e, pieces)


def _assemble(topology: Topology, parameters: Parameters, companion: str) -> Float[Array, "n_e n_e"]:
    return scatter_matrix((topology.n_e, topology.n_e), stiffness_pieces(topology, parameters, companion))


@traced_once
def element_stiffness(topology: Topology, parameters: Parameters) -> Float[Array, "n_e n_e"]:
    """Stiffness S between deformations and stress resultants, block diagonal.

    Returns S, (n_e, n_e) [N/m, N m/rad]. Source: Each element's stiffness companion.
    """
    return _assemble(topology, parameters, "stiffness")


@traced_once
def element_damping(topology: Topology, parameters: Parameters) -> Float[Array, "n_e n_e"]:
    """Damping S_d between deformation rates and stress resultants, block diagonal.

    Returns S_d, (n_e, n_e) [N s/m, N m s/rad]. Source: Each element's damping companion.
    """
    return _assemble(topology, parameters, "damping")


def is_nonlinear(topology: Topology) -> bool:
    """Whether some element states an energy, a dissipation or a law; known before tracing."""
    return any(not set(NONLINEAR).isdisjoint(block.companions) for block in topology.blocks)


def is_nonlinear_at_rest(topology: Topology) -> bool:
    """The same, of the undeformed mechanism at rest, where an energy of third order is not felt."""
    return any(map(has_law, topology.blocks))


def has_law(block: Block) -> bool:
    """Whether elements of a block state a dissipation, a law, or an energy that is not of third order."""
    return not {"dissipation", "law"}.isdisjoint(block.companions) or (
        "energy" in block.companions and not block.element.third_order
    )


def depends_on_rates(topology: Topology) -> bool:
    """Whether some element states a dissipation or a law; known before tracing."""
    return any(not {"dissipation", "law"}.isdisjoint(block.companions) for block in topology.blocks)


def _nonlinear_stress(topology: Topology, parameters: Parameters):
    """Blocks with a nonlinear companion, its stress ``f(e_el, ed_el, *arguments_el)``, what it depends on, arguments.

    An energy's stress depends on the deformations alone, argument 0, others on their rates too, argument 1.
    """
    for block, energy, *arguments in each_block(topology, parameters, "energy"):

        def elastic(e: Float[Array, "n"], ed: Float[Array, "n"], *rest: Any, energy: Callable[..., Any] = energy):
            return jax.grad(lambda e: energy((e,), *rest))(e)

        yield block, elastic, (0,), arguments
    for block, dissipation, *arguments in each_block(topology, parameters, "dissipation"):

        def damping(
            e: Float[Array, "n"], ed: Float[Array, "n"], *rest: Any, dissipation: Callable[..., Any] = dissipation
        ):
            return jax.grad(lambda ed: dissipation((e, ed), *rest))(ed)

        yield block, damping, (0, 1), arguments
    for block, law, *arguments in each_block(topology, parameters, "law"):

        def general(e: Float[Array, "n"], ed: Float[Array, "n"], *rest: Any, law: Callable[..., Any] = law):
            return law((e, ed), *rest)

        yield block, general, (0, 1), arguments


@traced_once
def nonlinear_stress(
    topology: Topology, parameters: Parameters, e: Float[Array, "n_e"], ed: Float[Array, "n_e"]
) -> Float[Array, "n_e"]:
    """Stress resultants of the elements' energies, dissipations and laws.

    Returns sigma, (n_e,) [N, N m]. Source: Each element's own companions: dE/de + dR/ded + law.
    """
    pieces = []
    for block, function, _, arguments in _nonlinear_stress(topology, parameters):
        pieces.append((block.e, jax.vmap(function)(e[block.e], ed[block.e], *arguments)))
    return scatter_vector(topology.n_e, pieces)


def nonlinear_tangent_pieces(
    topology: Topology, parameters: Parameters, e: Float[Array, "n_e"], ed: Float[Array, "n_e"]
) -> tuple[list[tuple[Array, Array]], list[tuple[Array, Array, Array]], list[tuple[Array, Array, Array]]]:
    """:func:`nonlinear_stress` of each block's elements with its indices, and its derivatives by e and by ed.

    Arguments as for :func:`nonlinear_stress`.
    """
    stress, tangents = [], ([], [])
    for block, function, counts, arguments in _nonlinear_stress(topology, parameters):

        def twice(*arguments: Any, function: Callable[..., Any] = function):
            found = function(*arguments)
            return found, found

        derivative = jax.vmap(jax.jacfwd(twice, argnums=counts, has_aux=True))
        found, sigma = derivative(e[block.e], ed[block.e], *arguments)
        stress.append((block.e, sigma))
        for pieces, matrices in zip(tangents, found, strict=False):
            pieces.append((block.e, block.e, matrices))
    return stress, *tangents


@traced_once
def nonlinear_tangents(
    topology: Topology, parameters: Parameters, e: Float[Array, "n_e"], ed: Float[Array, "n_e"]
) -> tuple[Float[Array, "n_e"], Float[Array, "n_e n_e"], Float[Array, "n_e n_e"] | None]:
    """:func:`nonlinear_stress` with its derivatives by its arguments, the deformations and their rates.

    Source: Derivative of :func:`nonlinear_stress`.

    Returns:
        sigma, (n_e,) [N, N m], and two block diagonal matrices, (n_e, n_e) [N/m, N m/rad; N s/m, N m s/rad], symmetric
        but for laws; None for the last where nothing depends on rates.
    """
    stress, *tangents = nonlinear_tangent_pieces(topology, parameters, e, ed)
    by_e, by_ed = (scatter_matrix((topology.n_e, topology.n_e), pieces) for pieces in tangents)
    return scatter_vector(topology.n_e, stress), by_e, by_ed if depends_on_rates(topology) else None


@traced_once
def nonlinear_energy(topology: Topology, parameters: Parameters, e: Float[Array, "n_e"]) -> Float[Array, ""]:
    """Elastic energy of the elements that state one. Returns () [J]. Source: Each element's energy companion."""
    total = jnp.array(0.0)
    for block, energy, *arguments in each_block(topology, parameters, "energy"):
        total = total + jnp.sum(jax.vmap(lambda e, *rest, energy=energy: energy((e,), *rest))(e[block.e], *arguments))
    return total


@traced_once
def thermal_deformations(
    topology: Topology, parameters: Parameters, temperature: Float[Array, "n_e _t"]
) -> Float[Array, "n_e"]:
    """Deformations that a change of temperature gives to free elements; those that are FIXED are held there.

    Returns (n_e,) [m, rad], linear in the temperature. Source: Each element's thermal companion; THEORY.md 2, eq.
    (2.31) to (2.33).

    Args:
        temperature: As :class:`flexmb.model.parameters.Loads` has it, (n_e, 3 or 4) [K, K/m].
    """
    pieces = []
    for block, function, *arguments in each_block(topology, parameters, "thermal"):
        own = temperature[block.e[:, 0]]
        change = (own[:, :2], own[:, 2:])[: len(heat_sizes(block.element))]
        pieces.append((block.e, jax.vmap(function)(change, *arguments)))
    return scatter_vector(topology.n_e, pieces)


def free_deformations(topology: Topology, parameters: Parameters, loads: Loads) -> Float[Array, "n_e"] | None:
    """Deformations at which the elements are free of stress: initial strains, and those of temperature.

    Returns (n_e,) [m, rad], or None: zero.
    """
    if loads.temperature is None:
        return parameters.strain
    warm = thermal_deformations(topology, parameters, loads.temperature)
    return warm if parameters.strain is None else warm + parameters.strain


def strain_of(topology: Topology, parameters: Parameters, loads: Loads, e: Float[Array, "n_e"]) -> Float[Array, "n_e"]:
    """Deformations less those at which the elements are free of stress."""
    free = free_deformations(topology, parameters, loads)
    return e if free is None else e - free


def stress_of_loads(
    topology: Topology, parameters: Parameters, loads: Loads, stiffness: Float[Array, "n_e n_e"]
) -> Float[Array, "n_e"] | None:
    """Stress resultants that loads add where no deformation changes: prestress, less what temperature relieves.

    Returns (n_e,) [N, N m], or None: zero. Source: Derivative of THEORY.md 5, eq. (5.4) by the loads.

    Args:
        stiffness: S, the tangent of what is not linear included, (n_e, n_e) [N/m, N m/rad].
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
    """Stress resultants of the elements, sigma = S (e - free) + nonlinear ones + prestress.

    Returns sigma without that of constant damping, (n_e,) [N, N m]. Source: THEORY.md 5, eq. (5.4).

    Args:
        ed: Their rates, (n_e,) [m/s, rad/s], for nonlinear elements; None: at rest.
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
    """Derivatives of the stress resultants by the deformations and by their rates.

    Returns S and S_d with the share of nonlinear elements; S_d is None where nothing depends on rates. Source:
    Derivative of :func:`stress_resultants`.
    """
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
    """At rest, :func:`stress_resultants` and their derivatives by the deformations, in one.

    Returns sigma, (n_e,) [N, N m], and S with the share of nonlinear elements, (n_e, n_e) [N/m, N m/rad]. Source:
    THEORY.md 5, eq. (5.4).
    """
    strain = strain_of(topology, parameters, loads, e)
    sigma = stiffness @ strain
    if is_nonlinear(topology):
        nonlinear, by_e, _ = nonlinear_tangents(topology, parameters, strain, jnp.zeros_like(e))
        sigma, stiffness = sigma + nonlinear, stiffness + by_e
    return _prestressed(sigma, loads), stiffness


def section_resultants(
    topology: Topology,
    parameters: Parameters,
    x: Float[Array, "n_x"],
    sigma: Float[Array, "n_e"],
    felt: Felt,
    places: Float[Array, "places"],
) -> list[Float[Array, "elements places 6"]]:
    """Forces and moments in the cross-sections of the elements, block by block.

    Args:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        sigma: Stress resultants, multipliers of FIXED deformations included, (n_e,) [N, N m].
        felt: Gravity and motion, which act along the elements.
        places: From 0 at the first end of an element to 1 at its last, (places,) [-].

    Returns:
        For each block with the companion ``resultants``, in order, (elements, places, 6) [N, N m].

    Source:
        Each element's resultants companion.
    """
    found = []
    inertias = {id(block): rest for block, *rest in each_block(topology, parameters, "inertia")}
    for block, function, ref, properties in each_block(topology, parameters, "resultants"):
        extra: dict[str, Any] = {"sigma": sigma[block.e]}
        if block.element.feels_fall:
            acts = id(block) in inertias
            extra["fall"] = fall(topology, felt, x, block, *inertias[id(block)]) if acts else None

        def one(
            x: Float[Array, "c"],
            ref: Float[Array, "c"],
            own: Any,
            extra: dict[str, Any],
            place: Float[Array, ""],
            function: Callable[..., Any] = function,
        ):
            return function(x, ref, own, place=place, **extra)

        everywhere = jax.vmap(jax.vmap(one, (None, None, None, None, 0)), (0, 0, 0, 0, None))
        found.append(everywhere(x[block.x], ref, properties, extra, places))
    return found
