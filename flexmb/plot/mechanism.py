"""The mechanism itself: elements, supports, degrees of freedom, loads and names."""

import dataclasses
from typing import Any

import jax.numpy as jnp
import numpy as np

from ..math.rotation import LBAR
from ..mechanics.loads import LoadFactors, nodal_forces
from ..model.model import Model
from ..model.roles import Role
from .canvas import ARROW, BLACK, GREEN, RED, arrow, frame, marks, mechanism_lines, new_axes, write
from .geometry import extent_of, lines, masses, nodes_of, places_of_rotations
from .state import displaced, state_of


def mechanism(
    shown: Any,
    *,
    at: Any = None,
    step: int | None = None,
    time: float | None = None,
    scale: float = 1.0,
    ghost: bool | None = None,
    supports: bool = True,
    dofs: bool = True,
    loads: bool = True,
    names: bool = False,
    ax: Any = None,
) -> Any:
    """Draw a mechanism, undeformed or where a result says that it is.

    Beams are drawn by the cubic of their ends, spectral beams by their own strains, rigid elements thick, springs with
    a law as zigzags, belts and gears with their circles, hinges and lumped masses as markers. An element of your own is
    drawn by its ``shape`` companion, or else by its points and rotations.

    Args:
        shown: Model, Linearization, Path or Motion.
        at: With a Model: equilibrium, configuration or linearisation of it; the undeformed state unless given.
        step: Which step of a path or output time of a motion; the last unless given.
        time: Time of a motion; the output time nearest to it is drawn [s].
        scale: Factor of the displacements from the undeformed state.
        ghost: Draw the undeformed mechanism too; unless given, where something has moved.
        supports: Mark what is fixed (triangle: position, square: rotation too) and what is prescribed (diamond).
        dofs: Arrows and names of the degrees of freedom that are coordinates.
        loads: Arrows of all nodal forces, incremental ones added, and moments, each with its size. The longest arrow is
            the largest.
        names: Names of nodes and elements.
        ax: matplotlib Axes to draw in, in space with ``projection="3d"``; new ones unless given.

    Returns:
        matplotlib Axes.

    Raises:
        TypeError: ``shown`` or ``at`` cannot be drawn.
        ValueError: ``at``, ``step``, ``time``, ``scale`` or ``ax`` does not fit.
    """
    model, x = state_of(shown, at, step, time)
    x = displaced(model, x, scale)
    reference = np.asarray(model.parameters.reference)
    ax = new_axes(model.labels.dimension, ax)
    seen = []
    moved = not np.allclose(x, reference, rtol=0, atol=1e-12)
    if moved if ghost is None else ghost:
        still = lines(model, reference)
        mechanism_lines(ax, still, ghost=True)
        seen += [line.points for line in still]
    drawn = lines(model, x)
    mechanism_lines(ax, drawn)
    points = {name: x[indices] for name, indices in nodes_of(model).items()}
    seen = np.concatenate([*seen, *(line.points for line in drawn), np.array(list(points.values()))])
    marks(ax, np.array([x[i] for i in masses(model)]), "mass", marker="o", markersize=7, color=BLACK, zorder=3)
    if supports:
        draw_supports(ax, model, points)
    size = ARROW * extent_of(seen)
    ends = _dofs(ax, model, points, size) if dofs else []
    ends += _loads(ax, model, x, points, size) if loads else []
    if names:
        for name, point in points.items():
            write(ax, point, f" {name}", va="bottom")
        for line in drawn:
            write(ax, line.points[len(line.points) // 2], line.element, color="#777777", style="italic", ha="center")
    frame(ax, np.concatenate([seen, *(end[None] for end in ends)]))
    return ax


def draw_supports(ax: Any, model: Model, points: dict[str, np.ndarray]) -> None:
    """Markers where something is fixed or prescribed.

    Args:
        ax: Axes.
        model: Mechanism.
        points: Where each node is, (d,) [m].
    """
    roles = model.roles()[0]
    held: dict[str, set[Role]] = {name: {roles[i] for i in index} for name, index in nodes_of(model).items()}
    turns = {name: {roles[i] for i in index} for name, index in nodes_of(model, "rotation").items()}
    paired = places_of_rotations(model)
    clamped = {point for name, own in turns.items() if own == {Role.FIXED} for point in paired.get(name, [])[:1]}
    fixed = {name for name, own in held.items() if Role.FIXED in own} | clamped
    moved = {name for name, own in held.items() if Role.PRESCRIBED in own}
    moved |= {point for name, own in turns.items() if Role.PRESCRIBED in own for point in paired.get(name, [])[:1]}
    for label, chosen, marker in (
        ("clamped", fixed & clamped, "s"),
        ("supported", fixed - clamped, "^"),
        ("prescribed", moved, "D"),
    ):
        at = np.array([points[name] for name in points if name in chosen])
        marks(ax, at, label, marker=marker, markersize=9, color=BLACK, markerfacecolor="none", zorder=4)


def _place(model: Model, name: str, points: dict[str, np.ndarray]) -> np.ndarray | None:
    """Where a node or a rotation is drawn."""
    if name in points:
        return points[name]
    own = places_of_rotations(model).get(name, [])
    return points[own[0]] if own else None


def _dofs(ax: Any, model: Model, points: dict[str, np.ndarray], size: float) -> list[np.ndarray]:
    """An arrow for each degree of freedom that is a position, its name for one that is a rotation."""
    ends = []
    for index in np.asarray(model.topology.x.dof).tolist():
        entry = model.labels.x[index]
        start = _place(model, entry.of, points)
        if start is None or entry.kind == "internal":
            continue
        vector = np.zeros(len(start))
        if entry.kind == "position":
            vector[entry.component - 1] = size
            arrow(ax, start, vector, f"dof {entry}", GREEN)
        write(ax, start + 1.1 * vector, str(entry), color=GREEN, va="top")
        ends.append(start + vector)
    return ends


def _loads(ax: Any, model: Model, x: np.ndarray, points: dict[str, np.ndarray], size: float) -> list[np.ndarray]:
    """Arrows of nodal forces, scaled to the largest; moments as arrows along their axis, or written in the plane."""
    forces = _forces(model, x)
    vectors = {n: forces[i] for n, i in nodes_of(model).items() if np.any(forces[i])}
    largest = max((np.linalg.norm(v) for v in vectors.values()), default=1.0)
    ends = []
    for name, force in vectors.items():
        value = float(np.linalg.norm(force))
        # The arrow ends at the node; a force that pulls away from the mechanism begins there.
        shown = size * force / largest
        arrow(ax, points[name], shown, f"force {name}", RED)
        write(ax, points[name] + 1.1 * shown, f"{value:.4g} N", color=RED, ha="center")
        ends.append(points[name] + shown)
    for name, moment in _moments(model, x, forces).items():
        start = _place(model, name, points)
        if start is None:
            continue
        if len(moment) == 1:
            sense = "↺" if moment[0] > 0 else "↻"
            write(ax, start, f"{sense} {abs(moment[0]):.4g} N m", color=RED, ha="left", va="bottom")
        else:
            value = float(np.linalg.norm(moment))
            along = size * moment / value
            arrow(ax, start, along, f"moment {name}", RED)
            arrow(ax, start, 0.8 * along, f"moment {name}", RED)
            write(ax, start + 1.1 * along, f"{value:.4g} N m", color=RED, ha="center")
            ends.append(start + along)
    return ends


def _forces(model: Model, x: np.ndarray) -> np.ndarray:
    """Nodal forces of all loads but gravity, (n_x,)."""
    p = model.parameters
    light = [None if own is None else dataclasses.replace(own, gravity=None) for own in (p.loads, p.increment)]
    parameters = dataclasses.replace(p, loads=light[0], increment=light[1])
    return np.asarray(nodal_forces(model.topology, parameters, LoadFactors(1.0, 1.0), jnp.asarray(x)))


def _moments(model: Model, x: np.ndarray, forces: np.ndarray) -> dict[str, np.ndarray]:
    """Moments by name of the rotation: (1,) in the plane, (3,) about global axes in space [N m]."""
    found = {}
    for name, index in nodes_of(model, "rotation").items():
        own = forces[index]
        # The dual of Euler parameters is 2 Lbar^T M and Lbar Lbar^T = I.
        moment = own if len(index) == 1 else np.einsum("ijk,k,j->i", LBAR, x[index], own) / 2
        if np.linalg.norm(moment) > 0:
            found[name] = moment
    return found
