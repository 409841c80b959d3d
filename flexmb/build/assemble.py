"""Index arrays and stacked numbers of a Model, from the contents of a Builder."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import jax
import jax.core
import jax.numpy as jnp
import numpy as np

from ..arguments import is_concrete
from ..elements.element import COMPANIONS, NONLINEAR, SECTIONAL, Element
from ..elements.general import General
from ..elements.nodes import ROTATION3, unit_norm
from ..elements.profile import Profile
from ..elements.sections import MaterialDamping, Rigidity
from ..math.indices import put
from ..mechanics.blocks import with_meaning
from ..model.by_name import TURN_OF, TURNS, frame_of, turn_of
from ..model.model import MOTIONS, Entry, Labels, Model, Signal
from ..model.topology import HELD, Block, Loads, Parameters, Role, RoleIndices, Topology
from .description import Description, Key, NamedSignal, turn_about

UNIT_NORM = Element(unit_norm)


def is_option(value: Any) -> bool:
    """Whether a property selects code and is no number, although it is not annotated ``Static``."""
    return isinstance(value, bool | str)


def stack(values: Sequence[Any]) -> Any:
    """Stack scalars or arrays to float64, by NumPy if none is traced.

    Shared values are traced once, since each operation of a trace takes a millisecond.
    """
    if is_concrete(values):
        return np.stack([np.asarray(v, float) for v in values])
    distinct = list({id(v): v for v in values}.values())
    traced = [v for v in distinct if not is_concrete(v)]
    known = [v for v in distinct if is_concrete(v)]
    stacked = jnp.stack([jnp.asarray(v, float) for v in traced])
    if known:
        stacked = jnp.concatenate([np.stack([np.asarray(v, float) for v in known]), stacked])
    order = {id(v): i for i, v in enumerate([*known, *traced])}
    places = np.array([order[id(v)] for v in values])
    return stacked if np.array_equal(places, np.arange(len(distinct))) else stacked[places]


class _Numbering:
    """Places of nodes and elements in the vectors of coordinates and deformations, with their roles.

    Attributes:
        members: Elements and constraints of Euler parameters: name, element, nodes, properties, roles.
        first_x, first_e: First coordinate of each node, and first deformation of each element.
        x_roles, e_roles: Role of each coordinate and deformation.
    """

    def __init__(self, builder: Description):
        self.members = [(n, m.element, m.nodes, m.properties, m.roles) for n, m in builder.members.items()]
        for name, node in builder.nodes.items():
            if node.kind is ROTATION3 and any(role is not Role.FIXED for role in node.roles):
                self.members.append((name, UNIT_NORM, (name,), {}, [Role.FIXED]))
        starts = np.cumsum([0] + [node.kind.size for node in builder.nodes.values()])
        self.first_x: dict[str, int] = dict(zip(builder.nodes, starts.tolist(), strict=False))
        self.x_roles = [role for node in builder.nodes.values() for role in node.roles]
        self.first_e: dict[str, int] = {}
        self.e_roles: list[Role] = []
        for name, *_, roles in self.members:
            self.first_e.setdefault(name, len(self.e_roles))
            self.e_roles += roles

    def index(self, key: Key) -> int:
        """Return the index of a coordinate or deformation."""
        kind, owner, number = key
        return (self.first_e if kind == "element" else self.first_x)[owner] + number - 1


def assemble(builder: Description) -> Model:
    """Model of a builder's contents, unchecked."""
    builder = with_tilts(builder)
    numbering, nodes = _Numbering(builder), builder.nodes.values()
    warm = {owner for sets in builder.loads.values() for _, owner, _ in sets.get("temperature", {})}
    blocks, properties, stressed = _blocks(builder, numbering.members, numbering.first_x, warm)
    points = [numbering.first_x[name] for name, node in builder.nodes.items() if node.kind.part == "position"]
    axes: Any = np.array(points, int)[None, :] + np.arange(builder.dimension or 2)[:, None]
    dofs = [[numbering.index(d) for d in builder.dofs if d[0] == kind] for kind in ("node", "element")]
    powers: Any = np.array([power for node in nodes for power in node.kind.powers or (0,) * node.kind.size], int)
    indices = _indices(numbering.x_roles, dofs[0]), _indices(numbering.e_roles, dofs[1])
    topology = Topology(blocks, *indices, axes, powers)
    initial = _loads(builder.loads["initial"], topology, numbering.index)
    increment = _loads(builder.loads["increment"], topology, numbering.index)
    has_increment = bool(jax.tree.leaves(increment)) or any("incremental" in m[3] for m in numbering.members)
    parameters = Parameters(
        stack([value for node in nodes for value in node.start]),
        properties,
        initial,
        increment if has_increment else None,
        _sparse(builder.loads["initial"].get("strain"), len(numbering.e_roles), numbering.index),
        _starts(builder),
        _weights(builder.signals),
    )
    topology, parameters = on_device((topology, parameters))
    return Model(topology, parameters, _labels(builder, numbering, stressed, warm))


def with_tilts(builder: Description) -> Description:
    """Return a builder in which rotations that are FIXED about two global axes turn about the third without limit.

    If two angles are zero, they do not determine a rotation by half a turn about the third axis. The tilts of the hinge
    about this axis determine all rotations about it.

    Returns:
        A copy. Without such rotations, or if an input moves one of the two angles: the builder itself.

    Source:
        THEORY.md 2, eq. (2.17).
    """
    found: dict[str, list[Role]] = {}
    hinges = (member for name, member in builder.members.items() if name.startswith(TURN_OF))
    inputs = [s for top in builder.signals["input"] for s in top.parts or (top,)]
    moved = {turn_of(s.key[1], TURNS[s.axis]) for s in inputs if s.axis is not None and s.quantity in MOTIONS}
    for rotation in dict.fromkeys(member.nodes[-1] for member in hinges):
        turns = [turn_about(builder, rotation, axis)[1] for axis in range(3)]
        if not builder.members.keys() >= set(turns):
            continue
        roles = {name: builder.members[name].roles for name in turns}
        free = [name for name in turns if roles[name][0] is not Role.FIXED]
        if len(free) == 1 and moved.isdisjoint({*turns} - {*free}):
            found |= {name: [Role.DEPENDENT, *roles[name][1:]] for name in turns if name not in free}
            found[free[0]] = [roles[free[0]][0], Role.FIXED, Role.FIXED]
    if not found:
        return builder
    twin = builder.copy()
    for name, roles in found.items():
        twin.members[name] = dataclasses.replace(twin.members[name], roles=roles)
    return twin


def _labels(builder: Description, numbering: _Numbering, stressed: Any, warm: set[str]) -> Labels:
    """Names of coordinates, deformations, elements and signals."""
    x_labels = [
        Entry(name, i, component, node.kind.part)
        for name, node in builder.nodes.items()
        for i, component in enumerate(node.kind.components, 1)
    ]
    e_labels = []
    for name, element, _, _, roles in numbering.members:
        kind, symbol = ("norm", "norm") if element is UNIT_NORM else ("deformation", "e")
        called = element.deformation_names
        e_labels += [Entry(name, i, f"{symbol}{i}", kind, called.get(i, "")) for i in range(1, len(roles) + 1)]
    elements = tuple((n, m.element.name, m.nodes) for n, m in builder.members.items() if not m.hidden)
    signals = {
        kind: tuple(_signal(builder, numbering, s) for s in entries) for kind, entries in builder.signals.items()
    }
    return Labels(
        tuple(x_labels),
        tuple(e_labels),
        elements,
        signals["input"],
        signals["output"],
        builder.dimension or 2,
        stressed,
        tuple(name for name, *_ in elements if name in warm),
    )


def _signal(builder: Description, numbering: _Numbering, s: NamedSignal) -> Signal:
    """Input or output by the index of its coordinate or deformation."""
    if s.parts:
        return Signal(s.name, s.quantity, -1, parts=tuple(_signal(builder, numbering, part) for part in s.parts))
    axis, key = s.axis, s.key
    if axis is not None and not s.local and any(role not in HELD for role in builder.nodes[key[1]].roles):
        # A hinge prescribes or fixes a rotation about an axis. The moment acts on the frame of the hinge.
        turn = turn_about(builder, key[1], axis)
        hinge = builder.members.get(turn[1])
        if s.quantity in MOTIONS and hinge is not None and hinge.roles[0] in HELD:
            axis, key = None, turn
        elif s.quantity == "reaction" and frame_of(key[1]) in builder.nodes:
            key = ("node", frame_of(key[1]), 1)
    of_element, at = key[0] == "element", numbering.index(key)
    constrained = (numbering.e_roles if of_element else numbering.x_roles)[at] in (Role.FIXED, Role.PRESCRIBED)
    return Signal(s.name, s.quantity, at, axis, s.local, of_element, constrained)


def _starts(builder: Description) -> Any:
    """Values and rates of the degrees of freedom at the start, (n_q,) each; None if none are given."""
    order = [d for d in builder.dofs if d[0] == "node"] + [d for d in builder.dofs if d[0] == "element"]
    if not builder.starts or not order:
        return None
    pairs = [builder.starts.get(key, (0.0, 0.0)) for key in order]
    return tuple(stack([pair[i] for pair in pairs]) for i in range(2))


def on_device(tree: Any) -> Any:
    """Arrays on the device, in one transfer, so that calls do not convert them again.

    Within a trace of JAX they stay known numbers, as the structure of a model always is.
    """
    leaves, structure = jax.tree.flatten(tree)
    on_host = [i for i, leaf in enumerate(leaves) if is_concrete(leaf)]
    with jax.core.eval_context():
        moved = jax.device_put([leaves[i] for i in on_host])
    for i, leaf in zip(on_host, moved, strict=True):
        leaves[i] = leaf
    return jax.tree.unflatten(structure, leaves)


def _weights(signals: dict[str, list[NamedSignal]]) -> tuple[Any, Any] | None:
    """Weights of the terms of all inputs, and of all outputs; None without combinations."""
    if not any(s.parts for some in signals.values() for s in some):
        return None
    inputs, outputs = ([w for s in signals[side] for w in s.weights or (1.0,)] for side in ("input", "output"))
    return stack(inputs) if inputs else np.zeros(0), stack(outputs) if outputs else np.zeros(0)


class _Piece(NamedTuple):
    """An element of a Builder with its indices, before it is stacked into a block."""

    name: str
    x: list[int]
    e: list[int]
    splits: tuple[int, ...]
    properties: dict[str, Any]
    companions: tuple[str, ...]


def _blocks(builder: Description, members: list[tuple], first_x: dict[str, int], warm: set[str]):
    """Members stacked by type and structure of their properties, in order of first appearance; and names with stress.

    Deformations and companions of elements of a type share a block, so that common parts are computed once. If
    companions differ, as for hinges with and without stiffness, deformations stay together in a block of their own.
    """
    groups: dict[Any, list[_Piece]] = {}
    first = 0
    for name, element, nodes, properties, roles in members:
        x = [first_x[n] + i for n in nodes for i in range(builder.nodes[n].kind.size)]
        e = list(range(first, first + len(roles)))
        first += len(roles)
        splits = tuple(np.cumsum([builder.nodes[n].kind.size for n in nodes])[:-1].tolist())
        rigid = all(role is Role.FIXED for role in roles)
        present = tuple(
            c
            for c in COMPANIONS
            # FIXED deformations need no stiffness, and elements without section no stress.
            if not (rigid and c in ("stiffness", "damping", *SECTIONAL, *NONLINEAR))
            and (c not in SECTIONAL or properties.get("section") is not None)
            and (c != "thermal" or name in warm)
            and element.arguments(getattr(element, _source(c, properties)), properties) is not None
        )
        key = (element, _structure(element.of_deformation(properties)))
        groups.setdefault(key, []).append(_Piece(name, x, e, splits, properties, present))
    blocks: list[tuple[Block, dict[str, Any], tuple[str | None, ...]]] = []
    for (element, _), group in groups.items():
        alike = _grouped(group, lambda piece: _structure(piece.properties))
        separate = len(alike) > 1
        if separate and group[0].e:
            deformed = [p._replace(properties=element.of_deformation(p.properties)) for p in group]
            blocks.append(_block(element, ("deformation",), deformed))
        for subgroup in alike.values():
            companions = tuple(c for c in COMPANIONS if any(c in p.companions for p in subgroup))
            if not separate and subgroup[0].e:
                companions = ("deformation", *companions)
            if companions:
                blocks.append(_block(element, companions, subgroup))
    return tuple(f[0] for f in blocks), tuple(f[1] for f in blocks), tuple(f[2] for f in blocks)


def _source(companion: str, properties: dict[str, Any]) -> str:
    """Companion that computes another companion: the stiffness computes the damping of a material."""
    by_material = companion == "damping" and isinstance(properties.get("damping"), MaterialDamping)
    return "stiffness" if by_material else companion


def _structure(properties: dict[str, Any]) -> Any:
    """Everything that stacked elements must have in common, without their numbers and kinds of section.

    Varying sections are stacked only with sections of the same function, general ones only with each other, and
    sections of leaf springs only with their kind, since the deformations depend on the sides.
    """
    options = tuple(sorted((k, v) for k, v in properties.items() if is_option(v)))
    numbers = {k: v for k, v in properties.items() if not is_option(v) and k != "section"}
    if isinstance(section := properties.get("section"), Profile | General) or "clamped" in properties:
        numbers["section"] = section
    leaves, structure = jax.tree.flatten(numbers)
    return options, structure, tuple(np.shape(leaf) for leaf in leaves)


def _block(
    element: Element, companions: tuple[str, ...], members: list[_Piece]
) -> tuple[Block, dict[str, Any], tuple[str | None, ...]]:
    """Elements stacked; several kinds of sections become a tuple of stacks, with the elements in this order."""
    pieces = [piece for group in _grouped(members, _kind_of_section).values() for piece in group]
    if any(piece.properties.get("section") is not None for piece in pieces):
        # An element without section, among others with one, gets a section of zeros.
        pieces = [
            p._replace(properties={**p.properties, "section": p.properties["section"] or Rigidity()}) for p in pieces
        ]
    kinds = _grouped(pieces, _kind_of_section)
    ordered = [piece for group in kinds.values() for piece in group]
    x: Any = np.array([p.x for p in ordered], int)
    e: Any = np.array([p.e for p in ordered], int).reshape(len(ordered), -1)
    options = tuple(sorted((k, v) for k, v in ordered[0].properties.items() if is_option(v)))
    stacked = {}
    for name, value in ordered[0].properties.items():
        if name == "section":
            stacks = [_stack_trees([p.properties[name] for p in group]) for group in kinds.values()]
            stacked[name] = tuple(stacks) if len(stacks) > 1 else stacks[0]
        elif not is_option(value):
            stacked[name] = _stack_trees([p.properties[name] for p in ordered])
    has_resultants = "resultants" in companions
    stressed = tuple(p.name if has_resultants and "resultants" in p.companions else None for p in ordered)
    block = Block(element, companions, options, x, e, ordered[0].splits)
    return *with_meaning(block, stacked), stressed


def _grouped(pieces: Iterable[_Piece], key: Callable[[_Piece], Any]) -> dict[Any, list[_Piece]]:
    """Elements by a key, in order of first appearance."""
    groups: dict[Any, list[_Piece]] = {}
    for piece in pieces:
        groups.setdefault(key(piece), []).append(piece)
    return groups


def _kind_of_section(piece: _Piece) -> Any:
    return jax.tree.structure(piece.properties.get("section"))


def _stack_trees(trees: list[Any]) -> Any:
    leaves = [jax.tree.leaves(tree) for tree in trees]
    columns = [stack(list(column)) for column in zip(*leaves, strict=True)]
    return jax.tree.unflatten(jax.tree.structure(trees[0]), columns)


def _indices(roles: list[Role], dofs: list[int]) -> RoleIndices:
    def of(role: Role) -> Any:
        return np.array([i for i, r in enumerate(roles) if r is role], int)

    chosen: Any = np.array(dofs, int)
    return RoleIndices(of(Role.FIXED), of(Role.DEPENDENT), chosen, of(Role.PRESCRIBED))


def _sparse(entries: dict | None, size: int, index: Callable[[Any], int]) -> Any:
    """Vector with the given entries, or matrix with the given rows; None without entries."""
    if not entries:
        return None
    places, values = np.array([index(key) for key in entries], int), stack(list(entries.values()))
    if isinstance(values, np.ndarray):
        dense = np.zeros((size, *values.shape[1:]))
        dense[places] = values
        return dense
    return put(jnp.zeros((size, *values.shape[1:])), places, values)


def _loads(entries: dict, topology: Topology, index: Callable[[Any], int]) -> Loads:
    prescribed = entries.get("prescribed", {})
    chosen = {}
    for field, roles, kind in (("x", topology.x, "node"), ("e", topology.e, "element")):
        of_kind = {key: value for key, value in prescribed.items() if key[0] == kind}
        dense = _sparse(of_kind, roles.size, index)
        chosen[field] = None if dense is None else dense[np.asarray(roles.prescribed)]
    gravity = entries.get("gravity")
    return Loads(
        force=_sparse(entries.get("force"), topology.n_x, index),
        gravity=None if not gravity else stack(gravity["all"]),
        prestress=_sparse(entries.get("prestress"), topology.n_e, index),
        x=chosen["x"],
        e=chosen["e"],
        temperature=_sparse(
            {key: stack(row) for key, row in entries.get("temperature", {}).items()}, topology.n_e, index
        ),
    )
