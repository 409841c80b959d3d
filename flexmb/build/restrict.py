"""Changes of a checked model: deformations are FIXED, tied to each other, measured or released."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..checks.mobility import allowed_motions, constraints
from ..compilation.record import Record, static
from ..elements import spatial
from ..elements.element import NONLINEAR, SECTIONAL
from ..elements.nodes import ROTATION3
from ..elements.tie import TiePart, tie
from ..math.subspace import above, independent_rows
from ..mechanics.blocks import deforming
from ..model.by_name import TURNS, frame_of, turn_of
from ..model.model import Entry, Labels, Model
from ..model.topology import Block, Loads, Parameters, RoleIndices, Topology
from ..numerical_limits import CANNOT_MOVE
from .assemble import on_device
from .dofs import choose

TIE = "tie"


def can_be_tied(model: Model) -> np.ndarray:
    """Whether each deformation may enter a tie; angles that count turns may not."""
    possible = np.zeros(model.topology.n_e, bool)
    for block in model.topology.blocks:
        if "deformation" in block.companions and not block.element.tracks_angle:
            possible[np.asarray(block.e)] = True
    return possible


class Restriction(Record):
    """FIXED and tied deformations of a model, for models of the same structure.

    Attributes:
        topology: Structure of the restricted model.
        labels: Its names.
        weights: Weights of the tied deformations in each tie, (1, ties, m) [-].
        tied: Numbers of the blocks with tied deformations.
    """

    topology: Topology
    labels: Labels = static()
    weights: jax.Array
    tied: tuple[int, ...] = static()

    def of(self, model: Model) -> Model:
        """The restricted model with the numbers of another model."""
        unrestricted = model.parameters
        more = self.topology.n_e - model.topology.n_e
        properties = unrestricted.properties
        if more:
            blocks = [(model.topology.blocks[i], unrestricted.properties[i]) for i in self.tied]
            parts = tuple(
                block.element.of_deformation(deforming(block, block_properties)) for block, block_properties in blocks
            )
            of = tuple(jax.tree.map(lambda leaf: jnp.asarray(leaf)[None], part) for part in parts)
            properties = (*properties, {"weights": self.weights, "of": of})

        parameters = Parameters(
            unrestricted.reference,
            properties,
            _longer_loads(unrestricted.loads, 0, more) or Loads(),
            _longer_loads(unrestricted.increment, 0, more),
            _longer(unrestricted.strain, more),
            weights=unrestricted.weights,
        )
        return Model(self.topology, parameters, self.labels)


def _longer(values: Array | None, more: int) -> Array | None:
    """Values followed by zeros."""
    return None if values is None else jnp.concatenate([values, jnp.zeros((more, *values.shape[1:]))])


def _longer_loads(loads: Loads | None, more_x: int, more_e: int) -> Loads | None:
    if loads is None:
        return None
    of_e = {name: _longer(getattr(loads, name), more_e) for name in ("prestress", "temperature")}
    return dataclasses.replace(loads, force=_longer(loads.force, more_x), **of_e)


def with_turn(model: Model, name: str) -> Model:
    """A model with a hinge that measures the rotation of a node in space about a global axis.

    The model is unchanged if it already has this hinge, or if ``name`` names no such rotation.
    """
    labels, top, original = model.labels, model.topology, model.parameters
    turned = labels.rotation_of(name)
    if turned is None or labels.place(name) is not None:
        return model
    part, axis = labels.x[turned[0][0]].of, turned[1]
    frame, hinge = frame_of(part), turn_of(part, TURNS[axis])
    at = labels.coordinates(frame)
    new: list[int] = [] if at else list(range(top.n_x, top.n_x + ROTATION3.size))
    e = list(range(top.n_e, top.n_e + 3))
    own_x, own_e = on_device((np.array([[*(at or new), *turned[0]]]), np.array([e])))
    block = Block(spatial.hinge, ("deformation",), (), own_x, own_e, (ROTATION3.size,))
    topology = Topology(
        (*top.blocks, block),
        roles_of([*np.asarray(top.x.fixed), *new], top.x.dependent, top.x.dof, top.x.prescribed),
        roles_of(top.e.fixed, [*np.asarray(top.e.dependent), *e], top.e.dof, top.e.prescribed),
        top.axes,
        on_device(np.concatenate([np.asarray(top.powers), np.zeros(len(new), int)])),
    )
    parameters = dataclasses.replace(
        original,
        reference=jnp.concatenate([original.reference, jnp.array(ROTATION3.start)]) if new else original.reference,
        properties=(*original.properties, {"axis": jnp.eye(3)[axis][None], "stiffness": None, "damping": None}),
        loads=_longer_loads(original.loads, len(new), 3) or Loads(),
        increment=_longer_loads(original.increment, len(new), 3),
        strain=_longer(original.strain, 3),
    )
    names = dataclasses.replace(
        labels,
        x=labels.x + tuple(Entry(frame, i + 1, ROTATION3.components[i], "rotation") for i in range(len(new))),
        e=labels.e + tuple(Entry(hinge, i + 1, f"e{i + 1}", "deformation") for i in range(3)),
        elements=(*labels.elements, (hinge, "hinge", (frame, part))),
        stressed=(*labels.stressed, (None,)),
    )
    return Model(topology, parameters, names)


def restrict(model: Model, fixed: list[int], tied: list[int], weights: np.ndarray) -> Restriction:
    """Fix deformations, tie others, and choose degrees of freedom among those of a checked model.

    Args:
        fixed: Deformations to fix, as indices in e.
        tied: Deformations in ties, as indices in e.
        weights: Their weights in each tie, (ties, tied) [-].
    """
    top = model.topology
    n_e, ties = top.n_e, len(weights)
    blocks, stressed, places = list(top.blocks), list(model.labels.stressed), []
    constrained = {*np.asarray(top.e.fixed).tolist(), *fixed}
    for i, block in enumerate(blocks):
        if constrained.issuperset(np.asarray(block.e).ravel().tolist()):
            # As in a model that is built with these roles: FIXED deformations need no stiffness.
            companions = tuple(c for c in block.companions if c not in ("stiffness", "damping", *SECTIONAL, *NONLINEAR))
            blocks[i] = dataclasses.replace(block, companions=companions)
    entries = model.labels.e
    if ties:
        places = [i for i, b in enumerate(top.blocks) if not set(tied).isdisjoint(np.asarray(b.e).ravel().tolist())]
        places = [i for i in places if "deformation" in top.blocks[i].companions]
        used = np.unique(np.concatenate([np.asarray(top.blocks[i].x).ravel() for i in places]))
        parts, order = [], []
        for i in places:
            block = top.blocks[i]
            rows = np.searchsorted(used, np.asarray(block.x))
            parts.append(TiePart(block.element, block.options, block.splits, tuple(map(tuple, rows.tolist()))))
            order += np.asarray(block.e).ravel().tolist()
        columns = np.zeros((ties, len(order)))
        columns[:, [order.index(j) for j in tied]] = weights
        new: Any = n_e + np.arange(ties)
        element = tie(tuple(parts), len(used), model.labels.dimension)
        blocks.append(Block(element, ("deformation",), (), jnp.asarray(used[None]), jnp.asarray(new[None]), ()))
        stressed.append((None,))
        entries += tuple(Entry(TIE, i + 1, f"e{i + 1}", "deformation") for i in range(ties))
    else:
        columns = np.zeros((0, 0))
    free = [i for i in np.asarray(top.e.free).tolist() if i not in constrained]
    e = roles_of(sorted([*constrained, *range(n_e, n_e + ties)]), sorted(free), [], top.e.prescribed)
    x = roles_of(top.x.fixed, np.sort(top.x.free), [], top.x.prescribed)
    labels = dataclasses.replace(model.labels, e=entries, stressed=tuple(stressed))
    bare = Restriction(
        Topology(tuple(blocks), x, e, top.axes, top.powers), labels, jnp.asarray(columns[None]), tuple(places)
    )
    return dataclasses.replace(bare, topology=with_dofs(bare.of(model), model))


def with_released(model: Model, indices: list[int]) -> Model:
    """A model with FIXED deformations released, and degrees of freedom for them."""
    top = model.topology
    constrained = [i for i in np.asarray(top.e.fixed).tolist() if i not in indices]
    free = sorted({*indices, *np.asarray(top.e.dependent).tolist(), *np.asarray(top.e.dof).tolist()})
    e = roles_of(constrained, free, [], top.e.prescribed)
    x = roles_of(top.x.fixed, np.sort(top.x.free), [], top.x.prescribed)
    bare = dataclasses.replace(
        model,
        topology=dataclasses.replace(top, x=x, e=e),
        parameters=dataclasses.replace(model.parameters, start=None),
    )
    return dataclasses.replace(bare, topology=with_dofs(bare, model))


def with_dofs(restricted: Model, model: Model) -> Topology:
    """Structure with the degrees of freedom of ``model``, and further ones for motions that they do not determine.

    ``restricted`` has other constraints and no degrees of freedom yet.
    """
    motions, _ = allowed_motions(restricted)
    top, original = restricted.topology, model.topology
    effects = constraints(restricted).jacobian[np.asarray(original.e.dof)] @ motions
    rows = above(motions[np.asarray(original.x.dof)], effects)
    chosen, _ = independent_rows(rows, motions.shape[1], CANNOT_MOVE)
    more_x, more_e = choose(restricted, motions, rows)
    count = original.x.dof.shape[0]
    x_dof = [int(original.x.dof[i]) for i in sorted(chosen) if i < count] + more_x
    e_dof = [int(original.e.dof[i - count]) for i in sorted(chosen) if i >= count] + more_e
    return dataclasses.replace(top, x=_chosen(top.x, x_dof), e=_chosen(top.e, e_dof))


def _chosen(roles: RoleIndices, dof: list[int]) -> RoleIndices:
    dependent = [i for i in np.asarray(roles.dependent).tolist() if i not in dof]
    return roles_of(roles.fixed, dependent, dof, roles.prescribed)


def roles_of(fixed: Any, dependent: Any, dof: Any, prescribed: Any) -> RoleIndices:
    """Indices of each role, from known indices in lists or arrays, without compiling."""
    return RoleIndices(*on_device([np.array(indices, int) for indices in (fixed, dependent, dof, prescribed)]))
