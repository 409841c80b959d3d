"""How a simulation goes from step to step: solver, tolerances, step sizes, and where it ends."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Literal

from jaxtyping import Array, Float

from ..arguments import as_floats, check_choice, check_number, check_whole, shown
from ..compilation.record import Record, static
from ..errors import ModelError
from ..mechanics.tree import Tree

if TYPE_CHECKING:
    import diffrax


FORMS = ("coordinates", "reduced", "chain", "tree")


class Integrator(Record):
    """How to integrate a motion; each may be given to :func:`simulate` as a keyword too.

    Attributes:
        form: "coordinates": all nodal coordinates, with a multiplier for each constraint, brought back onto the
            constraints after every step; no choice of degrees of freedom can fail on the way. "tree": the same, but
            that the last ends of spectral beams are computed from their first ends and strains wherever they close no
            loop. "reduced": the degrees of freedom, from which the rest follows in every evaluation; fewer unknowns,
            but it fails at a dead point. "chain": all coordinates of many elements, chains and nets alike, by
            Radau's method and without matrices of the size squared; it is differentiated in reverse mode, but where
            loads jump or an event ends the motion. Where a loose tolerance loses the way back, derivatives are NaN.
            None: "chain" where there are many beams and it applies; "tree"
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

    def _check_chain(self, controlled: bool) -> None:
        """Refuse what does not go with the form of chains."""
        if self.form != "chain":
            return
        if controlled:
            raise ValueError('form="chain" takes no controller: leave `form` out.')
        for name in ("solver", "controller", "adjoint"):
            if getattr(self, name) is not None:
                raise ValueError(f'form="chain" has its own solver and steps: leave `{name}` out, or `form`.')

    def checked(self, *, controlled: bool, jumps: bool) -> Integrator:
        """The same with its numbers as arrays, and with a solver that keeps the constraints.

        Args:
            controlled: Whether there is a controller.
            jumps: Whether loads jump.

        Raises:
            ValueError, TypeError: See :func:`simulate`.
        """
        if self.form is not None:
            check_choice("form", self.form, FORMS)
        self._check_chain(controlled)
        if controlled and self.form in ("reduced", "tree"):
            raise ValueError('A controller needs form="coordinates".')
        if self.event is not None and self.form == "tree":
            raise ValueError('An event sees the state of all coordinates: it needs form="coordinates".')
        check_number("rtol", self.rtol, above=0)
        check_number("atol", self.atol, least=0)
        if self.dt0 is not None:
            check_number("dt0", self.dt0, above=0)
        named = ("solver", "controller", "adjoint", "event")
        # The library of solvers takes long to load: the default needs it for derivatives alone.
        by_default = all(getattr(self, name) is None for name in named)
        solver = None if by_default else self._checked_solver(controlled, jumps)
        return dataclasses.replace(
            self,
            rtol=as_floats(self.rtol),
            atol=as_floats(self.atol),
            # Zero stands for none, so that parts with a given first step and those without are one program.
            dt0=as_floats(0.0 if self.dt0 is None else self.dt0),
            solver=solver,
            max_steps=check_whole("max_steps", self.max_steps, 1),
        )

    def _checked_solver(self, controlled: bool, jumps: bool) -> diffrax.AbstractSolver | None:
        """The solver, one that keeps the constraints; it and what goes with it are refused as :meth:`checked` says."""
        import diffrax

        from .energy_keeping import EnergyKeeping
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
        if isinstance(solver, EnergyKeeping) and (controlled or self.form in ("reduced", "tree")):
            raise ValueError('EnergyKeeping() needs form="coordinates" and no controller: take GeneralizedAlpha().')
        if not isinstance(solver, diffrax.AbstractAdaptiveSolver | None) and self.controller is None:
            name = type(solver).__name__
            if self.dt0 is None:
                raise ValueError(f"{name} takes steps of one size: say which with `dt0`.")
            if jumps:
                raise ValueError(
                    f"{name} would step over the jumps of the loads: give `controller=diffrax.StepTo(..)`."
                )
        return solver if isinstance(solver, MotionSolver | Projected | None) else Projected(solver)

    def on(self, tree: Tree | None, *, controlled: bool) -> Integrator:
        """The same with "tree" as its form where none is given and that serves, as checked before.

        Args:
            tree: Beams of the mechanism whose last ends can be computed.
            controlled: Whether there is a controller.

        Raises:
            ModelError: The form is "tree", but there are no such beams.
        """
        if self.form == "tree" and tree is None:
            raise ModelError(
                'form="tree" needs a spectral beam with FIXED closure whose far node is free and closes no loop, in a'
                " mechanism whose connections are not traced. Leave `form` out, and what serves is chosen."
            )
        if self.form is not None:
            return self
        needs_all = controlled or self.event is not None or tree is None
        if self.solver is not None and not needs_all:
            from .energy_keeping import EnergyKeeping

            needs_all = isinstance(self.solver, EnergyKeeping)
        return self if needs_all else dataclasses.replace(self, form="tree")
