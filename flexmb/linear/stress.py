"""Section resultants and stress on the surface of flexible elements, at a static equilibrium."""

import functools
import itertools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..arguments import check_whole, is_concrete
from ..compilation.compile import jit, unguarded
from ..compilation.record import Record, static
from ..display import Column, Labelled, Quantities, Summary, counted, kind_of, listed, span
from ..elements import spatial
from ..elements.curves import curve_length
from ..elements.section import Section
from ..elements.sections import Rectangle
from ..elements.surface import POINTS, squared, von_mises
from ..errors import BeamTheoryWarning, ModelError, warn
from ..mechanics.blocks import companion_of
from ..mechanics.loads import warn_of_increment
from ..mechanics.stress_resultants import block_resultants as resultants_of_blocks
from ..model.model import Labels, Model, as_determined, as_model
from ..model.topology import Block, Parameters, Topology
from ..numerical_limits import BESIDE_BREAK
from ..results import outcome_text
from ..statics.equilibrium import Equilibrium, equilibrium
from ..statics.solver_choice import by_sparse
from .about import Where, check_state
from .linearize import Linearization, ManyStates, Stressed

# Places along each element; moments of cubic beams are linear, with strain series they wave.
PLACES, PLACES_OF_SERIES = 5, 33
# Parts of a section that varies; each of many smooth pieces has fewer.
PARTS = 64
# Share of the stress of a torque in the largest stress from which missing stress of warping is a warning.
SHARE_OF_TORQUE = 0.1
# Part of a warning, by which others find it.
WITHOUT_WARPING = "Its stress leaves out the normal stress of restrained warping"
RESULTANTS = ("normal force", "shear force y", "shear force z", "torque", "bending moment y", "bending moment z")


class SectionResultants(Labelled, Record):
    """Force and moment in the cross-sections of every flexible element with a section.

    At each place, the part of the element towards end q acts on the part towards end p, in axes of the section. A
    positive normal force is tension. Positive moments turn about the positive axes.

    Attributes:
        values: Normal force, shear forces along y and z [N], torque, bending moments about y and z [N m], in this
            order, (elements, places, 6). A planar element has local z across it in the plane and local y into the
            plane.
        places: Places from 0 at an element's first end to 1 at its last, (places,) [-].
        result: Code of RESULTS.
        names: Names of the elements, in the order of the model.
    """

    values: Float[Array, "elements places 6"]
    places: Float[Array, "places"]
    result: Int[Array, ""]
    names: tuple[str, ...] = static()
    one_axis = "places"

    def quantities(self) -> dict[str, tuple[np.ndarray, str]]:
        """Return each force and moment, (elements, places), with its unit."""
        values = np.asarray(self.values)
        return {name: (values[..., i], "N" if i < 3 else "N m") for i, name in enumerate(RESULTANTS)}

    def quantities_by_name(self) -> Quantities:
        """Return each force and moment by element and place, and by the number of the state if there are several."""
        return _by_place(self.quantities(), self.names, self.places)

    def summary(self) -> Summary:
        """Return the outcome, and the extremes of each force and moment."""
        rows = {"result": outcome_text(self.result), **_extremes(self.quantities(), self.names, self.places)}
        return Summary(f"SectionResultants of {counted(len(self.names), 'element')} at {len(self.places)} places", rows)


def _by_place(values_by_name: dict[str, tuple[np.ndarray, str]], names: tuple[str, ...], places: Any) -> Quantities:
    """Quantities along elements, with the names of their axes."""
    states = max(values.ndim for values, _ in values_by_name.values()) - 2
    over = (*("step",) * states, "element", "place")
    axes = {"element": Column(("element",), np.array(names)), "place": Column(("place",), places, "-")}
    return Quantities(over, axes, {name: Column(over, values, unit) for name, (values, unit) in values_by_name.items()})


def _extremes(
    quantities: dict[str, tuple[np.ndarray, str]],
    names: tuple[str, ...],
    places: Float[Array, "places"],
    at_points: dict[str, np.ndarray] | None = None,
) -> dict[str, str]:
    """Range of each quantity, of ``at_points`` where given, and where it is largest."""
    rows = {}
    for name, (values, unit) in quantities.items():
        *state, element, place = np.unravel_index(np.argmax(np.abs(values)), values.shape)
        where = f", largest in '{names[element]}' at {float(places[place]):g}" if np.any(values) else ""
        where += f" of state {state[0]}" if where and state else ""
        rows[name] = span((at_points or {}).get(name, values), unit.strip("-")) + where
    return rows


class Location(NamedTuple):
    """A place in the model.

    Attributes:
        element: Name of the element.
        place: From 0 at its first end to 1 at its last, [-].
        point: Number of the point of the section, from 0, in the order of the section's ``stress``.
        state: Number of the state of a path or a motion, from 0; None for one state.
    """

    element: str
    place: float
    point: int
    state: int | None = None


class Stress(Labelled, Record):
    """Stress at points on the surface of every flexible element with a section.

    For a path or a motion, states are the first axis of all arrays except ``strength`` and ``fatigue``. ``maximum``
    contains the largest stress of each state, and ``where`` is the place in the worst state.

    Attributes:
        sigma_x: Stress along the element, (elements, places, 8) [Pa], at the points of the section's ``stress``:
            corners and middles of a rectangle, extremes of bending and shear of a circle.
        tau: Shear stress along the surface, counter-clockwise about x, (elements, places, 8) [Pa].
        von_mises: Equivalent stress, sqrt(sigma_x^2 - sigma_x across + across^2 + 3 tau^2), (elements, places, 8) [Pa].
        resultants: Force and moment in the sections.
        strength: Strength of the material, (elements, places) [Pa]; infinite for a material without a strength, None if
            no material has a strength.
        fatigue: Fatigue limit of the material, in the same form [Pa].
        across: Normal stress transverse to the element, in its surface, as in leaf springs near clamps, (elements,
            places, 8) [Pa]; None if no element has such a stress.
        left_out: Names of the flexible elements without stress, whose section is given by its rigidities.
    """

    sigma_x: Float[Array, "elements places 8"]
    tau: Float[Array, "elements places 8"]
    von_mises: Float[Array, "elements places 8"]
    resultants: SectionResultants
    strength: Float[Array, "elements places"] | None = None
    fatigue: Float[Array, "elements places"] | None = None
    across: Float[Array, "elements places 8"] | None = None
    left_out: tuple[str, ...] = static(default=())
    one_axis = "resultants.places"

    def quantities(self) -> dict[str, tuple[np.ndarray, str]]:
        """Return each stress (largest point of the section, with sign) and each force, (elements, places).

        The stress across an element is included if any element has it. "utilisation", the largest von Mises stress over
        the strength, is included if a material states its strength.
        """
        largest = {}
        for name, at_points in self._at_points().items():
            point = np.argmax(np.abs(at_points), axis=-1)[..., None]
            largest[name] = (np.take_along_axis(at_points, point, axis=-1)[..., 0], "Pa")
        if self.strength is not None:
            largest["utilisation"] = (np.asarray(self._over("strength")), "-")
        return {**largest, **self.resultants.quantities()}

    def _at_points(self) -> dict[str, np.ndarray]:
        parts = {"von Mises": self.von_mises, "sigma_x": self.sigma_x, "tau": self.tau, "across": self.across}
        return {name: np.asarray(values) for name, values in parts.items() if values is not None}

    def quantities_by_name(self) -> Quantities:
        """Return the same as :meth:`quantities` by element and place; of several states by their numbers too."""
        return _by_place(self.quantities(), self.names, self.places)

    def summary(self) -> Summary:
        """Return the outcome, and the extremes of the stresses."""
        stresses = {name: (values, unit) for name, (values, unit) in self.quantities().items() if unit in ("Pa", "-")}
        extremes = _extremes(stresses, self.names, self.places, self._at_points())
        rows = {"result": outcome_text(self.resultants.result), **extremes}
        if self.strength is not None:
            unknown = np.all(np.isinf(np.asarray(self.strength)), axis=1)
            if np.any(unknown):
                rows["without strength"] = listed(list(itertools.compress(self.names, unknown)))
        if self.left_out:
            rows["without stress"] = listed(self.left_out)
        *states, count, places, points = self.von_mises.shape
        many = f" in {states[0]} states" if states else ""
        return Summary(f"Stress of {counted(count, 'element')} at {places} places, {points} points each{many}", rows)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the elements, in the order of the model."""
        return self.resultants.names

    @property
    def places(self) -> Float[Array, "places"]:
        """Places from 0 at an element's first end to 1 at its last, (places,) [-]."""
        return self.resultants.places

    @property
    def by_element(self) -> Float[Array, "elements"]:
        """Largest von Mises stress of each element, (elements,) [Pa]."""
        return jnp.max(self.von_mises, axis=(-2, -1))

    @property
    def maximum(self) -> Float[Array, ""]:
        """Largest von Mises stress, () or (states,) [Pa]. The derivative jumps if its place jumps."""
        return jnp.max(self.von_mises, axis=(-3, -2, -1))

    @property
    def where(self) -> Location:
        """Place of the largest von Mises stress, the first of equal ones; TypeError for traced stress."""
        if isinstance(self.von_mises, jax.core.Tracer):
            raise TypeError("where needs concrete numbers. Use it outside jax.jit and jax.grad.")
        values = np.asarray(self.von_mises)
        *state, element, place, point = np.unravel_index(np.argmax(values), values.shape)
        return Location(self.names[element], float(self.places[place]), int(point), int(state[0]) if state else None)

    @property
    def utilisation(self) -> Float[Array, "elements"]:
        """Largest von Mises stress of each element over the strength of its material, (elements,) [-].

        Above one the element yields or breaks. Zero for a material without a strength; ModelError if no material has a
        strength.
        """
        return jnp.max(self._over("strength"), axis=-1)

    @property
    def fatigue_utilisation(self) -> Float[Array, "elements"]:
        """Largest von Mises stress of each element over the fatigue limit of its material, (elements,) [-].

        The value assumes a motion between this state and a state with the opposite stress.
        """
        return jnp.max(self._over("fatigue"), axis=-1)

    def _limit(self, quantity: str) -> Float[Array, "elements places"]:
        limit = getattr(self, quantity)
        if limit is None:
            raise ModelError(
                f"No material of the elements states its {quantity}. Give {quantity}=.. to Material, or use one of"
                " fm.materials that has it."
            )
        return limit

    def _over(self, quantity: str) -> Float[Array, "elements places"]:
        return jnp.max(self.von_mises, axis=-1) / self._limit(quantity)

    def smooth_utilisation(self, sharpness: float = 50.0) -> Float[Array, ""]:
        """Return an upper estimate of the largest :attr:`utilisation`, () [-], whose derivative has no jumps.

        Args:
            sharpness: As for :meth:`smooth_maximum`, () [-].

        Source:
            As :meth:`smooth_maximum`.
        """
        return self._smooth(sharpness, self._limit("strength")[:, :, None])

    def smooth_maximum(self, sharpness: float = 50.0) -> Float[Array, ""]:
        """Return an upper estimate of the largest von Mises stress, with a derivative without jumps.

        (sum of v^p)^(1/p) is between the maximum and n^(1/p) times the maximum, for n values. For 1000 values it is at
        most 15 % too large with p = 50, and 3.5 % with p = 200. It scales with the stress.

        Args:
            sharpness: p, at least 2, () [-]. A larger p is nearer to the maximum and less smooth.

        Returns:
            () [Pa].

        Source:
            Norms of order p and infinity of a vector.
        """
        return self._smooth(sharpness, 1.0)

    def _smooth(self, sharpness: float, limit: Float[Array, "elements places 1"] | float) -> Float[Array, ""]:
        """Norm of high order of the von Mises stress over a limit."""
        if not isinstance(sharpness, jax.core.Tracer) and not sharpness >= 2:
            raise ValueError(f"Argument `sharpness` must be at least 2, but is {sharpness}.")
        square = squared(self.sigma_x, self.tau, 0.0 if self.across is None else self.across) / limit**2
        # Scaled by the largest, so that no power overflows; the value does not depend on the scale.
        axes = (-3, -2, -1)
        largest = jax.lax.stop_gradient(jnp.max(square, axis=axes))
        largest = jnp.where(largest <= 0, 1.0, largest)
        powers = (square / largest[..., None, None, None]) ** (sharpness / 2)
        # A repeated place, as may occur under a trace, counts once.
        anew = jnp.diff(self.places, prepend=-1.0) > 0
        total = jnp.sum(jnp.where(anew[:, None], powers, 0.0), axis=axes)
        none = total <= 0
        return jnp.where(none, 0.0, jnp.sqrt(largest) * jnp.where(none, 1.0, total) ** (1 / sharpness))


def _rows(labels: Labels) -> tuple[tuple[str, ...], np.ndarray]:
    """Names of the stressed elements in the order of the model, and their rows among the elements of all blocks."""
    blocks = [names for names in labels.stressed if any(names)]
    rows = {name: row for row, name in enumerate(name for names in blocks for name in names)}
    names = tuple(name for name, *_ in labels.elements if name in rows)
    return names, np.array([rows[name] for name in names], int)


def _stacks(properties: dict[str, Any]) -> list[tuple[slice, Section]]:
    """Stacks of sections of one kind, and the slices of a block's elements they belong to."""
    section, stacks, start = properties["section"], [], 0
    for stack in section if isinstance(section, tuple) else (section,):
        part = slice(start, start + jax.tree.leaves(stack)[0].shape[0])
        stacks.append((part, stack))
        start = part.stop
    return stacks


def _lengths(block: Block, properties: dict[str, Any], reference: Float[Array, "n_x"]) -> Float[Array, "elements"]:
    """Undeformed lengths [m]."""
    parts = jnp.split(reference[block.x], block.splits, axis=1)
    kinds = block.element.nodes.values()
    ends = [part for kind, part in zip(kinds, parts, strict=True) if kind.part == "position"]
    chords = jnp.linalg.norm(ends[-1] - ends[0], axis=1)
    if (curvature := properties.get("curvature")) is None:
        return chords
    return jax.vmap(curve_length)(chords, curvature)


def has_stress(model: Model) -> bool:
    """Whether the section of some flexible element has a shape and so a stress."""
    return len(_rows(model.labels)[0]) > len(without_shape(model))


def left_out_of_stress(model: Model) -> list[str]:
    """:func:`without_shape`, with a warning, or with an error if no element has a stress."""
    left_out = without_shape(model)
    if left_out:
        text = (
            f"The section of element {listed([repr(name) for name in left_out])} is given by its rigidities, without a"
            " shape, and has no stress. Give its `outline`, or a section such as Rectangle, or use section_resultants;"
            " beside a hole, use solid elements."
        )
        if not has_stress(model):
            raise ModelError(text)
        warn(f"{text} It is left out of the stress.")
    return left_out


def without_shape(model: Model) -> list[str]:
    """Names of the flexible elements without stress, whose section is given by its rigidities."""
    shapeless = []
    for names, properties in zip(model.labels.stressed, model.parameters.properties, strict=True):
        if any(names):
            kinds = [stack.has_shape for part, stack in _stacks(properties) for _ in range(part.start, part.stop)]
            shapeless += [name for name, shaped in zip(names, kinds, strict=True) if name is not None and not shaped]
    return shapeless


class _Asked(NamedTuple):
    """Numbers for section resultants and stress, of one state or of several in front."""

    topology: Topology
    parameters: Parameters
    states: Stressed
    places: Float[Array, "places"]
    rows: Any

    def resultants(self, state: Stressed) -> list[Float[Array, "elements places 6"]]:
        """Section resultants of each block's elements, in one state."""
        return resultants_of_blocks(self.topology, self.parameters, state.x, state.sigma, state.felt, self.places)

    def blocks(self) -> list[tuple[Block, dict[str, Any], Float[Array, "elements"]]]:
        """Blocks with sections, their properties and the lengths of their elements."""
        blocks = zip(self.topology.blocks, self.parameters.properties, strict=True)
        reference = self.parameters.reference
        return [(b, p, _lengths(b, p, reference)) for b, p in blocks if "resultants" in b.companions]


@jit
def _resultants(asked: _Asked, *, several: bool):
    def in_state(state: Stressed):
        return jnp.concatenate(asked.resultants(state))[asked.rows]

    return (jax.vmap(in_state) if several else in_state)(asked.states)


@jit
def _stress(asked: _Asked, *, several: bool):
    """Resultants, stresses along, in shear, equivalent and across, and limits of materials by quantity."""
    (stresses, across) = (jax.vmap(_stress_in, (None, 0)) if several else _stress_in)(asked, asked.states)
    return *stresses, {**_borne(asked), "across": across}


def _stress_in(asked: _Asked, state: Stressed):
    """Resultants and stresses in one state; the last is None without stress across."""
    resultants = asked.resultants(state)
    strain = state.e if asked.parameters.strain is None else state.e - asked.parameters.strain
    block_stresses = []
    for values, (block, properties, lengths) in zip(resultants, asked.blocks(), strict=True):
        for part, stack in _stacks(properties):
            values_of_stack, length = values[part], lengths[part]
            if "surface" in block.companions:
                alike = {n: jax.tree.map(lambda p, at=part: p[at], v) for n, v in properties.items() if n != "section"}
                function, alike = companion_of(block, {**alike, "section": stack}, "surface")
                e, ref = strain[block.e][part], asked.parameters.reference[block.x][part]
                at_places = jax.vmap(functools.partial(_by_companion, function), (None, None, None, 0, 0))
                at_elements = jax.vmap(at_places, (0, 0, 0, None, 0))
                block_stresses.append(at_elements(e, ref, alike, asked.places, values_of_stack))
            elif stack.has_shape:
                at_places = jax.vmap(lambda s, length, place, r: s.at(place, length).stress(r), (None, None, 0, 0))
                at_elements = jax.vmap(at_places, (0, 0, None, 0))
                block_stresses.append(at_elements(stack, length, asked.places, values_of_stack))
            else:
                # Rigid elements in a block with flexible ones have no stress; ``rows`` leaves these zeros out.
                block_stresses.append((jnp.zeros((*values_of_stack.shape[:2], POINTS)),) * 2)
    sigma_x, tau = (jnp.concatenate([piece[i] for piece in block_stresses])[asked.rows] for i in range(2))
    across = None
    if any(len(piece) > 2 for piece in block_stresses):
        parts = [piece[2] if len(piece) > 2 else jnp.zeros_like(piece[0]) for piece in block_stresses]
        across = jnp.concatenate(parts)[asked.rows]
    equivalent = von_mises(sigma_x, tau, 0.0 if across is None else across)
    return (jnp.concatenate(resultants)[asked.rows], sigma_x, tau, equivalent), across


def _borne(asked: _Asked) -> dict[str, Float[Array, "k places"]]:
    """Limits of materials by quantity, infinite for materials without; only quantities that any states."""
    limits = {}
    stacks = [(stack, lengths[part]) for _, p, lengths in asked.blocks() for part, stack in _stacks(p)]

    for quantity in ("strength", "fatigue"):

        def at(section: Section, length: Float[Array, ""], place: Float[Array, ""], name: str = quantity):
            return jnp.asarray(section.at(place, length).stated(name), float)

        if any(stack.states(quantity) for stack, _ in stacks):
            every = [
                jax.vmap(jax.vmap(at, (None, None, 0)), (0, 0, None))(stack, length, asked.places)
                if stack.states(quantity)
                else jnp.full((length.shape[0], asked.places.shape[0]), jnp.inf)
                for stack, length in stacks
            ]
            limits[quantity] = jnp.concatenate(every)[asked.rows]
    return limits


def _by_companion(function: Callable[..., Any], e: Any, ref: Any, properties: dict[str, Any], place: Any, force: Any):
    """Stress by an element's own companion at a place, from the section resultants there."""
    return function((e,), ref, properties, place=place, resultants=force)


@jit
def _breaks(
    block: Block, properties: dict[str, Any], reference: Float[Array, "n_x"], stack: Any, *, first: int, after: int
) -> list[Float[Array, "n"]]:
    """Breaks of sections of one kind, of the first to the last of a block's elements."""
    lengths = _lengths(block, properties, reference)[first:after]
    return list(jax.vmap(lambda section, length: section.breaks_at(length))(stack, lengths))


def _places(model: Model, points: int | None) -> Any:
    """Ascending places along each element: even ones, both sides of breaks of sections, and within pieces."""
    parameters = model.parameters
    breaks, enough, varies = [], PLACES, False
    for block, properties in zip(model.topology.blocks, parameters.properties, strict=True):
        if "resultants" not in block.companions:
            continue
        enough = max(enough, PLACES_OF_SERIES if block.element.series else 0)
        for part, stack in _stacks(properties):
            varies = varies or stack.varies
            if stack.varies:
                breaks += _breaks(block, properties, parameters.reference, stack, first=part.start, after=part.stop)
    even = np.linspace(0.0, 1.0, points or enough)
    if not varies or (points and not breaks):
        return even
    library: Any = np if is_concrete(breaks) else jnp
    # Known breaks of several elements count once.
    breaks = [np.unique(np.concatenate(breaks))] if breaks and library is np else breaks
    edges = library.sort(library.concatenate([np.array([0.0, 1.0]), *breaks]))
    parts = 2 if points else max(2, int(PARTS / np.sqrt(len(edges) - 1)))
    within = edges[:-1, None] + (edges[1:] - edges[:-1])[:, None] * (np.arange(1, parts) / parts)
    sides = [edges[1:-1] - BESIDE_BREAK, edges[1:-1] + BESIDE_BREAK, library.ravel(within)]
    ends = even if points else np.array([0.0, 1.0])
    return library.sort(library.clip(library.concatenate([ends, *sides]), 0.0, 1.0))


def _state(
    model: Model, function: str, points: Any, where: Where, left_out: Sequence[str] = (), **equilibrium_options: Any
):
    """Names of the elements, arguments of both kernels, code of the state, and whether there are several states."""
    as_model(model, function)
    at: Any = where.at
    sparse = equilibrium_options["sparse"]
    if sparse is not None and at is not None:
        raise ValueError(f"Argument `sparse` of fm.{function} contradicts at=, a known state.")
    factor = equilibrium_options["load_factor"]
    if at is not None and not (is_concrete(factor) and np.ndim(factor) == 0 and factor == 1):
        raise ValueError(
            f"Argument `load_factor` of fm.{function} contradicts at=, which has its loads. Give"
            " at=fm.equilibrium(model, load_factor=..), or leave `at` out."
        )
    sparse = at is None and by_sparse(model, sparse)
    if at is None and not sparse:
        as_determined(model, function)
    points = None if points is None else check_whole("points", points, 2)
    names, rows = _rows(model.labels)
    if not names:
        raise ModelError("No flexible element has a section. Give one to the beams or trusses in question.")
    included = [name not in left_out for name in names]
    names, rows = tuple(itertools.compress(names, included)), rows[included]
    where.refuse(function)
    several = isinstance(where.at, ManyStates) and where.step is None and where.time is None
    if at is None:
        if where.increment is None:
            warn_of_increment(model, function)
        increment = 0.0 if where.increment is None else where.increment
        options: Any = equilibrium_options | {"sparse": sparse}
        at = equilibrium(model, increment=increment, **options)
    elif isinstance(where.at, ManyStates) and not several:
        at = where.state(model, function)
    if getattr(at, "x", None) is None:
        raise TypeError(
            "Argument `at` must be an Equilibrium, a Linearization, a Path or a Motion of this model, not"
            f" {kind_of(at)}."
        )
    if at.x.shape[int(several) :] != model.parameters.reference.shape:
        raise ValueError(
            f"Argument `at` must be a state of this model with {model.topology.n_x} coordinates, but x has shape"
            f" {at.x.shape}. For a linearisation along a motion give lin.at_time(number), or the motion itself."
        )
    check_state(at, model, function)
    states = at.stressed() if several else Stressed(at.x, at.sigma, at.felt, at.e)
    return names, _Asked(model.topology, model.parameters, states, _places(model, points), rows), at.result, several


def section_resultants(
    model: Model,
    *,
    points: int | None = None,
    at: Equilibrium | Linearization | ManyStates | None = None,
    step: int | None = None,
    time: float | None = None,
    load_factor: float = 1.0,
    increment: float | None = None,
    sparse: bool | None = None,
    throw: bool = True,
) -> SectionResultants:
    """Return normal and shear forces, torque and bending moments along every flexible element with a section.

    They are in equilibrium with the forces at the ends of the element: exactly at all places of a spectral beam. Along
    a cubic beam they are linear, plus the effect of the weight along its straight chord. The inertia of a moving beam
    acts like a weight; its rotary inertia acts on its ends. A truss has a normal force only: half of each transverse
    load acts on each end.

    Args:
        model: Mechanism; differentiable in ``model.parameters``.
        points: Number of places along each element, both ends included; by default 5, or 33 with strain series. For a
            section that jumps, flexmb adds both sides of each jump and the middle of each of the n segments. Without
            ``points`` it divides each segment into 64/sqrt(n) parts.
        at: Equilibrium or linearisation of this model, or its path or motion. For a path or a motion, all of its states
            are the first axis of the arrays, unless ``step`` or ``time`` selects one. Default: the equilibrium under
            the loads.
        step, time: Number or time [s] of one state of a path or a motion, as for :func:`flexmb.frequencies`.
        load_factor: Factor of the loads of the equilibrium, () [-].
        increment: Factor of the incremental loads of the equilibrium, () [-]; zero by default.
        sparse: Whether to solve the equilibrium by sparse matrices; see :func:`flexmb.equilibrium`. By default the size
            of the model decides.
        throw: Raise if the equilibrium fails; otherwise the code is in ``result``.

    Returns:
        SectionResultants with values (elements, places, 6) [N, N m].

    Raises:
        ModelError: No flexible element has a section.
        ValueError: There are fewer than two points; ``at`` is no state of this model; or arguments exclude each other.
        AnalysisError: As for ``equilibrium``.

    Source:
        Balance of an element's end with D_x^T sigma, the nodal forces of its stress resultants; THEORY.md 7.
    """
    where = Where(at, step, time, increment)
    options: Any = dict(load_factor=load_factor, sparse=sparse, throw=throw)
    names, asked, result, several = _state(model, "section_resultants", points, where, **options)
    return SectionResultants(_resultants(asked, several=several), jax.device_put(asked.places), result, names)


@unguarded
def stress(
    model: Model,
    *,
    points: int | None = None,
    at: Equilibrium | Linearization | ManyStates | None = None,
    step: int | None = None,
    time: float | None = None,
    load_factor: float = 1.0,
    increment: float | None = None,
    sparse: bool | None = None,
    throw: bool = True,
) -> Stress:
    """Return the stress on the surface of every flexible element with a section.

    An element whose section is given by its rigidities has no stress. flexmb leaves it out and warns.

    Args:
        model: Mechanism; differentiable in ``model.parameters``.
        points, at, step, time, load_factor, increment, sparse, throw: As for :func:`section_resultants`; ``at=path``
            and ``at=motion`` return all their states.

    Returns:
        Stress with sigma_x, tau and von_mises (elements, places, 8) [Pa], and utilisation of the strength of materials,
        (elements,) [-].

    Warns:
        FlexmbWarning: The stress is above the strength of a material; elements are left out.
        BeamTheoryWarning: A torque acts on a ``spatial.warping_beam``, or on a section with ``warping_length``, whose
            normal stress by restrained warping is left out.

    Raises:
        ModelError: No element has a section with a shape.
        ValueError: There are fewer than two points; ``at`` is no state of this model; or arguments exclude each other.
        AnalysisError: As for ``equilibrium``.

    Source:
        :func:`section_resultants`, and :mod:`flexmb.elements.surface` for the stress of each section.
    """
    left_out = left_out_of_stress(as_model(model, "stress"))
    where = Where(at, step, time, increment)
    options: Any = dict(load_factor=load_factor, sparse=sparse, throw=throw)
    names, asked, result, several = _state(model, "stress", points, where, left_out, **options)
    values, sigma_x, tau, equivalent, more = _stress(asked, several=several)
    resultants = SectionResultants(values, jax.device_put(asked.places), result, names)
    stresses = Stress(sigma_x, tau, equivalent, resultants, **more, left_out=tuple(left_out))
    if is_concrete((stresses, model.parameters.properties)):
        _warn_of_warping(model, stresses)
        if stresses.strength is not None:
            _warn_of_failure(stresses)
    return stresses


def _warn_of_warping(model: Model, stresses: Stress) -> None:
    """Warn of torsion whose normal stress by restrained warping the sections leave out.

    At a clamp it exceeds the shear stress: E' t k w/(4 l) for the twist rate k, with l of (2.24).
    """
    shape = stresses.von_mises.shape[-3:-1]
    largest = np.max(np.asarray(stresses.by_element).reshape(-1, shape[0]), axis=0)
    torques = np.max(np.abs(np.asarray(stresses.resultants.values)[..., 3]).reshape(-1, *shape), axis=(0, 2))
    torque_of = dict(zip(stresses.names, zip(torques, largest, strict=True), strict=True))
    twisted = []
    pairs = zip(model.topology.blocks, model.labels.stressed, model.parameters.properties, strict=True)
    for block, names, properties in pairs:
        for part, stack in _stacks(properties) if any(names) else ():
            if not isinstance(stack, Rectangle) or "surface" in block.companions:
                continue
            clamped = np.full(part.stop - part.start, stack.warping_length is not None and stack.clamped_ends > 0)
            if block.element.usual == spatial.warping_beam:
                clamped = np.any(np.asarray(properties["clamped"])[part] > 0, axis=1)
            sides = np.sort([np.asarray(stack.width), np.asarray(stack.thickness)], axis=0)
            for name, is_clamped, thin, wide in zip(names[part], clamped, *sides, strict=True):
                torque, most = torque_of.get(str(name), (0.0, 0.0))
                if is_clamped and np.sqrt(3) * 3 * torque / (wide * thin**2) > SHARE_OF_TORQUE * most:
                    twisted.append(repr(name))
    if twisted:
        warn(
            f"A torque acts on element {listed(twisted)}. {WITHOUT_WARPING}, which exceeds its shear stress near"
            " clamped ends. A spatial.leaf_spring counts both.",
            BeamTheoryWarning,
        )


def _warn_of_failure(stresses: Stress) -> None:
    """Warn of elements whose stress exceeds the strength of their material."""
    used = np.max(np.asarray(stresses.utilisation).reshape(-1, len(stresses.names)), axis=0)
    failing = [name for name, utilisation in zip(stresses.names, used, strict=True) if utilisation > 1]
    if failing:
        worst = int(np.nanargmax(used))
        warn(
            f"The stress is above the strength of the material in {listed([repr(name) for name in failing])}: by a"
            f" factor of {used[worst]:.4g} in '{stresses.names[worst]}'."
        )
