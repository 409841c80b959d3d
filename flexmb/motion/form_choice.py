"""Choice of the form of the equations of motion, and checks of a form that a user chose."""

from __future__ import annotations

from typing import Any

from ..arguments import check_choice, is_concrete
from ..errors import ModelError
from ..mechanics.sparse_order import SparseOrder, order_of
from ..mechanics.tree import Tree, tree_of
from ..model.model import Model
from ..statics.solver_choice import LARGE, is_long_chain
from .chain_form import obstacle
from .drive import Driven
from .drives_by_name import acted_on
from .integrator import Integrator, is_energy_keeping

FORMS = ("coordinates", "reduced", "chain", "tree")
# Mechanisms with at least this number of coordinates that are no chains use the sparse solver by default. Dense
# matrices take equal time at 320 to 340 coordinates, and twice as long at 480 (benchmarks/nets.py); the sparse form
# takes longer to compile.
NET = 400


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
