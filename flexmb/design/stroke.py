"""A mechanism at a stroke: held there by a drive, and released under the drive's force."""

import dataclasses
import difflib
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..build.dofs import CANNOT_MOVE
from ..build.restrict import roles_of, with_dofs
from ..checks.mobility import allowed_motions
from ..compilation.compile import jit
from ..display import among, unit_of
from ..errors import ModelError
from ..linear.buckling import multipliers_of, scaled_stiffness
from ..linear.linearize import Linearization, Matrices, linearize, matrices_at
from ..math.linear import factorise
from ..math.subspace import dense, row_sizes
from ..mechanics.deformation import undeformed
from ..mechanics.loads import lacks_potential, load_factors
from ..mechanics.residual import state
from ..model.by_name import TURN_OF, turned_by
from ..model.model import Entry, Model
from ..model.topology import Loads, Parameters, RoleIndices, Topology


class StrokeError(ModelError):
    """The driven coordinate is unknown, not named, or fixed."""


class AtStroke(NamedTuple):
    """A mechanism at a stroke.

    Attributes:
        held: Linearised while the drive holds the coordinate.
        free: Linearised with the drive as a dead force, and the coordinate as a degree of freedom.
        force: Force of the drive along the coordinate, () [N or N m].
        stiffness: Its change with the stroke, () [N/m or N m/rad].
        margins: Multipliers of the constant loads at which the released mechanism buckles, ascending, infinite if the
            loads do not act, (n_q,) [-]; None without constant loads.
    """

    held: Linearization
    free: Linearization
    force: Float[Array, ""]
    stiffness: Float[Array, ""]
    margins: Float[Array, "n_q"] | None


@dataclasses.dataclass(frozen=True)
class StrokeDrive:
    """The driven coordinate of a model, for models of the same structure.

    Attributes:
        entry: Name of the coordinate or deformation.
        kind: "x" or "e".
        index: Its index in x or e.
        given: Whether the model already prescribes it.
        held: Structure in which it is PRESCRIBED.
        free: Structure in which it is a degree of freedom.
    """

    entry: Entry
    kind: str
    index: int
    given: bool
    held: Topology
    free: Topology

    @property
    def name(self) -> str:
        """Name such as "top.x", "stage.phi", "hinge.e1"."""
        return coordinate_name(self.entry)

    def at(self, model: Model, stroke: float, *, throw: bool = True) -> AtStroke:
        """The equilibrium at a stroke under the constant loads, differentiable in model and stroke.

        Source:
            THEORY.md 5 and 6, eq. (6.3): with the drive's force as a load the same state is an equilibrium of the
            released mechanism, and a dead force adds nothing to its stiffness.
        """
        place = int(np.searchsorted(np.asarray(getattr(self.held, self.kind).prescribed), self.index))
        original, values = model.parameters, getattr(model.parameters.loads, self.kind)
        with_it, without = values, values
        if values is not None and self.given:
            without = jnp.concatenate([values[:place], values[place + 1 :]])
        elif values is not None:
            with_it = jnp.concatenate([values[:place], jnp.zeros(1), values[place:]])
        unit = np.zeros(getattr(self.held, self.kind).prescribed.shape[0])
        unit[place] = 1.0

        def with_values(topology: Topology, values: Any, increment: Loads | None) -> Model:
            loads = dataclasses.replace(original.loads, **{self.kind: values})
            parameters = dataclasses.replace(original, loads=loads, increment=increment, start=None)
            return Model(topology, parameters, model.labels)

        step: Any = {self.kind: jnp.asarray(unit)}
        driven = with_values(self.held, with_it, Loads(**step))
        constrained = linearize(driven, increment=stroke, throw=throw)
        free, factors = with_values(self.free, without, None), load_factors(1.0, stroke)
        structure = self.held, driven.parameters, factors
        matrices, *others = _let_go(
            self.free, free.parameters, structure, constrained.matrices, jnp.asarray(self.index), of=self.kind
        )
        return AtStroke(constrained, Linearization(matrices, free), *others)


@jit
def _let_go(
    topology: Topology, parameters: Parameters, structure: Any, held: Matrices, index: Array, *, of: str
) -> tuple[Matrices, Array, Array, Array | None]:
    """Matrices with the driven coordinate as a degree of freedom; force, stiffness and margins of :class:`AtStroke`."""
    factors, last_strain, loads = load_factors(1.0, 0.0), jax.lax.stop_gradient(held.e), parameters.loads
    at, force = state(topology, parameters, factors, held.x, last_strain), held.reactions[index]
    if of == "e":
        # A drive that lengthens an element pushes: it adds a negative stress resultant.
        force = at.sigma[index] - held.sigma[index]
        prestress = jnp.zeros(topology.n_e) if loads.prestress is None else loads.prestress
        driven = dataclasses.replace(loads, prestress=prestress.at[index].add(-force))
        parameters = dataclasses.replace(parameters, loads=driven)
        at = state(topology, parameters, factors, held.x, last_strain)
    matrices = matrices_at(topology, parameters, factors, at, held.iterations, held.result)
    row = (matrices.DFe if of == "e" else matrices.DFx)[index]
    stiffness = 1 / (row @ factorise(matrices.K).solve(row))
    more = Loads(loads.force, loads.gravity, loads.prestress, temperature=loads.temperature)
    if not jax.tree.leaves(more):
        return matrices, force, stiffness, None
    # The other loads grow while the drive holds the stroke; buckling concerns the released mechanism.
    structure, numbers, raised = structure
    still = state(structure, numbers, raised, held.x, last_strain)
    again = dataclasses.replace(parameters, increment=more)
    grown = structure, dataclasses.replace(numbers, increment=more), still
    pencil = scaled_stiffness(topology, again, at, last_strain, grown)
    margins = 1 + multipliers_of(*pencil, unsymmetric=lacks_potential(topology))
    return matrices, force, stiffness, jnp.sort(jnp.where(margins > 0, margins, jnp.inf))


def coordinate_name(entry: Entry) -> str:
    """Node and component, such as "top.x", "stage.phi", "c.rx", "hinge.e1"; a rotation has the name of its node."""
    if entry.component == 1 and entry.of.startswith(TURN_OF):
        node, axis = turned_by(entry.of)
        return f"{node}.{axis}" if axis else str(entry)
    return f"{entry.of.removesuffix('.rotation')}.{entry.symbol}"


def driven(model: Model, name: str | None) -> StrokeDrive:
    """The driven coordinate of a model, with the structures in which it is held and free."""
    kind, index = _of_model(model) if name is None else _place_of_name(model, name)
    entry, roles_of_kind = getattr(model.labels, kind)[index], getattr(model.topology, kind)
    called = f"Stroke '{coordinate_name(entry)}'"
    if entry.kind == "rotation" and entry.symbol != "phi":
        node = entry.of.removesuffix(".rotation")
        raise StrokeError(
            f"{called}: an Euler parameter is not an angle. Drive the angle of a hinge, or the angle about a global"
            f" axis: '{node}.rx'."
        )
    if index in np.asarray(roles_of_kind.fixed):
        raise StrokeError(f"{called} is fixed in this model. {_moving_hint(model)}")
    prescribed = np.asarray(roles_of_kind.prescribed)
    free = _without_dofs(model, kind, np.setdiff1d(prescribed, index))
    constrained = _without_dofs(model, kind, np.union1d(prescribed, index))
    if allowed_motions(constrained)[0].shape[1] != allowed_motions(free)[0].shape[1] - 1:
        raise ModelError(f"{called}: no motion of the undeformed mechanism moves it. {_moving_hint(model)}")
    structure = with_dofs(constrained, model)
    dofs = {k: [*np.asarray(getattr(structure, k).dof).tolist(), *([index] if k == kind else [])] for k in "xe"}
    roles = {}
    for k, chosen in dofs.items():
        role_indices: RoleIndices = getattr(free.topology, k)
        dependent = np.setdiff1d(np.asarray(role_indices.dependent), chosen)
        roles[k] = roles_of(role_indices.fixed, dependent, chosen, role_indices.prescribed)
    return StrokeDrive(entry, kind, index, index in prescribed, structure, dataclasses.replace(free.topology, **roles))


def _without_dofs(model: Model, kind: str, prescribed: np.ndarray) -> Model:
    """A model without degrees of freedom, and with other PRESCRIBED entries of one kind."""
    roles = {}
    for k in "xe":
        known: RoleIndices = getattr(model.topology, k)
        prescribed_of_kind = prescribed if k == kind else np.asarray(known.prescribed)
        dependent = np.setdiff1d(np.arange(known.size), np.concatenate([np.asarray(known.fixed), prescribed_of_kind]))
        roles[k] = roles_of(known.fixed, dependent, [], prescribed_of_kind)
    return dataclasses.replace(model, topology=dataclasses.replace(model.topology, **roles))


def _place_of_name(model: Model, name: str) -> tuple[str, int]:
    place = model.labels.place(name)
    if place is None or getattr(model.labels, place[0])[place[1]].kind == "internal":
        owner, _, number = str(name).rpartition(".")
        indices = model.labels.coordinates(owner)
        # Input files name coordinates by their numbers at the node.
        is_numbered = number.isdecimal() and 0 < int(number) <= len(indices)
        similar = [coordinate_name(model.labels.x[int(indices[int(number) - 1])])] if is_numbered else []
        if not number.isdecimal() or not indices:
            similar = similar or difflib.get_close_matches(str(name), model.labels.names(), 1)
        hint = f"Did you mean '{similar[0]}'?" if similar else _moving_hint(model, str(name))
        raise StrokeError(f"There is no coordinate or deformation '{name}' to drive. {hint}")
    return place


def _of_model(model: Model) -> tuple[str, int]:
    """The driven coordinate that the model itself determines."""
    top, more = model.topology, model.parameters.increment
    acting = [s for s in model.labels.inputs if s.axis is None and not s.held and not s.parts]
    candidates = [("e" if s.of_element else "x", s.index) for s in acting]
    for kind in "xe" if more is not None else "":
        values = getattr(more, kind)
        moved = [] if values is None else np.asarray(getattr(top, kind).prescribed)[np.flatnonzero(values)].tolist()
        candidates = [(kind, i) for i in moved] or candidates
    candidates = candidates or [(kind, i) for kind in "xe" for i in np.asarray(getattr(top, kind).dof).tolist()]
    if len(candidates) != 1:
        raise StrokeError(f"The stroke has no coordinate. Name one: stroke={{'top.x': 1e-3}}. {_moving_hint(model)}")
    return candidates[0]


def _moving_hint(model: Model, name: str = "") -> str:
    """A sentence with names of coordinates that move."""
    motions, _ = allowed_motions(model)
    moving = [
        coordinate_name(e) for e, size in zip(model.labels.x, row_sizes(motions), strict=True) if size > CANNOT_MOVE
    ]
    return f"These move: {among(moving, name)}." if moving else "Nothing of it moves."


def unit_of_driven(model: Model, what: StrokeDrive) -> str:
    """Unit of a stroke, "m" or "rad": in a mechanism of twice the size, angles have the same derivatives by angles."""
    if what.kind == "x":
        return unit_of(what.entry)
    top, reference = model.topology, np.array(model.parameters.reference)
    twice = reference.copy()
    positions = np.asarray(top.axes).ravel()
    twice[positions] *= 2
    rows = []
    for x in (reference, twice):
        jacobian = undeformed(top, dataclasses.replace(model.parameters, reference=x))[1]
        rows.append(dense(jacobian[[what.index]])[0])
    turns = np.setdiff1d(np.arange(top.n_x), positions)
    if np.any(rows[0][turns]):
        return "m" if np.linalg.norm(rows[1][turns]) > 1.5 * np.linalg.norm(rows[0][turns]) else "rad"
    return "m" if np.linalg.norm(rows[1]) > 0.75 * np.linalg.norm(rows[0]) else "rad"
