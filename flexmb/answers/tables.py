"""Answers as text: the table on the terminal and the log file."""

from typing import Any

import numpy as np

from ..errors import shown
from ..mechanics.inertia import total_mass
from ..model.model import Model
from ..model.roles import Role
from ..spacar.lines import statements
from ..spacar.series import described
from .answers import Answer

SHOWN_VALUES = 12
# The mode that has poles where it has no frequencies.
POLES_ALONE = 7
CLASS = {Role.FIXED: "O", Role.DEPENDENT: "C", Role.DOF: "M", Role.PRESCRIBED: "R"}


def _numbers(values, digits: int = 6) -> str:
    return "  ".join(f"{v:.{digits}g}" for v in np.ravel(np.asarray(values, float)).tolist())


def _matrix(name: str, values) -> list[str]:
    values = np.atleast_2d(np.asarray(values, float))
    if max(values.shape, default=0) > SHOWN_VALUES:
        return [f"{name}: {values.shape[0]} x {values.shape[1]}, see --json or --save"]
    return [f"{name}:", *("  " + "  ".join(f"{v:12.5g}" for v in row) for row in values.tolist())]


def _path(steps: list[dict[str, Any]], critical: list[dict[str, Any]]) -> list[str]:
    lines = [
        f"path ({len(steps)} states):",
        "        load factor  stable  lowest frequency [Hz]  first load multiplier",
    ]
    for i, s in enumerate(steps):
        hertz, multipliers = s["frequencies_hz"], s["load_multipliers"]
        lowest = "-" if not hertz else "unstable" if hertz[0] is None else f"{hertz[0]:.6g}"
        first = f"{multipliers[0]:.6g}" if len(multipliers) else "-"
        lines.append(
            f"  {i:3d}  {s['load_factor']:12.7g}  {'yes' if s['stable'] else 'NO':6}  {lowest:>21}  {first:>21}"
        )
    lines.append(f"critical points: {'none' if not critical else ''}".rstrip())
    return lines + [f"  {c['kind']:<11} at load factor {c['load_factor']:.10g}" for c in critical]


def _motion(data: dict[str, Any]) -> list[str]:
    times, energy = np.asarray(data["time"]), {name: np.asarray(e) for name, e in data["energy"].items()}
    lines = [f"motion from 0 to {times[-1]:.6g} s, {len(times)} output times; at the end:"]
    lines += [f"  node {node:<8}{_numbers(rows[-1])}" for node, rows in data["trajectory"].items()][:SHOWN_VALUES]
    total = sum(energy.values())
    lines.append("energy [J] at start and end: {:.6g}, {:.6g}".format(*(np.asarray(total)[[0, -1]])))
    for step in [data["steps"][0], data["steps"][-1]] if "steps" in data else []:
        hertz = ["-" if f is None else f"{f:.6g}" for f in step["frequencies_hz"][:SHOWN_VALUES]]
        lines.append(f"frequencies [Hz] at {step['time']:.6g} s: {'  '.join(hertz)}")
    return lines


def table(data: dict[str, Any]) -> str:
    """Short table of an answer for the terminal.

    Args:
        data: Keys and values of an answer.
    """
    lines = [f"{shown(data['model'])}  mode {data['mode']}  status {data['status']}"]
    lines.append("NDOF = NX - NXO - NEO = {nx} - {nxo} - {neo} = {ndof}".format(**data))
    names = ", ".join(f"{d['kind']} {d['of']}.{d['component']}" for d in data["dofs"])
    lines.append(f"degrees of freedom: {names or 'none named'}")
    lines += [f"warning: {text}" for text in data["warnings"]]
    if data["message"]:
        lines.append(data["message"])
    if "stable" in data:
        lines.append(f"stable: {'yes' if data['stable'] else 'NO'}")
    if "frequencies_hz" in data:
        pairs = list(zip(data["eigenvalues"], data["frequencies_hz"], strict=True))
        lines.append(f"natural frequencies [Hz] ({len(pairs)}, {data['massless']} motions without mass left out):")
        texts = [f"unstable, omega^2 = {v:.6g}" if f is None else f"{f:.7g}" for v, f in pairs]
        lines += [f"  {i + 1:3d}  {text}" for i, text in enumerate(texts[:SHOWN_VALUES])]
        lines += [f"  ... {len(texts) - SHOWN_VALUES} more"] if len(texts) > SHOWN_VALUES else []
    elif data["mode"] == POLES_ALONE and "poles" in data:
        lines.append("poles [1/s]:")
        lines += [f"  {i + 1:3d}  {re:.7g} {im:+.7g}j" for i, (re, im) in enumerate(data["poles"][:SHOWN_VALUES])]
        lines += [f"  ... {len(data['poles']) - SHOWN_VALUES} more"] * (len(data["poles"]) > SHOWN_VALUES)
    if "load_multipliers" in data:
        lines.append("load multipliers:")
        lines += [f"  {i + 1:3d}  {v:.7g}" for i, v in enumerate(data["load_multipliers"][:SHOWN_VALUES])]
    if "path" in data:
        lines += _path(data["path"], data["critical_points"])
    if "time" in data:
        lines += _motion(data)
    if "A" in data:
        lines.append(f"inputs: {', '.join(data['inputs']) or 'none'}")
        lines.append(f"outputs: {', '.join(data['outputs']) or 'none'}")
        for name in "ABCD":
            lines += _matrix(name, data[name]) if np.size(data[name]) else [f"{name}: empty"]
    return "\n".join(lines)


def _entries(title: str, entries, roles) -> list[str]:
    lines, grouped = [title], {}
    for entry, role, i in zip(entries, roles, range(1, len(roles) + 1), strict=True):
        if entry.kind != "norm":
            grouped.setdefault(entry.of, []).append(f"{entry.symbol}: {i} {CLASS[role]}")
    return lines + [f"  {name:<10}{'  '.join(parts)}" for name, parts in grouped.items()]


def _series(model: Model) -> list[str]:
    """What the numbers of spectral beams stand for."""
    blocks = [b for b in model.topology.blocks if b.element.fields and "deformation" in b.companions]
    firsts = [(model.labels.e[row[0]].of, described(b.element)) for b in blocks for row in np.asarray(b.e).tolist()]
    return ["SPECTRAL BEAMS", *(f"  {name:<10}{text}" for name, text in firsts)] if firsts else []


def _counts(kind: str, roles) -> str:
    found = {letter: sum(CLASS[role] == letter for role in roles) for letter in "OMRC"}
    return f"N{kind}O {found['O']}  N{kind}MM {found['M']}  N{kind}M {found['M'] + found['R']}  N{kind}C {found['C']}"


def log(found: Answer, source: str) -> str:
    """Log of a run: input, structure, numbers, transfer functions and results.

    Args:
        found: Answer of the analysis.
        source: Text of the input file, echoed without its comments.
    """
    data, model, lin = found.data, found.model, found.lin
    lines = [f"flexmb {data['flexmb']}   {data['model']}   mode {data['mode']}", "", "INPUT"]
    # Letters that a terminal would act on as their escapes, line by line.
    lines += ["  " + "".join(shown(c) for c in s.raw) for s in statements(source)]
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
        from ..linear.linearize import second_transfer

        m = lin.matrices
        lines += ["", f"STATIC EQUILIBRIUM: {int(m.iterations)} iterations", f"  x   {_numbers(m.x)}"]
        lines += [f"  e   {_numbers(m.e)}", f"  sig {_numbers(m.sigma)}", "TRANSFER FUNCTIONS"]
        lines += [*_matrix("DF x", m.DFx), *_matrix("DF e", m.DFe)]
        d2x, d2e = second_transfer(lin)
        for i, name in enumerate(model.q_labels if model is not None and len(m.M0) <= 3 else []):
            lines += [*_matrix(f"D2F x by {name}", d2x[:, :, i]), *_matrix(f"D2F e by {name}", d2e[:, :, i])]
        for name in ("M0", "C0", "D0", "K0", "N0", "G0"):
            lines += _matrix(name, getattr(m, name))
    return "\n".join([*lines, "", "RESULT", table(data), ""])
