"""A mechanism ready for analysis."""

from __future__ import annotations

import dataclasses
import difflib
import itertools
import os
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Array

from ..arguments import is_concrete, require_double_precision
from ..compilation.record import Record, static
from ..display import AT_MOST, Result, States, Summary, among, kind_of, listed, unit_of, unit_of_force
from ..errors import AnalysisError, ModelError
from ..results import RESULTS
from .by_name import TURNS, tilted_by, turn_of
from .properties import with_property
from .topology import Parameters, Role, RoleIndices, Topology

# Inputs that move held things, by order of their time derivative.
MOTIONS = ("displacement", "velocity", "acceleration")
# Quantities that are dual to coordinates, and what the units of rates have in addition.
ACTING = ("force", "moment", "reaction")
PER = {"velocity": "/s", "acceleration": "/s²"}


@dataclasses.dataclass(frozen=True)
class Entry:
    """Name of one coordinate or deformation.

    Attributes:
        of: Node or element.
        component: Number within it, from 1.
        symbol: Its sign, such as "x", "phi", "e2".
        kind: "position", "rotation" or "internal" for a coordinate, "deformation", or "norm" (not counted).
        name: Name of a deformation, such as "elongation", or "".
    """

    of: str
    component: int
    symbol: str
    kind: str
    name: str = ""

    def __str__(self) -> str:
        return f"{self.of}.{self.symbol}"


class Port(NamedTuple):
    """Node, axis, quantity and unit of an input or output.

    Attributes:
        node: Name of the node; empty for an element, and for a signal with parts.
        axis: "x", "y", "z", "phi", or "rx", "ry", "rz" about a global axis in space; empty otherwise.
        quantity: Quantity, as in :class:`Signal`.
        unit: SI unit; empty for a deformation, a stress resultant, and a signal with parts.
    """

    node: str = ""
    axis: str = ""
    quantity: str = ""
    unit: str = ""


@dataclasses.dataclass(frozen=True)
class Signal:
    """An input or output of the state-space model.

    Attributes:
        name: Its label.
        quantity: For an input "force", "moment" or "stress", or "displacement", "velocity" or "acceleration" of a FIXED
            or PRESCRIBED coordinate or deformation. For an output "position", "velocity", "acceleration", "reaction",
            "deformation", "deformation rate", "deformation acceleration" or "stress". For a rotation in space,
            "position", "velocity" and "acceleration" mean rotation vector, angular velocity and angular acceleration.
            For a signal with parts "actuator" or "sensor".
        index: Index in x or e; for a rotation in space, of its first Euler parameter; -1 for a signal with parts.
        axis: Axis 0, 1 or 2 of a rotation in space; None for a coordinate or a deformation.
        local: Whether the axis turns with the node.
        of_element: Whether the index is in e.
        held: Whether the coordinate or deformation is FIXED or PRESCRIBED.
        parts: Signals whose linear combination this is, with the weights in ``Parameters.weights``.
    """

    name: str
    quantity: str
    index: int
    axis: int | None = None
    local: bool = False
    of_element: bool = False
    held: bool = False
    parts: tuple["Signal", ...] = ()

    @property
    def terms(self) -> tuple["Signal", ...]:
        """Parts of the signal; a signal without parts is its only part."""
        return self.parts or (self,)

    @property
    def order(self) -> int | None:
        """0, 1 or 2 for an input that is a displacement, a velocity or an acceleration; otherwise None."""
        return MOTIONS.index(self.quantity) if self.held and self.quantity in MOTIONS else None

    def port(self, labels: "Labels") -> Port:
        """Node, axis, quantity and unit of the signal, as far as names determine them."""
        if self.index < 0 or self.of_element or self.quantity.startswith(("deformation", "stress")):
            return Port(quantity=self.quantity)
        entry = labels.x[self.index]
        if self.quantity in ACTING:
            turns = self.axis is not None or self.quantity == "moment"
            unit = "N m" if turns else unit_of_force(entry)
        else:
            unit = "rad" if self.axis is not None else unit_of(entry).replace("-", "")
            unit += PER.get(self.quantity, "") if unit else ""
        axis = entry.symbol if self.axis is None else "" if self.local else TURNS[self.axis]
        return Port(entry.of.removesuffix(".rotation"), axis, self.quantity, unit)

    def without_name(self) -> "Signal":
        """The signal without names, for compiled code."""
        return dataclasses.replace(self, name="", parts=tuple(part.without_name() for part in self.parts))


@dataclasses.dataclass(frozen=True)
class Labels:
    """Names, kept beside the numbers and outside compiled code.

    Attributes:
        x: Name of each coordinate, in order.
        e: Name of each deformation, in order.
        elements: Name, type and nodes of each element, in order of addition.
        inputs, outputs: Signals of the state-space model.
        dimension: 2 or 3.
        stressed: For each block of the topology, names of its elements in order; None for elements without section
            stresses.
        warm: Names of elements with a temperature.
        found: Degrees of freedom that ``build()`` found beside the named ones. They do not enter comparisons.
    """

    x: tuple[Entry, ...]
    e: tuple[Entry, ...]
    elements: tuple[tuple[str, str, tuple[str, ...]], ...]
    inputs: tuple[Signal, ...]
    outputs: tuple[Signal, ...]
    dimension: int
    stressed: tuple[tuple[str | None, ...], ...]
    warm: tuple[str, ...] = ()
    found: tuple[str, ...] = dataclasses.field(default=(), compare=False)

    def coordinates(self, node: str) -> list[int]:
        """Indices in x of a node, or of the rotation of a node as "name.rotation"."""
        return [i for i, entry in enumerate(self.x) if entry.of == node]

    def known(self, node: str) -> np.ndarray:
        """As :meth:`coordinates`, for a node that must exist. Raises KeyError: No such node."""
        indices = self.coordinates(node)
        if not indices:
            raise KeyError(f"no node '{node}' in this model{_instead(node, [entry.of for entry in self.x], 'node')}")
        return np.array(indices)

    def place(self, name: str) -> tuple[str, int] | None:
        """Place in "x" or "e" of a named coordinate or deformation; None for an unknown name.

        Names are "top.x", "top.phi" or "top.rotation.phi", "hinge.e2". "top.rx" means the angle of the hinge that turns
        or holds the rotation of a node in space about this axis.
        """
        owner, _, component = str(name).rpartition(".")
        meant = {str(name): 0, f"{owner}.rotation.{component}": 1, f"{turn_of(owner, component)}.e1": 2}
        matches = [
            (meant[text], kind, i)
            for kind in "xe"
            for i, entry in enumerate(getattr(self, kind))
            if entry.kind != "norm" and (text := str(entry)) in meant
        ]
        if matches:
            return min(matches)[1:]
        return ("e", self.e_places[name]) if name in self.e_places else None

    def names(self) -> list[str]:
        """Names of everything that can be driven or loaded: coordinates, rotations in space by axis, deformations."""
        names = []
        for entry in (*self.x, *self.e):
            if entry.symbol[0] == "l" and entry.kind == "rotation":
                symbols = TURNS if entry.component == 1 else ()
            else:
                symbols = () if entry.kind in ("norm", "internal") else (entry.symbol,)
            names += [f"{entry.of.removesuffix('.rotation')}.{symbol}" for symbol in symbols]
        return names

    def rotation_of(self, name: str) -> tuple[list[int], int] | None:
        """Euler parameters in x, and axis, of a name such as "top.rx"; None for another name."""
        owner, _, component = str(name).rpartition(".")
        if component not in TURNS or self.dimension != 3:
            return None
        indices = self.coordinates(f"{owner}.rotation") or self.coordinates(owner)
        return (indices, TURNS.index(component)) if indices and self.x[indices[0]].kind == "rotation" else None

    def holding(self, name: str) -> list[int]:
        """Return the indices in e of hinge deformations that hold a rotation such as "top.rx" if they are FIXED."""
        of, _, axis = name.rpartition(".")
        hinges = {turn_of(of, axis): 1}
        for other in TURNS:
            if other != axis:
                hinges[turn_of(of, other)] = 2 + tilted_by(turn_of(of, other)).index(axis)
        return [i for i, entry in enumerate(self.e) if hinges.get(entry.of) == entry.component]

    def parts(self, node: str) -> list[str]:
        """A node and its rotation, if they exist; for "name.rotation" the rotation. Raises KeyError: No such node."""
        parts = [part for part in (node, f"{node}.rotation") if self.coordinates(part)]
        if not parts:
            self.known(node)
        return parts

    @property
    def e_places(self) -> dict[str, int]:
        """Indices in e of deformations by label, such as "leaf.e4", and by name, as "leaf.elongation"."""
        entries = [(i, entry) for i, entry in enumerate(self.e) if entry.kind == "deformation"]
        return {str(entry): i for i, entry in entries} | {f"{e.of}.{e.name}": i for i, e in entries if e.name}

    def deformations(self, element: str, number: int | str | None = None) -> Any:
        """Indices in e of an element's deformations, or of one. Raises KeyError: No such element or deformation."""
        indices = [i for i, entry in enumerate(self.e) if entry.of == element and entry.kind != "norm"]
        if not indices:
            elements = [entry.of for entry in self.e if entry.kind != "norm"]
            raise KeyError(f"no element '{element}' in this model{_instead(element, elements, 'element')}")
        if number is None:
            return np.array(indices)
        for i in indices:
            if number in (self.e[i].component, self.e[i].symbol) or (number and number == self.e[i].name):
                return i
        names = ", ".join(f"{e.component} {e.name}" for i in indices if (e := self.e[i]).name)
        raise KeyError(
            f"element '{element}' has deformations 1 to {len(indices)}, not {number!r}{f': {names}' if names else ''}"
        )


class Model(Result, Record):
    """A checked mechanism: topology and parameters, with names.

    Attributes:
        topology: Structure.
        parameters: Numbers; differentiate and replace these.
        labels: Names.
    """

    topology: Topology
    parameters: Parameters
    labels: Labels = static()
    one_axis = "parameters.reference"

    def without_names(self) -> Model:
        """The mechanism without names, so that mechanisms with other names share compiled code."""
        labels = self.labels
        inputs, outputs = (tuple(s.without_name() for s in some) for some in (labels.inputs, labels.outputs))
        return dataclasses.replace(self, labels=Labels((), (), (), inputs, outputs, labels.dimension, ()))

    def with_property(self, path: str, values: Any, elements: Sequence[str] | None = None) -> Model:
        """Return the mechanism with other numbers for one property of its elements, without building it again.

        A thousand elements take as little time as one, also under ``jax.grad`` and in ``fm.tune``. The degrees of
        freedom and the undeformed mechanism stay as they were built.

        Args:
            path: Property, such as "section.thickness", "section.material.E" or "stiffness".
            values: One number per element, (elements,), or one number for all, () [the property's unit].
            elements: Names of the elements, in the order of the numbers. None: all elements with this property, in the
                order of ``labels.elements``.

        Raises:
            ModelError: An element or the property does not exist, the count of numbers is wrong, or ``build`` would
                refuse the numbers.
        """
        return dataclasses.replace(self, parameters=with_property(self, path, values, elements))

    @property
    def q_labels(self) -> list[str]:
        """Name of each degree of freedom, in the order of q."""
        t = self.topology
        return [str(self.labels.x[i]) for i in _list(t.x.dof)] + [str(self.labels.e[i]) for i in _list(t.e.dof)]

    def roles(self) -> tuple[list[Role], list[Role]]:
        """Role of every coordinate and every deformation, including unit norms."""
        return _roles(self.topology.x), _roles(self.topology.e)

    def signals(self) -> tuple[tuple[Signal, ...], tuple[Signal, ...]]:
        """Inputs and outputs, with a note whether their coordinates are constrained in the present roles."""
        constrained = None
        if is_concrete(self.topology):
            constrained = [
                {*_list(role_indices.fixed), *_list(role_indices.prescribed)}
                for role_indices in (self.topology.x, self.topology.e)
            ]

        def now(signal: Signal) -> Signal:
            if signal.parts:
                return dataclasses.replace(signal, parts=tuple(now(part) for part in signal.parts))
            return (
                signal
                if constrained is None
                else dataclasses.replace(signal, held=signal.index in constrained[signal.of_element])
            )

        return tuple(tuple(now(s) for s in some) for some in (self.labels.inputs, self.labels.outputs))  # type: ignore

    def counts(self) -> dict[str, int]:
        """Numbers of NDOF = NX - NXO - NEO: nx, ne, nxo, neo, ndof; tutorial WA 1239 (2012), eq. (2.13).

        A spatial rotation counts as 3 coordinates, a PRESCRIBED entry as a constraint.
        """
        constrained = (Role.FIXED, Role.PRESCRIBED)
        x_roles, e_roles = self.roles()
        entries = list(zip(self.labels.x, x_roles, strict=True))
        norms = sum(entry.kind == "norm" for entry in self.labels.e)
        # A rotation fixed as a whole loses its norm with its four parameters: 3 coordinates, 3 constraints.
        rotations = {entry.of for entry, role in entries if entry.symbol == "l0"}
        rotations -= {entry.of for entry, role in entries if entry.symbol[0] == "l" and role not in constrained}
        nx = len(entries) - sum(entry.symbol == "l0" for entry, _ in entries)
        nxo = sum(role in constrained for _, role in entries) - len(rotations)
        ne = len(e_roles) - norms
        neo = sum(r in constrained and n.kind != "norm" for n, r in zip(self.labels.e, e_roles, strict=True))
        return {"nx": nx, "ne": ne, "nxo": nxo, "neo": neo, "ndof": nx - nxo - neo}

    def overview(self) -> str:
        """Table of every coordinate and deformation with its role."""
        lines = [f"NDOF = NX - NXO - NEO = {'{nx} - {nxo} - {neo} = {ndof}'.format(**self.counts())}"]
        x_roles, e_roles = self.roles()
        lines.append(f"degrees of freedom: {self.topology.n_q}")
        for title, entries, roles in (("node", self.labels.x, x_roles), ("element", self.labels.e, e_roles)):
            pairs = [pair for pair in zip(entries, roles, strict=True) if pair[0].kind != "norm"]
            grouped: dict[str, list[str]] = {}
            for (owner, role), run in itertools.groupby(pairs, key=lambda pair: (pair[0].of, pair[1])):
                symbols = [entry.symbol for entry, _ in run]
                # A leaf spring has dozens of internal coordinates.
                named = [f"{symbols[0]} to {symbols[-1]}"] if len(symbols) > AT_MOST else symbols
                grouped.setdefault(owner, []).extend(f"{symbol} {role.value}" for symbol in named)
            wide = max([16, *(len(name) + 1 for name in grouped)])
            lines.append(f"{title:<{wide}}" + "components")
            lines += [f"{name:<{wide}}" + ", ".join(parts) for name, parts in grouped.items()]
        return "\n".join(lines)

    def states(self) -> States:
        """States to draw: the undeformed mechanism alone."""
        return States(self, self.parameters.reference)

    def summary(self) -> Summary:
        """Return the counts, and the names of the degrees of freedom."""
        names, t = self.labels, self.topology
        if len(names.x) != t.n_x:
            return super().summary()
        rows = {
            "elements": str(len(names.elements)),
            "nodes": str(len({entry.of for entry in names.x if entry.kind == "position"})),
            "degrees of freedom": f"{t.n_q}: {listed(self.q_labels)}" if t.n_q else "0",
            "NDOF = NX - NXO - NEO": "{ndof} = {nx} - {nxo} - {neo}".format(**self.counts()),
        }
        where = "the plane" if names.dimension == 2 else "space"
        return Summary(f"Model in {where}: {t.n_x} coordinates, {t.n_e} deformations", rows, "mechanism")


# Remedies for arguments of another class than Model.
_INSTEAD = {
    "Builder": "call its build() first",
    "SpacarModel": "call .builder.build() first",
    "LightResults": "give its .model",
    "Lean": "give its .model",
    "Linearization": (
        "give its .model. Damping of fm.damped belongs to the linearisation alone; to damp the model, damp its elements"
        " by fm.sections.damping_from_ratio"
    ),
    "Equilibrium": "give the model, or fm.linearize(model, ..) about the same loads if a linearisation is accepted",
    "Path": "give its .model, and at=path, step=-1 for its last state",
    "Motion": "give its .model, and at=motion, step=-1 for its last state",
    "str": "read a file by fm.read_spacar(path).builder.build()",
    "NoneType": "a function that builds a model ends with: return b.build()",
    "function": "call it, if it builds a model",
}


def as_model(given: Any, function: str) -> Model:
    """A model; other arguments are refused with a remedy.

    Raises:
        TypeError: The argument is no Model.
        RuntimeError: Double precision is off.
    """
    if isinstance(given, Model):
        require_double_precision()
        return given
    kind = type(given).__name__
    instead = _INSTEAD.get("str" if isinstance(given, str | os.PathLike) else kind, "build() of a Builder makes one")
    raise TypeError(f"fm.{function} takes a Model, as Builder.build() returns it, not {kind_of(given)}: {instead}.")


def as_known_model(given: Any, function: str, numbers: bool = True) -> Model:
    """As :func:`as_model`, for a model with known structure, and known numbers if ``numbers``.

    Raises:
        TypeError: The argument is no Model, or ``jax.jit`` traces its structure, or a derivative its numbers.
    """
    model = as_model(given, function)
    if numbers and not is_concrete(model):
        raise TypeError(
            f"fm.{function} takes a model of known numbers: call it outside jax.jit, jax.grad and jax.vmap."
        )
    if not is_concrete(model.topology):
        raise TypeError(
            f"fm.{function} takes a model of known structure. Within a function under jax.jit, build the model from"
            " dimensions or capture it, and do not pass it as an argument."
        )
    return model


def as_determined(given: Any, function: str) -> Model:
    """As :func:`as_model`, for a model that its degrees of freedom determine, for dense matrices.

    Raises:
        TypeError: The argument is no Model.
        ModelError: An unchecked model has more or fewer degrees of freedom.
        AnalysisError: out_of_memory: the machine cannot hold the dense matrices.
    """
    model = as_model(given, function)
    x, e = model.topology.x, model.topology.e
    missing = x.dependent.shape[0] - sum(indices.shape[0] for indices in (e.fixed, e.prescribed, e.dof))
    if missing:
        raise ModelError(
            f"fm.{function}: the {model.topology.n_q} degrees of freedom of this model, built with check=False, do not"
            f" determine it: {abs(missing)} {'more' if missing > 0 else 'fewer'} are needed. Build it with checks."
        )
    n, rows = model.topology.n_x, model.topology.n_e
    # Curvature, constraints of the DEPENDENT coordinates with factors, and Jacobian exist at the same time.
    needed, available = 8 * n * (3 * n + rows), memory()
    if needed > available:
        raise AnalysisError(
            RESULTS.out_of_memory.name,
            f"fm.{function}: dense matrices of {n} coordinates take {needed / 1e9:.3g} GB or more, but there are"
            f" {available / 1e9:.3g} GB. Use sparse matrices where possible (sparse=True, count=), or fewer elements.",
        )
    return model


def memory() -> float:
    """Memory of this machine [bytes]; infinite if unknown."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return float("inf")


def _instead(name: str, existing: list[str], kind: str) -> str:
    """End of a message on an unknown name: the nearest names, or some of the existing ones."""
    names = list(dict.fromkeys(existing))
    similar = difflib.get_close_matches(str(name), names, 3, 0.5)
    if similar:
        return f"; did you mean {' or '.join(map(repr, similar))}?"
    names = [name for name in names if not name.endswith((".rotation", ".internal", ".warping"))]
    return f"; it has {among(names)}" if names else f"; it has no {kind}"


def _list(indices: Array) -> list[int]:
    return np.asarray(indices).tolist()


def _roles(indices: RoleIndices) -> list[Role]:
    roles = [Role.DEPENDENT] * indices.size
    for role in Role:
        for i in _list(getattr(indices, role.value)):
            roles[i] = role
    return roles
