"""Methods of results by names of nodes and elements, the same for a state, a path and a motion."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import computed
from ..math.rotation import LBAR, rotation_vector

# Rotations in space are named by global axes.
TURNS = ("rx", "ry", "rz")
# A rotation in space that is prescribed or held about an axis has a hinge, from a frame that is FIXED: "turn of c"
# about an own axis, "turn of c.rx" about a global one, both from "frame of c".
TURN_OF, FRAME_OF = "turn of ", "frame of "
# Quantities that only some results have, and where to find them.
_HELD = {
    "e": ("deformations", "an equilibrium, a configuration, a linearisation, a path or a motion has them"),
    "sigma": ("stress resultants", "fm.equilibrium, fm.linearize, fm.path and fm.simulate find them"),
    "reactions": ("reactions", "fm.equilibrium, fm.linearize, fm.path and fm.simulate find them"),
    "external": ("forces", "fm.equilibrium, fm.linearize, fm.path and fm.simulate find them"),
    "xd": ("velocities", "a configuration and a motion have them"),
    "xdd": ("accelerations", "a motion has them"),
}


def turn_of(node: str, axis: str = "") -> str:
    """Name of the hinge that turns or holds the rotation of a node in space."""
    return TURN_OF + node.removesuffix(".rotation") + (f".{axis}" if axis else "")


def turned_by(element: str) -> tuple[str, str]:
    """Node that a hinge with such a name turns, or its rotation, and the global axis; "" for another axis."""
    node, _, axis = element.removeprefix(TURN_OF).rpartition(".")
    return (node, axis) if axis in TURNS else (element.removeprefix(TURN_OF), "")


def tilted_by(element: str) -> tuple[str, ...]:
    """Names of the other two global axes, about which deformations 2 and 3 of such a hinge turn the node."""
    return tuple(axis for axis in TURNS if axis != turned_by(element)[1])


def frame_of(node: str) -> str:
    """Name of the rotation from which these hinges start, for a node or its rotation."""
    return FRAME_OF + node.removesuffix(".rotation")


class ByName:
    """Base class of results with methods by names of nodes and elements, such as ``result.reaction("foot", "x")``.

    A result has one state, or several along a first axis; methods return values for all states. The name of a node also
    refers to its rotation. Components of a node are "x", "y" or "z". Its rotation has the component "phi" in the
    plane, and in space "rx", "ry" or "rz" about the global axes.
    """

    def at(self: Any, node: str) -> Float[Array, "*states n"]:
        """Return the coordinates of a node, or of its rotation as "name.rotation".

        Returns (states, n) [m]; [rad] for a rotation in the plane; Euler parameters [-] in space. Raises KeyError: No
        such node.
        """
        return _picked(self.x, self.labels.known(node))

    def position(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """Return the position of a node, (states, 2 or 3), or (states,) for one component [m].

        Raises KeyError: No such node.
        """
        if self.labels.x[self.labels.known(node)[0]].kind != "position":
            raise KeyError(f"'{node}' is no position: ask rotation('{node.removesuffix('.rotation')}') or at('{node}')")
        return self._placed(self.x, node, component, "rotation")

    def rotation(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """Return the rotation of a node from the global axes.

        Returns the angle in the plane, (states,) [rad]. In space returns the rotation vector, axis times angle,
        (states, 3) [rad], with a length of at most a full turn; the deformation of a hinge counts past full turns.
        Differentiable at zero rotation too. Raises KeyError: No such node or component, or the node has no rotation.
        """
        vectors = jnp.vectorize(rotation_vector, signature="(n)->(m)")
        return self._turned(self.x, node, component, lambda _, values: vectors(values))

    def velocity(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """Return velocities of a node's coordinates; for its rotation see :meth:`angular_velocity`.

        Returns (states, n), or (states,) for one component [m/s].

        Raises:
            KeyError: No such node or component.
            AttributeError: The result has no velocities.
        """
        return self._placed(_array_of(self, "xd"), node, component, "angular_velocity")

    def acceleration(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """Return accelerations of a node's coordinates; for its rotation see :meth:`angular_acceleration`.

        Returns (states, n), or (states,) for one component [m/s^2].

        Raises:
            KeyError: No such node or component.
            AttributeError: The result has no accelerations.
        """
        return self._placed(_array_of(self, "xdd"), node, component, "angular_acceleration")

    def angular_velocity(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """Return the angular velocity of a node.

        Returns the rate of the angle in the plane, (states,); in space about the global axes, (states, 3) [rad/s].

        Raises:
            KeyError: No such node or component, or the node has no rotation.
            AttributeError: The result has no velocities.
        """
        return self._turned(_array_of(self, "xd"), node, component, _about_axes)

    def angular_acceleration(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """Return the rate of :meth:`angular_velocity`.

        Returns the second rate of the angle in the plane, (states,); in space about the global axes, (states, 3)
        [rad/s^2].

        Raises:
            KeyError: No such node or component, or the node has no rotation.
            AttributeError: The result has no accelerations.
        """
        return self._turned(_array_of(self, "xdd"), node, component, _about_axes)

    def reaction(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """Return force and moment of the support on the mechanism at a node; zero without support.

        Args:
            node: Name of the node, or of its rotation as "name.rotation" for only the moment.

        Returns:
            Forces, then moments about global axes if the node has a rotation, (states, n), or (states,) for one
            component [N, N m].

        Raises:
            KeyError: No such node or component.
            AttributeError: The result has no reactions.
        """
        return self._acting(_array_of(self, "reactions"), node, component)

    def force_needed(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """Return the external force at a node that keeps the mechanism in its state.

        It is the sum of loads and supports, without weight: the force of the drive at a prescribed coordinate, the load
        at a loaded node, and zero elsewhere. Returns as :meth:`reaction` [N, N m]. Source: D_x^T sigma less weight, in
        motion with inertia forces: THEORY.md 5, eq. (5.1) and (5.2).

        Args:
            node: Name of the node, or of its rotation as "name.rotation" for the moment alone.

        Raises:
            KeyError: No such node or component.
            AttributeError: The result has no forces.
        """
        return self._acting(_array_of(self, "external"), node, component)

    def deformation(self: Any, element: str, number: int | str | None = None) -> Float[Array, "..."]:
        """Return deformations of an element, (states, n), or (states,) for one [m, rad if angular].

        Args:
            number: Name or number (from 1) of the deformation, as in ``released=``; None: all.

        Raises:
            KeyError: No such element, or it has no such deformation.
            AttributeError: The result has no deformations.
        """
        return _picked(_array_of(self, "e"), self.labels.deformations(element, number))

    def stress_resultant(self: Any, element: str, number: int | str | None = None) -> Float[Array, "..."]:
        """Return stress resultants of an element, dual to its deformations; constraint forces for FIXED deformations.

        Returns (states, n), or (states,) for one [N, N m if angular].

        Args:
            number: Name or number (from 1) of the deformation, as in ``released=``; None: all.

        Raises:
            KeyError: No such element, or it has no such deformation.
            AttributeError: The result has no stress resultants.
        """
        return _picked(_array_of(self, "sigma"), self.labels.deformations(element, number))

    def _placed(self: Any, values: Any, node: str, component: str | None, of_rotation: str) -> Any:
        """Values at a node's own coordinates, or at one of them."""
        indices = self.labels.known(node)
        names = [self.labels.x[i].symbol for i in indices]
        if component in ("phi", *TURNS) and component not in names:
            raise KeyError(f"'{component}' is a component of a rotation: ask {of_rotation}('{node}', '{component}')")
        return _picked(values, indices if component is None else indices[_number(node, names, component)])

    def _turned(self: Any, values: Any, node: str, component: str | None, function: Any) -> Any:
        """Values at a node's rotation; in space a function of its Euler parameters and the values."""
        parts = [
            part for part in self.labels.parts(node) if self.labels.x[self.labels.known(part)[0]].kind == "rotation"
        ]
        if not parts:
            raise KeyError(f"node '{node}' has no rotation: no element that turns with it is joined to it")
        indices = self.labels.known(parts[0])
        part_values = _picked(values, indices)
        if len(indices) == 1:
            _number(node, ["phi"], component)
            return _picked(part_values, 0)
        part_values = function(_picked(self.x, indices), part_values)
        return part_values if component is None else _picked(part_values, _number(node, TURNS, component))

    def _acting(self: Any, values: Any, node: str, component: str | None) -> Any:
        """Forces and moments from values dual to the coordinates; 2 Lbar^T m is dual to Euler parameters."""
        return _along_axes(self.labels, self.x, values, node, component, 0.5)


def node_motions(labels: Any, x: Any, shapes: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
    """Displacements, then rotations about global axes, of small motions about a state.

    Raises KeyError: No such node or component.
    """
    rows = computed(lambda _, shapes: shapes.T, shapes)
    return _along_axes(labels, x, rows, node, component, 2.0)


def _picked(values: Any, indices: Any) -> Any:
    """Entries of the last axis."""
    return computed(lambda _, values: values[..., indices], values)


def _along_axes(labels: Any, x: Any, values: Any, node: str, component: str | None, factor: float) -> Any:
    """Values at a node and its rotation, there a factor times Lbar times the values, about global axes."""
    results, names = [], []
    for part in labels.parts(node):
        indices = labels.known(part)
        part_values = _picked(values, indices)
        turns = labels.x[indices[0]].symbol == "l0"
        # Hinges that turn a rotation start at its frame, whose support has the moment that turns it.
        places = [indices, labels.coordinates(frame_of(part))] if turns else []
        about_axes = [_with_lbar(_picked(x, at), _picked(values, at), factor) for at in places if len(at)]
        results.append(sum(about_axes[1:], about_axes[0]) if turns else part_values)
        names += TURNS if turns else [labels.x[i].symbol for i in indices]
    values = results[0] if len(results) == 1 else computed(lambda xp, *parts: xp.concatenate(parts, axis=-1), *results)
    return values if component is None else _picked(values, _number(node, names, component))


def _number(node: str, names: Any, component: str | None) -> int:
    """Number of a component among some. Raises KeyError: No such component."""
    if component is None:
        return 0
    if component not in names:
        raise KeyError(f"node '{node}' has no component {component!r} here; it has {', '.join(names)}")
    return list(names).index(component)


def _array_of(result: Any, quantity: str) -> Any:
    """An array of a result. Raises AttributeError: The result has none."""
    try:
        return getattr(result, quantity)
    except AttributeError as error:
        name, where = _HELD[quantity]
        raise AttributeError(f"This {type(result).__name__} has no {name}: {where}.") from error


def _with_lbar(lam: Any, values: Any, factor: float) -> Any:
    """A factor times Lbar times values at Euler parameters."""
    lbar = factor * np.asarray(LBAR)
    return computed(lambda xp, lam, values: xp.einsum("ijk,...k,...j->...i", lbar, lam, values), lam, values)


def _about_axes(lam: Any, rates: Any) -> Any:
    """Angular velocity from rates of Euler parameters, angular acceleration from second rates."""
    return _with_lbar(lam, rates, 2.0)
