"""All analyses of a document: modes of the command line, the stroke, and an answer over a dimension."""

from __future__ import annotations

import contextlib
import dataclasses
import threading
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from .. import plot
from ..answers.answers import Answer, answer, modes
from ..answers.mode import Mode
from ..answers.tables import table
from ..build.builder import Builder
from ..build.restrict import with_turn
from ..design.stroke import driven
from ..design.verdict import verdict
from ..errors import ModelError, heard, printable
from ..linear.linearize import Linearization
from ..linear.stress import has_stress, stress
from ..mechanics.loads import has_loads
from ..model.by_name import TURNS
from ..plot.answer import figure_bytes, image
from ..plot.canvas import GREY, figure_grid, prefix_for
from ..progress import Stopped
from ..spacar.reading import Channel, Leg
from ..spacar.trajectories import NOMINAL, REFERENCES
from ..viewer.page import page_data
from ..viewer.view import view
from .building import built_whole, free_names, numeric_values
from .document import Document
from .jobs import Job
from .options import FIELDS, checked_options, missing
from .traced import traced
from .wants import answer_unit

# pyplot numbers figures of the whole process: draw one picture at a time.
PICTURES = threading.Lock()


class Analysis(NamedTuple):
    """An analysis: title, answer in a sentence, needs as of :class:`flexmb.answers.mode.Mode`, and what runs it."""

    title: str
    doc: str
    needs: tuple[str, ...]
    run: Callable[[Request], dict[str, Any]]


@dataclasses.dataclass
class Request:
    """What an analysis receives: document, mechanism, checked options by name, and the job."""

    document: Document
    builder: Builder
    options: dict[str, Any]
    job: Job

    def watch(self, what: str, total: float | None = None) -> Callable[..., None]:
        """A function to call with the number of things done; it stops when the job does."""

        def report(completed: float, *more: Any) -> None:
            if self.job.stopped:
                raise Stopped
            goal = total if total is not None or not more else more[0]
            self.job.tell(fraction=min(1.0, completed / goal) if goal else None, text=f"{what}: {completed:g}")

        return report


# Number of lines of a table on the page.
MOST_LINES = 60


def analyses() -> dict[str, Analysis]:
    """All analyses by name."""
    return {mode.name: _analysis_of_mode(mode) for mode in modes().values()} | WORKBENCH_ANALYSES


def offered_analyses(document: Document) -> dict[str, dict[str, Any]]:
    """Analyses for the page: title, doc, fields, and what the document lacks, in words."""
    offers = {}
    for name, analysis in analyses().items():
        fields = [field for need in analysis.needs for field in FIELDS.get(need, lambda _: [])(document)]
        lacks = next((text for need in analysis.needs if (text := missing(need, document))), None)
        offers[name] = {"title": analysis.title, "doc": analysis.doc, "fields": fields, "missing": lacks}
    return offers


def _analysis_of_mode(mode: Mode) -> Analysis:
    bode, more = (" and Bode plot", ("frequencies",)) if "signals" in mode.needs else ("", ())
    title, doc = mode.name.replace("-", " ").capitalize(), mode.about[:1].upper() + mode.about[1:]
    return Analysis(f"{title}{bode} (mode {mode.number})", doc, (*mode.needs, *more), lambda asked: _run(mode, asked))


def run(document: Document, name: str, options: Mapping[str, Any], job: Job) -> dict[str, Any]:
    """Run an analysis with texts of its fields, which may contain names of the document.

    Returns:
        "status" ("done" or "failed"), "title", "text", "rows", and if there are any "picture" (SVG) and "view" (data
        of a page that plays it).
    """
    known = offered_analyses(document)
    if name not in known:
        raise ValueError(f"There is no analysis '{printable(name)}'. There are: {', '.join(known)}.")
    analysis = known[name]
    if analysis["missing"]:
        raise ModelError(analysis["missing"])
    builder = built_whole(document).builder
    asked = Request(document, builder, checked_options(analysis, options, document), job)
    job.tell(title=analysis["title"], text="compiling")
    return {"title": analysis["title"], **analyses()[name].run(asked)}


def _run(mode: Mode, asked: Request) -> dict[str, Any]:
    """Run a mode of the command line."""
    options, settings, most = asked.options, {}, asked.options.get("max_steps")
    if "times" in mode.needs:
        settings |= {"TIMESTEP": {"end": options["end"], "steps": options["steps"]}}
        settings |= {"ERROR": {"relative": options["rtol"]}}
    if "trajectory" in mode.needs:
        settings |= _trajectory(asked)
    on_path = "steps" in mode.needs
    watch = asked.watch("states" if on_path else "parts of the time")

    def by_load(_: int, load: float) -> None:
        """Progress of a path, which ends at the load factor 1."""
        watch(max(float(load), 0.0), 1.0)

    name, progress = printable(asked.document.data["title"]) or "mechanism", by_load if on_path else watch
    mode_answer = answer(
        asked.builder, name, mode.number, max_steps=most, settings=settings, progress=progress, dofs="auto"
    )
    lines = table(mode_answer.data).splitlines()[1:]
    more = [f"… and {len(lines) - MOST_LINES} more lines"] if len(lines) > MOST_LINES else []
    data: dict[str, Any] = {
        "status": "failed" if mode_answer.exit_status else "done",
        "text": "\n".join([*lines[:MOST_LINES], *more]),
        "rows": [] if mode_answer.found is None else list(map(list, mode_answer.found.summary().rows.items())),
    }
    if mode_answer.model is None or (mode_answer.exit_status and mode_answer.found is None and mode_answer.lin is None):
        return data
    asked.job.tell(text="drawing")
    with PICTURES, heard():
        data["picture"] = _picture(mode_answer, options).decode()
    states = mode_answer.shown.states() if hasattr(mode_answer.shown, "states") else None
    along: Any = mode_answer.found if states is not None and states.along is not None else None
    with heard():
        stresses = None
        if along is not None and has_stress(along.model):
            with contextlib.suppress(ModelError, TypeError, ValueError):
                stresses = stress(along.model, at=along)
        data["view"] = page_data(view(mode_answer.shown, stresses))
    return data


def _picture(mode_answer: Answer, options: Mapping[str, Any]) -> bytes:
    low, high = options.get("low"), options.get("high")
    if mode_answer.picture != "bode" or (low is None and high is None):
        return image(mode_answer, "svg")
    low = (high or 1.0) / 1e4 if low is None else low
    high = low * 1e4 if high is None else high
    if not 0 < low < high:
        raise ValueError(f"The frequencies are {low:g} and {high:g} Hz. They must be positive and ascending.")
    return figure_bytes(lambda: plot.bode(mode_answer.lin, hertz=np.geomspace(low, high, 400)), "svg")


def _trajectory(asked: Request) -> dict[str, Any]:
    """Settings of a file for a trajectory of a coordinate, with the inputs and outputs of the mechanism."""
    builder, options = asked.builder, asked.options
    name = options["coordinate"] or _only_coordinate(builder)
    node, _, axis = name.rpartition(".")
    owner, component = (f"{node}.rotation", 1) if axis == "phi" else (node, "xyz".index(axis) + 1)
    if owner not in builder.nodes:
        raise ModelError(f"'{printable(name)}' does not turn: no element asks for the rotation of '{printable(node)}'.")
    if not builder.dofs and builder.nodes[owner].roles[component - 1].name == "DEPENDENT":
        builder.dof(node, axis)
    # Names of files are numbers, and start values may be unknown.
    at: Any = owner
    start: Any = builder.nodes[owner].start
    leg = Leg(at, component, 0.0, options["duration"], float(start[component - 1]) + options["by"], options["law"], 1)
    settings: dict[str, Any] = {"TRAJX": [leg]}
    for i, signal in enumerate(builder.signals["input"], 1):
        keyword = NOMINAL[0] if signal.key[0] == "node" else NOMINAL[1]
        settings.setdefault(keyword, []).append(_channel(i, signal))
    words = {quantity: keyword for keyword, quantity in REFERENCES.items()}
    for i, signal in enumerate(builder.signals["output"], 1):
        if signal.quantity in words:
            settings.setdefault(words[signal.quantity], []).append(_channel(i, signal))
    if not builder.signals["input"] and builder.nodes[owner].roles[component - 1].name == "DOF":
        raise ModelError(f"Nothing drives '{printable(name)}'. Add an input there, or prescribe it.")
    return settings


def _channel(number: int, signal: Any) -> Channel:
    component = signal.key[2] if signal.axis is None else TURNS[signal.axis]
    return Channel(number, signal.key[1], component, 1)


def _only_coordinate(builder: Builder) -> str:
    if len(builder.dofs) == 1 and builder.dofs[0][0] == "node":
        _, owner, component = builder.dofs[0]
        return f"{owner.removesuffix('.rotation')}.{'phi' if owner.endswith('.rotation') else 'xyz'[component - 1]}"
    raise ModelError("No coordinate is chosen. Choose one above, or name one degree of freedom.")


def _stroke(asked: Request) -> dict[str, Any]:
    """Verdict over the stroke, with stresses on the page."""
    options, model = asked.options, asked.builder.build()
    stroke: Any = options["to"] if options["coordinate"] is None else {options["coordinate"]: options["to"]}
    with heard() as warnings:
        watch = asked.watch("strokes")
        assessment = verdict(model, stroke, node=options["node"], steps=options["steps"], progress=watch)
    asked.job.tell(text="drawing")
    title, rows, *_ = assessment.summary()
    text = "\n".join([title, *warnings])
    with PICTURES, heard():
        picture = figure_bytes(lambda: plot.verdict(assessment), "svg").decode()
    with heard():
        stresses = None
        if "stress" in assessment.curves:
            model = with_turn(model, str(options["coordinate"]))
            excitation = driven(model, options["coordinate"])
            states: list[Linearization] = [excitation.at(model, s).held for s in assessment.stroke.tolist()]
            stresses = [stress(state.model, at=state) for state in states]
        data = page_data(view(assessment, stresses))
    return {"status": "done", "text": text, "rows": list(map(list, rows.items())), "picture": picture, "view": data}


def _sweep(asked: Request) -> dict[str, Any]:
    """Frequencies, load multiplier, stress and mass as one name varies."""
    options, document, model = asked.options, asked.document, asked.builder.build()
    name, numbers = options["name"] or free_names(document)[0], numeric_values(document)
    present_value = float(numbers[f"names/{name}/value"])
    ends = [options[end] if options[end] is not None else numbers.get(f"names/{name}/{end}") for end in ("low", "high")]
    wide = sorted((present_value / 2, 2 * present_value))
    low, high = (float(w if end is None else end) for end, w in zip(ends, wide, strict=True))
    if not low < high:
        raise ValueError(f"'{printable(name)}' goes from {low:g} to {high:g}. The last value must be larger.")
    keys = [f"frequency {i + 1}" for i in range(min(3, model.topology.n_q))] + ["mass"]
    if has_loads(model.topology, model.parameters):
        keys += ["multiplier 1"] + (["stress"] if has_stress(model) else [])
    function = traced(document, model, keys)
    at, watch = function.at(document), asked.watch("designs", options["points"])
    values, rows = np.linspace(low, high, options["points"]), []
    names = np.array([float(numbers[f"names/{n}/value"]) for n in function.names])
    for i, value in enumerate(values.tolist()):
        watch(i)
        names[function.names.index(name)] = value
        answers, _, code = at(names)
        rows.append(np.where(np.isfinite(answers) & (code == 0), answers, np.nan))
    results = np.array(rows)
    lost = int(np.sum(np.any(np.isnan(results), axis=1)))
    with PICTURES, heard():
        picture = figure_bytes(lambda: _curves(name, values, present_value, keys, results), "svg").decode()
    plain = [[number if np.isfinite(number) else None for number in row] for row in results.tolist()]
    table = [{name: v, **dict(zip(keys, row, strict=True))} for v, row in zip(values.tolist(), plain, strict=True)]
    text = f"{printable(name)} from {low:g} to {high:g}" + (f"; {lost} designs have no answer" if lost else "")
    return {"status": "done", "text": text, "rows": table, "picture": picture}


def _curves(name: str, values: np.ndarray, present_value: float, keys: list[str], results: np.ndarray) -> Any:
    """A panel for each kind of answer."""
    kinds = list(dict.fromkeys(key.partition(" ")[0] for key in keys))
    figure, axes = figure_grid(len(kinds), size=(3.7, 2.9), most=2)
    for ax, kind in zip(axes, kinds, strict=True):
        entries = [k for k, key in enumerate(keys) if key.partition(" ")[0] == kind]
        unit_of_kind = answer_unit(keys[entries[0]])
        factor, unit = prefix_for(float(np.nanmax(np.abs(results[:, entries]), initial=0.0)), unit_of_kind)
        factor, unit = (1.0, "kg") if kind == "mass" else (factor, unit) if unit_of_kind else (1.0, "-")
        for k in entries:
            ax.plot(values, factor * results[:, k], label=keys[k])
        ax.axvline(present_value, color=GREY, linewidth=1.0, linestyle="--")
        ax.set(xlabel=name.replace("$", r"\$"), ylabel=f"{kind} [{unit}]")
        ax.grid(visible=True, alpha=0.3)
        if len(entries) > 1:
            ax.legend(fontsize=8)
    return figure


WORKBENCH_ANALYSES = {
    "stroke": Analysis(
        "Over the stroke",
        "Force of the drive, stress, support stiffness, frequencies and parasitic motion at each stroke.",
        ("stroke",),
        _stroke,
    ),
    "sweep": Analysis(
        "Over a dimension",
        "Frequencies, load multiplier, stress and mass as one of the names varies.",
        ("names",),
        _sweep,
    ),
}
