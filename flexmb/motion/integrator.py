"""How a simulation goes from step to step: solver, tolerances, step sizes, and where it ends."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, Literal

from jaxtyping import Array, Float

from ..arguments import as_floats, check_number, check_whole, shown
from ..compilation.record import Record, static

if TYPE_CHECKING:
    import diffrax


def is_energy_keeping(solver: Any) -> bool:
    """Whether a solver is ``EnergyKeeping()``, which is loaded where a solver is given alone."""
    if solver is None:
        return False
    from .energy_keeping import EnergyKeeping

    return isinstance(solver, EnergyKeeping)


class Integrator(Record):
    """How to integrate a motion; each may be given to :func:`simulate` as a keyword too.

    Attributes:
        form: "coordinates": all nodal coordinates, with a multiplier for each constraint, brought back onto the
            constraints after every step; no choice of degrees of freedom can fail on the way. "tree": the same, but
            that the last ends of spectral beams are computed from their first ends and strains wherever they close no
            loop. "reduced": the degrees of freedom, from which the rest follows in every evaluation; fewer unknowns,
            but it fails at a dead point. "chain": all coordinates of many elements, chains and nets alike, without
            matrices of the size squared; it is differentiated in reverse mode, but where loads jump or an event ends
            the motion. None: "chain" where there are many beams and it applies; "tree"
            where there are such beams and no controller, event or ``EnergyKeeping()``, which need all coordinates; or
            "coordinates".
        rtol: Largest error of a displacement in one step, over the greatest displacement so far, or over half the
            mechanism's extent (half a radian) where that is less. What comes together over a motion is of the same size
            where it is damped or short, and more where it is neither (``benchmarks/stability.py``). Small deformations
            beside a large motion want a smaller one. Energy that a step gains or loses although no force does that work
            is at most 3 rtol of the greatest kinetic plus elastic energy.
        atol: Part of that error which is allowed of a mechanism that has not moved, as share of its extent, and in
            radians; by default just above round-off.
        solver: Solver of diffrax, or one of ours: ``Rodas5P()``, for stiff motion, unless given; of fixed steps
            ``GeneralizedAlpha()`` and ``EnergyKeeping()``.
        controller: Step size controller of diffrax, in place of the one of rtol and atol, or of fixed steps.
        dt0: First step, or the step of a solver of fixed steps [s].
        adjoint: How diffrax differentiates; reverse mode unless given, ``diffrax.ForwardMode()`` for forward mode.
        event: Event of diffrax that ends the motion; later times are then given as not finite. Without a root finder
            the motion ends with its step. A condition of time and state is looked at at 17 places of each step, unless
            steps are of equal length or by a ``controller`` of yours: then where steps end alone. It sees t and y,
            where y.u are displacements of the coordinates that move, in extents of the mechanism: y.u[0] is zero where
            the first of them passes its undeformed place.
        max_steps: Most steps to take, with ``progress`` in each part.
    """

    form: Literal["coordinates", "reduced", "chain", "tree"] | None = static(default=None)
    rtol: float | Float[Array, ""] = 1e-5
    atol: float | Float[Array, ""] = 1e-13
    solver: diffrax.AbstractSolver | None = None
    controller: diffrax.AbstractStepSizeController | None = None
    dt0: float | Float[Array, ""] | None = None
    adjoint: diffrax.AbstractAdjoint | None = None
    event: diffrax.Event | None = None
    max_steps: int = static(default=200_000)

    def checked(self, *, jumps: bool) -> Integrator:
        """The same with its numbers as arrays, and with a solver that keeps the constraints.

        Args:
            jumps: Whether loads jump.

        Raises:
            ValueError, TypeError: See :func:`simulate`.
        """
        check_number("rtol", self.rtol, above=0)
        check_number("atol", self.atol, least=0)
        if self.dt0 is not None:
            check_number("dt0", self.dt0, above=0)
        named = ("solver", "controller", "adjoint", "event")
        # The library of solvers takes long to load: the default needs it for derivatives alone.
        by_default = all(getattr(self, name) is None for name in named)
        solver = None if by_default else self._checked_solver(jumps)
        return dataclasses.replace(
            self,
            rtol=as_floats(self.rtol),
            atol=as_floats(self.atol),
            # Zero stands for none, so that parts with a given first step and those without are one program.
            dt0=as_floats(0.0 if self.dt0 is None else self.dt0),
            solver=solver,
            max_steps=check_whole("max_steps", self.max_steps, 1),
        )

    def _checked_solver(self, jumps: bool) -> diffrax.AbstractSolver | None:
        """The solver, one that keeps the constraints; it and what goes with it are refused as :meth:`checked` says."""
        import diffrax

        from .projected import Projected
        from .solver import MotionSolver

        for name, kind, wanted in (
            ("solver", diffrax.AbstractSolver, "a solver, such as Rodas5P() or diffrax.Dopri8()"),
            ("controller", diffrax.AbstractStepSizeController, "a step size controller of diffrax"),
            ("adjoint", diffrax.AbstractAdjoint, "an adjoint of diffrax"),
            ("event", diffrax.Event, "an Event of diffrax"),
        ):
            value = getattr(self, name)
            if value is not None and not isinstance(value, kind):
                raise TypeError(f"Argument `{name}` must be {wanted}, not {shown(value)}.")
        solver = self.solver
        if not isinstance(solver, diffrax.AbstractAdaptiveSolver | None) and self.controller is None:
            name = type(solver).__name__
            if self.dt0 is None:
                raise ValueError(f"{name} takes steps of one size: say which with `dt0`.")
            if jumps:
                raise ValueError(
                    f"{name} would step over the jumps of the loads: give `controller=diffrax.StepTo(..)`."
                )
        return solver if isinstance(solver, MotionSolver | Projected | None) else Projected(solver)
