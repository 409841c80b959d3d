"""Counts, answers and the picture of the newest document, computed in a thread beside the server."""

import dataclasses
import logging
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from ..errors import AnalysisError, ModelError, heard
from ..linear.buckling import Buckling
from ..linear.modes import Modes
from ..viewer.page import Colours, page_data
from ..viewer.view import view
from .advice import advice, mass_advice
from .building import build
from .counts import Count, count, quick_numbers
from .live_answers import Answers, Wants
from .ways import Ways


class Scenes:
    """Scenes one after the other; a mode keeps the sign that it had before."""

    def __init__(self):
        self._before: tuple[Any, np.ndarray] | None = None

    def of_answers(self, found: Answers, slopes: Mapping[str, float] | None = None) -> dict[str, Any]:
        """Scene of an analysed mechanism, with elements coloured by ``slopes`` if wanted."""
        wants, model = found.wants, found.model
        colouring = found.stress if wants.colour == "stress" else None
        mode_set: Modes | Buckling | None = {"modes": found.modes, "buckling": found.buckled}.get(wants.state)
        if mode_set is not None and mode_set.shapes.shape[1]:
            count = mode_set.shapes.shape[1]
            mode = min(wants.mode, count - 1)
            scene_view = view(self._steady(mode_set, mode), stress=colouring, which=[mode])
            description = {"kind": "modes", "mode": mode, "modes": count}
        else:
            scene_view = view(model if found.lin is None else found.lin, stress=colouring)
            description = {"kind": scene_view.kind, "mode": 0, "modes": 0}
        if slopes is not None and wants.colour == "sensitivity":
            parts = scene_view.lines.parts
            # Constant along each element.
            values = np.repeat([slopes.get(part.name, np.nan) for part in parts], [part.count for part in parts])[None]
            largest = float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0)) or 1.0
            label = f"{wants.sensitivity_of}: % per % of the section's sizes"
            colours = Colours(label, "coolwarm", -largest, largest, values)
            scene_view = dataclasses.replace(scene_view, colours=colours)
        return {**description, "view": page_data(scene_view)}

    def of_count(self, count: Count) -> dict[str, Any] | None:
        """Scene of a mechanism without answers: its self-stress, or its shape; None without elements."""
        if count.drawn is None:
            return None
        over = count.mobility is not None and count.mobility.overconstraints
        scene_view = view(count.mobility if over else count.drawn)
        return {"kind": scene_view.kind, "mode": 0, "modes": len(scene_view.choices), "view": page_data(scene_view)}

    def _steady(self, mode_set: Modes | Buckling, mode: int) -> Modes | Buckling:
        """The modes, the chosen one with its former sign."""
        shape = np.asarray(mode_set.shapes)[:, mode]
        key = (type(mode_set), mode, shape.shape)
        before = self._before[1] if self._before and self._before[0] == key else shape
        sign = -1.0 if before @ shape < 0 else 1.0
        self._before = key, sign * shape
        if sign > 0:
            return mode_set
        signs = jnp.ones(mode_set.shapes.shape[1]).at[mode].set(sign)
        return dataclasses.replace(mode_set, shapes=mode_set.shapes * signs)


# Number of structures known to be compiled.
MOST = 200


class Live:
    """A thread that computes what is shown of the newest document.

    It sends the counts first, then the answers, then the scene, each with its revision. For a new structure it sends
    each answer as soon as it is compiled.

    Attributes:
        counted: Newest count with its advice.
    """

    def __init__(self, tell: Callable[[dict[str, Any]], None], build: Callable[[Any], Any] = build):
        """Start the thread, which calls ``tell`` with every message; ``build`` makes builder and problems."""
        self._tell, self._build = tell, build
        self._changed = threading.Condition()
        self._next: tuple[int, Any, Wants] | None = None
        self._busy = self._stopped = False
        self._compiled: dict[Any, None] = {}
        self._good = _nothing()
        self._scenes, self._ways = Scenes(), Ways(self._again)
        self._shown: tuple[int, Any, Wants] | None = None
        self.counted: dict[str, Any] = {}
        self._thread = threading.Thread(target=self._run, name="flexmb live", daemon=True)
        self._thread.start()

    def show(self, revision: int, document: Any, wants: Wants | None = None) -> None:
        """Compute this next, instead of what waits."""
        with self._changed:
            self._next = revision, document, wants or Wants()
            self._changed.notify_all()

    def wait(self, timeout: float) -> bool:
        """Wait until nothing is left to compute, for a time [s] at most; whether that is so."""
        end = time.monotonic() + timeout
        with self._changed:
            while self._busy or self._next is not None:
                remaining = end - time.monotonic()
                if remaining <= 0 or not self._changed.wait(remaining):
                    return not self._busy and self._next is None
            return True

    def stop(self) -> None:
        """End the thread after the present computation; it sends nothing more."""
        with self._changed:
            self._stopped, self._next = True, None
            self._changed.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=10)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._busy = False
                self._changed.notify_all()
                while self._next is None and not self._stopped:
                    self._changed.wait()
                if self._stopped or self._next is None:
                    return
                self._shown, self._next, self._busy = self._next, None, True
                revision, document, wants = self._shown
            try:
                self._evaluate(revision, document, wants)
            except Exception as fault:  # The pages show any fault, and the next edit follows.
                logging.getLogger("flexmb").exception("revision %s", revision)
                self._failed(revision, f"{type(fault).__name__}: {fault}")

    def _again(self) -> None:
        """Compute the same once more, since something wanted has been compiled."""
        with self._changed:
            self._next = self._next or self._shown
            self._changed.notify_all()

    def _say(self, topic: str, revision: int, **content: Any) -> None:
        if not self._stopped:
            self._tell({"tell": topic, "revision": revision, **content})

    def _evaluate(self, revision: int, document: Any, wants: Wants) -> None:
        built = self._build(document)
        if not built.builder.nodes and not built.problems:
            # The next mechanism on an empty drawing is another one: no answer stays.
            self._good = _nothing()
        dof_count = self._count(revision, built, document.things)
        if built.problems:
            more = f" There are {len(built.problems)} such problems." if len(built.problems) > 1 else ""
            self._failed(revision, f"{built.problems[0]['message']}{more}", dof_count)
        elif dof_count.model is None:
            self._failed(revision, dof_count.message, dof_count)
        else:
            self._answer(revision, dof_count, document, wants)

    def _count(self, revision: int, built: Any, items: list[dict[str, Any]]) -> Count:
        """Count, and send it with advice; for a new structure send first the numbers that need no compiling."""
        builder = built.builder
        key = "count", tuple((m.element, len(m.roles)) for m in builder.members.values())
        if key not in self._compiled:
            self._say("count", revision, **Count("counting", "", quick_numbers(builder)).message_data(), advice=[])
        dof_count = count(builder)
        self._remember(key)
        self._tell_count(revision, dof_count, advice(dof_count, items))
        return dof_count

    def _tell_count(self, revision: int, dof_count: Count, suggestions: list[dict[str, Any]]) -> None:
        self.counted = {"revision": revision, **dof_count.message_data(), "advice": suggestions}
        self._say("count", **self.counted)

    def _remember(self, key: Any) -> None:
        self._compiled[key] = None
        while len(self._compiled) > MOST:
            del self._compiled[next(iter(self._compiled))]

    def _failed(self, revision: int, message: str, dof_count: Count | None = None) -> None:
        """Send the last good answers, which are old, and the scene of a count."""
        self._say("answers", revision, status="failed", message=message, stale=True, **self._good)
        if dof_count is not None:
            self._show(revision, lambda: self._scenes.of_count(dof_count))

    def _answer(self, revision: int, dof_count: Count, document: Any, wants: Wants) -> None:
        assert dof_count.model is not None
        answers, announced = Answers(dof_count.model, wants), False
        # What an analysis is compiled for: structure, and shapes of all arrays.
        leaves, structure = jax.tree.flatten((dof_count.model.topology, dof_count.model.parameters))
        kind = structure, tuple(leaf.shape for leaf in leaves)
        with heard() as heard_warnings:
            heard_warnings.extend(dof_count.warnings)
            for name, analyse in answers.analyses():
                key = name, kind
                is_new = key not in self._compiled
                if is_new and not announced:
                    announced = True
                    self._computing(revision, **(_so_far(revision, answers, heard_warnings) if answers.values else {}))
                try:
                    analyse()
                except (AnalysisError, ModelError, NotImplementedError) as fault:
                    self._failed(revision, str(fault), dof_count)
                    return
                self._remember(key)
                if is_new:
                    with self._changed:
                        if self._next is not None:
                            return
                    self._computing(revision, **_so_far(revision, answers, heard_warnings))
                    if name == "frequencies":
                        self._show(revision, lambda: self._scenes.of_answers(answers))
        self._good = _so_far(revision, answers, heard_warnings)
        message = "" if answers.fault is None else str(answers.fault)
        if message and dof_count.status == "loose":
            message = dof_count.message
        self._say("answers", revision, status="ok", message=message, stale=False, **self._good)
        if answers.fault is not None and (suggestions := mass_advice(dof_count.model)):
            self._tell_count(revision, dof_count, [*suggestions, *self.counted["advice"]])
        slopes = None
        if wants.sensitivity_of is not None:
            ways = self._ways.of(document, answers)
            self._say("ways", revision, **ways)
            slopes = ways["by_element"]
        self._show(revision, lambda: self._scenes.of_answers(answers, slopes))

    def _computing(self, revision: int, **partial: Any) -> None:
        content = {**self._good, **partial}
        stale = content["of_revision"] != revision
        self._say("answers", revision, status="computing", message="", stale=stale, **content)

    def _show(self, revision: int, make: Callable[[], dict[str, Any] | None]) -> None:
        """Send a scene; a scene that cannot be drawn takes no answer with it."""
        try:
            scene = make()
        except Exception:  # The answers stay, and the page keeps its old picture.
            logging.getLogger("flexmb").exception("scene of revision %s", revision)
            return
        if scene is not None:
            self._say("scene", revision, of_revision=revision, **scene)


def _so_far(revision: int, answers: Answers, heard_warnings: list[str]) -> dict[str, Any]:
    """Answers of a revision so far, as copies: the caller sends them while more are computed."""
    warnings = list(dict.fromkeys(heard_warnings))
    return {"of_revision": revision, "values": dict(answers.values), "words": [*answers.words], "warnings": warnings}


def _nothing() -> dict[str, Any]:
    """Answers before there are any."""
    return {"of_revision": None, "values": {}, "words": [], "warnings": []}
