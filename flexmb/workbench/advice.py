"""What to do about a mechanism that is not what it should be, as edits that a button makes."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ..build.dofs import CANNOT_MOVE, choose, named_rows
from ..checks.mobility import motions_of
from ..linear.linearize import linearize
from ..linear.spectrum import masses_of_motions
from ..math.subspace import independent_rows
from ..model.model import Entry, Model
from .counts import Count

# A mass and a rotary inertia to begin with, that one changes [kg, kg m^2].
MASS, INERTIA = "0.1", "1e-4"
# A motion whose mass is below this share of the largest has none.
MASSLESS = 1e-12
# Pieces of advice of one kind.
AT_MOST = 4

Advice = dict[str, Any]


def advice(found: Count, things: Iterable[dict[str, Any]]) -> list[Advice]:
    """What to do about over- and under-constraints and about what floats."""
    things = list(things)
    return [*_releases(found, things), *_determinations(found, things), *_of_loose(found, things)]


def mass_advice(model: Model) -> list[Advice]:
    """Where to put mass, of a mechanism that moves somewhere without any."""
    lin = linearize(model, increment=0.0, throw=False)
    mass = np.asarray(lin.matrices.M0)
    if not mass.size or not np.all(np.isfinite(mass)):
        return []
    values, motions = masses_of_motions(mass)
    light = np.asarray(lin.matrices.DFx) @ motions[:, np.abs(values) <= MASSLESS]
    wanted: list[Advice] = []
    for motion in light.T:
        entry = model.labels.x[int(np.argmax(np.abs(motion)))]
        node = entry.of.removesuffix(".rotation")
        if entry.kind == "position":
            one = {"text": f"Put a mass on node '{node}'", "ops": [_add("mass", node=node, mass=MASS)]}
        elif entry.kind == "rotation" and model.labels.dimension == 2:
            one = {"text": f"Put rotary inertia on node '{node}'", "ops": [_add("inertia", node=node, inertia=INERTIA)]}
        elif entry.kind == "rotation":
            whole = [INERTIA, "0", "0", INERTIA, "0", INERTIA]
            one = {"text": f"Put rotary inertia on node '{node}'", "ops": [_add("inertia", node=node, inertia=whole)]}
        else:
            continue
        if one not in wanted:
            wanted.append(one)
    return wanted[:AT_MOST]


def _add(call: str, **arguments: Any) -> dict[str, Any]:
    return {"op": "add", "thing": {"call": call, "args": arguments}}


def _releases(found: Count, things: list[dict[str, Any]]) -> list[Advice]:
    """Deformations to release, one a state of self-stress, and all of them; supports are edited where they are."""
    if found.mobility is None or not found.over:
        return []
    proposed = [one for one in dict.fromkeys(found.mobility.release) if one is not None]
    releases = [(of, component) for of, component in proposed if isinstance(component, int)]
    given = []
    for element, number in releases[:AT_MOST]:
        text = f"Release deformation {number} of '{element}'"
        given.append({"text": text, "ops": _release([(element, number)], things)})
    if len(releases) > 1:
        every = ", ".join(f"{number} of '{element}'" for element, number in releases)
        given.insert(0, {"text": f"Release deformations {every}", "ops": _release(releases, things)})
    return given


def _release(releases: Sequence[tuple[str, int]], things: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Edits that release deformations: in the field of the element where it says which, else by a call of its own."""
    ops = []
    for element in dict.fromkeys(name for name, _ in releases):
        numbers = [number for name, number in releases if name == element]
        thing = next((one for one in things if one.get("name") == element and "nodes" in one.get("args", {})), None)
        words = str(thing["args"].get("released") or "").replace(",", " ").split() if thing else []
        if thing and words and all(word.isdecimal() for word in words):
            whole = " ".join(map(str, sorted({*map(int, words), *numbers})))
            ops.append({"op": "set", "address": f"{thing['id']}/released", "to": whole})
        else:
            ops.append(_add("release", element=element, deformations=" ".join(map(str, numbers))))
    return ops


def _determinations(found: Count, things: list[dict[str, Any]]) -> list[Advice]:
    """What to name as degree of freedom, or to fix, where motions are left; or to have them found."""
    named = [thing["id"] for thing in things if thing["call"] == "dof"]
    if found.status not in ("underconstrained", "both", "dof") or not named:
        return []
    given: list[Advice] = [
        {"text": "Have the degrees of freedom found", "ops": [{"op": "delete", "ids": named}]},
    ]
    if found.drawn is None or not found.under:
        return given
    model = found.drawn
    motions, _ = motions_of(model)
    rows = named_rows(model, motions)
    taken, rest = independent_rows(rows, model.topology.n_q, CANNOT_MOVE)
    left, wanted = motions @ rest, motions.shape[1] - len(taken)
    if wanted <= 0:
        return given
    x, e = choose(model, motions, rows)
    more = [model.labels.x[i] for i in x] + [model.labels.e[i] for i in e]
    if len(more) == wanted and all(entry.kind in ("position", "rotation", "deformation") for entry in more):
        names = ", ".join(map(str, more))
        given.append({"text": f"Name {names} as degrees of freedom too", "ops": [_dof(entry) for entry in more]})
    free = [i for i in np.asarray(model.topology.x.dependent).tolist() if _can_be_fixed(model.labels.x[i])]
    chosen, _ = independent_rows(left[free], wanted, CANNOT_MOVE)
    if len(chosen) == wanted:
        held = [model.labels.x[free[i]] for i in sorted(chosen)]
        ops = [_add("fix", node=entry.of, components=entry.symbol) for entry in held]
        given.append({"text": f"Fix {', '.join(map(str, held))}", "ops": ops})
    return given


def _dof(entry: Entry) -> dict[str, Any]:
    component = str(entry.component) if entry.kind == "deformation" else entry.symbol
    return _add("dof", of=entry.of, components=component)


def _can_be_fixed(entry: Entry) -> bool:
    return entry.kind == "position" or entry.symbol == "phi"


def _of_loose(found: Count, things: list[dict[str, Any]]) -> list[Advice]:
    """Nodes to delete that stand alone, and nodes to fix of what floats."""
    own = {thing.get("name"): thing["id"] for thing in things if thing["call"] == "node"}
    given: list[Advice] = []
    if not any(part.elements for part in found.parts):
        return given
    for part in found.parts:
        if part.elements and not part.held and part.nodes:
            node = part.nodes[0]
            given.append({"text": f"Fix node '{node}'", "ops": [_add("fix", node=node)]})
        elif not part.elements and part.nodes and part.nodes[0] in own:
            node = part.nodes[0]
            given.append({"text": f"Delete node '{node}'", "ops": [{"op": "delete", "ids": [own[node]]}]})
    return given[:AT_MOST]
