"""Named nodes and elements in, a checked Model out."""

from __future__ import annotations

import copy
import dataclasses
import difflib
from collections.abc import Sequence
from typing import Any

import jax
import numpy as np

from ..elements import planar, spatial
from ..elements.element import ALL, Element, as_element
from ..elements.nodes import ANGLE, POINT2, POINT3, ROTATION3, NodeKind
from ..elements.sections import Section
from ..errors import ModelError
from ..model.model import Model
from ..model.roles import Role
from .assemble import assemble, is_concrete, number_of_deformations, stack
from .carry import as_in, next_carried, note
from .dofs import complete

AXES = ("x", "y", "z")

# "node" or "element", its name, and the number of a coordinate or deformation from 1.
Key = tuple[str, str, int]


@dataclasses.dataclass
class Node:
    """A node: its kind, start coordinates and the role of each."""

    kind: NodeKind
    start: Any
    roles: list[Role]


@dataclasses.dataclass
class Member:
    """An element: its type, nodes, properties and the role of each deformation."""

    element: Element
    nodes: tuple[str, ...]
    properties: dict[str, Any]
    roles: list[Role]
    hidden: bool = False


class Builder:
    """Describe a mechanism by named nodes and elements.

    A node has a position; its rotation, named "name.rotation", exists once an element asks for it. Everything that is
    a number may be traced, so that a function that builds a model can be differentiated and batched. Checks of values
    run on concrete numbers only.

    Example:
        >>> b = Builder()
        >>> b.node("foot", (0, 0)); b.node("top", (0, 0.1))
        >>> b.add(planar.beam, "foot", "top", name="leaf", section=leaf)
        >>> b.fix("foot"); b.mass("top", 0.2)
        >>> model = b.build()

    Raises:
        RuntimeError: Double precision is off.
    """

    def __init__(self):
        if jax.dtypes.canonicalize_dtype(np.float64) != np.float64:
            raise RuntimeError(
                "flexmb needs double precision: a leaf spring is 1e5 times stiffer in tension than in bending."
                " Call flexmb.enable_x64() before building a model."
            )
        self.nodes: dict[str, Node] = {}
        self.members: dict[str, Member] = {}
        self.dofs: list[Key] = []
        self.loads: dict[str, dict[str, Any]] = {"initial": {}, "increment": {}}
        self.signals: dict[str, list[tuple[str, str, Key]]] = {"input": [], "output": []}
        self.starts: dict[Key, tuple[Any, Any]] = {}
        self.dimension: int | None = None
        self._clamped: set[str] = set()

    # -- nodes and elements ------------------------------------------------------------------------------------

    def node(self, name: str, position: Sequence[float]) -> str:
        """Add a node at a position.

        Args:
            name: Its name.
            position: Coordinates in the undeformed mechanism, (2,) in the plane or (3,) in space [m].

        Returns:
            The name.

        Raises:
            ModelError: The name is taken, or the position has another dimension than the rest or is not finite.
        """
        name = str(name)
        position = list(position)
        if len(position) not in (2, 3):
            raise ModelError(f"Node '{name}' must have 2 or 3 coordinates, but has {len(position)}.")
        kind = POINT2 if len(position) == 2 else POINT3
        self._new_node(name, kind, position)
        return name

    def rotation(self, name: str, start: Sequence[float] | None = None) -> str:
        """Add a rotation of its own, for a second body hinged at a position that already has one.

        Args:
            name: Its name.
            start: Angle (1,) or Euler parameters (4,) in the undeformed mechanism; by default unturned.

        Returns:
            The name.
        """
        kind = ANGLE if self._dimension_for(name) == 2 else ROTATION3
        self._new_node(str(name), kind, list(kind.start) if start is None else list(start))
        return str(name)

    def add(
        self,
        element: Any,
        *nodes: str,
        name: str | None = None,
        released: Sequence[int] | str | None = None,
        **properties: Any,
    ) -> str:
        """Add an element.

        Args:
            element: Element type, such as ``planar.beam``, or a bare deformation function.
            nodes: One name for each positional parameter of the element, or one for each end: a node that has a
                position stands for its rotation too where the next parameter asks for one.
            name: Its name; by default the type and a number.
            released: Numbers (from 1) of the deformations that may change, or "all"; the others are FIXED at zero.
                By default as the element type says: all of an elastic element, none of a rigid one. What an element
                only measures is released in any case.
            properties: What the element type asks for, such as ``section``.

        Returns:
            The name.

        Raises:
            ModelError: Unknown node, wrong number of nodes, missing or unknown property, deformation out of range,
                zero length, parallel y vector.
        """
        element = as_element(element)
        name = f"{element.name} {len(self.members) + 1}" if name is None else str(name)
        if name in self.members:
            raise ModelError(f"Element '{name}' is defined twice. Give each element its own name.")
        nodes = self._resolve(element, name, [str(n) for n in nodes])
        properties = self._complete(element, name, properties)
        references = [self.nodes[n].start for n in nodes]
        self._check_member(element, name, references, properties)
        n_e = number_of_deformations(element, properties)
        self.members[name] = Member(element, nodes, properties, [Role.FIXED] * n_e)
        usual = (ALL if element.is_elastic(properties) else ()) if element.released is None else element.released
        wanted = usual if released is None else released
        self.release(name, *(range(1, n_e + 1) if isinstance(wanted, str) else wanted), *element.measured)
        return name

    def release(self, element: str, *deformations: int) -> None:
        """Let deformations of an element change (DEPENDENT).

        Args:
            element: Name of the element.
            deformations: Numbers from 1.
        """
        for i in deformations:
            self._set_role(self._member(element), element, int(i), Role.DEPENDENT)

    # -- supports, degrees of freedom, mass, loads ---------------------------------------------------------------

    def fix(self, node: str, *components: str | int) -> None:
        """Hold coordinates at their start values.

        Args:
            node: Name of the node.
            components: Names ("x", "phi") or numbers from 1; "position" or "rotation" for all of that part. None:
                the whole node, its rotation included if it has or gets one.
        """
        if components in ((), ("position",), ("rotation",)):
            parts = [self._position(node) if node in self.nodes else self._unknown_node(node, "fix")]
            if components == ("rotation",):
                parts = [self._rotation_of(node)]
            elif not components:
                parts.append(f"{node}.rotation")
            for part in parts:
                if part not in self.nodes:
                    self._clamped.add(part)
                    continue
                for i in range(self.nodes[part].kind.size):
                    self._set_role(self.nodes[part], part, i + 1, Role.FIXED)
            return
        for part, i in (self._coordinate(node, c) for c in components):
            self._set_role(self.nodes[part], part, i, Role.FIXED)

    def dof(self, of: str, *components: str | int, kind: str | None = None) -> None:
        """Name degrees of freedom: coordinates of a node or deformations of an element, in the order of q.

        Coordinates come before deformations in q, each in the order given.

        Args:
            of: Name of a node or an element.
            components: Coordinates ("x", "phi" or numbers) or numbers of deformations, from 1.
            kind: "node" or "element", where both bear the name.
        """
        for component in components:
            key = self._entry(of, component, kind)
            if key in self.dofs:
                raise ModelError(f"'{of}.{component}' is named as a degree of freedom twice.")
            self._assign(of, component, Role.DOF, kind)
            self.dofs.append(key)

    def prescribe(
        self,
        of: str,
        component: str | int,
        value: float = 0.0,
        *,
        increment: bool = False,
        axis: Sequence[float] | None = None,
        tilt: str | None = None,
        kind: str | None = None,
    ) -> None:
        """Prescribe a coordinate's displacement from its start value, a node's rotation, or a deformation.

        A rotation is an angle that counts past half and full turns. In space it is that of a hinge named "turn of"
        the node, between a fixed rotation "frame of" the node and the node's own: its e1 is the angle, its stress
        resultant the moment that is needed.

        Args:
            of: Name of a node or an element.
            component: Coordinate, "rotation", or number of a deformation, from 1.
            value: Displacement, angle or deformation, () [m, rad].
            increment: Whether the value belongs to the incremental loads.
            axis: Of a rotation in space, (3,) along the global axes.
            tilt: Of a rotation in space: "fixed" (unless given) turns the node about the axis and no other way, "free"
                holds the angle about the axis alone.
            kind: "node" or "element", where both bear the name.
        """
        if component == "rotation" and kind != "element":
            of, component, kind = self._turned(str(of), axis, tilt)
        elif axis is not None or tilt is not None:
            raise ModelError(f"'{of}.{component}': only component \"rotation\" takes an axis or a tilt.")
        entry = self._entry(of, component, kind)
        self._check_finite(f"Prescribed value of '{of}'", value)
        if self._owner(entry).roles[entry[2] - 1] is not Role.PRESCRIBED:
            self._assign(of, component, Role.PRESCRIBED, kind)
        self._load("prescribed", increment)[entry] = value

    def start(
        self, of: str, component: str | int, value: float = 0.0, velocity: float = 0.0, *, kind: str | None = None
    ) -> None:
        """Set where a degree of freedom starts from in a simulation; it is named as one if none are.

        Args:
            of: Name of a node or an element.
            component: Coordinate, or number of a deformation, from 1.
            value: Displacement from the position given, or deformation, () [m, rad].
            velocity: Its rate, () [m/s, rad/s].
            kind: "node" or "element", where both bear the name.
        """
        for what, number in (("value", value), ("velocity", velocity)):
            self._check_finite(f"Start {what} of '{of}'", number)
        self.starts[self._entry(of, component, kind)] = (value, velocity)

    def mass(self, node: str, mass: Any, *, inertia: Any = None) -> None:
        """Put a lumped mass on a node, and optionally rotary inertia on its rotation.

        Args:
            node: Name of the node.
            mass: () [kg].
            inertia: In the plane () of either sign; in space (Ixx, Ixy, Ixz, Iyy, Iyz, Izz) about global axes, or the
                matrix of them [kg m^2].
        """
        if is_concrete(mass) and np.any(np.asarray(mass, float) < 0):
            raise ModelError(f"The mass on node '{node}' is {mass}, but it cannot be negative. Rotary inertia may be.")
        self._add_hidden("mass", self._position(node), mass=mass)
        if inertia is not None:
            self.inertia(node, inertia)

    def inertia(self, node: str, inertia: Any) -> None:
        """Put lumped rotary inertia on a node's rotation.

        Args:
            node: Name of the node or of a rotation.
            inertia: See :meth:`mass`.

        Raises:
            ModelError: Another number of values, or a matrix that is not symmetric.
        """
        rotation, shape = self._rotation_of(node), np.shape(inertia)
        if self.nodes[rotation].kind is ANGLE:
            if shape != ():
                raise ModelError(f"The inertia of node '{node}' must be one number in the plane, not of shape {shape}.")
        elif shape == (3, 3):
            if is_concrete(inertia) and not np.allclose(inertia, np.transpose(inertia), rtol=1e-9, atol=0):
                raise ModelError(f"The inertia of node '{node}' must be a symmetric matrix, not {inertia}.")
            inertia = stack([inertia[i][j] for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))])
        elif shape != (6,):
            raise ModelError(
                f"The inertia of node '{node}' must be (Ixx, Ixy, Ixz, Iyy, Iyz, Izz) or a matrix of three by three,"
                f" not of shape {shape}."
            )
        self._add_hidden("inertia", rotation, inertia=inertia)

    def force(self, node: str, force: Sequence[float], *, increment: bool = False, follower: bool = False) -> None:
        """Apply a constant force to a node.

        Args:
            node: Name of the node.
            force: Components along the global axes [N]; for a rotation: forces dual to its coordinates.
            increment: Whether the force belongs to the incremental loads.
            follower: Whether it turns with the node's rotation, from the direction given; it then has no potential.
        """
        part = str(node) if str(node) in self.nodes else self._unknown_node(str(node), "force")
        force, size = list(force), self.nodes[part].kind.size
        if len(force) > size:
            raise ModelError(f"Force on node '{part}' has {len(force)} components, but the node has {size}.")
        if follower:
            self._check_finite(f"Force on node '{part}'", force)
            if self.nodes[part].kind.part != "position" or len(force) != size:
                raise ModelError(f"A follower force on '{part}' needs a node with a position, and {size} components.")
            options = {"incremental": True} if increment else {}
            self._add_hidden("follower_force", part, self._rotation_of(part), force=stack(force), **options)
            return
        for i, value in enumerate(force):
            self._check_finite(f"Force on node '{part}'", value)
            forces = self._load("force", increment)
            key = ("node", part, i + 1)
            forces[key] = forces.get(key, 0.0) + value

    def moment(self, node: str, moment: Any, *, increment: bool = False, follower: bool = False) -> None:
        """Apply a constant moment to a node's rotation, about fixed axes or about axes that turn with it.

        Args:
            node: Name of the node or of a rotation.
            moment: () in the plane, (3,) about the global axes in space [N m].
            increment: Whether the moment belongs to the incremental loads.
            follower: Whether its axis turns with the rotation; in the plane there is no difference.
        """
        part = self._rotation_of(node)
        if self.nodes[part].kind is ANGLE:
            self.force(part, [moment] if np.ndim(moment) == 0 else moment, increment=increment)
        else:
            options = {"incremental": True} if increment else {}
            self._add_hidden("follower_moment" if follower else "moment", part, moment=moment, **options)

    def gravity(self, acceleration: Sequence[float], *, increment: bool = False) -> None:
        """Let gravity act on all mass.

        Args:
            acceleration: Components along the global axes [m/s^2].
            increment: Whether it belongs to the incremental loads.
        """
        acceleration = list(acceleration)
        if len(acceleration) != (self.dimension or len(acceleration)):
            raise ModelError(f"Gravity must have {self.dimension} components, but has {len(acceleration)}.")
        self._check_finite("Gravity", acceleration)
        self._load("gravity", increment)["all"] = acceleration

    def prestress(self, element: str, *values: float, increment: bool = False) -> None:
        """Add constant stress resultants to those of an element's stiffness.

        Args:
            element: Name of the element.
            values: From the first deformation on [N, N m].
            increment: Whether it belongs to the incremental loads.
        """
        for i, value in enumerate(values, 1):
            self._check_finite(f"Prestress of element '{element}'", value)
            self._load("prestress", increment)[self._entry(element, i, "element")] = value

    def strain(self, element: str, *values: float) -> None:
        """Set the deformations at which an element is free of stress.

        Args:
            element: Name of the element.
            values: From the first deformation on [m, rad].
        """
        for i, value in enumerate(values, 1):
            self._load("strain", False)[self._entry(element, i, "element")] = value

    # -- inputs and outputs -------------------------------------------------------------------------------------

    def input(self, of: str, component: str | int, *, name: str | None = None, kind: str | None = None) -> None:
        """Name an input of the state-space model: a force on a coordinate, or a stress in a deformation.

        Args:
            of: Name of a node or an element.
            component: Coordinate, or number of a deformation, from 1.
            name: Its label; by default made of the other arguments.
            kind: "node" or "element", where both bear the name.
        """
        entry = self._entry(of, component, kind)
        quantity = "stress" if entry[0] == "element" else "force"
        self.signals["input"].append((name or f"{quantity} {of}.{component}", quantity, entry))

    def output(
        self,
        of: str,
        component: str | int,
        quantity: str = "",
        *,
        name: str | None = None,
        kind: str | None = None,
    ) -> None:
        """Name an output of the state-space model.

        Args:
            of: Name of a node or an element.
            component: Coordinate, or number of a deformation, from 1.
            quantity: "position", "velocity" or "acceleration" of a coordinate; "deformation", "deformation rate",
                "deformation acceleration" or "stress" of a deformation. By default the first.
            name: Its label; by default made of the other arguments.
            kind: "node" or "element", where both bear the name.
        """
        entry = self._entry(of, component, kind)
        allowed = ("position", "velocity", "acceleration")
        if entry[0] == "element":
            allowed = ("deformation", "deformation rate", "deformation acceleration", "stress")
        quantity = quantity or allowed[0]
        if quantity not in allowed:
            raise ModelError(f"Output '{of}.{component}' must be one of {', '.join(allowed)}, not '{quantity}'.")
        self.signals["output"].append((name or f"{quantity} {of}.{component}", quantity, entry))

    # -- the model ----------------------------------------------------------------------------------------------

    def build(self, *, dofs: str = "auto", release: str = "none", check: bool = True) -> Model:
        """Make the model.

        Args:
            dofs: "auto" finds degrees of freedom where none are named; "named" takes those named and no others, but for
                the coefficients of spectral beams that they leave undetermined.
            release: "auto" releases deformations until no over-constraint is left.
            check: Whether to check counts and rank of the constraints; they can be checked on concrete numbers only.

        Returns:
            Model.

        Raises:
            ModelError: Nothing to analyse.
            MechanismError: Over- or under-constrained, counts that do not agree, or degrees of freedom that cannot
                move or do not determine the rest.
        """
        if not self.members:
            raise ModelError("The model has no elements. Add at least one.")
        strangers = [
            f"{of} {component}" for kind, of, component in self.starts if (kind, of, component) not in self.dofs
        ]
        if self.dofs and strangers:
            raise ModelError(
                f"Only degrees of freedom have start values, and {', '.join(strangers)} is none: name it with dof()."
            )
        model, before = assemble(self), next_carried()
        if not is_concrete(model.parameters.reference):
            if before is not None and (twin := as_in(self, before)) is not self:
                return note(assemble(twin))
            if not self.dofs and dofs == "auto":
                raise ModelError(
                    "Degrees of freedom cannot be found while numbers of the model are traced. Name them with dof();"
                    " an untraced build says which it finds in model.q_labels."
                )
            e, named = model.topology.e, model.topology.n_q
            # By shapes, since indices are traced too under jit: the constraint matrix must be square.
            missing = model.topology.x.dependent.shape[0] - sum(a.shape[0] for a in (e.fixed, e.prescribed, e.dof))
            if missing:
                raise ModelError(
                    f"NDOF = {named + missing}, but {named} degrees of freedom are named, and the rest cannot be found"
                    " while the model's geometry is traced. Name all that an untraced build says in model.q_labels."
                )
            return note(model)
        return note(complete(self, model, dofs, release) if check else model)

    def copy(self) -> Builder:
        """A builder with the same contents, to vary."""
        twin = copy.copy(self)
        for field in ("nodes", "members"):
            contents = {k: dataclasses.replace(v, roles=list(v.roles)) for k, v in getattr(self, field).items()}
            setattr(twin, field, contents)
        twin.dofs, twin._clamped, twin.starts = list(self.dofs), set(self._clamped), dict(self.starts)
        twin.loads = {k: {n: dict(v) for n, v in sets.items()} for k, sets in self.loads.items()}
        twin.signals = {k: list(v) for k, v in self.signals.items()}
        return twin

    # -- helpers ------------------------------------------------------------------------------------------------

    def _load(self, kind: str, increment: bool) -> dict:
        return self.loads["increment" if increment else "initial"].setdefault(kind, {})

    def _dimension_for(self, name: str) -> int:
        if self.dimension is None:
            raise ModelError(f"Node '{name}': add a node with a position first; it decides plane or space.")
        return self.dimension

    def _new_node(self, name: str, kind: NodeKind, start: list) -> None:
        if name in self.nodes:
            raise ModelError(f"Node '{name}' is defined twice. Give each node its own name.")
        if self.dimension is not None and kind.dimension != self.dimension:
            raise ModelError(
                f"Node '{name}' has {kind.size} coordinates, but the mechanism is"
                f" {'planar' if self.dimension == 2 else 'spatial'}."
            )
        for value in start:
            self._check_finite(f"Node '{name}'", value)
        self.dimension = kind.dimension
        role = Role.FIXED if name in self._clamped else Role.DEPENDENT
        self.nodes[name] = Node(kind, start, [role] * kind.size)

    def _turned(self, node: str, axis: Sequence[float] | None, tilt: str | None) -> tuple[str, str | int, str]:
        """What is prescribed in place of a node's rotation: the angle in the plane, that of a hinge in space."""
        part = self._rotation_of(node)
        if self.nodes[part].kind is ANGLE:
            if axis is not None or tilt is not None:
                raise ModelError(f"Rotation of node '{node}': in the plane it takes neither an axis nor a tilt.")
            return part, "phi", "node"
        if axis is None:
            raise ModelError(f"Rotation of node '{node}': in space it needs an axis, such as axis=(0, 0, 1).")
        if tilt not in (None, "fixed", "free"):
            raise ModelError(f"Rotation of node '{node}': tilt must be 'fixed' or 'free', not {tilt!r}.")
        node = part.removesuffix(".rotation")
        name, frame = f"turn of {node}", f"frame of {node}"
        if name not in self.members:
            held = [role.value for role in self.nodes[part].roles if role is not Role.DEPENDENT]
            if held:
                raise ModelError(f"The rotation of node '{node}' is {held[0]} already and cannot be prescribed too.")
            self.rotation(frame)
            self.fix(frame)
            self.add(spatial.hinge, frame, part, name=name, axis=axis, released=(2, 3) if tilt == "free" else ())
        known, roles = self.members[name].properties["axis"], self.members[name].roles
        other = is_concrete((known, list(axis))) and not np.allclose(known, np.asarray(axis, float))
        if other or (tilt is not None and (tilt == "free") is not (roles[1] is Role.DEPENDENT)):
            raise ModelError(f"Rotation of node '{node}': it is prescribed already, with another axis or tilt.")
        return name, 1, "element"

    def _check_finite(self, what: str, value: Any) -> None:
        if is_concrete(value) and not np.all(np.isfinite(np.asarray(value, float))):
            raise ModelError(f"{what} has a value that is not a finite number: {value}.")

    def _add_hidden(self, kind: str, *nodes: str, **properties: Any) -> None:
        node = nodes[0]
        element = getattr(planar if self.nodes[node].kind.dimension == 2 else spatial, kind)
        count = sum(name.startswith(f"{kind} {node}") for name in self.members)
        self.members[f"{kind} {node} {count + 1}"] = Member(
            element, nodes, self._complete(element, f"{kind} of {node}", properties), [], hidden=True
        )

    def _unknown_node(self, name: str, where: str) -> Any:
        near = difflib.get_close_matches(name, self.nodes, 1)
        hint = f" Did you mean '{near[0]}'?" if near else " Add it with node() first."
        raise ModelError(f"No node '{name}' ({where}).{hint}")

    def _position(self, node: str) -> str:
        node = str(node)
        return node if node in self.nodes else self._unknown_node(node, "position")

    def _rotation_of(self, node: str) -> str:
        """Name of a node's rotation, which is made if it is not there yet."""
        node = str(node)
        if node in self.nodes and self.nodes[node].kind.part == "rotation":
            return node
        if f"{node}.rotation" not in self.nodes:
            if node not in self.nodes:
                self._unknown_node(node, "rotation")
            self.rotation(f"{node}.rotation")
        return f"{node}.rotation"

    def _resolve(self, element: Element, name: str, nodes: list[str]) -> tuple[str, ...]:
        """One node for each positional parameter of an element."""
        kinds = [(p, k) for p, k in element.nodes.items() if k.part != "internal"]
        expected = ", ".join(f"{p} ({k.part})" for p, k in kinds)
        wrong = ModelError(
            f"Element '{name}' ({element.name}) joins {len(kinds)} nodes: {expected}. Give one name for each, or one"
            f" for each end; got {len(nodes)}: {', '.join(nodes) or 'none'}."
        )
        waiting = list(nodes) if len(nodes) == len(kinds) else None
        found: list[str] = []
        source, used = iter(nodes), set()
        current = None
        for parameter, kind in kinds:
            if waiting is not None:
                current = waiting.pop(0)
            elif current is None or self._part_kind(current, kind) is None or kind.part in used:
                current, used = next(source, None), set()
                if current is None:
                    raise wrong
            used.add(kind.part)
            if current not in self.nodes and not current.endswith(".rotation"):
                self._unknown_node(current, f"element '{name}', {parameter}")
            part = self._part_kind(current, kind)
            if part is None:
                raise wrong
            if kind.part == "rotation":
                part = self._rotation_of(current)
            if self.nodes[part].kind.dimension != kind.dimension:
                raise ModelError(
                    f"Element '{name}' ({element.name}) is {'planar' if kind.dimension == 2 else 'spatial'}, but node"
                    f" '{part}' is not."
                )
            found.append(part)
        if waiting is None and next(source, None) is not None:
            raise wrong
        own = [k for k in element.nodes.values() if k.part == "internal"]
        return tuple(found + [self._internal(name, kind) for kind in own])

    def _internal(self, element: str, kind: NodeKind) -> str:
        """Node of the coordinates that an element owns; an element owns one such node at most, its last."""
        node = f"{element}.internal"
        self._new_node(node, kind, list(kind.start))
        return node

    def _part_kind(self, node: str, kind: NodeKind) -> str | None:
        """Whether a name can stand for a node of this kind."""
        if node not in self.nodes:
            return node if kind.part == "rotation" and node.endswith(".rotation") else None
        own = self.nodes[node].kind.part
        return node if own == kind.part or (own == "position" and kind.part == "rotation") else None

    def _complete(self, element: Element, name: str, properties: dict[str, Any]) -> dict[str, Any]:
        """Properties with defaults filled in, checked for names and finiteness."""
        known = element.properties
        for given in properties:
            if given not in known and given != "incremental":
                raise ModelError(
                    f"Element '{name}' ({element.name}) has no property '{given}'. It takes:"
                    f" {', '.join(known) or 'none'}."
                )
        complete = {k: stack(v) if isinstance(v, list | tuple) else v for k, v in properties.items()}
        # Stiffness, damping and mass may be left out; a law is what its element is for.
        needed = {
            n for f in (element.deformation, element.law) for n in element.arguments(f, dict.fromkeys(known, 0)) or {}
        }
        for wanted, parameter in known.items():
            if wanted in complete:
                continue
            if parameter.default is not parameter.empty:
                complete[wanted] = parameter.default
            elif wanted in needed:
                raise ModelError(f"Element '{name}' ({element.name}) needs the property '{wanted}'.")
            else:
                complete[wanted] = None
        for wanted, value in complete.items():
            for leaf in jax.tree.leaves(value):
                if not isinstance(leaf, str):
                    self._check_finite(f"Property '{wanted}' of element '{name}'", leaf)
            if isinstance(value, Section) and is_concrete(value):
                for fault in value.faults():
                    raise ModelError(f"The section of element '{name}' has {fault}.")
        return complete

    def _check_member(self, element: Element, name: str, references: list, properties: dict) -> None:
        if element.check is None or not is_concrete((references, properties)):
            return
        ref = element.reference([np.asarray(r, float) for r in references])
        for fault in element.check(ref=ref, **(element.arguments(element.check, properties) or {})):
            raise ModelError(f"Element '{name}' {fault}.")

    def _member(self, name: str) -> Member:
        name = str(name)
        if name not in self.members or self.members[name].hidden:
            shown = [n for n, m in self.members.items() if not m.hidden]
            near = difflib.get_close_matches(name, shown, 1)
            raise ModelError(f"No element '{name}'." + (f" Did you mean '{near[0]}'?" if near else ""))
        return self.members[name]

    def _owner(self, key: Key) -> Node | Member:
        return (self.members if key[0] == "element" else self.nodes)[key[1]]

    def _coordinate(self, node: str, component: str | int) -> tuple[str, int]:
        """Node and number of a coordinate named by a letter or a number."""
        part = node = str(node)
        if isinstance(component, str) and not component.isdigit():
            if node in self.nodes and self.nodes[node].kind.part == "position" and component not in AXES:
                part = self._rotation_of(node)
            if part not in self.nodes:
                self._unknown_node(part, f"coordinate {component}")
            names = self.nodes[part].kind.components
            if component not in names:
                raise ModelError(f"Node '{part}' has no coordinate '{component}'. It has: {', '.join(names)}.")
            return part, names.index(component) + 1
        if part not in self.nodes:
            self._unknown_node(part, f"coordinate {component}")
        if not 1 <= int(component) <= self.nodes[part].kind.size:
            raise ModelError(f"Node '{part}' has coordinates 1 to {self.nodes[part].kind.size}, not {component}.")
        return part, int(component)

    def _entry(self, of: str, component: str | int, kind: str | None = None) -> Key:
        """Kind and name of the owner, and number, of a coordinate or a deformation."""
        of = str(of)
        is_element = of in self.members and not self.members[of].hidden
        if kind not in (None, "node", "element"):
            raise ModelError(f"Argument `kind` must be 'node' or 'element', not {kind!r}.")
        if kind is None and is_element and of in self.nodes:
            raise ModelError(
                f'\'{of}\' is the name of a node and of an element: say which with kind="node" or "element".'
            )
        if kind == "element" or (kind is None and is_element):
            self._member(of)
            count = len(self.members[of].roles)
            if not str(component).isdigit() or not 1 <= int(component) <= count:
                raise ModelError(f"Element '{of}' has deformations 1 to {count}, not {component}.")
            return "element", of, int(component)
        return "node", *self._coordinate(of, component)

    def _assign(self, of: str, component: str | int, role: Role, kind: str | None) -> None:
        key = self._entry(of, component, kind)
        self._set_role(self._owner(key), key[1], key[2], role)

    def _set_role(self, owner: Node | Member, name: str, number: int, role: Role) -> None:
        if not 1 <= number <= len(owner.roles):
            raise ModelError(f"Element '{name}' has deformations 1 to {len(owner.roles)}, not {number}.")
        present = owner.roles[number - 1]
        free = (Role.DEPENDENT,) if isinstance(owner, Node) else (Role.FIXED, Role.DEPENDENT)
        if present is not role and present not in free:
            what = "Coordinate" if isinstance(owner, Node) else "Deformation"
            raise ModelError(f"{what} {number} of '{name}' is {present.value} already and cannot be {role.value} too.")
        owner.roles[number - 1] = role
