"""What a solver of motion asks of the equations: states, residual, and how to stay on the constraints."""

from typing import NamedTuple, Protocol

from jaxtyping import Array, Float


class MotionState(NamedTuple):
    """State that diffrax integrates.

    Attributes:
        u: Positions, (n,) [m, rad, -].
        w: Velocities, (n,) [1/s].
        memory: What is carried along without being part of the state: the turn of angles past pi, or a guess for
            Newton's method, (k,).
    """

    u: Float[Array, "n"]
    w: Float[Array, "n"]
    memory: Float[Array, "k"]


class Tangent(NamedTuple):
    """Derivatives of the residual R(t, u, w, z).

    Attributes:
        by_u: (n + m, n).
        by_w: (n + m, n).
        by_z: (n + m, n + m).
        by_t: (n + m,), or None where no load depends on time.
    """

    by_u: Float[Array, "r n"]
    by_w: Float[Array, "r n"]
    by_z: Float[Array, "r r"]
    by_t: Float[Array, "r"] | None


class Equations(Protocol):
    """Equations of motion 0 = R(t, u, w, z) with z = (accelerations (n,), multipliers (m,)), linear in z."""

    @property
    def states(self) -> int:
        """Number of velocities, the last ones, that are states of a controller."""
        ...

    def residual(self, t, state: MotionState, z: Float[Array, "r"]) -> Float[Array, "r"]:
        """R, (n + m,)."""
        ...

    def tangent(self, t, state: MotionState, z: Float[Array, "r"]) -> Tangent:
        """Derivatives of R."""
        ...

    def acceleration(self, t, state: MotionState) -> Float[Array, "r"]:
        """Z that makes R vanish."""
        ...

    def gap(self, t, state: MotionState) -> Float[Array, "m"]:
        """How far the constraints of the multipliers are from being kept."""
        ...

    def rate_of_memory(self, t, state: MotionState, z: Float[Array, "r"]) -> Float[Array, "k"]:
        """How the memory changes."""
        ...

    def settle(self, t, state: MotionState, mass=None) -> MotionState:
        """The state brought back onto the constraints, memory renewed; by the least change measured by a mass."""
        ...
