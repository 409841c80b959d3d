"""What the stage draws: the chosen mode or state, as the page of the viewer has it."""

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
    """Scenes one after the other, whose modes do not turn over: each goes the way that it went before."""

    def __init__(self):
        self._before: tuple[Any, np.ndarray] | None = None

    def of_answers(self, found: Answers, slopes: Mapping[str, float] | None = None, label: str = "") -> dict[str, Any]:
        """Scene of a mechanism that has been analysed.

        Args:
            found: Answers, and what is wanted.
            slopes: Where sensitivity colours the elements: that of each element, by its name.
            label: What the slopes are.
        """
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
        """Scene of a mechanism that cannot be analysed: its self-stress, or its shape; None without elements."""
        if count.drawn is None:
            return None
        over = count.mobility is not None and count.mobility.overconstraints
        shown = view(count.mobility if over else count.drawn)
        return {"kind": shown.kind, "mode": 0, "modes": len(shown.choices), "view": page_data(shown)}

    def _steady(self, found: Modes | Buckling, mode: int) -> Modes | Buckling:
        """The modes, the chosen one turned over where it would go against the one before it."""
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
    """Colours of all elements by their sensitivity, the same all along each."""
    own = np.array([slopes.get(part.name, np.nan) for part in shown.lines.parts])
    values = np.repeat(own, [part.count for part in shown.lines.parts])[None]
    finite = np.abs(own[np.isfinite(own)])
    largest = float(np.max(finite, initial=0.0)) or 1.0
    return Colours(label, "coolwarm", -largest, largest, values)
