"""Named nodes and elements in, a checked Model out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import jax.core
import numpy as np

from ..arguments import (
    as_floats,
    as_known,
    check_choice,
    check_flag,
    check_numbers,
    copied,
    holds,
    is_concrete,
    nan_if_refused,
    require_double_precision,
    short_repr,
)
from ..compilation.compile import unguarded
from ..elements import planar, spatial
from ..elements.element import COMPANIONS, Element
from ..elements.element_text import deformations_of
from ..elements.nodes import ANGLE, POINT2, POINT3, ROTATION3, WARPING
from ..errors import ModelError
from ..mechanics.deformation import in_undeformed
from ..model.by_name import TURN_OF, TURNS, frame_of, turn_of
from ..model.model import MOTIONS, Model
from ..model.topology import Role
from ..numerical_limits import TEN_DIGITS
from .assemble import assemble, stack
from .calls import records_call
from .carry import as_in, collect_model, next_carried, note_builder
from .clamps import with_clamps
from .curved_leaves import warn_of_curved_leaves
from .description import Description, Key, Member, NamedSignal, turn_about
from .dofs import check_inputs, complete_model, with_started
from .ends_in_line import nan_if_not_stiff, warn_of_ends, with_steps
from .given import name_text, nonempty_arguments, number_list, released_in
from .holes import check_holes
from .idle import warn_of_idle
from .mistaken_units import warn_of_lengths
from .plain_beams import warn_of_plain_beams
from .properties import complete_properties, element_type, number_of_deformations, with_material_damping, with_options
from .sound import nan_if_impossible
from .step import body_of_step

# Quantities of inputs with a force, of outputs at coordinates and rotations, and of outputs at deformations.
FORCES = ("force", "moment", "stress")
MEASURED = ("position", "velocity", "acceleration", "reaction")
STRAINED = ("deformation", "deformation rate", "deformation acceleration", "stress")


class Builder(Description):
    """Describe a mechanism by named nodes and elements.

    A node has a position. If an element needs the rotation of a node, flexmb adds it and names it "name.rotation". JAX
    may trace all numbers (``jax.grad``, ``jax.vmap``). flexmb checks values unless they are traced. Repeated forces,
    moments, masses and bodies add up. For prescribed motions, gravity, prestress, strains, temperatures and start
    values, the last value replaces the earlier values.

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
        require_double_precision()
        super().__init__()

    # -- nodes and elements ------------------------------------------------------------------------------------

    @records_call
    def node(self, name: str, position: Sequence[float]) -> str:
        """Add a node at a position.

        Args:
            name: Its name.
            position: Coordinates in the undeformed mechanism, (2,) in the plane or (3,) in space [m].

        Returns:
            The name.

        Raises:
            ModelError: The name exists, or the position is not finite or differs in dimension from the other nodes.
        """
        name = name_text("A node", name)
        if name.endswith(".rotation"):
            raise ModelError(
                f"Node '{name}' has a name that is reserved for the rotation of a node: add a rotation with rotation()."
            )
        position = number_list(f"Node '{name}'", position)
        if len(position) not in (2, 3):
            raise ModelError(f"Node '{name}' must have 2 or 3 coordinates, but has {len(position)}.")
        kind = POINT2 if len(position) == 2 else POINT3
        self._new_node(name, kind, position)
        return name

    @records_call
    def rotation(self, name: str, start: Sequence[float] | None = None) -> str:
        """Add a separate rotation for a second body at a node, which is hinged to the body of that node.

        Args:
            name: Its name.
            start: Angle (1,) or Euler parameters (4,) in the undeformed mechanism; by default no rotation.

        Returns:
            The name.

        Raises:
            ModelError: The name exists, there is no node with a position yet, or ``start`` is no rotation.
        """
        name = name_text("A rotation", name)
        kind = ANGLE if self._dimension_for(name) == 2 else ROTATION3
        start_values = list(kind.start) if start is None else number_list(f"Start of rotation '{name}'", start)
        self._new_node(name, kind, start_values)
        return name

    @records_call
    def warping(self, name: str) -> str:
        """Add a separate warping coordinate, for beams that do not share the warping of their node.

        Args:
            name: Its name. Use it in ``add`` as a node of an element with warping.

        Returns:
            The name.

        Raises:
            ModelError: The name exists, or there is no node with a position in space yet.
        """
        name = name_text("A warping", name)
        self._dimension_for(name)
        self._new_node(name, WARPING, list(WARPING.start))
        return name

    @records_call
    @unguarded
    def add(
        self,
        element: Any,
        *nodes: str,
        name: str | None = None,
        released: Sequence[int | str] | str | None = None,
        **properties: Any,
    ) -> str:
        """Add an element.

        Args:
            element: Element type, such as ``planar.beam``, or a bare deformation function.
            nodes: One name for each end, or one name for each positional parameter of the element. The name of an end
                refers to its position, and to its rotation and warping if the element needs them.
            name: Its name; by default the type and a number.
            released: Names or numbers (from 1) of the deformations that may change, or "all". The others are FIXED, at
                zero or at their thermal value. The name of a strain field releases all of its coefficients. By default
                all deformations of an elastic element are released, and none of a rigid element. The closure of a
                spectral beam is released by its name only. Deformations that are only measured (turns of gears and
                belts, warping) are always released.
            properties: Properties of the element type, such as ``section``, and its options, such as ``order``.

        Returns:
            The name.

        Raises:
            ModelError: A node is unknown, the number of nodes is wrong, a property is missing, unknown or of the wrong
                kind, a deformation has no such name or number, a length is zero, a y vector is parallel to its element,
                or the functions of an element type do not fit together.
        """
        element = element_type(element)
        name = self._free_name(element.name) if name is None else name_text("An element", name)
        if name in self.members:
            raise ModelError(f"Element '{name}' is defined twice. Give each element its own name.")
        element, properties = with_options(
            element, name, {key: copied(as_known(value)) for key, value in properties.items()}
        )
        properties = complete_properties(element, name, properties)
        n_e = number_of_deformations(element, name, properties)
        companions = [c for c in (getattr(element, kind) for kind in COMPANIONS) if c is not None]
        if not n_e and all(element.arguments(c, properties) is None for c in companions):
            needed = ", ".join(repr(key) for c in companions for key in element.wanted(c)) or "a companion"
            raise ModelError(f"Element '{name}' ({element.name}) has no effect without the property {needed}.")
        roles = [Role.FIXED] * n_e
        usual = element.freed(properties)
        for i in (*released_in(name, usual if released is None else released, element, n_e), *element.measured):
            roles[i - 1] = Role.DEPENDENT
        resolved = self._resolve(element, name, [str(n) for n in nodes])
        kinds = list(element.nodes.values())
        starts = [self.nodes[n].start if n in self.nodes else k.start for n, k in zip(resolved, kinds, strict=True)]
        self._check_member(element, name, starts, properties)
        # Nodes are made last, so that a refused element leaves nothing behind.
        for node, kind in zip(resolved, kinds, strict=True):
            if node not in self.nodes:
                self._new_node(node, kind, list(kind.start))
        self.members[name] = Member(element, resolved, with_material_damping(element, properties), roles)
        return name

    # -- supports, degrees of freedom, mass, loads ---------------------------------------------------------------

    @records_call
    def fix(self, node: str, *components: str | int) -> None:
        """Fix coordinates at their start values: a support.

        Args:
            node: Name of the node.
            components: Names ("x", "phi") or numbers from 1; "position" or "rotation" for all coordinates of that part;
                in space "rx", "ry" or "rz", the angle about this global axis (see :meth:`prescribe`). Without
                components: the whole node, and its rotation if a later element adds one.
        """
        node, word = str(node), components[0] if len(components) == 1 else None
        if components and not (isinstance(word, str) and word in ("position", "rotation")):
            if self.dimension == 3 and set(TURNS).issubset(components):
                self.fix(node, "rotation")
            keys = [self._entry(node, c, "node") for c in components]
            self._set_roles(keys, Role.FIXED)
            part = self._rotation_name(node) if any(key[0] == "element" for key in keys) else ""
            if part and all(self._role(turn_about(self, part, i)) is Role.FIXED for i in range(3)):
                self.fix(node, "rotation")
            elif part:
                self._measure_third(part)
            return
        if node not in self.nodes:
            self._unknown_node(node, "fix")
        if word == "rotation":
            parts = [self._rotation_name(node)]
        else:
            parts = [self._position(node)] if word == "position" else [node, f"{node}.rotation"]
        existing = [part for part in parts if part in self.nodes or word == "rotation"]
        self._set_roles([("node", p, i + 1) for p in existing for i in range(self._kind_of(p).size)], Role.FIXED)
        for name, member in self.members.items():
            # A rotation FIXED as a whole replaces one that is FIXED about an axis.
            if name.startswith(TURN_OF) and member.nodes[-1] in existing and member.roles[0] is Role.FIXED:
                member.roles[0] = Role.DEPENDENT
        self._clamped.update(part for part in parts if part not in existing)

    @records_call
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

        Frequencies, buckling and compliance belong to the mechanism with this motion locked.

        A rotation is an angle that counts past half and full turns. In space it is the angle about an axis, and the
        node may turn about other axes. flexmb adds a FIXED rotation, "frame of c", and a hinge. The hinge joins the
        frame to the rotation of node "c", and measures the angle: its deformation 1. It is named "turn of c"; for a
        global axis, "turn of c.rx". ``reaction`` and ``force_needed`` of the node return the moment that turns the
        node; the stress resultant of the hinge has the opposite sign.

        Args:
            of: Name of a node or an element.
            component: Coordinate, "rotation", or name or number (from 1) of a deformation; in space also "rx", "ry" or
                "rz", the angle about this global axis.
            value: Displacement, angle or deformation, () [m, rad].
            increment: Whether the value belongs to the incremental loads.
            axis: Axis of "rotation" in space, (3,) along the global axes.
            tilt: For "rotation" in space: with "free" (default) the node may also turn about other axes, with "fixed"
                it turns about the axis only.
            kind: "node" or "element", if both have the name.

        Source:
            THEORY.md 2, eq. (2.17): the angle, and the tilts that are free.
        """
        check_flag("increment", increment, ModelError)
        check_numbers(f"Prescribed value of '{of}'", value, (), ModelError)
        self._check_kind(kind)
        if isinstance(component, str) and component == "rotation" and kind != "element":
            entry = self._turned(str(of), axis, tilt)
        elif axis is not None or tilt is not None:
            raise ModelError(f"'{of}.{component}': only component \"rotation\" takes an axis or a tilt.")
        else:
            entry = self._entry_to_free(of, component, kind)
        self._set_roles([entry], Role.PRESCRIBED)
        self._load("prescribed", increment)[entry] = copied(value)

    @records_call
    def start(
        self, of: str, component: str | int, value: float = 0.0, velocity: float = 0.0, *, kind: str | None = None
    ) -> None:
        """Set the start value of a degree of freedom in a simulation.

        If no degrees of freedom are named, the coordinate or deformation becomes a degree of freedom. A degree of
        freedom that a trajectory drives starts at this value too. All other coordinates follow.

        Args:
            of: Name of a node or an element.
            component: Coordinate, or name or number (from 1) of a deformation; in space also "rx", "ry" or "rz", as for
                :meth:`prescribe`.
            value: Displacement from the given position, or deformation, () [m, rad].
            velocity: Its rate, () [m/s, rad/s].
            kind: "node" or "element", if both have the name.
        """
        for quantity, number in (("value", value), ("velocity", velocity)):
            check_numbers(f"Start {quantity} of '{of}'", number, (), ModelError)
        entry = self._entry(of, component, kind)
        self._owner(entry)
        self.starts[entry] = copied((value, velocity))

    @records_call
    def mass(self, node: str, mass: Any, *, inertia: Any = None) -> None:
        """Put a lumped mass on a node, and optionally rotary inertia on its rotation.

        Args:
            node: Name of the node.
            mass: Mass, () [kg].
            inertia: In the plane (), of either sign; in space (Ixx, Ixy, Ixz, Iyy, Iyz, Izz) about global axes, or
                their matrix [kg m^2].
        """
        part = self._position(node)
        check_numbers(f"The mass on node '{node}'", mass, (), ModelError)
        if is_concrete(mass) and np.asarray(mass) < 0:
            raise ModelError(f"The mass on node '{node}' is {mass}, but it cannot be negative. Rotary inertia may be.")
        rotary = None if inertia is None else self._inertia(node, inertia)
        self._add_hidden("mass", part, mass=mass)
        if rotary is not None:
            self._add_hidden("inertia", rotary[0], inertia=rotary[1])

    @records_call
    def inertia(self, node: str, inertia: Any) -> None:
        """Put lumped rotary inertia on a node's rotation.

        Args:
            node: Name of the node or of a rotation.
            inertia: See :meth:`mass`.

        Raises:
            ModelError: The number of values is wrong, or the matrix is not symmetric.
        """
        rotation, checked_inertia = self._inertia(node, inertia)
        self._add_hidden("inertia", rotation, inertia=checked_inertia)

    @records_call
    @unguarded
    def body(
        self,
        node: str,
        mass: Any = None,
        *,
        center: Any = None,
        inertia: Any = None,
        step: Any = None,
        material: Any = None,
        at: Any = None,
    ) -> None:
        """Fix a body to a node and its rotation: from numbers, or from a STEP file.

        Gravity acts at its centre of mass. Bodies and masses on one node add up.

        Args:
            node: Name of the node.
            mass: Mass, () [kg]; for a STEP file, volume times density.
            center: Centre of mass from the node, along global axes of the undeformed mechanism, (2,) or (3,) [m]; by
                default the node.
            inertia: About the centre of mass, as for :meth:`mass`, in the plane () [kg m^2]; by default zero.
            step: Path of a STEP file in any units, whose solids are the body. The axes of the file are the global axes,
                in the plane x and y. Needs build123d: pip install 'flexmb[cad]'.
            material: With ``step``: a Material with a density, or a density, () [kg/m^3].
            at: With ``step``: position of the origin of the file from the node, (2,) or (3,) [m]; by default the node.

        Raises:
            ModelError: The mass is not positive. A principal moment of inertia is negative, or larger than the sum of
                the others. Numbers are given beside a STEP file. The file is missing or has no solids.
            ImportError: build123d is not installed.

        Source:
            THEORY.md 3, its table.
        """
        part, rotation = self._position(node), self._rotation_name(str(node))
        subject, dimension = f"The body on node '{node}'", self.dimension or 2
        if step is not None:
            if beside := [n for n, v in (("mass", mass), ("center", center), ("inertia", inertia)) if v is not None]:
                raise ModelError(
                    f"{subject}: a STEP file determines its {' and '.join(beside)}; leave out one of them."
                )
            mass, center, inertia = body_of_step(subject, step, material, at, dimension)
        elif extra := [n for n, v in (("material", material), ("at", at)) if v is not None]:
            raise ModelError(f"{subject}: {' and '.join(extra)} needs a STEP file: give step= too.")
        if mass is None:
            raise ModelError(f"{subject} needs a mass [kg], or a STEP file and its material.")
        center = [0.0] * dimension if center is None else center
        inertia = (0.0 if dimension == 2 else [0.0] * 6) if inertia is None else inertia
        check_numbers(f"{subject}: its mass", mass, (), ModelError)
        check_numbers(f"{subject}: its center", center, (dimension,), ModelError)
        properties = {"mass": mass, "center": center, "inertia": self._inertia(node, inertia)[1]}
        if is_concrete((mass, properties["inertia"])):
            check: Any = (planar.body if dimension == 2 else spatial.body).check
            for fault in check(ref=None, mass=mass, inertia=properties["inertia"]):
                raise ModelError(f"{subject} {fault}.")
        self._add_hidden("body", part, rotation, **properties)

    def _inertia(self, node: str, inertia: Any) -> tuple[str, Any]:
        """Name of a node's rotation, and a copy of its inertia, checked."""
        rotation, inertia = self._rotation_name(str(node)), copied(inertia)
        check_numbers(f"The inertia of node '{node}'", inertia, fault=ModelError)
        shape = np.shape(stack(inertia)) if isinstance(inertia, list | tuple) else np.shape(inertia)
        if self._kind_of(rotation) is ANGLE:
            if shape != ():
                raise ModelError(f"The inertia of node '{node}' must be one number in the plane, not of shape {shape}.")
        elif shape == (3, 3):
            matrix = as_floats(inertia)
            with nan_if_refused() as marked:
                if not holds(abs(matrix - matrix.T) <= TEN_DIGITS * abs(matrix).max()):
                    raise ModelError(f"The inertia of node '{node}' must be a symmetric matrix, not {inertia}.")
                inertia = marked(stack([inertia[i][j] for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))]))
        elif shape != (6,):
            raise ModelError(
                f"The inertia of node '{node}' must be (Ixx, Ixy, Ixz, Iyy, Iyz, Izz) or a matrix of three by three,"
                f" not of shape {shape}."
            )
        return rotation, inertia

    @records_call
    def force(self, node: str, force: Sequence[float], *, increment: bool = False, follower: bool = False) -> None:
        """Apply a constant force to a node.

        Args:
            node: Name of the node.
            force: Components along the global axes [N]. On a rotation: generalised forces, one for each of its
                coordinates. On the internal coordinates of an element: generalised forces, from the first coordinate
                on. The work is the generalised force times the change of its coordinate.
            increment: Whether the force belongs to the incremental loads.
            follower: Whether the force turns with the node's rotation; it then has no potential.
        """
        part = str(node) if str(node) in self.nodes else self._unknown_node(str(node), "force")
        check_flag("increment", increment, ModelError)
        check_flag("follower", follower, ModelError)
        force, kind = number_list(f"Force on node '{part}'", force), self.nodes[part].kind
        if len(force) > kind.size or (len(force) < kind.size and kind.part != "internal"):
            raise ModelError(f"Force on node '{part}' has {len(force)} components, but the node has {kind.size}.")
        if follower:
            if kind.part != "position":
                raise ModelError(f"A follower force on '{part}' needs a node with a position.")
            options = {"incremental": True} if increment else {}
            self._add_hidden("follower_force", part, self._rotation_name(part), force=stack(force), **options)
            return
        forces = self._load("force", increment)
        for i, value in enumerate(force):
            key = ("node", part, i + 1)
            forces[key] = forces.get(key, 0.0) + value

    @records_call
    def moment(self, node: str, moment: Any, *, increment: bool = False, follower: bool = False) -> None:
        """Apply a constant moment to a node's rotation, about fixed axes or about axes that turn with it.

        Args:
            node: Name of the node or of a rotation.
            moment: () in the plane, (3,) about the global axes in space [N m].
            increment: Whether the moment belongs to the incremental loads.
            follower: Whether its axis turns with the rotation; this makes no difference in the plane.
        """
        part = self._rotation_name(str(node))
        check_flag("increment", increment, ModelError)
        check_flag("follower", follower, ModelError)
        flat = self._kind_of(part) is ANGLE
        expected = "one number in the plane" if flat else "three numbers in space"
        components = self._numbers_of(f"Moment on node '{node}'", moment, (1,) if flat else (3,), expected)
        if flat:
            self._owner(("node", part, 1))
            self.force(part, components, increment=increment)
        else:
            options = {"incremental": True} if increment else {}
            self._add_hidden("follower_moment" if follower else "moment", part, moment=moment, **options)

    @records_call
    def gravity(self, acceleration: Sequence[float], *, increment: bool = False) -> None:
        """Let gravity act on all mass; a second call replaces the first.

        Args:
            acceleration: Components along the global axes [m/s^2].
            increment: Whether it belongs to the incremental loads.
        """
        check_flag("increment", increment, ModelError)
        acceleration = number_list("Gravity", acceleration)
        self._check_gravity(acceleration)
        self._load("gravity", increment)["all"] = acceleration

    @records_call
    def prestress(self, element: str, *values: float, increment: bool = False, **named: float) -> None:
        """Add constant stress resultants to the elastic stress resultants; a second call replaces the first.

        Example:
            >>> b.prestress("wire", elongation=50.0)

        Args:
            element: Name of the element.
            values: Values from the first deformation on [N, N m].
            increment: Whether it belongs to the incremental loads.
            named: Values by name of the deformation; for a strain field its mean [N, N m].

        Raises:
            ModelError: A deformation is unknown or given twice, or belongs to the closure of a spectral beam, where
                stress has no effect.
        """
        check_flag("increment", increment, ModelError)
        self._load("prestress", increment).update(self._values("Prestress", element, values, named))

    @records_call
    def strain(self, element: str, *values: float, **named: float) -> None:
        """Set the deformations at which an element is free of stress; a second call replaces the first.

        Example:
            >>> b.strain("leaf", elongation=1e-6)

        Args:
            element: Name of the element.
            values: Values from the first deformation on [m, rad].
            named: Values by name of the deformation; the name of a strain of a spectral beam or leaf spring takes the
                mean strain times the length [m, rad].

        Raises:
            ModelError: The element or the deformation (closure of a spectral beam) has no stiffness; a deformation is
                unknown or given twice.
        """
        member = self._member(element)
        if not member.element.is_elastic(member.properties):
            raise ModelError(f"Strain of element '{element}': it has no stiffness, so a strain has no effect.")
        self._load("strain", False).update(self._values("Strain", element, values, named))

    @records_call
    def temperature(self, element: str, change: Any, *, gradient: Any = None, increment: bool = False) -> None:
        """Change the temperature of an element, which expands and bends away from its warmer side.

        An element that may expand freely has no stress. FIXED deformations expand too: a rigid beam gets longer. A
        second call replaces temperature and gradient of the first.

        Args:
            element: Name of the element; its material, its section or the rigid element itself states ``alpha``, the
                coefficient of thermal expansion.
            change: Change from the temperature of the undeformed mechanism, () [K]; or at the first and the last end,
                linear in between, (2,) [K].
            gradient: Temperature gradient across the element [K/m]. In space: (2,), along local y and z. In the plane:
                (), positive if the left side is warmer, seen from the first end to the last. None: zero.
            increment: Whether the change belongs to the incremental loads.

        Raises:
            ModelError: The element is unknown, does not expand with temperature or has no ``alpha``; the element has a
                gradient but does not bend; numbers are invalid or too many.
        """
        check_flag("increment", increment, ModelError)
        name, member = str(element), self._member(element)
        subject = f"Temperature of element '{name}'"
        if member.element.thermal is None:
            raise ModelError(
                f"{subject}: temperature does not deform an element of type {member.element.name}. Trusses, beams,"
                " spectral beams, rigid beams and your own elements with a companion `thermal` expand."
            )
        if not member.element.expands(member.properties):
            raise ModelError(
                f"{subject}: its coefficient of thermal expansion is not stated. Give its material alpha, as in"
                " Material(.., alpha=11.5e-6), or a section or rigid element that has no material alpha itself."
            )
        ends = self._numbers_of(subject, change, (1, 2), "one number, or two for its ends")
        axes = (self.dimension or 2) - 1
        across = [0.0] * axes
        if gradient is not None:
            if not member.element.bends_by_heat:
                raise ModelError(
                    f"{subject}: an element of type {member.element.name} does not bend. Leave the gradient out."
                )
            expected = "two numbers in space, along local y and z" if axes == 2 else "one number in the plane"
            across = self._numbers_of(f"Gradient of the temperature of element '{name}'", gradient, (axes,), expected)
        self._load("temperature", increment)["element", name, 1] = [ends[0], ends[-1], *across]

    # -- inputs and outputs -------------------------------------------------------------------------------------

    @records_call
    def input(
        self,
        of: str,
        component: str | int,
        quantity: str = "",
        *,
        name: str | None = None,
        kind: str | None = None,
        local: bool = False,
    ) -> None:
        """Name an input: a force, a moment or a stress resultant, or the motion of a support such as a shaking floor.

        Args:
            of: Name of a node or an element.
            component: Coordinate, or name or number (from 1) of a deformation. A rotation in the plane is "phi". A
                rotation in space is "rx", "ry" or "rz", and the input is then a moment or a motion about this global
                axis, in every state.
            quantity: By default "force" on a coordinate, "moment" on a rotation in space, or "stress" in a deformation
                that can change. A "stress" is a stress resultant of the element. A positive stress resultant acts
                against its deformation, as in a stretched spring. For the motion of a support: "displacement",
                "velocity" or "acceleration" of a FIXED or PRESCRIBED coordinate or deformation, or of a rotation that
                is FIXED as a whole.
            name: Its label; by default built from the other arguments.
            kind: "node" or "element", if both have the name.
            local: For a rotation in space: use the axis that turns with the node. It equals the global axis where the
                Euler parameters of the node are (1, 0, 0, 0).

        Raises:
            ModelError: A node, element or component is unknown, the component is an Euler parameter, the quantity does
                not exist, or another signal has this label. :meth:`build` refuses a force on a FIXED or PRESCRIBED
                coordinate, and a motion of any other coordinate.
        """
        self._add_signal("input", name, self._signal("input", of, component, quantity, kind, local))

    @records_call
    def output(
        self,
        of: str,
        component: str | int,
        quantity: str = "",
        *,
        name: str | None = None,
        kind: str | None = None,
        local: bool = False,
    ) -> None:
        """Name an output.

        Args:
            of: Name of a node or an element.
            component: Coordinate, or name or number (from 1) of a deformation. The rotation of a node in the plane is
                "phi". In space, "rx", "ry" or "rz" means the rotation, angular velocity or angular acceleration about
                this global axis, or the moment of a support about it. In linearised equations, a rotation is
                infinitesimal and counts from the state of linearisation. In a simulation, it is a component of the sum
                of two rotation vectors: from the undeformed mechanism to the start, and from the start to the present
                state. This component jumps at a full turn; the angle of a hinge does not.
            quantity: "position", "velocity" or "acceleration" of a coordinate or a rotation. "reaction" is the force or
                moment of the support on a FIXED or PRESCRIBED coordinate. "deformation", "deformation rate",
                "deformation acceleration" or "stress" of a deformation; the stress of a FIXED deformation is the
                transmitted force or moment. The default is "position" or "deformation".
            name: Its label; by default built from the other arguments.
            kind: "node" or "element", if both have the name.
            local: As for :meth:`input`.

        Raises:
            ModelError: As for :meth:`input`; no such quantity.
        """
        self._add_signal("output", name, self._signal("output", of, component, quantity, kind, local))

    @records_call
    def sensor(self, name: str, weights: Mapping[str, Any]) -> None:
        """Name an output that is a linear combination of measured quantities.

        Example:
            >>> b.sensor("yaw", {"left tip.y": 1 / w, "right tip.y": -1 / w})
            >>> b.sensor("lag", {"velocity stage.x": 1.0, "velocity coil.x": -1.0})

        Args:
            name: Its label.
            weights: Factor of each part, () [unit of the sensor over unit of the part], differentiable. A part is
                "node.component", "element.number" or "element.deformation" (its name). Write the quantity first unless
                it is the default of :meth:`output`.

        Raises:
            ModelError: As for :meth:`output`; no parts.
        """
        self._combine("output", "sensor", name, weights)

    @records_call
    def actuator(self, name: str, weights: Mapping[str, Any]) -> None:
        """Name an input that acts on several coordinates or deformations at once.

        Example:
            >>> b.actuator("push-pull", {"A.x": 1.0, "B.x": -1.0})
            >>> b.actuator("floor", {"acceleration A.y": 1.0, "acceleration B.y": 1.0})

        Args:
            name: Its label.
            weights: Effect of a unit of the input on each part, () [unit of the part over unit of the input],
                differentiable. A part is named as for :meth:`sensor`, with a quantity of :meth:`input`.

        Raises:
            ModelError: As for :meth:`input`. There are no parts, forces are combined with motions, or motions are of
                several kinds.
        """
        self._combine("input", "actuator", name, weights)

    def _combine(self, side: str, kind: str, name: str, weights: Mapping[str, Any]) -> None:
        name = name_text(f"A {kind}" if side == "output" else f"An {kind}", name)
        if not isinstance(weights, Mapping) or not weights:
            raise ModelError(
                f"{kind.capitalize()} '{name}' needs a dictionary of its parts and their factors, such as"
                f" {{'A.x': 1.0, 'B.x': -1.0}}, not {short_repr(weights)}."
            )
        parts = []
        for text, factor in weights.items():
            check_numbers(f"{kind.capitalize()} '{name}': the factor of '{text}'", factor, (), ModelError)
            parts.append(self._part(side, f"{kind.capitalize()} '{name}'", text))
        if side == "input" and len(kinds := {p.quantity if p.quantity in MOTIONS else "force" for p in parts}) > 1:
            raise ModelError(
                f"Actuator '{name}' has parts of several kinds, {', '.join(sorted(kinds))}: combine forces, moments and"
                " stresses, or motions of one quantity."
            )
        keys = [part[1:5] for part in parts]
        if twice := [text for i, text in enumerate(weights) if keys[i] in keys[:i]]:
            raise ModelError(f"{kind.capitalize()} '{name}' has '{twice[0]}' twice: give the sum of its factors.")
        signal = NamedSignal("", kind, parts[0].key, parts=tuple(parts), weights=copied(tuple(weights.values())))
        self._add_signal(side, name, signal)

    def _part(self, side: str, subject: str, text: str) -> NamedSignal:
        """A part of a combination, given as "node.component" after a quantity."""
        owner, _, component = str(text).rpartition(".")
        quantity = ""
        if owner not in {*self.members, *self.nodes} and owner.removesuffix(".rotation") not in self.nodes:
            first = [q for q in (*FORCES, *MOTIONS, *MEASURED, *STRAINED) if owner.startswith(f"{q} ")]
            quantity = max(first, key=len, default="")
            owner = owner.removeprefix(f"{quantity} ") if quantity else owner
        if not owner:
            raise ModelError(
                f"{subject}: '{text}' is no part: write node and component, such as 'tip.y', or element and number."
            )
        return self._signal(side, owner, component, quantity, None, False)

    def _signal(
        self, side: str, owner: str, component: str | int, quantity: str, kind: str | None, local: bool
    ) -> NamedSignal:
        """An input or output, with a label built from its arguments."""
        entry, axis = self._signalled(side.capitalize(), owner, component, kind, local)
        angle = axis is None and entry[0] == "node" and self._kind_of(entry[1]) is ANGLE
        if side == "output":
            allowed = STRAINED if entry[0] == "element" else MEASURED
        else:
            usual = ("stress",) if entry[0] == "element" else ("force",) if axis is None else ("moment",)
            allowed = (*usual, *(("moment",) if angle else ()), *MOTIONS)
        chosen = quantity or allowed[0]
        if not isinstance(chosen, str) or chosen not in allowed:
            raise ModelError(
                f"{side.capitalize()} '{owner}.{component}' must be one of {', '.join(allowed)}, not"
                f" {short_repr(chosen)}."
            )
        # In the plane a moment is a force dual to the angle.
        meant = "force" if angle and chosen == "moment" else chosen
        return NamedSignal(f"{chosen} {owner}.{component}", meant, entry, axis, local)

    def _signalled(
        self, side: str, owner: str, component: Any, kind: str | None, local: bool
    ) -> tuple[Key, int | None]:
        """Key of a signal, and the axis of a rotation in space."""
        check_flag("local", local, ModelError)
        self._check_kind(kind)
        owner = str(owner)
        about = self.dimension == 3 and isinstance(component, str) and component in TURNS
        if about and kind != "element" and not (kind is None and owner in self.members and owner not in self.nodes):
            return ("node", self._rotation_name(owner), 1), TURNS.index(component)
        if local:
            raise ModelError(f"{side} '{owner}.{component}': only a rotation in space (rx, ry, rz) takes `local`.")
        entry = self._entry(owner, component, kind)
        if entry[0] == "node" and self._kind_of(entry[1]) is ROTATION3:
            name = f"{entry[1]}.{ROTATION3.components[entry[2] - 1]}"
            raise ModelError(
                f"{side} '{name}' is an Euler parameter. It is no angle, and its dual force is no moment. Name the axis"
                " of the rotation: rx, ry or rz."
            )
        return entry, None

    def _add_signal(self, side: str, name: str | None, signal: NamedSignal) -> None:
        name = name_text(f"An {side}", name or signal.name)
        # In a control system a blank replaces the dot.
        if name.replace(".", " ") in [known.name.replace(".", " ") for known in self.signals[side]]:
            raise ModelError(f"{side.capitalize()} '{name}' is named twice. Give each {side} a name of its own.")
        for part in signal.parts or (signal,):
            self._owner(part.key)
        self.signals[side].append(signal._replace(name=name))

    # -- the model ----------------------------------------------------------------------------------------------

    @unguarded
    def build(self, *, dofs: str | Sequence[str] = "auto", release: str = "none", check: bool = True) -> Model:
        """Return the checked model.

        Args:
            dofs: "auto" finds degrees of freedom if none are named. "named" uses the named degrees of freedom. If these
                leave coefficients of spectral beams undetermined, it adds these coefficients. Or a list of names, as in
                ``model.q_labels``: "top.x", "top.rotation.phi", "hinge.e2".
            release: "auto" releases deformations until no over-constraint remains: first of elastic elements, then of
                joints and supports. It needs ``check=True`` and positions of nodes that are not traced.
            check: Whether to check the number and the rank of the constraints; traced numbers are not checked.

        Returns:
            Model.

        Raises:
            ModelError: There are no elements; a force input acts on a FIXED or PRESCRIBED coordinate; a motion input or
                a reaction belongs to a coordinate that is neither FIXED nor PRESCRIBED; deformations are not zero in
                the undeformed mechanism.
            MechanismError: The mechanism is over- or under-constrained; the number of degrees of freedom does not agree
                with the constraints; named degrees of freedom cannot move or do not determine the position; too_large:
                the mechanism is too large to be checked.

        Warns:
            FlexmbWarning: FIXED or PRESCRIBED deformations have a prestress, strain or damping without effect; an
                element has rigidities that it does not use, and lacks a rigidity that it needs; an automatic release
                has no effect at some position of the mechanism.
            FlexmbWarning: Lengths or material constants are off by a factor of a unit, such as lengths in millimetres.
            BeamTheoryWarning: Plain beams neglect shear or restrained warping. The effect on a stiffness exceeds 1 %.
        """
        if not isinstance(dofs, str):
            return self.with_dofs(dofs).build(dofs="named", release=release, check=check)
        check_choice("dofs", dofs, ("auto", "named"), ModelError)
        check_choice("release", release, ("auto", "none"), ModelError)
        check_flag("check", check, ModelError)
        if release == "auto" and not check:
            raise ModelError("release='auto' needs the checks: leave out check=False, or name the releases.")
        if not self.members:
            raise ModelError("The model has no elements. Add at least one.")
        for loads in self.loads.values():
            self._check_gravity(loads.get("gravity", {}).get("all"))
        strangers = [f"{key[1]} {key[2]}" for key in self.starts if key not in self.dofs]
        if self.dofs and strangers:
            raise ModelError(
                f"Only degrees of freedom have start values, and {', '.join(strangers)}"
                f" {'is none: name it' if len(strangers) == 1 else 'are none: name them'} with dof()."
            )
        if check:
            warn_of_lengths(self)
            warn_of_idle(self)
            warn_of_plain_beams(self)
            warn_of_curved_leaves(self)
            check_holes(self)
        note_builder(self)
        before = next_carried()
        described = nan_if_not_stiff(with_steps(with_clamps(self, before), self))
        if check:
            warn_of_ends(described)
        model = assemble(described if check else with_started(described))
        blocks = zip(model.topology.blocks, model.parameters.properties, strict=True)
        if not is_concrete(
            (model.parameters.reference, [in_undeformed(block, properties) for block, properties in blocks])
        ):
            if before is not None and (twin := as_in(described, before)) is not described:
                return _finished(check_inputs(assemble(twin), twin))
            if not check:
                return _finished(model)
            if release == "auto":
                raise ModelError(
                    "Over-constraints cannot be found while numbers of the model's geometry are traced. Release the"
                    " deformations by name (released=, or release()) that an untraced build with release='auto'"
                    " releases."
                )
            if not self.dofs and dofs == "auto":
                raise ModelError(
                    "Degrees of freedom cannot be found while numbers of the model are traced. Name them with dof(), or"
                    " use the result of an untraced build: build(dofs=model.q_labels)."
                )
            e, named = model.topology.e, model.topology.n_q
            # By shapes, since under jit indices are traced too: the constraint matrix must be square.
            missing = model.topology.x.dependent.shape[0] - sum(a.shape[0] for a in (e.fixed, e.prescribed, e.dof))
            if missing:
                raise ModelError(
                    f"NDOF = {named + missing}, but {named} degrees of freedom are named, and the rest cannot be found"
                    " while the model's geometry is traced. Name all of model.q_labels of an untraced build."
                )
            return _finished(check_inputs(model, described))
        if not check:
            return _finished(model)
        return check_inputs(_finished(complete_model(described, model, dofs, release)))

    # -- helpers ------------------------------------------------------------------------------------------------

    def _turned(self, node: str, axis: Sequence[float] | None, tilt: str | None) -> Key:
        """Key of a prescribed rotation: the angle in the plane, deformation 1 of a hinge in space."""
        part = self._rotation_name(node)
        if self._kind_of(part) is ANGLE:
            if axis is not None or tilt is not None:
                raise ModelError(f"Rotation of node '{node}': in the plane, leave out axis and tilt.")
            return "node", part, 1
        if axis is None:
            raise ModelError(f"Rotation of node '{node}': in space it needs an axis, such as axis=(0, 0, 1).")
        if tilt is not None and not (isinstance(tilt, str) and tilt in ("fixed", "free")):
            raise ModelError(f"Rotation of node '{node}': tilt must be 'fixed' or 'free', not {short_repr(tilt)}.")
        node = part.removesuffix(".rotation")
        name, new = turn_of(node), turn_of(node) not in self.members
        properties = complete_properties(spatial.hinge, name, {"axis": axis})
        if new:
            present_roles = [r for r in (self._role(("node", part, i)) for i in range(1, 5)) if r is not Role.DEPENDENT]
            if present_roles:
                raise ModelError(
                    f"The rotation of node '{node}' is {present_roles[0].value} already and cannot be prescribed too."
                )
            self._check_member(spatial.hinge, name, [ROTATION3.start] * 2, properties)
            self._new_turn(name, part, properties)
        member = self.members[name]
        if member.nodes != (frame_of(part), part):
            raise ModelError(f"Element '{name}' exists already, but prescribing a rotation needs this name.")
        if new and tilt == "fixed":
            member.roles[1:] = [Role.FIXED] * 2
        known, roles = member.properties["axis"], member.roles
        other = is_concrete((known, properties)) and not np.allclose(known, properties["axis"])
        if other or (tilt is not None and (tilt == "free") is not (roles[1] is Role.DEPENDENT)):
            raise ModelError(f"Rotation of node '{node}': it is prescribed already, with another axis or tilt.")
        return "element", name, 1

    def _values(self, kind: str, name: str, values: tuple, named: dict[str, Any]) -> dict[Key, Any]:
        """Numbers of an element's deformations by key, from values from the first on and by name."""
        nonempty_arguments(kind.lower(), name, (*values, *named))
        element, by_key = self._member(name).element, {}
        strains = deformations_of(element, *element.closure) or f"those from {len(element.closure) + 1} on"
        for deformation, value in (*enumerate(values, 1), *named.items()):
            check_numbers(f"{kind} of element '{name}'", value, (), ModelError)
            key = self._entry(name, deformation, "element")
            if key in by_key:
                raise ModelError(f"{kind} of element '{name}': deformation {key[2]} ({deformation}) is given twice.")
            idle = kind == "Strain" or self._role(key) is Role.FIXED
            # Traced numbers count as nonzero.
            if idle and key[2] in element.closure and not (is_concrete(value) and value == 0):
                raise ModelError(
                    f"{kind} of element '{name}': deformation {element.called(key[2])} is part of its closure and has"
                    f" no effect. Name a strain. Its strains are {strains}."
                )
            by_key[key] = copied(value)
        return by_key

    @staticmethod
    def _numbers_of(what: str, given: Any, counts: tuple[int, ...], wanted: str) -> list:
        """One number or several as a list of allowed length."""
        check_numbers(what, given, fault=ModelError)
        alone = not isinstance(given, list | tuple) and np.ndim(given) == 0
        numbers = [copied(given)] if alone else number_list(what, given)
        if len(numbers) not in counts:
            raise ModelError(f"{what} must be {wanted}, not {short_repr(given)}.")
        return numbers

    def _check_gravity(self, acceleration: list | None) -> None:
        """Refuse gravity of another dimension than the nodes."""
        if acceleration is None:
            return
        if len(acceleration) != (self.dimension or len(acceleration)) or len(acceleration) not in (2, 3):
            raise ModelError(f"Gravity must have {self.dimension or '2 or 3'} components, but has {len(acceleration)}.")

    def _add_hidden(self, kind: str, *nodes: str, **properties: Any) -> None:
        node = nodes[0]
        element = getattr(planar if self.dimension == 2 else spatial, kind)
        completed = complete_properties(element, f"{kind} of {node}", copied(properties))
        for part in nodes:
            self._owner(("node", part, 1))
        self.members[self._free_name(f"{kind} {node}")] = Member(element, nodes, completed, [], hidden=True)

    def _resolve(self, element: Element, name: str, nodes: list[str]) -> tuple[str, ...]:
        """One node for each positional parameter of an element; rotations and inner coordinates may not exist yet."""
        kinds = {p: k for p, k in element.nodes.items() if k.part != "internal"}
        wrong = ModelError(
            f"Element '{name}' ({element.name}) joins {len(kinds)} nodes:"
            f" {', '.join(f'{p} ({k.part})' for p, k in kinds.items())}. Give one name for each, or one"
            f" for each end; got {len(nodes)}: {', '.join(nodes) or 'none'}."
        )
        # One name for each node, perhaps without the warping, or one name for each end.
        warpings = sum(kind.part == "warping" for kind in kinds.values())
        each = len(nodes) in (len(kinds), len(kinds) - warpings)
        resolved: list[str] = []
        unread, used, current = iter(nodes), set(), None
        for parameter, kind in kinds.items():
            if each:
                begins = kind.part != "warping" or len(nodes) == len(kinds)
            else:
                begins = current is None or kind.part in used or not self._can_mean(current, kind)
            if begins:
                current, used = next(unread, None), set()
            if current is None:
                raise wrong
            used.add(kind.part)
            if current not in self.nodes and not current.endswith((".rotation", ".warping")):
                self._unknown_node(current, f"element '{name}', {parameter}")
            if not self._can_mean(current, kind):
                raise wrong
            name_of = {"rotation": self._rotation_name, "warping": self._warping_name}.get(kind.part, str)
            resolved.append(name_of(current))
            if self.dimension != kind.dimension:
                raise ModelError(
                    f"Element '{name}' ({element.name}) is {'planar' if kind.dimension == 2 else 'spatial'}, but node"
                    f" '{resolved[-1]}' is not."
                )
        if next(unread, None) is not None:
            raise wrong
        for node in resolved:
            if resolved.count(node) > 1:
                raise ModelError(f"Element '{name}' ({element.name}) joins node '{node}' to itself. Give it two nodes.")
        # Inner coordinates of an element are one node, its last.
        internal = [f"{name}.internal" for k in element.nodes.values() if k.part == "internal"]
        for node in internal:
            if node in self.nodes:
                raise ModelError(f"Node '{node}' is defined twice. Give each element its own name.")
        return (*resolved, *internal)

    def _check_member(self, element: Element, name: str, references: list, properties: dict) -> None:
        if element.check is None or not is_concrete((references, properties)):
            return
        ref = element.reference([np.asarray(r, float) for r in references])
        # Known numbers stay known even if others of the mechanism are traced.
        with jax.core.eval_context():
            faults = element.check(ref=ref, **(element.arguments(element.check, properties) or {}))
        for fault in faults:
            raise ModelError(f"Element '{name}' {fault}.")


def _finished(model: Model) -> Model:
    return collect_model(nan_if_impossible(model))
