"""Results are asked by the names of nodes and elements: the same questions of a state, a path and a motion."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..arguments import computed
from ..math.rotation import LBAR, rotation_vector

# Rotations in space are asked for about the global axes.
TURNS = ("rx", "ry", "rz")
# A rotation in space that is turned or held about an axis has a hinge there, from a frame that is FIXED: "turn of c"
# about an axis of one's own, "turn of c.rx" about a global one, both from "frame of c".
TURN_OF, FRAME_OF = "turn of ", "frame of "
# What a result may hold, and which results do.
_HELD = {
    "e": ("deformations", "an equilibrium, a configuration, a linearisation, a path or a motion has them"),
    "sigma": ("stress resultants", "fm.equilibrium, fm.linearize, fm.path and fm.simulate find them"),
    "reactions": ("reactions", "fm.equilibrium, fm.linearize, fm.path and fm.simulate find them"),
    "external": ("forces", "fm.equilibrium, fm.linearize, fm.path and fm.simulate find them"),
    "xd": ("velocities", "a configuration and a motion have them"),
    "xdd": ("accelerations", "a motion has them"),
}


def turn_of(node: str, axis: str = "") -> str:
    """Name of the hinge by which the rotation of a node in space is turned or held."""
    return TURN_OF + node.removesuffix(".rotation") + (f".{axis}" if axis else "")


def turned_by(element: str) -> tuple[str, str]:
    """Node whose rotation a hinge of such a name turns, or the rotation, and the global axis; "" about another axis."""
    node, _, axis = element.removeprefix(TURN_OF).rpartition(".")
    return (node, axis) if axis in TURNS else (element.removeprefix(TURN_OF), "")


def frame_of(node: str) -> str:
    """Name of the rotation from which these hinges turn it, of a node or of its rotation."""
    return FRAME_OF + node.removesuffix(".rotation")


class ByName:
    """Base class of results that are asked by names of nodes and elements, as ``result.reaction("foot", "x")``.

    A result is of one state, or of several: then their axis stands in front, and each method answers for all of them.
    A node's rotation is asked for by the name of the node. A component of a node is "x", "y" or "z"; of its rotation
    "phi" in the plane, and in space "rx", "ry" or "rz", about the global axes.
    """

    def at(self: Any, node: str) -> Float[Array, "*states n"]:
        """Coordinates of a node, or of its rotation as "name.rotation".

        Returns (states, n) [m], of a rotation in the plane [rad], in space its Euler parameters [-]. Raises KeyError:
        No such node.
        """
        return _picked(self.x, self.labels.known(node))

    def position(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """Where a node is.

        Returns (states, 2 or 3), or (states,) of one component [m]. Raises KeyError: No such node or component.
        """
        if self.labels.x[self.labels.known(node)[0]].kind != "position":
            raise KeyError(
                f"'{node}' is no position: ask rotation('{node.removesuffix('.rotation')}'), or at('{node}')"
            )
        return self._placed(self.x, node, component, "rotation")

    def rotation(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """How far a node is turned from the global axes.

        Raises KeyError: No such node or component, or the node has no rotation.

        Returns:
            The angle in the plane, (states,); the rotation vector in space, the axis times the angle, (states, 3)
            [rad], within a full turn to either side: past it, a hinge's deformation counts on. It is differentiable at
            zero rotation too.
        """
        return self._turned(self.x, node, component, lambda _, own: _vectors(own))

    def velocity(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """Velocities of a node's coordinates; of its rotation see :meth:`angular_velocity`.

        Returns (states, n), or (states,) of one component [m/s].

        Raises:
            KeyError: No such node or component.
            AttributeError: The result has no velocities.
        """
        return self._placed(_held(self, "xd"), node, component, "angular_velocity")

    def acceleration(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """Accelerations of a node's coordinates, as :meth:`velocity`.

        Returns (states, n), or (states,) of one component [m/s^2].

        Raises:
            KeyError: No such node or component.
            AttributeError: The result has no accelerations.
        """
        return self._placed(_held(self, "xdd"), node, component, "angular_acceleration")

    def angular_velocity(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """How fast a node turns.

        Returns the rate of the angle in the plane, (states,); about the global axes in space, (states, 3) [rad/s].

        Raises:
            KeyError: No such node or component, or the node has no rotation.
            AttributeError: The result has no velocities.
        """
        return self._turned(_held(self, "xd"), node, component, _about_axes)

    def angular_acceleration(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """Rate of :meth:`angular_velocity`.

        Returns the second rate of the angle in the plane, (states,); about the global axes in space, (states, 3)
        [rad/s^2].

        Raises:
            KeyError: No such node or component, or the node has no rotation.
            AttributeError: The result has no accelerations.
        """
        return self._turned(_held(self, "xdd"), node, component, _about_axes)

    def reaction(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """Force and moment of the support on the mechanism at a node, zero where nothing is held.

        Args:
            node: Name of the node, or of its rotation as "name.rotation" for the moment alone.

        Returns:
            Forces, then the moments if the node has a rotation, about global axes, (states, n), or (states,) of one
            component [N, N m].

        Raises:
            KeyError: No such node or component.
            AttributeError: The result has no reactions.
        """
        return self._acting(_held(self, "reactions"), node, component)

    def force_needed(self: Any, node: str, component: str | None = None) -> Float[Array, "..."]:
        """What must act on the mechanism at a node from outside, so that it is in the state that it is in.

        Loads and supports together, without weight: where a coordinate is prescribed, what its drive has to give; where
        a load acts, that load; zero elsewhere. Returns as :meth:`reaction` [N, N m]. Source: D_x^T sigma less weight,
        in motion with the forces of inertia: THEORY.md 5, eq. (5.1) and (5.2).

        Args:
            node: Name of the node, or of its rotation as "name.rotation" for the moment alone.

        Raises:
            KeyError: No such node or component.
            AttributeError: The result has no forces.
        """
        return self._acting(_held(self, "external"), node, component)

    def deformation(self: Any, element: str, number: int | str | None = None) -> Float[Array, "..."]:
        """Deformations of an element. Returns (states, n), or (states,) of one [m, rad if angular].

        Args:
            number: Which, its name or number from 1, as in ``released=``; all of them unless given.

        Raises:
            KeyError: No such element, or it has no such deformation.
            AttributeError: The result has no deformations.
        """
        return _picked(_held(self, "e"), self.labels.deformations(element, number))

    def stress_resultant(self: Any, element: str, number: int | str | None = None) -> Float[Array, "..."]:
        """Stress resultants of an element, dual to its deformations; of what is FIXED, the constraint force.

        Returns (states, n), or (states,) of one [N, N m if angular].

        Args:
            number: Which, its name or number from 1, as in ``released=``; all of them unless given.

        Raises:
            KeyError: No such element, or it has no such deformation.
            AttributeError: The result has no stress resultants.
        """
        return _picked(_held(self, "sigma"), self.labels.deformations(element, number))

    def _placed(self: Any, values: Any, node: str, component: str | None, of_rotation: str) -> Any:
        """Values at a node's own coordinates, or at one of them; a component of its rotation another method has."""
        indices = self.labels.known(node)
        names = [self.labels.x[i].symbol for i in indices]
        if component in ("phi", *TURNS) and component not in names:
            raise KeyError(f"'{component}' is a component of a rotation: ask {of_rotation}('{node}', '{component}')")
        return _picked(values, indices if component is None else indices[_number(node, names, component)])

    def _turned(self: Any, values: Any, node: str, component: str | None, function: Any) -> Any:
        """Values at a node's rotation; in space what a function makes of its Euler parameters and them."""
        parts = [
            part for part in self.labels.parts(node) if self.labels.x[self.labels.known(part)[0]].kind == "rotation"
        ]
        if not parts:
            raise KeyError(f"node '{node}' has no rotation: no element that turns with it is joined to it")
        indices = self.labels.known(parts[0])
        own = _picked(values, indices)
        if len(indices) == 1:
            _number(node, ["phi"], component)
            return _picked(own, 0)
        own = function(_picked(self.x, indices), own)
        return own if component is None else _picked(own, _number(node, TURNS, component))

    def _acting(self: Any, values: Any, node: str, component: str | None) -> Any:
        """Forces and moments of values that are dual to the coordinates: to Euler parameters 2 Lbar^T m is."""
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
    """Values at a node and its rotation, that of Euler parameters by a factor times Lbar about the global axes."""
    pieces, names = [], []
    for part in labels.parts(node):
        indices = labels.known(part)
        own = _picked(values, indices)
        turns = labels.x[indices[0]].symbol == "l0"
        # Hinges that turn a rotation act on it by way of their frame, whose support has the moment that turns it.
        places = [indices, labels.coordinates(frame_of(part))] if turns else []
        about_axes = [_with_lbar(_picked(x, at), _picked(values, at), factor) for at in places if len(at)]
        pieces.append(sum(about_axes[1:], about_axes[0]) if turns else own)
        names += TURNS if turns else [labels.x[i].symbol for i in indices]
    whole = pieces[0] if len(pieces) == 1 else computed(lambda xp, *of: xp.concatenate(of, axis=-1), *pieces)
    return whole if component is None else _picked(whole, _number(node, names, component))


def _number(node: str, names: Any, component: str | None) -> int:
    """Which of some components one is. Raises KeyError: None of them."""
    if component is None:
        return 0
    if component not in names:
        raise KeyError(f"node '{node}' has no component {component!r} here; it has {', '.join(names)}")
    return list(names).index(component)


def _held(result: Any, quantity: str) -> Any:
    """An array of a result. Raises AttributeError: It has none."""
    try:
        return getattr(result, quantity)
    except AttributeError as error:
        what, where = _HELD[quantity]
        raise AttributeError(f"This {type(result).__name__} has no {what}: {where}.") from error


def _vectors(lam: Any) -> Any:
    """Rotation vectors of Euler parameters, (.., 4) to (.., 3)."""
    return jnp.vectorize(rotation_vector, signature="(n)->(m)")(lam)


def _with_lbar(lam: Any, values: Any, factor: float) -> Any:
    """A factor times Lbar times values at Euler parameters, (.., 4) to (.., 3)."""
    lbar = factor * np.asarray(LBAR)
    return computed(lambda xp, lam, values: xp.einsum("ijk,...k,...j->...i", lbar, lam, values), lam, values)


def _about_axes(lam: Any, rates: Any) -> Any:
    """Angular velocity of rates of Euler parameters, acceleration of second rates, (.., 4) to (.., 3)."""
    return _with_lbar(lam, rates, 2.0)
