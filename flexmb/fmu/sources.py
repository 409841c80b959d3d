"""Sources of a unit: the C files of this folder, and data.h with the numbers of one plant."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from .description import Placed
from .plant import Plant

FOLDER = Path(__file__).parent
TABLE_FILE = "matrices.bin"


def sources(plant: Plant, found: list[Placed], token: str, fmi: int, settable: bool) -> dict[str, bytes]:
    """Contents of the files to compile, by name; the unit reads matrices that are not settable from a file."""
    kernel = ["nonlinear.c"] if plant.source else ["linear.c"]
    files = {name: (FOLDER / name).read_bytes() for name in ("core.c", "algebra.c", "fmi.c", *kernel, f"fmi{fmi}.c")}
    if plant.source:
        files["plant.c"] = plant.source.encode()
    files["data.h"] = _data(plant, found, token, fmi, settable).encode()
    return files


def table(plant: Plant) -> bytes:
    """Matrices in the unit's file: a one, then each matrix at all knots."""
    values = [np.ones(1), *(np.ravel(m) for m in plant.matrices.values())]
    return np.concatenate(values).astype("<f8").tobytes()


def _data(plant: Plant, found: list[Placed], token: str, fmi: int, settable: bool) -> str:
    n_t = 0 if plant.source else 1 if plant.times is None else len(plant.times)
    kinds = {kind: [one for one in found if one.kind == kind] for kind in ("input", "state", "parameter", "output")}
    # FMI 2.0 has no arrays: each entry has a reference.
    arrays = [one for one in kinds["parameter"] if np.ndim(one.variable.start)] if fmi == 3 else []
    starts = [np.ravel(one.variable.start) for kind in ("input", "state", "parameter") for one in kinds[kind]]
    counts = {
        "N_T": n_t,
        "N_U": len(plant.inputs),
        "N_X": len(plant.states),
        "N_P": sum(np.size(one.variable.start) for one in kinds["parameter"]),
        "N_Y": len(plant.outputs),
        "N_NOMINAL": plant.n_nominal,
        "N_ABSOLUTE": len(plant.displacements),
        "HAS_D": int("D" in plant.matrices),
        "SETTABLE": int(settable),
        "N_MEMORY": len(plant.memory),
        "N_WORK": plant.work,
        "N_ARRAYS": max(len(arrays), 1),
    }
    lines = ["/* The numbers of one plant; core.c says what they are. Generated. */"]
    lines += [f"#define {name} {count}" for name, count in counts.items()]
    lines += [f'#define TOKEN "{token}"', f'#define TABLE_FILE "{TABLE_FILE}"']
    # Without arrays one entry with an unused reference.
    at, sizes = [one.reference for one in arrays], [np.size(one.variable.start) for one in arrays]
    lines += [_array("unsigned int", "ARRAY_AT", map(str, at or [4294967295]))]
    lines += [_array("size_t", "ARRAY_SIZE", map(str, sizes or [0]))]
    # Without displacements one unused entry: C has no empty arrays.
    lines += [_array("size_t", "ABSOLUTE_OF", map(str, plant.displacements or [0]))]
    lines += [_numbers("ABSOLUTE_FROM", [plant.outputs[i].origin for i in plant.displacements] or [0.0])]
    lines += [_numbers("NOMINAL", [v.nominal for v in plant.states])]
    lines += [_numbers("START", np.concatenate([*starts, np.ravel(plant.memory)]))]
    if n_t > 1:
        lines += [_numbers("TIMES", plant.times)]
    return "\n".join(lines) + "\n"


def _numbers(name: str, values: Any) -> str:
    return _array("double", name, (repr(float(value)) for value in values))


def _array(kind: str, name: str, values: Iterable[str]) -> str:
    words, lines, line = list(values), [], ""
    for word in words:
        if len(line) + len(word) > 110:
            lines.append(line)
            line = ""
        line += f"{word}, "
    return f"static const {kind} {name}[{len(words)}] = {{\n" + "\n".join([*lines, line]).rstrip(", ") + "\n};"
