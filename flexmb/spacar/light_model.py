"""SPACAR Light scripts as Builders: beams, supports and loads, and released deformations."""

from collections.abc import Mapping
from typing import Any

import jax
import numpy as np

from ..arguments import is_concrete
from ..build.builder import Builder
from ..checks.mobility import mobility, removals
from ..display import among, counted
from ..elements import spatial
from ..elements.sections import Circle, Material, Rectangle, Rigidity, Section
from ..errors import MechanismError, ModelError
from ..model.model import Model
from .light_checks import acts, rotations
from .light_fields import AXES, INPUTS, OUTPUTS, Script, field_value

Releases = Mapping[int, tuple[int, ...]]


def node_name(node: int) -> str:
    """Name of a node in the Builder."""
    return f"n{node}"


def beam_names(script: Script, element: int) -> list[str]:
    """Names in the Builder of the beams, or of the hinge, of an element."""
    fields = script.properties(element)
    count = field_value(fields, "eprops", "nbeams") if script.flexible(element) else 1
    return [f"e{element}.{i + 1}" for i in range(count)]


def build_script(script: Script) -> tuple[Builder, Model, Releases]:
    """Builder and Model of a script, and the released deformations of each element, which depend on geometry alone."""
    releases: Releases = script.opt.get("rls", {})
    if is_concrete((script.nodes, [fields.get("orien") for fields in script.eprops.values()])):
        # Nothing here is traced: compute at once, also within a trace.
        with jax.ensure_compile_time_eval():
            releases = _complete(script, releases)
    elif "rls" not in script.opt:
        raise ModelError(
            "The geometry (nodes or orien) is traced: over-constraints cannot be found. Give opt.rls, such as"
            " `overconstraints` of an untraced run, or {} for no release."
        )
    builder = describe(script, releases)
    return builder, builder.build(dofs="named", check=False), releases


def _complete(script: Script, releases: Releases) -> Releases:
    """Releases of a script, found if they are not given."""
    bare = describe(script, releases, bare=True).build(dofs="named", check=False)
    last = {beam_names(script, k)[-1]: k for k in script.numbers()}
    candidates = {(beam, i) for beam, k in last.items() for i in script.flexible(k) if i not in releases.get(k, ())}
    bare_mobility = mobility(bare)
    removed = removals(bare, candidates) if bare_mobility.overconstraints else ()
    proposed: dict[int, tuple[int, ...]] = {}
    for beam, i in (r for r in removed if r is not None):
        proposed[last[beam]] = tuple(sorted((*proposed.get(last[beam], ()), i)))
    if bare_mobility.underconstraints:
        raise MechanismError("underconstrained" if not bare_mobility.overconstraints else "both", _loose(bare_mobility))
    if None in removed:
        raise MechanismError("overconstrained", _redundant(script, {**releases, **proposed}, removed.count(None)))
    if removed and "rls" in script.opt:
        lines = [f"  opt.rls({k}).def = {list(numbers)} more" for k, numbers in proposed.items()]
        raise MechanismError(
            "overconstrained",
            f"The mechanism is over-constrained with opt.rls as given ({len(removed)} times). Leave opt.rls out to have"
            " it released automatically, or add, for example:\n" + "\n".join(lines),
        )
    return {k: releases.get(k, ()) + proposed.get(k, ()) for k in script.numbers() if k in releases or k in proposed}


def _loose(bare_mobility: Any) -> str:
    lines = [f"The mechanism is under-constrained: {counted(bare_mobility.underconstraints, 'free motion')}."]
    for i in range(bare_mobility.underconstraints):
        moving = list(dict.fromkeys(share.of.removesuffix(".rotation") for share in bare_mobility.motions(i)))
        parts = among(f"{s.of}.{s.symbol} ({s.share:.2g})" for s in bare_mobility.motions(i))
        lines.append(f"  motion {i + 1} of {among(moving)}: {parts}")
    return "\n".join([*lines, "Fix or support these nodes (n3 is node 3), or join them to the rest."])


def _redundant(script: Script, releases: Releases, count: int) -> str:
    """Message about over-constraints that no release removes."""
    bare_mobility = mobility(describe(script, releases, bare=True).build(dofs="named", check=False))
    lines = [f"The mechanism is over-constrained, and no deformation in flex can be released for it ({count} times)."]
    for i in range(bare_mobility.overconstraints):
        shares = [s for s in bare_mobility.stresses(i) if s.of[0] == "e" and not s.of.endswith(".pin")]
        stressed: dict[int, set[int]] = {}
        for share in shares:
            stressed.setdefault(int(share.of[1:].split(".")[0]), set()).add(share.component)
        flex = {k: set(script.flexible(k)) for k in sorted(stressed) if "flex" in script.properties(k)}
        soft = {k: sorted(stressed[k] - known) for k, known in flex.items()}
        advice = [f"add one of {numbers} to flex of element {k}" for k, numbers in soft.items() if numbers]
        remedy = "; or ".join(advice) or "they form a loop of rigid elements; make one of them flexible"
        lines.append(f"  elements {', '.join(map(str, sorted(stressed)))} hold each other: {remedy}")
    return "\n".join(lines)


def describe(script: Script, releases: Releases, bare: bool = False) -> Builder:
    """Builder of a script, with deformations in flex of each element's last beam as DOFs, except released ones.

    A bare Builder has geometry and supports only, without numbers that may be traced.
    """
    b = Builder()
    for i in range(1, len(script.nodes) + 1):
        b.node(node_name(i), list(script.nodes[i - 1]))
    for k in script.numbers():
        if script.is_hinge(k):
            _add_hinge(b, script, k)
        else:
            _add_beams(b, script, k, bare)
    for i, fields in sorted(script.nprops.items()):
        _support(b, node_name(i), fields, bare)
        if not bare:
            _load(b, node_name(i), fields)
    for k in script.numbers():
        beams = beam_names(script, k)
        for beam in beams:
            free = releases.get(k, ()) if beam is beams[-1] else ()
            remaining = [i for i in script.flexible(k) if i not in free]
            if free:
                b.release(beam, *free)
            if remaining:
                b.dof(beam, *remaining)
    for name, node in list(b.nodes.items()):
        if node.kind.part == "warping" and not _holds_warping(script, name.removesuffix(".warping")):
            b.dof(name, 1)
    if not bare and "gravity" in script.opt and acts(script.opt["gravity"]):
        b.gravity(list(script.opt["gravity"]))
    return b


def _add_hinge(b: Builder, script: Script, k: int) -> None:
    """A hinge between the rotations of two nodes, whose positions are tied."""
    p, q = (node_name(i) for i in script.ends(k))
    b.add(spatial.hinge, p, q, name=f"e{k}.1", axis=script.properties(k)["orien"], released=())
    b.add(spatial.rigid_beam, p, q, name=f"e{k}.pin")


def _add_beams(b: Builder, script: Script, k: int, bare: bool) -> None:
    fields, beams = script.properties(k), beam_names(script, k)
    p, q = script.ends(k)
    start, end = script.nodes[p - 1], script.nodes[q - 1]
    y = field_value(fields, "eprops", "orien") if "flex" in fields or "dens" in fields else None
    section = None if bare else section_of(script, k)
    ends = [node_name(p)]
    for i in range(1, len(beams)):
        ends.append(b.node(f"e{k}.n{i}", list(start + (end - start) * (i / len(beams)))))
    ends.append(node_name(q))
    for beam, first, second in zip(beams, ends[:-1], ends[1:], strict=True):
        element, named = spatial.beam, {"name": beam, "section": section, "y": y, "released": ()}
        if script.warps(k):
            element, named["clamped"] = spatial.warping_beam, [_holds_warping(script, n) for n in (first, second)]
        b.add(element, first, second, **named)


def section_of(script: Script, k: int) -> Section | None:
    """Section of an element; for a rigid one only its mass, and None without density."""
    fields = script.properties(k)
    flexible = bool(script.flexible(k))
    if not flexible and "dens" not in fields:
        return None
    dim = fields["dim"]
    moduli = (fields["emod"], fields["smod"]) if flexible else (1.0, 1.0)
    material = Material(*moduli, fields["dens"])
    if fields["cshape"] == "circ":
        section: Section = Circle(dim[0], material, shear=True)
    else:
        # The closed form for both ends of the whole element; a warping beam needs none.
        length = _length(script, k) if flexible and fields.get("cw") else None
        section = Rectangle(dim[0], dim[1], material, shear=True, warping_length=length, warping_modulus="beam")
    if flexible:
        return section
    s = section.rigidity()
    return Rigidity(mass=s.mass, Jx=s.Jx, Jy=s.Jy, Jz=s.Jz)


def _length(script: Script, k: int) -> Any:
    p, q = script.ends(k)
    along = script.nodes[q - 1] - script.nodes[p - 1]
    return (along @ along) ** 0.5


def _holds_warping(script: Script, name: str) -> bool:
    """Whether nothing warps at a node: its rotation is held, or a rigid element or a hinge is joined.

    Nodes between the beams of an element are free. A build has the same rules, and one on thickness, which may be
    traced here.
    """
    number = next((i for i in range(1, len(script.nodes) + 1) if node_name(i) == name), None)
    if number is None:
        return False
    fields = script.nprops.get(number, {})
    if any(field in fields for field in ("fix", "fix_orien", "fix_warp")) or rotations(fields):
        return True
    return any(script.is_hinge(k) or not script.flexible(k) for k in script.at(number))


def _support(b: Builder, node: str, fields: dict[str, Any], bare: bool) -> None:
    for name, parts in (("fix", ()), ("fix_pos", ("position",)), ("fix_orien", ("rotation",))):
        if name in fields:
            b.fix(node, *parts)
    for axis in AXES:
        if f"fix_{axis}" in fields:
            b.fix(node, axis)
    for when, increment in (("_initial", False), ("", True)):
        for axis in AXES:
            value = fields.get(f"displ{when}_{axis}")
            if value is not None:
                b.prescribe(node, axis, 0.0 if bare else value, increment=increment)
    for name, (axis, value) in rotations(fields).items():
        # One axis given by its letter leaves the tilt free, as in the predecessor; "rot" holds the tilt.
        if axis in AXES:
            about, angle, tilt = np.eye(3)[AXES.index(axis)], value, "free"
        else:
            about, angle, tilt = value[1:] / (value[1:] @ value[1:]) ** 0.5, value[0], "fixed"
        about, angle = (np.eye(3)[0], 0.0) if bare and tilt == "fixed" else (about, 0.0 if bare else angle)
        b.prescribe(node, "rotation", angle, axis=list(about), tilt=tilt, increment="initial" not in name)


def _load(b: Builder, node: str, fields: dict[str, Any]) -> None:
    if acts(fields.get("mass")):
        b.mass(node, fields["mass"])
    if acts(fields.get("mominertia")):
        b.inertia(node, fields["mominertia"])
    for when, increment in (("_initial", False), ("", True)):
        if acts(fields.get(f"force{when}")):
            b.force(node, list(fields[f"force{when}"]), increment=increment)
        if acts(fields.get(f"moment{when}")):
            b.moment(node, fields[f"moment{when}"], increment=increment)
    for word in (w for w in INPUTS if w in fields.get("transfer_in", ())):
        b.input(node, word[-1], name=f"{word.replace('_', '-')} {node}")
    for word in (w for w in OUTPUTS if w in fields.get("transfer_out", ())):
        quantity = "position" if word.startswith("displ") else "velocity"
        b.output(node, word[-1], quantity, name=f"{word.replace('_', '-')} {node}")
