"""The numbers beside the drawing: each that of the public function, one analysis after the other."""

import contextlib
import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import jax
import numpy as np

from ..arguments import check_choice, check_whole
from ..display import counted, measured, short
from ..errors import AnalysisError, ModelError
from ..linear.buckling import Buckling, buckling
from ..linear.compliance import compliance
from ..linear.linearize import Linearization, linearize
from ..linear.modes import Modes, modes, poles
from ..linear.stress import Stress, stress
from ..mechanics.loads import has_loads
from ..model.model import Model
from ..questions.mass import mass
from ..questions.question import ANGLES, axes_of, unit_of_question
from .traced import answer_of

# How many frequencies and load multipliers are told.
FREQUENCIES, MULTIPLIERS = 6, 3
STATES, COLOURS = ("modes", "buckling", "equilibrium", "self-stress"), ("stress", "sensitivity")
# A motion moves freely whose eigenvalue is below this share of the largest: it is round-off.
FREE = 1e-13
# What an analysis refuses a mechanism with: told beside its answer, where the others go on.
REFUSED = (AnalysisError, ModelError, NotImplementedError)

Value = dict[str, Any]


@dataclasses.dataclass(frozen=True)
class Wants:
    """What is computed and sent beside the counts.

    Attributes:
        mode: Number of the mode that is shown, from 0.
        amplitude: As the page shows it; nothing is computed from it.
        state: What is shown: "modes", "buckling", "equilibrium" or "self-stress".
        colour: What colours the elements: "stress", "sensitivity" or None.
        support_node: Node whose support stiffness is told, or None.
        sensitivity_of: Key of the answer whose sensitivities are told, such as "frequency 1", or None.
    """

    mode: int = 0
    amplitude: float | None = None
    state: str = "modes"
    colour: str | None = None
    support_node: str | None = None
    sensitivity_of: str | None = None

    def changed(self, changes: Mapping[str, Any]) -> "Wants":
        """The same with some of them changed.

        Raises:
            ValueError: There is no such want, or it cannot have this value.
        """
        known = [field.name for field in dataclasses.fields(self)]
        for name, value in changes.items():
            if name not in known:
                raise ValueError(f"There is no want '{name}'; there are {', '.join(known)}.")
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
    """Answers about one model, which are made one analysis after the other and kept for the picture.

    Attributes:
        model: The mechanism.
        wants: What is asked for.
        values: Answers so far, by key: label, value, unit and text; a value that is none is None.
        words: What is not computed, and why.
        lin: Linearised equations, once they are there.
        modes: Modes, or None where there are none.
        buckled: Buckling, or None.
        stress: Stress, or None.
        fault: Of the modes; None where there is none.
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
        # As the public functions take it: without incremental loads, which buckling scales.
        self.increment = None if model.parameters.increment is None else 0.0

    def analyses(self) -> Iterator[tuple[str, Callable[[], None]]]:
        """Analyses to be called one after the other, by name; the first raises where there is no equilibrium."""
        yield "frequencies", self._frequencies
        yield "mass", self._mass
        if self.wants.support_node:
            yield "stiffness", self._stiffness
        if self.loaded:
            yield "displacement", self._displacement
            yield "buckling", self._buckling
            yield "stress", self._stress
        else:
            self.words.append("There are no loads, and so no displacement, no stress and no buckling.")
        if self.wants.sensitivity_of:
            yield "question", self._question
        if self.increment is not None:
            self.words.append("Incremental loads are left out of the state that is shown; buckling scales them.")

    def _add(self, key: str, value: Any, unit: str, label: str = "", text: str | None = None, **more: Any) -> None:
        number = None if value is None else float(value)
        finite = number is not None and math.isfinite(number)
        told = measured(number, unit) if number is not None and finite and text is None else text or "none"
        self.values[key] = {
            "label": label or key,
            "value": number if finite else None,
            "unit": unit,
            "text": told,
            **more,
        }

    def _refused(self, key: str, unit: str, label: str, fault: Exception) -> None:
        """An answer that there is not, and why."""
        self._add(key, None, unit, label, "none", message=str(fault))
        self.words.append(f"{(label or key).capitalize()}: {fault}")

    def _frequencies(self) -> None:
        self.lin = lin = linearize(self.model, increment=self.increment)
        try:
            found = self.modes = modes(lin)
        except NotImplementedError:
            self._poles(lin)
            return
        except REFUSED as fault:
            self.fault = fault
            self._refused("frequency 1", "Hz", "", fault)
            return
        values, squares = np.asarray(found.frequencies).tolist(), np.asarray(found.eigenvalues).tolist()
        free = FREE * max(map(abs, squares), default=0.0)
        for i, (hertz, square) in enumerate(zip(values[:FREQUENCIES], squares, strict=False), 1):
            unstable = square < -free
            text = f"unstable, ω² = {square:.4g} rad²/s²" if unstable else None
            text = "0 Hz, moves freely" if abs(square) <= free else text
            self._add(f"frequency {i}", hertz, "Hz", text=text, unstable=unstable)
        if found.massless:
            self.words.append(f"{counted(found.massless, 'motion')} without mass: of no frequency.")
        if not self.model.topology.n_q:
            self.words.append("Nothing can move, so that there are no frequencies.")
        elif not values:
            self.fault = AnalysisError("singular_mass", "Nothing has mass, so that there are no frequencies. Add mass.")

    def _poles(self, lin: Linearization) -> None:
        """Where the stiffness has no potential, frequencies may be complex."""
        self.words.append("Loads without a potential: poles stand in place of frequencies.")
        found = [pole for pole in np.asarray(poles(lin)).tolist() if pole.imag >= 0]
        for i, pole in enumerate(found[:FREQUENCIES], 1):
            text = f"{pole.real:.4g} ± {pole.imag:.4g}i rad/s"
            self._add(f"pole {i}", abs(pole.imag) / (2 * math.pi), "Hz", text=text, unstable=pole.real > 0)

    def _mass(self) -> None:
        own = mass(self.model)
        self._add("mass", own, "kg", text=f"{short(own)} kg")

    def _stiffness(self) -> None:
        node, lin = str(self.wants.support_node), self.lin
        assert lin is not None
        if node not in {entry.of for entry in self.model.labels.x}:
            self.words.append(f"There is no node '{node}' in the mechanism, and so no stiffness of it.")
            return
        try:
            found = np.asarray(compliance(lin, node))
        except REFUSED as fault:
            self._refused("stiffness", "N/m", f"stiffness of '{node}'", fault)
            return
        for axis, own in zip(axes_of(self.model.labels, node), np.diag(found).tolist(), strict=False):
            turns = axis in ANGLES
            label = f"stiffness of '{node}' {'about ' + axis[1:] if len(axis) == 2 else 'along ' + axis}"
            label = label.replace("along phi", "in rotation")
            unit = "N m/rad" if turns else "N/m"
            self._add(f"stiffness {axis}", 1 / own if own else None, unit, label, None if own else "rigid")

    def _displacement(self) -> None:
        lin, labels = self.lin, self.model.labels
        assert lin is not None
        moved = np.asarray(lin.x) - np.asarray(self.model.parameters.reference)
        nodes: dict[str, list[int]] = {}
        for i, entry in enumerate(labels.x):
            if entry.kind == "position":
                nodes.setdefault(entry.of, []).append(i)
        sizes = {name: float(np.linalg.norm(moved[own])) for name, own in nodes.items()}
        where = max(sizes, key=lambda name: sizes[name])
        text = f"{measured(sizes[where], 'm')} of '{where}'"
        self._add("displacement", sizes[where], "m", "largest displacement", text, where={"node": where})
        chosen = self.wants.support_node
        for i in nodes.get(chosen or "", ()):
            axis = labels.x[i].symbol
            self._add(f"displacement {axis}", moved[i], "m", f"displacement of '{chosen}' along {axis}")

    def _question(self) -> None:
        """Any other question whose sensitivities are wanted."""
        key = str(self.wants.sensitivity_of)
        if key in self.values or self.lin is None:
            return
        with contextlib.suppress(KeyError, ValueError, *REFUSED):
            self._add(key, answer_of(key, self.wants.support_node)(self.lin), unit_of_question(key).removesuffix("-"))

    def _buckling(self) -> None:
        try:
            found = self.buckled = buckling(self.model, increment=self.increment)
        except REFUSED as fault:
            self._refused("multiplier 1", "", "load multiplier", fault)
            return
        multipliers = np.asarray(found.multipliers).tolist()
        for i, own in enumerate(multipliers[:MULTIPLIERS], 1):
            self._add(f"multiplier {i}", own, "", f"load multiplier {i}", f"{own:.5g}")
        if not multipliers:
            self.words.append("The loads stress no motion, so that nothing buckles.")

    def _stress(self) -> None:
        assert self.lin is not None
        try:
            found = self.stress = stress(self.model, at=self.lin)
        except REFUSED as fault:
            self.words.append(f"No stress: {fault}")
            return
        where = found.where
        text = f"{measured(float(found.maximum), 'Pa')} in '{where.element}' at {where.place:g}"
        place = {"element": where.element, "place": where.place}
        self._add("stress", found.maximum, "Pa", "largest stress", text, where=place)
        if found.strength is not None:
            used = np.asarray(found.utilisation)
            worst = int(np.argmax(used))
            text = f"{used[worst]:.4g} in '{found.names[worst]}'"
            self._add("utilisation", used[worst], "", "stress over strength", text)


def _is_loaded(model: Model) -> bool:
    """Whether anything acts: loads that are all zero, such as a motion that is prescribed but not given yet, do not."""
    own = model.parameters
    given = [np.asarray(leaf) for leaf in jax.tree.leaves((own.loads, own.increment, own.strain))]
    elements = any(block.element.force is not None for block in model.topology.blocks)
    return has_loads(model.topology, own) and (elements or any(np.any(leaf) for leaf in given))
