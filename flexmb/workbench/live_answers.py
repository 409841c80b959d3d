"""The numbers beside the drawing, from the public functions, one analysis after the other."""

import contextlib
import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import jax
import numpy as np

from ..arguments import check_choice, check_whole
from ..display import counted, quantity_text, short
from ..errors import AnalysisError, ModelError
from ..linear.buckling import Buckling, buckling
from ..linear.compliance import compliance
from ..linear.linearize import Linearization, linearize
from ..linear.modes import Modes, modes, poles
from ..linear.stress import Stress, stress
from ..mechanics.loads import has_loads
from ..model.model import Model
from ..numerical_limits import FREE_STIFFNESS
from ..plot.geometry import nodes_of
from ..questions.mass import mass
from ..questions.question import ANGLES, components_of, unit_of_question
from .traced import answer_of, increment_of

# Number of frequencies and load multipliers.
FREQUENCIES, MULTIPLIERS = 6, 3
STATES, COLOURS = ("modes", "buckling", "equilibrium", "self-stress"), ("stress", "sensitivity")
# Faults of one answer, after which the other answers still follow.
REFUSED = (AnalysisError, ModelError, NotImplementedError)

Value = dict[str, Any]


@dataclasses.dataclass(frozen=True)
class Wants:
    """What the page wants beside the counts.

    Attributes:
        mode: Number of the shown mode, from 0.
        amplitude: Amplitude on the page.
        state: Shown state: "modes", "buckling", "equilibrium" or "self-stress".
        colour: Colour of the elements: "stress", "sensitivity" or None.
        support_node: Node for the support stiffness, or None.
        sensitivity_of: Key of the answer whose sensitivities are wanted, such as "frequency 1", or None.
    """

    mode: int = 0
    amplitude: float | None = None
    state: str = "modes"
    colour: str | None = None
    support_node: str | None = None
    sensitivity_of: str | None = None

    def changed(self, changes: Mapping[str, Any]) -> "Wants":
        """Other wants, checked."""
        known = [field.name for field in dataclasses.fields(self)]
        for name, value in changes.items():
            if name not in known:
                raise ValueError(f"There is no question '{name}'; there are {', '.join(known)}.")
            if name == "mode":
                check_whole("mode", value, 0)
            elif name == "state":
                check_choice("state", value, STATES)
            elif name == "colour" and value is not None:
                check_choice("colour", value, COLOURS)
            elif name in ("support_node", "sensitivity_of") and not isinstance(value, str | None):
                raise ValueError(f"Want `{name}` must be a name or nothing.")
        return dataclasses.replace(self, **changes)


class Answers:
    """Answers about one model, computed one analysis after the other and kept for the picture.

    Attributes:
        values: Answers so far, by key: label, value (None if there is none), unit and text.
        words: What is not computed, and why.
        fault: Fault of the modes, or None.
    """

    def __init__(self, model: Model, wants: Wants):
        self.model, self.wants = model, wants
        self.values: dict[str, Value] = {}
        self.words: list[str] = []
        self.lin: Linearization | None = None
        self.modes: Modes | None = None
        self.buckled: Buckling | None = None
        self.stress: Stress | None = None
        self.fault: Exception | None = None
        self.loaded = _is_loaded(model)
        self.increment = increment_of(model)

    def analyses(self) -> Iterator[tuple[str, Callable[[], None]]]:
        """Analyses by name, to be called one after the other; the first raises if there is no equilibrium."""
        yield "frequencies", self._frequencies
        yield "mass", lambda: self._add("mass", total := mass(self.model), "kg", text=f"{short(total)} kg")
        if self.wants.support_node:
            yield "stiffness", self._stiffness
        if self.loaded:
            yield "displacement", self._displacement
            yield "buckling", self._buckling
            yield "stress", self._stress
        else:
            self.words.append("Without loads there is no displacement, no stress and no buckling.")
        if self.wants.sensitivity_of:
            yield "question", self._question
        if self.increment is not None:
            self.words.append("The shown state has no incremental loads. Buckling scales them.")

    def _add(self, key: str, value: Any, unit: str, label: str = "", text: str | None = None, **more: Any) -> None:
        number = None if value is None else float(value)
        finite = number is not None and math.isfinite(number)
        text = quantity_text(number, unit) if number is not None and finite and text is None else text or "none"
        value = number if finite else None
        self.values[key] = {"label": label or key, "value": value, "unit": unit, "text": text, **more}

    def _refused(self, key: str, unit: str, label: str, fault: Exception) -> None:
        """Report an answer that does not exist, and why."""
        self._add(key, None, unit, label, "none", message=str(fault))
        self.words.append(f"{(label or key).capitalize()}: {fault}")

    def _frequencies(self) -> None:
        self.lin = lin = linearize(self.model, increment=self.increment)
        try:
            mode_set = self.modes = modes(lin)
        except NotImplementedError:
            self._poles(lin)
            return
        except REFUSED as fault:
            self.fault = fault
            self._refused("frequency 1", "Hz", "", fault)
            return
        values, squares = np.asarray(mode_set.frequencies).tolist(), np.asarray(mode_set.eigenvalues).tolist()
        free = FREE_STIFFNESS * max(map(abs, squares), default=0.0)
        for i, (hertz, square) in enumerate(zip(values[:FREQUENCIES], squares, strict=False), 1):
            special = f"unstable, ω² = {square:.4g} rad²/s²" if square < -free else "0 Hz, moves freely"
            text = special if square <= free else None
            self._add(f"frequency {i}", hertz, "Hz", text=text, unstable=square < -free)
        if mode_set.massless:
            self.words.append(f"{counted(mode_set.massless, 'motion')} without mass have no frequency.")
        if not self.model.topology.n_q:
            self.words.append("Nothing can move. There are no frequencies.")
        elif not values:
            self.fault = AnalysisError("singular_mass", "Nothing has mass. There are no frequencies. Add mass.")

    def _poles(self, lin: Linearization) -> None:
        """Poles instead of frequencies, which may be complex if the stiffness has no potential."""
        self.words.append("Loads have no potential: poles replace frequencies.")
        upper_poles = [pole for pole in np.asarray(poles(lin)).tolist() if pole.imag >= 0]
        for i, pole in enumerate(upper_poles[:FREQUENCIES], 1):
            text = f"{pole.real:.4g} ± {pole.imag:.4g}i rad/s"
            self._add(f"pole {i}", abs(pole.imag) / (2 * math.pi), "Hz", text=text, unstable=pole.real > 0)

    def _stiffness(self) -> None:
        node, lin = str(self.wants.support_node), self.lin
        assert lin is not None
        if node not in {entry.of for entry in self.model.labels.x}:
            self.words.append(f"The mechanism has no node '{node}', and so no stiffness there.")
            return
        try:
            compliance_matrix = np.asarray(compliance(lin, node))
        except REFUSED as fault:
            self._refused("stiffness", "N/m", f"stiffness of '{node}'", fault)
            return
        axes = components_of(self.model.labels, node)
        for axis, entry in zip(axes, np.diag(compliance_matrix).tolist(), strict=False):
            direction = "in rotation" if axis == "phi" else f"about {axis[1:]}" if axis in ANGLES else f"along {axis}"
            unit = "N m/rad" if axis in ANGLES else "N/m"
            label = f"stiffness of '{node}' {direction}"
            self._add(f"stiffness {axis}", 1 / entry if entry else None, unit, label, None if entry else "rigid")

    def _displacement(self) -> None:
        lin, labels = self.lin, self.model.labels
        assert lin is not None
        moved = np.asarray(lin.x) - np.asarray(self.model.parameters.reference)
        nodes = nodes_of(self.model)
        sizes = {name: float(np.linalg.norm(moved[entries])) for name, entries in nodes.items()}
        where = max(sizes, key=lambda name: sizes[name])
        text = f"{quantity_text(sizes[where], 'm')} of '{where}'"
        self._add("displacement", sizes[where], "m", "largest displacement", text, where={"node": where})
        chosen = self.wants.support_node
        for i in nodes.get(chosen or "", ()):
            axis = labels.x[i].symbol
            self._add(f"displacement {axis}", moved[i], "m", f"displacement of '{chosen}' along {axis}")

    def _question(self) -> None:
        """Another question whose sensitivities are wanted."""
        key = str(self.wants.sensitivity_of)
        if key in self.values or self.lin is None:
            return
        with contextlib.suppress(KeyError, ValueError, *REFUSED):
            self._add(key, answer_of(key, self.wants.support_node)(self.lin), unit_of_question(key).removesuffix("-"))

    def _buckling(self) -> None:
        try:
            buckling_modes = self.buckled = buckling(self.model, increment=self.increment)
        except REFUSED as fault:
            self._refused("multiplier 1", "", "load multiplier", fault)
            return
        multipliers = np.asarray(buckling_modes.multipliers).tolist()
        for i, multiplier in enumerate(multipliers[:MULTIPLIERS], 1):
            self._add(f"multiplier {i}", multiplier, "", f"load multiplier {i}", f"{multiplier:.5g}")
        if not multipliers:
            self.words.append("The loads stress no motion. Nothing buckles.")

    def _stress(self) -> None:
        assert self.lin is not None
        try:
            stress_field = self.stress = stress(self.model, at=self.lin)
        except REFUSED as fault:
            self.words.append(f"No stress: {fault}")
            return
        where = stress_field.where
        text = f"{quantity_text(float(stress_field.maximum), 'Pa')} in '{where.element}' at {where.place:g}"
        place = {"element": where.element, "place": where.place}
        self._add("stress", stress_field.maximum, "Pa", "largest stress", text, where=place)
        if stress_field.strength is not None:
            used = np.asarray(stress_field.utilisation)
            worst = int(np.argmax(used))
            text = f"{used[worst]:.4g} in '{stress_field.names[worst]}'"
            self._add("utilisation", used[worst], "", "stress over strength", text)


def _is_loaded(model: Model) -> bool:
    """Whether nonzero loads act."""
    parameters = model.parameters
    leaves = [np.asarray(leaf) for leaf in jax.tree.leaves((parameters.loads, parameters.increment, parameters.strain))]
    elements = any(block.element.force is not None for block in model.topology.blocks)
    return has_loads(model.topology, parameters) and (elements or any(np.any(leaf) for leaf in leaves))
