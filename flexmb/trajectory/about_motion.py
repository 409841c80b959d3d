"""The motion about which vibrations are described: its inputs, outputs and degrees of freedom."""

import dataclasses
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import as_floats, computed, is_concrete
from ..compilation.compile import jit, jit_beside_options
from ..display import listed, short
from ..errors import AnalysisError, ModelError, warn
from ..mechanics.deformation import deformation_jacobian
from ..mechanics.signals import DEFORMATION_ORDERS, ORDERS, combined, terms_of
from ..model.model import Model
from ..model.topology import Parameters, Topology, coordinate_scales, extent_of
from ..motion.coordinates_form import coordinates_form
from ..motion.drive import Driven, Table
from ..motion.element_forces import deformations_and_slopes
from ..motion.full_turns import warn_of_full_turns
from ..motion.loop import controlled_form, under_inputs
from ..motion.motion import Motion
from ..results import RESULTS

# Quantities that measure the motion that an input prescribes, for coordinates (False) and deformations (True).
MEASURES = {False: tuple(ORDERS), True: tuple(DEFORMATION_ORDERS)}
# A warning names an input whose parts drift apart by this share of their way, and by this share of the largest way or
# speed in the mechanism.
APART, ROUND_OFF = 1e-6, 1e-9


class About(NamedTuple):
    """A motion about which vibrations are described.

    Attributes:
        motion: The motion.
        u0: Its inputs [N, N m; m, rad, and their rates, of held things that move].
        held: Force that holds each degree of freedom along it and is released [N, N m].
    """

    motion: Motion
    u0: Float[Array, "n_t n_u"]
    held: Float[Array, "n_t n_q"]


def about(given: Any, function: str) -> About:
    """A simulated motion, along which nothing is held, or the motion of inverse dynamics.

    Raises:
        TypeError: The argument is neither.
        ModelError: The motion did not reach its end, or has only one time.
    """
    motion = getattr(given, "motion", given)
    if not isinstance(motion, Motion):
        raise TypeError(
            f"fm.trajectory.{function} takes a Motion from fm.simulate(..) or a Nominal from"
            f" fm.trajectory.inverse_dynamics(..), not {type(given).__name__}."
        )
    if len(motion.t) < 2:
        raise ModelError(f"fm.trajectory.{function} needs a motion with at least two times.")
    if is_concrete(motion.x) and not np.all(np.isfinite(np.asarray(motion.x))):
        raise ModelError(
            f"fm.trajectory.{function} was given a motion that did not reach its end: motion.until(count)."
        )
    count = len(motion.t)
    inputs = len(motion.labels.inputs)
    if motion is not given:
        return About(motion, given.u0, given.f0)
    u0 = motion.u if motion.u.shape[1] else jnp.zeros((count, inputs))
    u0 = u0 + inputs_that_move(motion)
    for excitation in motion.driven:
        if excitation.given is not None:
            input_values = jax.lax.map(excitation.given, motion.t)
            u0 = jnp.asarray(u0).at[:, excitation.of_input].add(jnp.reshape(input_values, (count,)))
    return About(motion, u0, jnp.zeros((count, motion.model.topology.n_q)))


def inputs_that_move(motion: Motion) -> Float[Array, "n_t n_u"]:
    """Inputs that move held things, along the motion itself, (n_t, n_u); zero for forces.

    Displacements count from the undeformed mechanism. If two inputs move the same thing, each has all of its motion.
    """
    model = motion.model
    labels, weights, top = model.labels, model.parameters.weights, model.topology
    terms = terms_of(labels.inputs)
    moving = [i for i, term in enumerate(terms) if term.order is not None]
    if is_concrete((top.x.prescribed, top.e.prescribed)):
        # FIXED things do not move.
        driven = [np.asarray(indices).tolist() for indices in (top.x.prescribed, top.e.prescribed)]
        moving = [i for i in moving if terms[i].index in driven[terms[i].of_element]]
    if not moving:
        return jax.device_put(np.zeros((len(motion.t), len(labels.inputs))))
    moving_terms = [terms[i] for i in moving]
    seen = tuple(dataclasses.replace(t, quantity=MEASURES[t.of_element][t.order or 0]) for t in moving_terms)
    alone = None if weights is None else (weights[0], jnp.ones(len(seen)))
    parameters, labels_seen = model.parameters, dataclasses.replace(labels, outputs=seen)
    measuring_them = dataclasses.replace(
        model, labels=labels_seen, parameters=dataclasses.replace(parameters, weights=alone)
    )
    moved = outputs_of(dataclasses.replace(motion, model=measuring_them))
    every = jnp.asarray(combined(labels.inputs, None if weights is None else weights[0]))
    moves = np.array([term.order is not None for term in terms])
    squares = jnp.sum(jnp.where(moves, every, 0.0) ** 2, axis=1)
    input_motion = moved @ every[:, np.array(moving)].T / jnp.where(squares > 0, squares, 1.0)
    if is_concrete((input_motion, moved, motion.xd)):
        parts = dict(zip(moving, np.asarray(moved).T, strict=True))
        _warn_of_parts(motion, np.asarray(input_motion), np.asarray(every), parts)
    return input_motion


def _warn_of_parts(motion: Motion, input_motion: np.ndarray, every: np.ndarray, moved: dict[int, np.ndarray]) -> None:
    """Warn of an input whose parts do not move together; constant distances are allowed."""
    sizes = extent_of(motion.model.topology, motion.model.parameters), np.max(np.abs(motion.xd), initial=0.0)
    span = float(np.ptp(np.asarray(motion.t))) or 1.0
    floors = (ROUND_OFF * sizes[0], ROUND_OFF * sizes[1], ROUND_OFF * sizes[1] / span)
    first = 0
    for number, signal in enumerate(motion.labels.inputs):
        for place, term in enumerate(signal.terms, first):
            if len(signal.terms) == 1 or term.order is None:
                continue
            part_motion = moved.get(place, np.zeros(len(input_motion)))
            difference = input_motion[:, number] * every[number, place] - part_motion
            difference = difference - difference[0] * (term.order == 0)
            if np.max(np.abs(difference)) > APART * np.max(np.abs(part_motion)) + floors[term.order]:
                warn(
                    f"Input '{signal.name}' moves several coordinates together, but in this motion they move"
                    " differently. Its nominal value is nearest to all of them."
                )
                break
        first += len(signal.terms)


def freedoms_of(motion: Motion) -> tuple[Float[Array, "n_t n_q"], Float[Array, "n_t n_q"]]:
    """Degrees of freedom along a motion, from the undeformed mechanism, and their rates [m, rad; 1/s]."""
    return _freedoms(motion.model.topology, motion.model.parameters, (motion.x, motion.xd, motion.near))


@jit_beside_options
def _freedoms(topology: Topology, parameters: Parameters, rows: tuple[Array, ...]):
    form = coordinates_form(topology, parameters)

    def at_one_time(at: tuple[Array, ...]):
        x, xd, last_strain = at
        e, jacobian = deformations_and_slopes(form.elements, x, last_strain)
        freedoms = jnp.concatenate([(x - parameters.reference)[topology.x.dof], e[topology.e.dof]])
        return freedoms, jnp.concatenate([xd[topology.x.dof], (jacobian @ xd)[topology.e.dof]])

    return jax.lax.map(at_one_time, rows)


def loads_of_freedoms(top: Topology, t: Float[Array, "n_t"], f: Float[Array, "n_t n_q"]) -> tuple[Driven, ...]:
    """Forces along the degrees of freedom over time, as loads that are exact at the times."""
    n = top.x.dof.shape[0]
    parts = ("force", top.x.dof, lambda _, f: f[:, :n]), ("stress", top.e.dof, lambda _, f: -f[:, n:])
    return tuple(Driven(quantity, at, Table(t, computed(part, f))) for quantity, at, part in parts if at.shape[0])


def check_freedoms(motion: Motion) -> None:
    """Refuse a motion along which the degrees of freedom do not determine the configuration.

    A change of sign of a determinant shows such a place between two times. An even number of changes stays unseen. At
    such a place the matrices of vibrations are infinite, and interpolation in time does not show this. Raises
    AnalysisError: singular_configuration, with the first times.
    """
    model, top = motion.model, motion.model.topology
    if not is_concrete((model, motion.x, motion.near)) or top.e.given.shape[0] != top.x.dependent.shape[0]:
        return
    signs = np.asarray(_sides(model.without_names(), motion.x, motion.near))
    if len(passed := np.flatnonzero(signs[1:] * signs[:-1] < 0)):
        first, last = (short(float(motion.t[passed[0] + i])) for i in range(2))
        raise AnalysisError(
            RESULTS.singular_configuration.name,
            f"Between t = {first} and {last} s the degrees of freedom"
            f" ({listed(model.q_labels)}) do not determine the configuration, so they cannot describe vibrations there."
            " Name others, such as the rotation of a hinge instead of a coordinate or Euler parameters.",
        )


@jit
def _sides(model: Model, x: Float[Array, "n_t n_x"], near: Float[Array, "n_t n_e"]) -> Float[Array, "n_t"]:
    """Signs of determinants of the derivatives of given deformations by dependent coordinates, scaled."""
    top, parameters = model.topology, model.parameters
    sizes = coordinate_scales(top, parameters)[top.x.dependent]

    def side(at: tuple[Array, Array]):
        rows = deformation_jacobian(top, parameters, *at)[1][top.e.given][:, top.x.dependent] * sizes
        return jnp.linalg.slogdet(rows / jnp.max(jnp.abs(rows), axis=1, keepdims=True, initial=1e-300))[0]

    return jax.lax.map(side, (x, near))


def outputs_of(motion: Motion) -> Float[Array, "n_t n_y"]:
    """Outputs along a motion as sensors measure them, (n_t, n_y); rotations in space since the undeformed mechanism.

    Warns:
        FlexmbWarning: A measured rotation about an axis in space passes a full turn, where it jumps.
    """
    if not motion.labels.outputs:
        return as_floats(np.zeros((len(motion.t), 0)))
    warn_of_full_turns(motion, motion.model.parameters.reference)
    count = len(motion.labels.inputs)
    u = motion.u if motion.u.shape[1] == count else jnp.zeros((len(motion.t), count))
    rows = motion.t, motion.x, motion.xd, motion.near, u
    return _outputs(motion.model.without_names(), motion.driven, rows)


def origins_of(model: Model) -> Float[Array, "n_y"]:
    """Start coordinates of displacements among the outputs [m], in the undeformed mechanism; NaN for other outputs."""
    outputs, entries = model.labels.outputs, model.labels.x
    moved = [s.quantity == "position" and not s.parts and entries[s.index].kind == "position" for s in outputs]
    places = np.array([s.index for s in outputs], int)
    return computed(lambda xp, x: xp.where(np.array(moved, bool), x[places], np.nan), model.parameters.reference)


@jit_beside_options
def _outputs(model: Model, driven: tuple[Driven, ...], rows: tuple[Array, ...]):
    undriven = coordinates_form(model.topology, model.parameters, driven)
    sensors = controlled_form(model, undriven, None)

    def at_one_time(at: tuple[Array, ...]):
        t, x, xd, last_strain, u = at
        state = undriven.state_of(x, xd, last_strain)
        # Outputs without forces are known for motions without mass too.
        z = under_inputs(model, undriven, u).acceleration(t, state)[0] if sensors.places.late else None
        return sensors.measured(t, state, z, u)

    return jax.lax.map(at_one_time, rows)
