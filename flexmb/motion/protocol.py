"""What a solver of motion asks of the equations: states, residual, and how to stay on the constraints."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

from jaxtyping import Array, Bool, Float

from ..math.linear import factorise

# Rates of the places whose velocities make up the kinetic energy, of each block of elements; None: it has no mass.
InertiaRates = tuple[Float[Array, "elements k d"] | None, ...]


class MotionState(NamedTuple):
    """State that diffrax integrates.

    Attributes:
        u: How far coordinates that move are from their undeformed values, in the order of the model, those that are
            FIXED or PRESCRIBED left out; positions in extents of the mechanism, (n,) [-].
        w: Their rates, (n,) [1/s].
        memory: What is carried along without being part of the state: the turn of angles past pi, or a guess for
            Newton's method, (k,).
    """

    u: Float[Array, "n"]
    w: Float[Array, "n"]
    memory: Float[Array, "k"]


class WholeMotion(NamedTuple):
    """What a state stands for, or many states with a row for each.

    Attributes:
        x: Nodal coordinates, (n_x,) [m, rad, -].
        xd: Their velocities, (n_x,) [1/s].
        near: Deformations, (n_e,) [m, rad]; angles are counted past full turns.
        u: Inputs that a controller gives, (n_u,) [N, N m]; (0,) where there is none.
    """

    x: Float[Array, "n_x"]
    xd: Float[Array, "n_x"]
    near: Float[Array, "n_e"]
    u: Float[Array, "n_u"]


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

    @property
    def mass(self) -> Float[Array, "n n"]:
        """Mass matrix of the coordinates that move, (n, n)."""
        n = self.by_u.shape[1]
        return self.by_z[:n, :n]

    def solver(self, step: Any) -> Callable[[Float[Array, "r"]], Float[Array, "r"]]:
        """Return the function that solves with R_z + step R_w + step^2 R_u, for a right-hand side (n + m,)."""
        n = self.by_u.shape[1]
        return factorise(self.by_z.at[:, :n].add(step * self.by_w + step**2 * self.by_u)).solve

    def product(self, w: Float[Array, "n"], u: Float[Array, "n"]) -> Float[Array, "r"]:
        """Change R_w w + R_u u of the residual, (n + m,)."""
        return self.by_w @ w + self.by_u @ u


class Equations(Protocol):
    """Equations of motion 0 = R(t, u, w, z) with z = (accelerations (n,), multipliers (m,)), linear in z.

    These are all members that integration and solvers use; the five forms of the equations have them. In all of them
    t is the time [s], and z is (n + m,).
    """

    @property
    def size(self) -> int:
        """Number n of positions and of velocities, with the states of a controller, which count as velocities."""
        ...

    @property
    def states(self) -> int:
        """Number of velocities, the last ones, that are states of a controller."""
        ...

    @property
    def unknowns(self) -> int:
        """Number n + m of accelerations and multipliers."""
        ...

    def state_of(
        self, x: Float[Array, "n_x"], xd: Float[Array, "n_x"], near: Float[Array, "n_e"] | None
    ) -> MotionState:
        """State of a mechanism, with the controller at its start.

        Args:
            x: Nodal coordinates, (n_x,) [m, rad, -].
            xd: Their velocities, (n_x,) [1/s].
            near: Deformations there, (n_e,) [m, rad], or None: turns are counted from the undeformed mechanism.
        """
        ...

    def whole_motion(self, t: Float[Array, ""], state: MotionState) -> WholeMotion:
        """Everything about the mechanism that a state stands for."""
        ...

    def residual(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Float[Array, "r"]:
        """R: forces out of balance along what moves, and second rates of the constraints, (n + m,)."""
        ...

    def tangent(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Any:
        """Derivatives of R: a :class:`Tangent`, or element matrices with the same methods."""
        ...

    def regular(self, by_z: Float[Array, "r r"]) -> Bool[Array, ""]:
        """Whether every motion that the constraints allow carries mass.

        Args:
            by_z: Derivative of R by z, (n + m, n + m).
        """
        ...

    def acceleration(self, t: Float[Array, ""], state: MotionState) -> tuple[Float[Array, "r"], Bool[Array, ""]]:
        """The z that makes R vanish, (n + m,), and whether every motion that the constraints allow carries mass."""
        ...

    def gap(self, t: Float[Array, ""], state: MotionState) -> Float[Array, "m"]:
        """How far the constraints of the multipliers are from being kept, (m,) [m, rad]."""
        ...

    def rate_of_memory(self, t: Float[Array, ""], state: MotionState, z: Float[Array, "r"]) -> Float[Array, "k"]:
        """How the memory changes, (k,)."""
        ...

    def settle(self, t: Float[Array, ""], state: MotionState, mass: Float[Array, "n n"] | None = None) -> MotionState:
        """The state brought back onto the constraints, by the least change that a mass measures; memory renewed.

        Args:
            mass: Mass matrix of what moves, where it is at hand; otherwise a form takes one of its own.
        """
        ...


class EnergyEquations(Equations, Protocol):
    """Equations that also know the forces over a finite step, whose work is the energy that the elements gain."""

    def inertia_rates(self, t: Float[Array, ""], state: MotionState) -> InertiaRates:
        """Rates of the places of inertia, of each block of elements."""
        ...

    def forces_over_step(
        self,
        times: tuple[Any, Any],
        states: tuple[MotionState, MotionState],
        rates: InertiaRates,
        multipliers: Float[Array, "m"],
    ) -> tuple[Float[Array, "n"], InertiaRates]:
        """Mean forces out of balance over a step, (n,), and the rates of the places of inertia at its end.

        Args:
            times: Its begin and end [s].
            states: There; velocities are not used.
            rates: Rates of the places of inertia at its begin.
            multipliers: Mean multipliers, (m,) [N, N m].
        """
        ...

    def velocities_of(self, t: Float[Array, ""], state: MotionState, rates: InertiaRates) -> Float[Array, "n"]:
        """Velocities that the constraints allow and that come closest to given rates of the places of inertia, (n,).

        Args:
            state: State; its velocities are not used.
        """
        ...
