"""Advice about a mechanism with faults, as edits that a button makes."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ..build.dofs import CANNOT_MOVE, choose, named_rows
from ..checks.mobility import allowed_motions
from ..linear.linearize import linearize
from ..linear.spectrum import masses_of_motions
from ..math.subspace import independent_rows
from ..model.model import Model
from ..numerical_limits import NO_MASS
from .counts import Count

# Mass and rotary inertia to begin with [kg, kg m^2].
MASS, INERTIA = "0.1", "1e-4"
# Number of pieces of advice of one kind.
AT_MOST = 4

Advice = dict[str, Any]


def advice(found: Count, things: Iterable[dict[str, Any]]) -> list[Advice]:
    """Advice about over- and under-constraints, and about floating parts."""
    things = list(things)
    return [*_releases(found, things), *_determinations(found, things), *_loose_suggestions(found, things)]


def mass_advice(model: Model) -> list[Advice]:
    """Advice where to put mass, for a mechanism with massless motions."""
    lin = linearize(model, increment=0.0, throw=False)
    mass = np.asarray(lin.matrices.M0)
    if not mass.size or not np.all(np.isfinite(mass)):
        return []
    values, motions = masses_of_motions(mass)
    light = np.asarray(lin.matrices.DFx) @ motions[:, np.abs(values) <= NO_MASS]
    inertia = INERTIA if model.labels.dimension == 2 else [INERTIA, "0", "0", INERTIA, "0", INERTIA]
    calls = {"position": ("a mass", "mass", MASS), "rotation": ("rotary inertia", "inertia", inertia)}
    suggestions: list[Advice] = []
    for motion in light.T:
        entry = model.labels.x[int(np.argmax(np.abs(motion)))]
        if entry.kind in calls:
            (what, call, value), node = calls[entry.kind], entry.of.removesuffix(".rotation")
            piece = {"text": f"Put {what} on node '{node}'", "ops": [_add(call, node=node, **{call: value})]}
            suggestions += [piece] if piece not in suggestions else []
    return suggestions[:AT_MOST]


def _add(call: str, **arguments: Any) -> dict[str, Any]:
    return {"op": "add", "thing": {"call": call, "args": arguments}}


def _releases(dof_count: Count, items: list[dict[str, Any]]) -> list[Advice]:
    """Deformations to release, one for each state of self-stress, and all of them."""
    if dof_count.mobility is None or not dof_count.over:
        return []
    proposed = [release for release in dict.fromkeys(dof_count.mobility.release) if release is not None]
    # Supports are edited where they are.
    releases = [(element_name, component) for element_name, component in proposed if isinstance(component, int)]
    suggestions = []
    for element, number in releases[:AT_MOST]:
        text = f"Release deformation {number} of '{element}'"
        suggestions.append({"text": text, "ops": _release([(element, number)], items)})
    if len(releases) > 1:
        every = ", ".join(f"{number} of '{element}'" for element, number in releases)
        suggestions.insert(0, {"text": f"Release deformations {every}", "ops": _release(releases, items)})
    return suggestions


def _release(releases: Sequence[tuple[str, int]], items: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Edits that release deformations, in the field of an element that lists numbers, otherwise by a call."""
    ops = []
    for element in dict.fromkeys(name for name, _ in releases):
        numbers = [number for name, number in releases if name == element]
        item = next((t for t in items if t.get("name") == element and "nodes" in t.get("args", {})), None)
        words = str(item["args"].get("released") or "").replace(",", " ").split() if item else []
        if item and words and all(word.isdecimal() for word in words):
            text = " ".join(map(str, sorted({*map(int, words), *numbers})))
            ops.append({"op": "set", "address": f"{item['id']}/released", "to": text})
        else:
            ops.append(_add("release", element=element, deformations=" ".join(map(str, numbers))))
    return ops


def _determinations(dof_count: Count, items: list[dict[str, Any]]) -> list[Advice]:
    """Degrees of freedom to name, or supports to fix, for motions that are left; or to let the Builder choose."""
    named = [item["id"] for item in items if item["call"] == "dof"]
    if dof_count.status not in ("underconstrained", "both", "dof") or not named:
        return []
    suggestions: list[Advice] = [{"text": "Have the degrees of freedom found", "ops": [{"op": "delete", "ids": named}]}]
    if dof_count.drawn is None or not dof_count.under:
        return suggestions
    model = dof_count.drawn
    motions, _ = allowed_motions(model)
    rows = named_rows(model, motions)
    chosen_rows, remaining_basis = independent_rows(rows, model.topology.n_q, CANNOT_MOVE)
    remaining_motions, n_missing = motions @ remaining_basis, motions.shape[1] - len(chosen_rows)
    if n_missing <= 0:
        return suggestions
    x, e = choose(model, motions, rows)
    more = [model.labels.x[i] for i in x] + [model.labels.e[i] for i in e]
    if len(more) == n_missing and all(entry.kind in ("position", "rotation", "deformation") for entry in more):
        names = ", ".join(map(str, more))
        components = [str(entry.component) if entry.kind == "deformation" else entry.symbol for entry in more]
        ops = [_add("dof", of=e.of, components=component) for e, component in zip(more, components, strict=True)]
        suggestions.append({"text": f"Name {names} as degrees of freedom too", "ops": ops})
    labels = model.labels.x
    dependent = np.asarray(model.topology.x.dependent).tolist()
    free = [i for i in dependent if labels[i].kind == "position" or labels[i].symbol == "phi"]
    chosen, _ = independent_rows(remaining_motions[free], n_missing, CANNOT_MOVE)
    if len(chosen) == n_missing:
        fixed = [labels[free[i]] for i in sorted(chosen)]
        ops = [_add("fix", node=entry.of, components=entry.symbol) for entry in fixed]
        suggestions.append({"text": f"Fix {', '.join(map(str, fixed))}", "ops": ops})
    return suggestions


def _loose_suggestions(dof_count: Count, items: list[dict[str, Any]]) -> list[Advice]:
    """Nodes to delete that nothing joins, and nodes to fix of floating parts."""
    ids = {item.get("name"): item["id"] for item in items if item["call"] == "node"}
    suggestions: list[Advice] = []
    if not any(part.elements for part in dof_count.parts):
        return suggestions
    for part in dof_count.parts:
        if part.elements and not part.held and part.nodes:
            node = part.nodes[0]
            suggestions.append({"text": f"Fix node '{node}'", "ops": [_add("fix", node=node)]})
        elif not part.elements and part.nodes and part.nodes[0] in ids:
            node = part.nodes[0]
            suggestions.append({"text": f"Delete node '{node}'", "ops": [{"op": "delete", "ids": [ids[node]]}]})
    return suggestions[:AT_MOST]
