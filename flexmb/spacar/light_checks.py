"""Checks of a SPACAR Light script: geometry, supports, element sets, options."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..arguments import is_concrete
from ..errors import ModelError, printable
from ..numerical_limits import LIGHT_LENGTH_RATIO, LIGHT_PARALLEL, LIGHT_SHORTEST, LIGHT_THIN, TEN_DIGITS
from .light_fields import AXES, COUNTS, Script, field_faults, field_value, structures_by_number
from .lines import LARGEST, SMALLEST, within

MANY_STEPS = 100


def check_script(script: Script) -> None:
    """Raise ModelError with one line a fault; add ``sets`` and warnings to the script, and convert some options."""
    faults = list(_connections(script))
    if not faults:
        faults += _membership(script)
        for number in sorted(script.eprops):
            faults += _set(script, number)
        if is_concrete(script.nodes):
            faults += _lengths(script)
        for number in sorted(script.nprops):
            faults += _node(script, number)
        faults += [*_supports(script), *_options(script)]
    if faults:
        raise ModelError("\n".join(faults))


def acts(value: Any) -> bool:
    """Whether a load is given, and not known to be zero."""
    return value is not None and (not is_concrete(value) or bool(np.any(np.asarray(value) != 0)))


def _connections(script: Script) -> Iterator[str]:
    n = len(script.nodes)
    if is_concrete(script.nodes):
        for i in np.flatnonzero(~np.all(within(script.nodes), axis=1)):
            size = f"finite numbers, 0 or from {SMALLEST:g} to {LARGEST:g} in size"
            yield f"Node {i + 1}: its position must be {size}, but is {script.nodes[i]}."
    pairs: dict[tuple[int, int], int] = {}
    for k in script.numbers():
        p, q = script.ends(k)
        for end in (p, q):
            if not 1 <= end <= n:
                yield f"Element {k}: there is no node {end}; nodes are numbered from 1 to {n}."
        if p == q:
            yield f"Element {k}: joins node {p} to itself; give it two nodes."
        first = pairs.setdefault((min(p, q), max(p, q)), k)
        if first != k:
            script.warnings.append(f"Elements {first} and {k} join the same nodes {p} and {q}.")
    for i in range(1, n + 1):
        if not np.any(script.elements == i):
            yield f"Node {i}: is in no element; attach it or leave it out."


def _lengths(script: Script) -> Iterator[str]:
    ends = script.nodes[script.elements - 1]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    for k in script.numbers():
        if script.is_hinge(k) and lengths[k - 1] > LIGHT_SHORTEST:
            yield f"Element {k}: a hinge joins two nodes at the same place, but they are {lengths[k - 1]:.6g} m apart."
        elif not script.is_hinge(k) and lengths[k - 1] <= LIGHT_SHORTEST:
            yield f"Element {k}: its length is {lengths[k - 1]:.6g} m, but must be more than {LIGHT_SHORTEST:g} m."
    beams = [k for k in script.numbers() if not script.is_hinge(k) and lengths[k - 1] > LIGHT_SHORTEST]
    if not beams:
        return
    longest, shortest = (choose(beams, key=lambda k: lengths[k - 1]) for choose in (max, min))
    if lengths[longest - 1] > LIGHT_LENGTH_RATIO * lengths[shortest - 1]:
        times = f"more than {LIGHT_LENGTH_RATIO} times as long as element {shortest}"
        yield f"Element {longest}: is {times}; check the units."
    for k in beams:
        yield from _orientation(script, k, ends[k - 1, 1] - ends[k - 1, 0])


def _orientation(script: Script, k: int, along: np.ndarray) -> Iterator[str]:
    fields = script.properties(k)
    if not ("flex" in fields or "dens" in fields):
        return
    across = field_value(fields, "eprops", "orien")
    if is_concrete(across):
        size = np.linalg.norm(along) * np.linalg.norm(across)
        if np.linalg.norm(np.cross(along, across)) <= LIGHT_PARALLEL * size:
            default = "" if "orien" in fields else " (the default)"
            yield (
                f"Element {k}: orien = {np.asarray(across).tolist()}{default} in eprops({script.sets[k]}) is zero or"
                " parallel to its axis; give the direction of the width."
            )


def _membership(script: Script) -> Iterator[str]:
    for number, fields in sorted(script.eprops.items()):
        if "elems" not in fields:
            yield f"eprops({number}).elems: is missing; give the numbers of the elements of this set."
        for k in fields.get("elems", ()):
            if k > len(script.elements):
                yield f"eprops({number}).elems: there is no element {k}; they are numbered to {len(script.elements)}."
            elif k in script.sets:
                yield (
                    f"Element {k}: is in eprops({script.sets[k]}) and in eprops({number}); each element belongs to one"
                    " set."
                )
            else:
                script.sets[k] = number


def _set(script: Script, number: int) -> Iterator[str]:
    fields, where = script.eprops[number], f"eprops({number})"
    if fields.get("type") == "hinge":
        other = [name for name in fields if name not in ("elems", "type", "orien")]
        if other:
            yield f"{where}: a hinge takes elems and orien, not {', '.join(other)}."
        if not acts(fields.get("orien")):
            yield f"{where}.orien: must be the axis of the hinge, three numbers not all zero."
        return
    yield from field_faults(fields, "eprops", f"{where}.{{}}:")
    yield from _section(script, number)
    flex, form = field_value(fields, "eprops", "flex"), fields.get("cshape")
    if missing := [name for name in ("emod", "smod", "dens", "cshape", "dim") if flex and name not in fields]:
        yield f"{where}: flexible elements need {', '.join(missing)} too."
    for name in ("warping", "cw"):
        if name in fields and not (2 in flex and form == "rect"):
            script.warnings.append(
                f"{where}.{name} has no effect: it is for elements of cshape 'rect' whose torsion, 2, is in flex."
            )
    if "warping" in fields and "cw" in fields:
        yield f"{where}: has warping and cw, which model the same effect; leave out cw."
    if "nbeams" in fields and not flex:
        script.warnings.append(f"{where}.nbeams has no effect on rigid elements.")


def _section(script: Script, number: int) -> Iterator[str]:
    fields, where = script.eprops[number], f"eprops({number})"
    if missing := [name for name in ("cshape", "dim") if "dens" in fields and name not in fields]:
        yield f"{where}: has dens, and so needs {', '.join(missing)} for its mass."
    sizes = {"rect": (2, "[width, thickness]"), "circ": (1, "the diameter")}.get(fields.get("cshape", ""))
    if sizes is None or "dim" not in fields:
        return
    if fields["dim"].shape[0] != sizes[0]:
        yield f"{where}.dim: of a '{fields['cshape']}' must be {sizes[1]}, but has {fields['dim'].shape[0]} numbers."
    # The predecessor refuses so thin a rectangle; foils of 50 micrometres exist.
    elif is_concrete(fields["dim"]) and 0 < np.min(fields["dim"]) < LIGHT_THIN:
        script.warnings.append(f"{where}.dim = {fields['dim'].tolist()} is below {LIGHT_THIN:g} m: is it in metres?")


def rotations(own: dict[str, Any]) -> dict[str, tuple[str, Any]]:
    """Prescribed rotations of a node: for each field its axis ("x", "y", "z" or "free") and its value."""
    single = {f"rot{when}_{axis}": axis for when in ("", "_initial") for axis in AXES}
    named = {**single, "rot": "free", "rot_initial": "free"}
    return {name: (axis, own[name]) for name, axis in named.items() if name in own}


def _node(script: Script, number: int) -> Iterator[str]:
    fields, where = script.nprops[number], f"Node {number}"
    if number > len(script.nodes):
        yield f"nprops({number}): there is no node {number}; nodes are numbered to {len(script.nodes)}."
        return
    fix_names = [name for name in fields if name.startswith("fix")]
    if "fix" in fields and len(fix_names) > 1:
        yield f"{where}: fix fixes the whole node; leave out {', '.join(n for n in fix_names if n != 'fix')}."
    elif "fix_pos" in fields and any(f"fix_{axis}" in fields for axis in AXES):
        yield f"{where}: fix_pos fixes x, y and z; leave out {', '.join(n for n in fix_names if n[4:] in AXES)}."
    for i, axis in enumerate(AXES):
        ways = [name for name in ("fix", "fix_pos", f"fix_{axis}") if name in fields][:1]
        ways += [n for n in ("force", "force_initial") if n in fields and acts(fields[n][i])][:1]
        ways += [n for n in (f"displ_{axis}", f"displ_initial_{axis}") if n in fields][:1]
        if len(ways) > 1:
            yield f"{where}: {' and '.join(ways)} act on {axis}; choose one."
    turns = rotations(fields)
    ways = [name for name in ("fix", "fix_orien") if name in fields][:1]
    ways += [name for name in ("moment", "moment_initial") if acts(fields.get(name))][:1] + list(turns)[:1]
    if len(ways) > 1:
        yield f"{where}: {' and '.join(ways)} act on its rotation; choose one."
    yield from _turns(where, turns)
    yield from field_faults(fields, "nprops", f"{where}: {{}}")
    if acts(fields.get("mass")) and ("fix" in fields or "fix_pos" in fields):
        script.warnings.append(f"{where}: its mass does not move, since the node is fixed.")
    if "fix_warp" in fields and not any("warping" in script.properties(k) for k in script.at(number)):
        script.warnings.append(f"{where}: fix_warp has no effect, since no element there has warping.")


def _turns(where: str, turns: dict[str, tuple[str, Any]]) -> Iterator[str]:
    if len({axis for axis, _ in turns.values()}) > 1:
        yield (
            f"{where}: {' and '.join(turns)} turn about several axes; a node has one axis, which may be any axis with"
            " rot."
        )
        return
    known = None
    for name, (axis, value) in turns.items():
        if axis != "free" or not is_concrete(value):
            continue
        if not np.linalg.norm(value[1:]) > 0:
            yield f"{where}: {name} must be [angle, ax, ay, az] with an axis that is not zero."
            continue
        unit = value[1:] / np.linalg.norm(value[1:])
        if known is not None and not np.allclose(unit, known, rtol=0, atol=TEN_DIGITS):
            yield f"{where}: rot and rot_initial turn about two axes; a node has one axis."
        known = unit


def _supports(script: Script) -> Iterator[str]:
    """A necessary number of supports; the rank of the constraints decides later."""
    count = 0
    for fields in script.nprops.values():
        count += 6 * ("fix" in fields) + 3 * ("fix_pos" in fields) + 3 * ("fix_orien" in fields)
        for axis in AXES:
            names = (f"fix_{axis}", f"displ_{axis}", f"displ_initial_{axis}")
            count += any(name in fields for name in names)
        turns = {axis for axis, _ in rotations(fields).values()}
        count += 3 * ("free" in turns) + len(turns - {"free"})
    if count < 6:
        yield f"nprops: {count} coordinates are fixed, but at least 6 are needed; use fix, fix_pos, fix_x .."


def _options(script: Script) -> Iterator[str]:
    opt = script.opt
    for name in ("customdyn", "customkin"):
        if name in opt:
            yield (
                f"opt.{name}: lines of an input file are not read here. Add to the model with the methods of"
                " Builder (spacar_light(..).builder), or read the whole file with read_spacar."
            )
    yield from field_faults(opt, "opt", "opt.{}:")
    if field_value(opt, "opt", "loadsteps") >= MANY_STEPS:
        script.warnings.append(f"opt.loadsteps = {opt['loadsteps']}: so many equilibria take long.")
    if "rls" in opt:
        yield from _releases(script)
    if "transfer" in opt:
        try:
            transfer = np.ravel(np.asarray(opt["transfer"], float))
        except (ValueError, TypeError):
            transfer = np.zeros(0)
        if transfer.size not in (1, 2) or transfer[0] not in (0, 1) or not np.all(transfer >= 0):
            yield f"opt.transfer: must be true, or [true, damping ratio], but is {printable(repr(opt['transfer']))}."
            return
        opt["transfer"] = tuple(transfer.tolist()) if transfer[0] else None
    given = {name for properties in script.nprops.values() for name in properties}
    fields = [name for name in ("transfer_in", "transfer_out") if name in given]
    if opt.get("transfer"):
        if len(fields) < 2:
            yield "opt.transfer: needs an input (transfer_in) and an output (transfer_out) at some node."
    elif fields:
        script.warnings.append(f"{' and '.join(fields)} have no effect without opt.transfer.")


def _releases(script: Script) -> Iterator[str]:
    """``opt.rls`` by element number; empty if nothing is released."""
    stated, releases = script.opt["rls"], {}
    faults: list[str] = []
    pairs = structures_by_number(stated, "opt.rls", faults)
    yield from faults
    for number, value in pairs:
        if not isinstance(value, dict) and hasattr(value, "__dict__") and not hasattr(value, "shape"):
            value = vars(value)
        if isinstance(value, dict):
            value = value.get("def", value.get("def_", ()))
        try:
            numbers = COUNTS.read(value) if np.size(value) else ()
        except (ValueError, TypeError, OverflowError):
            yield f"opt.rls({number}): must be numbers of deformations, but is {printable(repr(value))}."
            continue
        if not 1 <= number <= len(script.elements):
            yield f"opt.rls({number}): there is no element {number}; they are numbered to {len(script.elements)}."
        elif not set(numbers) <= set(script.flexible(number)):
            flex = list(script.flexible(number)) or "none, it is rigid"
            yield f"opt.rls({number}): must be some of the flex of element {number} ({flex}), but is {list(numbers)}."
        elif numbers:
            releases[number] = numbers
    script.opt["rls"] = releases
