"""Marks at the nodes of a mechanism: supports, degrees of freedom and loads."""

import dataclasses
from typing import NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from ..math.rotation import LBAR
from ..mechanics.loads import LoadFactors, nodal_forces
from ..model.model import Model
from ..model.topology import Role
from .canvas import prefix_for
from .geometry import nodes_of, places_of_rotations

SUPPORTS = ("clamped", "supported", "prescribed")


class Mark(NamedTuple):
    """A degree of freedom or a load.

    Attributes:
        kind: "dof", "force" or "moment".
        name: Of the coordinate, or of the node that carries the load.
        node: Where it is drawn.
        vector: Its direction, of a load with its size, (d,) [-, N, N m]; None where it has none in the picture: a
            degree of freedom that is a rotation, a moment in the plane.
        text: What is written beside it.
    """

    kind: str
    name: str
    node: str
    vector: Float[np.ndarray, "d"] | None
    text: str


def supports(model: Model) -> dict[str, list[str]]:
    """Nodes by kind of support; "clamped" if the rotation is fixed too."""
    roles, places = model.roles()[0], _places(model)
    position_roles: dict[str, set[Role]] = {name: {roles[i] for i in index} for name, index in nodes_of(model).items()}
    turns = {name: {roles[i] for i in index} for name, index in nodes_of(model, "rotation").items()}
    clamped = {places.get(name) for name, entries in turns.items() if entries == {Role.FIXED}}
    fixed = {name for name, entries in position_roles.items() if Role.FIXED in entries} | clamped
    moved = {places.get(name) for name, entries in (position_roles | turns).items() if Role.PRESCRIBED in entries}
    chosen = zip(SUPPORTS, (fixed & clamped, fixed - clamped, moved), strict=True)
    return {kind: [name for name in position_roles if name in points] for kind, points in chosen}


def dofs(model: Model) -> list[Mark]:
    """Degrees of freedom that are coordinates of nodes, with a unit vector for each position."""
    places, dof_marks = _places(model), []
    for index in np.asarray(model.topology.x.dof).tolist():
        entry = model.labels.x[index]
        node = places.get(entry.of)
        if node is None or entry.kind == "internal":
            continue
        vector = np.eye(model.labels.dimension)[entry.component - 1] if entry.kind == "position" else None
        dof_marks.append(Mark("dof", str(entry), node, vector, str(entry)))
    return dof_marks


def loads(model: Model, x: Float[np.ndarray, "n_x"]) -> list[Mark]:
    """Nodal forces and moments of all loads except gravity, incremental ones included."""
    forces, places = _forces(model, x), _places(model)
    load_marks = [
        Mark("force", name, name, forces[i], sized(float(np.linalg.norm(forces[i])), "N"))
        for name, i in nodes_of(model).items()
        if np.any(forces[i])
    ]
    for name, moment in _moments(model, x, forces).items():
        node = places.get(name)
        if node is None:
            continue
        size = sized(float(np.linalg.norm(moment)), "N m")
        turn, vector = (f"{'↺' if moment[0] > 0 else '↻'} ", None) if len(moment) == 1 else ("", moment)
        load_marks.append(Mark("moment", name, node, vector, turn + size))
    return load_marks


def sized(size: float, unit: str) -> str:
    """Size of a load with its unit, with a prefix if that is shorter: "12.5 N", "2 µN"."""
    factor, prefixed = (1.0, unit) if 1e-3 <= size < 1e4 else prefix_for(size, unit)
    return f"{size * factor:.4g} {prefixed}"


def _places(model: Model) -> dict[str, str]:
    """Node at which each node or rotation is drawn."""
    rotations = {name: points[0] for name, points in places_of_rotations(model).items()}
    return rotations | {name: name for name in nodes_of(model)}


def _forces(model: Model, x: np.ndarray) -> np.ndarray:
    """Nodal forces of all loads except gravity, (n_x,)."""
    p = model.parameters
    loads, increment = (None if s is None else dataclasses.replace(s, gravity=None) for s in (p.loads, p.increment))
    parameters = dataclasses.replace(p, loads=loads, increment=increment)
    return np.asarray(nodal_forces(model.topology, parameters, LoadFactors(1.0, 1.0), jax.device_put(x)))


def _moments(model: Model, x: np.ndarray, forces: np.ndarray) -> dict[str, np.ndarray]:
    """Moments by name of the rotation: (1,) in the plane, (3,) about global axes in space [N m]."""
    moments = {}
    for name, index in nodes_of(model, "rotation").items():
        dual = forces[index]
        # The dual of Euler parameters is 2 Lbar^T M and Lbar Lbar^T = I.
        moment = dual if len(index) == 1 else np.einsum("ijk,k,j->i", LBAR, x[index], dual) / 2
        if np.linalg.norm(moment) > 0:
            moments[name] = moment
    return moments
