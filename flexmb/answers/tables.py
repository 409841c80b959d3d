"""Answers as text: the table on the terminal and the log file."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import printable
from ..mechanics.inertia import total_mass
from ..model.model import Entry, Model
from ..model.topology import Role
from ..spacar.lines import statements
from ..spacar.series import meaning_of_deformations
from .answer_parts import matrix, row
from .answers import Answer, mode_of

CLASS = {Role.FIXED: "O", Role.DEPENDENT: "C", Role.DOF: "M", Role.PRESCRIBED: "R"}


def table(data: dict[str, Any]) -> str:
    """Short table of an answer for the terminal."""
    lines = [f"{printable(data['model'])}  mode {data['mode']}  status {data['status']}"]
    lines.append("NDOF = NX - NXO - NEO = {nx} - {nxo} - {neo} = {ndof}".format(**data))
    names = ", ".join(f"{d['kind']} {d['of']}.{d['component']}" for d in data["dofs"])
    lines.append(f"degrees of freedom: {names or 'none named'}")
    lines += [f"warning: {text}" for text in data["warnings"]]
    if data["message"]:
        lines.append(data["message"])
    if "stable" in data:
        lines.append(f"stable: {'yes' if data['stable'] else 'NO'}")
    lines += mode_of(data["mode"]).table(data)
    for text, answer in data.get("asked", {}).items():
        lines.append(f"{printable(text)} [{answer['unit']}]: {row(answer['values'])}")
    return "\n".join(lines)


def _entries(title: str, entries: Sequence[Entry], roles: Sequence[Role]) -> list[str]:
    lines, grouped = [title], {}
    for entry, role, i in zip(entries, roles, range(1, len(roles) + 1), strict=True):
        if entry.kind != "norm":
            grouped.setdefault(entry.of, []).append(f"{entry.symbol}: {i} {CLASS[role]}")
    return lines + [f"  {name:<10}{'  '.join(parts)}" for name, parts in grouped.items()]


def _series(model: Model) -> list[str]:
    """Meaning of the numbers of spectral beams."""
    blocks = [b for b in model.topology.blocks if b.element.fields and "deformation" in b.companions]
    firsts = [
        (model.labels.e[row[0]].of, meaning_of_deformations(b.element))
        for b in blocks
        for row in np.asarray(b.e).tolist()
    ]
    return ["SPECTRAL BEAMS", *(f"  {name:<10}{text}" for name, text in firsts)] if firsts else []


def _counts(kind: str, roles: Sequence[Role]) -> str:
    n = {letter: sum(CLASS[role] == letter for role in roles) for letter in "OMRC"}
    return f"N{kind}O {n['O']}  N{kind}MM {n['M']}  N{kind}M {n['M'] + n['R']}  N{kind}C {n['C']}"


def log(found: Answer, source: str) -> str:
    """Log of a run: input, structure, numbers, transfer functions and results."""
    data, model, lin = found.data, found.model, found.lin
    lines = [f"flexmb {data['flexmb']}   {data['model']}   mode {data['mode']}", "", "INPUT"]
    # Control letters are escaped: a terminal would act on them.
    lines += ["  " + "".join(printable(c) for c in s.raw) for s in statements(source)]
    if model is not None:
        x_roles, e_roles = model.roles()
        lines += ["", "Classes: O fixed, C calculable, M degree of freedom, R prescribed"]
        lines += _entries("ELEMENTS: deformation numbers and classes", model.labels.e, e_roles)
        lines += _series(model)
        lines += _entries("NODES: coordinate numbers and classes", model.labels.x, x_roles)
        lines += ["DEGREES OF FREEDOM", *(f"  {i + 1}  {name}" for i, name in enumerate(model.q_labels))]
        lines += [_counts("E", e_roles), _counts("X", x_roles)]
        lines.append("NX {nx}  NE {ne}  NXO {nxo}  NEO {neo}  NDOF {ndof}".format(**data))
        lines += ["", "ELEMENT PROPERTIES (by type)"]
        for block, properties in zip(model.topology.blocks, model.parameters.properties, strict=True):
            lines.append(f"  {block.element.name}, {block.x.shape[0]} elements: {properties}")
        lines += ["LOADS", f"  {model.parameters.loads}", f"  increments: {model.parameters.increment}"]
        lines.append(f"TOTAL MASS {float(total_mass(model.topology, model.parameters)):.9g} kg")
    if lin is not None:
        from ..linear.second_order_transfer import second_transfer

        m = lin.matrices
        lines += ["", f"STATIC EQUILIBRIUM: {int(m.iterations)} iterations", f"  x   {row(m.x)}"]
        lines += [f"  e   {row(m.e)}", f"  sig {row(m.sigma)}", "TRANSFER FUNCTIONS"]
        lines += [*matrix("DF x", m.DFx), *matrix("DF e", m.DFe)]
        d2x, d2e = second_transfer(lin)
        for i, name in enumerate(model.q_labels if model is not None and len(m.M0) <= 3 else []):
            lines += [*matrix(f"D2F x by {name}", d2x[:, :, i]), *matrix(f"D2F e by {name}", d2e[:, :, i])]
        for name in ("M0", "C0", "D0", "K0", "N0", "G0"):
            lines += matrix(name, getattr(m, name))
    return "\n".join([*lines, "", "RESULT", table(data), ""])
