"""Degrees of freedom found by an untraced build, carried over to traced builds of the same function."""

import contextlib
import contextvars
from collections.abc import Iterator
from typing import Any

import numpy as np

from ..collecting import setting
from ..model.model import Model
from .description import Description

_RECORD: contextvars.ContextVar[list[Model] | None] = contextvars.ContextVar("record", default=None)
_BUILDERS: contextvars.ContextVar[list[Description] | None] = contextvars.ContextVar("builders", default=None)
_REPLAY: contextvars.ContextVar[Iterator[Model] | None] = contextvars.ContextVar("replay", default=None)


def collected_models() -> contextlib.AbstractContextManager[list[Model]]:
    """Collect the models that are built, in order."""
    return setting(_RECORD, [])


def built() -> contextlib.AbstractContextManager[list[Description]]:
    """Collect the builders that build, in order, before they do."""
    return setting(_BUILDERS, [])


def carried_choices(models: list[Model]) -> contextlib.AbstractContextManager[Any]:
    """Pass degrees of freedom and releases of models to traced builds in the same order."""
    return setting(_REPLAY, iter(models))


def note_builder(builder: Description) -> None:
    """Collect a copy of a builder if builders are collected."""
    if (builders := _BUILDERS.get()) is not None:
        builders.append(builder.copy())


def collect_model(model: Model) -> Model:
    """Collect a finished model if models are collected."""
    if (models := _RECORD.get()) is not None:
        models.append(model)
    return model


def next_carried() -> Model | None:
    """The model that the present build repeats, or None."""
    replay = _REPLAY.get()
    return None if replay is None else next(replay, None)


def as_in(builder: Description, model: Model) -> Description:
    """A builder with the roles of a model with the same nodes and elements."""
    labels, topology, twin = model.labels, model.topology, builder.copy()
    owners: tuple[Any, Any] = (twin.nodes, twin.members)
    for owner, entries, roles in zip(owners, (labels.x, labels.e), model.roles(), strict=True):
        for entry, role in zip(entries, roles, strict=True):
            if entry.kind != "norm":
                if entry.of not in owner or len(owner[entry.of].roles) < entry.component:
                    return builder
                owner[entry.of].roles[entry.component - 1] = role
    twin.dofs = [("node", labels.x[i].of, labels.x[i].component) for i in np.asarray(topology.x.dof).tolist()]
    twin.dofs += [("element", labels.e[i].of, labels.e[i].component) for i in np.asarray(topology.e.dof).tolist()]
    return twin
