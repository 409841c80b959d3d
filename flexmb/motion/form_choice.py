"""The form in which equations of motion are integrated: as asked for, or chosen."""

from __future__ import annotations

from typing import Any

from ..arguments import check_choice, is_concrete
from ..errors import ModelError
from ..math.sparse import LARGE
from ..mechanics.levels import Levels
from ..mechanics.sparse_order import SparseOrder, order_of
from ..mechanics.tree import Tree, tree_of
from ..model.model import Model
from .chain_form import obstacle
from .drive import Driven
from .drives_by_name import acted_on
from .integrator import Integrator, is_energy_keeping

FORMS = ("coordinates", "reduced", "chain", "tree")
# From so many coordinates on, mechanisms that are no chains are solved on the host by default. Nets in the plane and
# lattices in space take the time of dense matrices at 320 to 340, and a net of 480 half of it (benchmarks/nets.py); to
# compile takes longer, once.
NET = 400


def check_form(integrator: Integrator, controlled: bool) -> None:
    """Refuse a form that does not exist, or that does not go with what else is asked for.

    Args:
        controlled: Whether there is a controller.

    Raises:
        ValueError: See above.
    """
    form = integrator.form
    if form is not None:
        check_choice("form", form, FORMS)
    if form == "chain":
        if controlled:
            raise ValueError('form="chain" takes no controller: leave `form` out.')
        for name in ("solver", "controller", "adjoint"):
            if getattr(integrator, name) is not None:
                raise ValueError(f'form="chain" has its own solver and steps: leave `{name}` out, or `form`.')
    partly = form in ("reduced", "tree")
    if controlled and partly:
        raise ValueError('A controller needs form="coordinates".')
    if (controlled or partly) and is_energy_keeping(integrator.solver):
        raise ValueError('EnergyKeeping() needs form="coordinates" and no controller: take GeneralizedAlpha().')
    if integrator.event is not None and form == "tree":
        raise ValueError('An event sees the state of all coordinates: it needs form="coordinates".')


def chosen_form(
    integrator: Integrator, model: Model, driven: tuple[Driven, ...], controlled: bool, jumps: Any, numbers: Any
) -> tuple[str, Levels | SparseOrder | None, Tree | None]:
    """The form, with the order of the unknowns for "chain" and the beams whose last ends are computed for "tree".

    Args:
        integrator: As checked.
        controlled: Whether there is a controller.
        jumps: Times at which loads jump, or None.
        numbers: What else may be traced.

    Raises:
        ModelError: The form that is asked for does not apply.
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
                'form="tree" needs a spectral beam with FIXED closure whose far node is free and closes no loop, in a'
                " mechanism whose connections are not traced. Leave `form` out, and what serves is chosen."
            )
    return form or "coordinates", None, None


def _order(
    integrator: Integrator, model: Model, driven: tuple[Driven, ...], controlled: bool, jumps: Any, numbers: Any
) -> Levels | SparseOrder | None:
    """Order of the unknowns of a chain or a net, None where the form "chain" is not taken."""
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
    if not asked and (why is not None or controlled or any(one is not None for one in options)):
        return None
    if not asked and top.x.free.shape[0] < LARGE:
        return None
    order = order_of(top)
    return None if not asked and isinstance(order, SparseOrder) and top.x.free.shape[0] < NET else order
