"""Options of time integration: form and its choice, solver, tolerances, step sizes, end of the motion."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, Literal

from jaxtyping import Array, Float

from ..arguments import as_floats, check_choice, check_number, check_whole, is_concrete, short_repr
from ..compilation.record import Record, static
from ..errors import ModelError
from ..mechanics.sparse_order import SparseOrder, order_of
from ..mechanics.tree import Tree, tree_of
from ..model.model import Model
from ..statics.solver_choice import LARGE, is_long_chain
from .chain_form import obstacle
from .drive import Driven
from .drives_by_name import acted_on

if TYPE_CHECKING:
    import diffrax

FORMS = ("coordinates", "reduced", "chain", "tree")
# Mechanisms with at least this number of coordinates that are no chains use the sparse solver by default. Dense
# matrices take equal time at 320 to 340 coordinates, and twice as long at 480 (benchmarks/nets.py); the sparse form
# takes longer to compile.
NET = 400


def is_energy_keeping(solver: Any) -> bool:
    """Whether a solver is ``EnergyKeeping()``, without loading it by default."""
    if solver is None:
        return False
    from .energy_keeping import EnergyKeeping

    return isinstance(solver, EnergyKeeping)


class Integrator(Record):
    """Options of time integration. :func:`simulate` accepts each attribute as a keyword too.

    Attributes:
        form: Coordinates of the equations:

            - "coordinates": all nodal coordinates with a multiplier for each constraint, projected onto the constraints
              after each step. This form needs no degrees of freedom. A choice of degrees of freedom may fail during the
              motion.
            - "tree": the same, except for spectral beams that close no loop. flexmb computes the last end of such a
              beam from its first end and its strains. Not with a controller, an event or ``EnergyKeeping()``.
            - "reduced": the degrees of freedom. Each evaluation solves for the other coordinates. This form has fewer
              unknowns, but fails at a dead point. Not with explicit solvers.
            - "chain": all coordinates of many elements, without dense matrices. Not differentiable in reverse mode if
              loads jump or an event ends the motion.
            - None: "chain" for a large mechanism or a long chain, "tree" for such spectral beams, if the form applies;
              otherwise "coordinates".
        rtol: Largest relative error of a displacement in one step. The error is divided by the greatest displacement so
            far, but at least by half the extent of the mechanism (for rotations, half a radian). The accumulated error
            is of the same size if the motion is damped or short, otherwise larger (``benchmarks/stability.py``). Use a
            smaller value for small deformations beside a large motion. Without work by a force, a step may gain or lose
            at most 3 rtol of the greatest kinetic plus elastic energy.
        atol: Allowed error at zero displacement, as a share of the extent, or in radians; by default just above
            round-off.
        solver: Solver of diffrax or of flexmb. flexmb has ``Rodas5P()`` for stiff motion (default), and, with fixed
            steps, ``GeneralizedAlpha()`` and ``EnergyKeeping()``.
        controller: Step size controller of diffrax. It replaces the control by rtol and atol, or the fixed steps.
        dt0: First step, or the fixed step [s].
        adjoint: Adjoint of diffrax: reverse mode by default, forward mode with ``diffrax.ForwardMode()``.
        event: Event of diffrax that ends the motion; rows of later times are not finite. Without a root finder the
            motion ends at the end of the step. A condition of time and state is evaluated at 17 places of each step;
            with fixed steps or a `controller` only at ends of steps. Its arguments are t and y. The entries of y.u are
            displacements of the coordinates that move, divided by the extent of the mechanism: y.u[0] is zero when the
            first of these coordinates passes its undeformed place.
        max_steps: Largest number of steps; with ``progress``, in each part.
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
        """Return a copy with numbers as arrays, and with a solver that satisfies the constraints.

        Args:
            jumps: Whether loads jump.

        Raises:
            ValueError, TypeError: As :func:`simulate`.
        """
        check_number("rtol", self.rtol, above=0)
        check_number("atol", self.atol, least=0)
        if self.dt0 is not None:
            check_number("dt0", self.dt0, above=0)
        named = ("solver", "controller", "adjoint", "event")
        # diffrax takes long to load. The default needs it for derivatives alone.
        by_default = all(getattr(self, name) is None for name in named)
        solver = None if by_default else self._checked_solver(jumps)
        return dataclasses.replace(
            self,
            rtol=as_floats(self.rtol),
            atol=as_floats(self.atol),
            # Zero means none, so that parts with and without a given first step share one program.
            dt0=as_floats(0.0 if self.dt0 is None else self.dt0),
            solver=solver,
            max_steps=check_whole("max_steps", self.max_steps, 1),
        )

    def _checked_solver(self, jumps: bool) -> diffrax.AbstractSolver | None:
        """A solver that satisfies the constraints; raise for a wrong solver, controller, adjoint or event."""
        import diffrax

        from .solver import MotionSolver, Projected

        for name, kind, expected in (
            ("solver", diffrax.AbstractSolver, "a solver, such as Rodas5P() or diffrax.Dopri8()"),
            ("controller", diffrax.AbstractStepSizeController, "a step size controller of diffrax"),
            ("adjoint", diffrax.AbstractAdjoint, "an adjoint of diffrax"),
            ("event", diffrax.Event, "an Event of diffrax"),
        ):
            value = getattr(self, name)
            if value is not None and not isinstance(value, kind):
                raise TypeError(f"Argument `{name}` must be {expected}, not {short_repr(value)}.")
        solver = self.solver
        if not isinstance(solver, diffrax.AbstractAdaptiveSolver | None) and self.controller is None:
            name = type(solver).__name__
            if self.dt0 is None:
                raise ValueError(f"{name} takes steps of one size. Give the size as `dt0`.")
            if jumps:
                raise ValueError(f"{name} would pass over jumps of the loads. Give `controller=diffrax.StepTo(..)`.")
        return solver if isinstance(solver, MotionSolver | Projected | None) else Projected(solver)


def check_form(integrator: Integrator, controlled: bool) -> None:
    """Raise ValueError for an unknown form, or a form that other arguments exclude."""
    form = integrator.form
    if form is not None:
        check_choice("form", form, FORMS)
    if form == "chain":
        if controlled:
            raise ValueError('form="chain" takes no controller. Leave `form` out.')
        for name in ("solver", "controller", "adjoint"):
            if getattr(integrator, name) is not None:
                raise ValueError(f'form="chain" has its own solver and steps. Leave `{name}` out, or `form`.')
    partly = form in ("reduced", "tree")
    if controlled and partly:
        raise ValueError('A controller needs form="coordinates".')
    if (controlled or partly) and is_energy_keeping(integrator.solver):
        raise ValueError('EnergyKeeping() needs form="coordinates" and no controller. Use GeneralizedAlpha().')
    if form == "reduced" and _is_explicit(integrator.solver):
        raise ValueError(
            'form="reduced" does not take explicit solvers: each of their stages needs Newton\'s method, which is'
            " about a hundred times slower than the default. Leave `solver` out, or `form`."
        )
    if integrator.event is not None and form == "tree":
        raise ValueError('An event reads the state of all coordinates. It needs form="coordinates".')


def _is_explicit(solver: Any) -> bool:
    """Return whether a solver is an explicit Runge-Kutta method; load diffrax only for a given solver."""
    if solver is None:
        return False
    import diffrax

    return isinstance(solver, diffrax.AbstractERK)


def chosen_form(
    integrator: Integrator, model: Model, driven: tuple[Driven, ...], controlled: bool, jumps: Any, numbers: Any
) -> tuple[str, SparseOrder | None, Tree | None]:
    """Return the form, the order of the unknowns for "chain", and the beams with computed last ends for "tree".

    Args:
        numbers: Other values that JAX may trace.

    Raises:
        ModelError: The form that the user chose does not apply.
    """
    form, top = integrator.form, model.topology
    if form in (None, "chain"):
        order = _order(integrator, model, driven, controlled, jumps, numbers)
        if order is not None:
            return "chain", order, None
    if form in (None, "tree"):
        needs_all = controlled or integrator.event is not None or is_energy_keeping(integrator.solver)
        tree = None if needs_all else tree_of(top, acted_on(model, driven))
        if tree is not None:
            return "tree", None, tree
        if form == "tree":
            raise ModelError(
                'form="tree" needs a spectral beam with FIXED closure whose far node is free and closes no loop, and'
                " connections that are not traced. Leave `form` out: flexmb chooses a form that applies."
            )
    return form or "coordinates", None, None


def _order(
    integrator: Integrator, model: Model, driven: tuple[Driven, ...], controlled: bool, jumps: Any, numbers: Any
) -> SparseOrder | None:
    """Return the order of the unknowns of a chain or a net; None if another form applies."""
    asked, top = integrator.form == "chain", model.topology
    why = obstacle(top, driven)
    if why is None and not is_concrete(top):
        why = "its connections are traced (a model that is an argument of jax.jit, jax.grad or jax.vmap)"
    by_diffrax = jumps is not None or integrator.event is not None
    if why is None and by_diffrax and not is_concrete((model, driven, numbers, jumps, integrator)):
        why = "numbers are traced (jax.jit, jax.grad, jax.vmap) of a motion with jumps or an event"
    if asked and why is not None:
        raise ModelError(f'form="chain" does not apply: {why}. Leave `form` out.')
    options = (integrator.solver, integrator.controller, integrator.adjoint)
    if asked:
        return order_of(top)
    if why is not None or controlled or any(option is not None for option in options):
        return None
    size = top.x.free.shape[0]
    return order_of(top) if size >= NET or (size >= LARGE and is_long_chain(top)) else None
