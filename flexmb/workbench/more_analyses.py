"""Analyses beside the modes of the command line: a mechanism over its stroke, and answers over a dimension."""

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
    """Force of the drive, stress, support stiffness, frequencies and parasitic motion at each stroke."""
    options, model = asked.options, asked.builder.build()
    stroke: Any = options["to"] if options["coordinate"] is None else {options["coordinate"]: options["to"]}
    with heard() as said:
        watch = asked.watch("strokes")
        found = verdict(model, stroke, node=options["node"], steps=options["steps"], progress=watch)
    asked.job.tell(text="drawing")
    title, rows, *_ = found.summary()
    told: dict[str, Any] = {
        "status": "done",
        "text": "\n".join([title, *said]),
        "rows": [list(row) for row in rows.items()],
    }
    with PICTURES, heard():
        told["picture"] = figure_bytes(lambda: plot.verdict(found), "svg").decode()
    with heard():
        own = None
        if "stress" in found.curves:
            model = with_turn(model, str(options["coordinate"]))
            what = driven(model, options["coordinate"])
            states: list[Linearization] = [what.at(model, s).held for s in found.stroke.tolist()]
            own = [stress(held.model, at=held) for held in states]
        told["view"] = page_data(view(found, own) if own else view(found))
    return told


def _sweep(asked: Request) -> dict[str, Any]:
    """Frequencies, load multiplier, stress and mass as one of the names varies."""
    options, document, model = asked.options, asked.document, asked.builder.build()
    name, numbers = options["name"] or free_names(document)[0], numbers_of(document)
    now = float(numbers[f"names/{name}/value"])
    ends = [options[end] if options[end] is not None else numbers.get(f"names/{name}/{end}") for end in ("low", "high")]
    low, high = (float(v if v is not None else w) for v, w in zip(ends, sorted((now / 2, 2 * now)), strict=True))
    if not low < high:
        raise ValueError(f"'{clean(name)}' goes from a lower to a higher value, not from {low:g} to {high:g}.")
    keys = [f"frequency {i + 1}" for i in range(min(3, model.topology.n_q))] + ["mass"]
    if has_loads(model.topology, model.parameters):
        keys += ["multiplier 1"] + (["stress"] if has_stress(model) else [])
    function = traced(document, model, keys)
    at, watch = function.at(document), asked.watch("designs", options["points"])
    values, rows = np.linspace(low, high, options["points"]), []
    whole = np.array([float(numbers[f"names/{n}/value"]) for n in function.names])
    for i, value in enumerate(values.tolist()):
        watch(i)
        whole[function.names.index(name)] = value
        answers, _, code = at(whole)
        rows.append(np.where(np.isfinite(answers) & (code == 0), answers, np.nan))
    found = np.array(rows)
    lost = int(np.sum(np.any(np.isnan(found), axis=1)))
    with PICTURES, heard():
        picture = figure_bytes(lambda: _curves(name, values, now, keys, found), "svg").decode()
    table_ = [
        {name: v, **dict(zip(keys, row, strict=True))} for v, row in zip(values.tolist(), _plain(found), strict=True)
    ]
    text = f"{clean(name)} from {low:g} to {high:g}" + (f"; {lost} designs have no answer" if lost else "")
    return {"status": "done", "text": text, "rows": table_, "picture": picture}


def _plain(values: np.ndarray) -> list[list[float | None]]:
    return [[float(v) if np.isfinite(v) else None for v in row] for row in values]


def _curves(name: str, values: np.ndarray, now: float, keys: list[str], found: np.ndarray) -> Any:
    """A panel for each kind of answer."""
    import matplotlib.pyplot as plt

    kinds = list(dict.fromkeys(key.partition(" ")[0] for key in keys))
    figure = plt.figure(figsize=(3.7 * min(2, len(kinds)), 2.9 * -(-len(kinds) // 2)), layout="constrained")
    for i, kind in enumerate(kinds):
        ax = figure.add_subplot(-(-len(kinds) // 2), min(2, len(kinds)), i + 1)
        own = [k for k, key in enumerate(keys) if key.partition(" ")[0] == kind]
        factor, unit = prefix_for(float(np.nanmax(np.abs(found[:, own]), initial=0.0)), unit_of(keys[own[0]]))
        factor, unit = (1.0, "kg") if kind == "mass" else (factor, unit) if unit_of(keys[own[0]]) else (1.0, "-")
        for k in own:
            ax.plot(values, factor * found[:, k], label=keys[k])
        ax.axvline(now, color=GREY, linewidth=1.0, linestyle="--")
        ax.set(xlabel=name.replace("$", r"\$"), ylabel=f"{kind} [{unit}]")
        ax.grid(visible=True, alpha=0.3)
        if len(own) > 1:
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
