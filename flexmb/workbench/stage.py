"""The picture on the stage: the chosen mode or state, as data for the page of the viewer."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import jax.numpy as jnp
import numpy as np

from ..linear.buckling import Buckling
from ..linear.modes import Modes
from ..model.model import Model
from ..viewer.page import Colours, page_data
from ..viewer.view import view
from .counts import Count
from .live_answers import Answers


class Scenes:
    """Scenes one after the other; a mode keeps the sign that it had before."""

    def __init__(self):
        self._before: tuple[Any, np.ndarray] | None = None

    def of_answers(self, found: Answers, slopes: Mapping[str, float] | None = None, label: str = "") -> dict[str, Any]:
        """Scene of an analysed mechanism, with elements coloured by ``slopes`` if wanted."""
        wants, model = found.wants, found.model
        colouring = found.stress if wants.colour == "stress" else None
        own: Modes | Buckling | None = {"modes": found.modes, "buckling": found.buckled}.get(wants.state)
        if own is not None and own.shapes.shape[1]:
            count = own.shapes.shape[1]
            mode = min(wants.mode, count - 1)
            shown = view(self._steady(own, mode), stress=colouring, which=[mode])
            found_scene = {"kind": "modes", "mode": mode, "modes": count}
        else:
            shown = view(model if found.lin is None else found.lin, stress=colouring)
            found_scene = {"kind": shown.kind, "mode": 0, "modes": 0}
        if slopes is not None and wants.colour == "sensitivity":
            shown = dataclasses.replace(shown, colours=_of_slopes(model, shown, slopes, label))
        return {**found_scene, "view": page_data(shown)}

    def of_count(self, count: Count) -> dict[str, Any] | None:
        """Scene of a mechanism without answers: its self-stress, or its shape; None without elements."""
        if count.drawn is None:
            return None
        over = count.mobility is not None and count.mobility.overconstraints
        shown = view(count.mobility if over else count.drawn)
        return {"kind": shown.kind, "mode": 0, "modes": len(shown.choices), "view": page_data(shown)}

    def _steady(self, found: Modes | Buckling, mode: int) -> Modes | Buckling:
        """The modes, the chosen one with its former sign."""
        shape = np.asarray(found.shapes)[:, mode]
        key = (type(found), mode, shape.shape)
        before = self._before[1] if self._before and self._before[0] == key else shape
        sign = -1.0 if before @ shape < 0 else 1.0
        self._before = key, sign * shape
        if sign > 0:
            return found
        signs = jnp.ones(found.shapes.shape[1]).at[mode].set(sign)
        return dataclasses.replace(found, shapes=found.shapes * signs)


def _of_slopes(model: Model, shown: Any, slopes: Mapping[str, float], label: str) -> Colours:
    """Colours of elements by their sensitivity, constant along each."""
    by_part = np.array([slopes.get(part.name, np.nan) for part in shown.lines.parts])
    values = np.repeat(by_part, [part.count for part in shown.lines.parts])[None]
    finite = np.abs(by_part[np.isfinite(by_part)])
    largest = float(np.max(finite, initial=0.0)) or 1.0
    return Colours(label, "coolwarm", -largest, largest, values)
