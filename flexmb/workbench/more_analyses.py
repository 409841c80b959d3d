"""Analyses beside the modes of the command line: the stroke, and answers over a dimension."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import plot
from ..build.restrict import with_turn
from ..design.stroke import driven
from ..design.verdict import verdict
from ..errors import clean, heard
from ..linear.linearize import Linearization
from ..linear.stress import has_stress, stress
from ..mechanics.loads import has_loads
from ..plot.answer import figure_bytes
from ..plot.canvas import GREY, prefix_for
from ..viewer.page import page_data
from ..viewer.view import view
from .asked import PICTURES, Analysis, Request
from .building import free_names, numbers_of
from .traced import traced
from .wants import unit_of


def _stroke(asked: Request) -> dict[str, Any]:
    """Verdict over the stroke, with stresses on the page."""
    options, model = asked.options, asked.builder.build()
    stroke: Any = options["to"] if options["coordinate"] is None else {options["coordinate"]: options["to"]}
    with heard() as warnings:
        watch = asked.watch("strokes")
        found = verdict(model, stroke, node=options["node"], steps=options["steps"], progress=watch)
    asked.job.tell(text="drawing")
    title, rows, *_ = found.summary()
    text = "\n".join([title, *warnings])
    with PICTURES, heard():
        picture = figure_bytes(lambda: plot.verdict(found), "svg").decode()
    with heard():
        stresses = None
        if "stress" in found.curves:
            model = with_turn(model, str(options["coordinate"]))
            what = driven(model, options["coordinate"])
            states: list[Linearization] = [what.at(model, s).held for s in found.stroke.tolist()]
            stresses = [stress(state.model, at=state) for state in states]
        data = page_data(view(found, stresses) if stresses else view(found))
    return {"status": "done", "text": text, "rows": list(map(list, rows.items())), "picture": picture, "view": data}


def _sweep(asked: Request) -> dict[str, Any]:
    """Frequencies, load multiplier, stress and mass as one name varies."""
    options, document, model = asked.options, asked.document, asked.builder.build()
    name, numbers = options["name"] or free_names(document)[0], numbers_of(document)
    now = float(numbers[f"names/{name}/value"])
    ends = [options[end] if options[end] is not None else numbers.get(f"names/{name}/{end}") for end in ("low", "high")]
    low, high = (float(v if v is not None else w) for v, w in zip(ends, sorted((now / 2, 2 * now)), strict=True))
    if not low < high:
        raise ValueError(f"'{clean(name)}' goes from {low:g} to {high:g}. The last value must be larger.")
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
    found = np.array(rows)
    lost = int(np.sum(np.any(np.isnan(found), axis=1)))
    with PICTURES, heard():
        picture = figure_bytes(lambda: _curves(name, values, now, keys, found), "svg").decode()
    plain = [[number if np.isfinite(number) else None for number in row] for row in found.tolist()]
    table = [{name: v, **dict(zip(keys, row, strict=True))} for v, row in zip(values.tolist(), plain, strict=True)]
    text = f"{clean(name)} from {low:g} to {high:g}" + (f"; {lost} designs have no answer" if lost else "")
    return {"status": "done", "text": text, "rows": table, "picture": picture}


def _curves(name: str, values: np.ndarray, now: float, keys: list[str], found: np.ndarray) -> Any:
    """A panel for each kind of answer."""
    import matplotlib.pyplot as plt

    kinds = list(dict.fromkeys(key.partition(" ")[0] for key in keys))
    figure = plt.figure(figsize=(3.7 * min(2, len(kinds)), 2.9 * -(-len(kinds) // 2)), layout="constrained")
    for i, kind in enumerate(kinds):
        ax = figure.add_subplot(-(-len(kinds) // 2), min(2, len(kinds)), i + 1)
        entries = [k for k, key in enumerate(keys) if key.partition(" ")[0] == kind]
        unit_of_kind = unit_of(keys[entries[0]])
        factor, unit = prefix_for(float(np.nanmax(np.abs(found[:, entries]), initial=0.0)), unit_of_kind)
        factor, unit = (1.0, "kg") if kind == "mass" else (factor, unit) if unit_of_kind else (1.0, "-")
        for k in entries:
            ax.plot(values, factor * found[:, k], label=keys[k])
        ax.axvline(now, color=GREY, linewidth=1.0, linestyle="--")
        ax.set(xlabel=name.replace("$", r"\$"), ylabel=f"{kind} [{unit}]")
        ax.grid(visible=True, alpha=0.3)
        if len(entries) > 1:
            ax.legend(fontsize=8)
    return figure


OWN = {
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
