"""Interface between solvers and equations of motion: states, residual, projection onto the constraints."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..math.linear import factorise


class MotionState(NamedTuple):
    """State that diffrax integrates.

    Attributes:
        u: Displacements from the undeformed mechanism, over their sizes, of the coordinates that move, in the order of
            the model [-].
        w: Their rates [1/s].
        memory: Carried along, but not integrated: turns of angles, or a guess for Newton's method.
    """

    u: Float[Array, "n"]
    w: Float[Array, "n"]
    memory: Float[Array, "k"]


class WholeMotion(NamedTuple):
    """Motion of all coordinates, at one time or with a row for each time.

    Attributes:
        x: Nodal coordinates [m, rad, -].
        xd: Their velocities [1/s].
        near: Deformations [m, rad]; angles are counted past full turns.
        u: Inputs from a controller [N, N m]; (0,) without one.
    """

    x: Float[Array, "n_x"]
    xd: Float[Array, "n_x"]
    near: Float[Array, "n_e"]
    u: Float[Array, "n_u"]


class Tangent(NamedTuple):
    """Derivatives of the residual R(t, u, w, z); `by_t` is None if no load depends on time."""

    by_u: Float[Array, "r n"]
    by_w: Float[Array, "r n"]
    by_z: Float[Array, "r r"]
    by_t: Float[Array, "r"] | None

    @property
    def mass(self) -> Float[Array, "n n"]:
        """Mass matrix of the free coordinates."""
        n = self.by_u.shape[1]
        return self.by_z[:n, :n]

    def solver(self, step: Any) -> Callable[[Float[Array, "r"]], Float[Array, "r"]]:
        """Function that solves with R_z + step R_w + step^2 R_u."""
        n = self.by_u.shape[1]
        return factorise(self.by_z.at[:, :n].add(step * self.by_w + step**2 * self.by_u)).solve

    def product(self, w: Float[Array, "n"], u: Float[Array, "n"]) -> Float[Array, "r"]:
        """R_w w + R_u u."""
        return self.by_w @ w + self.by_u @ u


class Equations(Protocol):
    """Equations of motion 0 = R(t, u, w, z) with z = (accelerations (n,), multipliers (m,)), linear in z.

    These are all members that integration and solvers use. The forms of the equations implement them.
    """

    @property
    def size(self) -> int:
        """Number n of positions and of velocities; states of a controller count as velocities."""
        ...

    @property
    def states(self) -> int:
        """Number of states of a controller, the last velocities."""
        ...

    @property
    def unknowns(self) -> int:
        """Number n + m of accelerations and multipliers."""
        ...

    def state_of(
        self, x: Float[Array, "n_x"], xd: Float[Array, "n_x"], near: Float[Array, "n_e"] | None
    ) -> MotionState:
        """State of nodal coordinates, with the controller at its start; turns count from `near`, None for zero."""
        ...

    def whole_motion(self, t: Float[Array, ""], state: MotionState) -> WholeMotion:
        """Motion of all coordinates in a state."""
        ...

    def residual(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Float[Array, "r"]:
        """R: forces out of balance along the free coordinates, and second rates of the constraints."""
        ...

    def tangent(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Any:
        """Derivatives of R: a :class:`Tangent`, or element matrices with the same methods."""
        ...

    def regular(self, by_z: Float[Array, "r r"]) -> Bool[Array, ""]:
        """Return whether every motion that the constraints allow has mass, from the derivative of R by z."""
        ...

    def acceleration(self, t: Float[Array, ""], state: MotionState) -> tuple[Float[Array, "r"], Bool[Array, ""]]:
        """Return the z with R = 0, and whether every motion that the constraints allow has mass."""
        ...

    def gap(self, t: Float[Array, ""], state: MotionState) -> Float[Array, "m"]:
        """Errors of the constraints with multipliers [m, rad]."""
        ...

    def rate_of_memory(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Float[Array, "k"]:
        """Rate of the memory."""
        ...

    def settle(self, t: Float[Array, ""], state: MotionState, mass: Float[Array, "n n"] | None = None) -> MotionState:
        """Return the state projected onto the constraints in a mass norm, with updated memory."""
        ...


def by_time(equations: Equations, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Float[Array, "r"]:
    """Derivative of the residual by time."""
    return jax.jvp(lambda t: equations.residual(t, state, z), (t,), (jnp.ones_like(t),))[1]
