"""Frequency responses in the universal file format, data set 58, as programs for modal tests read and write it."""

import os
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import printable, warn
from ..files import for_files
from ..model.model import Port

ENDINGS = (".uff", ".unv")
# Function type of a frequency response; specific data types of a frequency and of what signals are.
RESPONSE, FREQUENCY = 4, 18
TYPES = {
    "position": 8, "displacement": 8, "velocity": 11, "acceleration": 12,
    "force": 13, "moment": 13, "reaction": 9,
}  # fmt: skip
DIRECTIONS = {"x": 1, "y": 2, "z": 3, "rx": 4, "ry": 5, "rz": 6, "phi": 6}
# Letters of a name of an entity, of an identification line and of a unit; digits of a frequency.
ENTITY, LINE, UNIT, DIGITS = 10, 80, 20, 5
SI = {
    "type": 164, "units_code": 1, "units_description": "SI", "temp_mode": 1, "length": 1.0, "force": 1.0, "temp": 1.0,
    "temp_offset": 273.15,
}  # fmt: skip


def write_responses(response: Any, path: str | os.PathLike) -> None:
    """Write every response of a FrequencyResponse; see :meth:`FrequencyResponse.save`."""
    target, hertz, values = Path(path), np.asarray(response.hertz), np.asarray(response.response)
    if target.suffix not in ENDINGS:
        raise ValueError(
            f"A file of responses ends in {', '.join(ENDINGS)} or .csv, not '{printable(target.name)}'. For other"
            " programs use to_pandas() or to_xarray()."
        )
    if len(hertz) < 2:
        raise ValueError("A universal file needs two frequencies or more.")
    if not np.all(np.isfinite(values)):
        raise ValueError(
            "A universal file contains only finite numbers, but a response is not finite: damp the resonance."
        )
    for name in (*response.outputs, *response.inputs):
        if len(name) > LINE or not name.isprintable():
            raise ValueError(f"A universal file has lines of {LINE} letters, which cannot contain '{printable(name)}'.")
    pyuff = for_files("pyuff")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"There is no folder '{printable(target.parent)}'.")
    known_ports = {"outputs": response.output_ports, "inputs": response.input_ports}
    ports = {kind: side_ports or (Port(),) * len(getattr(response, kind)) for kind, side_ports in known_ports.items()}
    numbers = _node_numbers([port.node for side_ports in ports.values() for port in side_ports])
    even = _is_even(hertz)
    sets = [dict(SI)]
    for i, (output, output_port) in enumerate(zip(response.outputs, ports["outputs"], strict=True)):
        for j, (source, source_port) in enumerate(zip(response.inputs, ports["inputs"], strict=True)):
            sets.append({
                "type": 58, "func_type": RESPONSE, "data": values[:, i, j].astype(complex), "x": hertz,
                "abscissa_spacing": int(even), "abscissa_spec_data_type": FREQUENCY, "abscissa_axis_units_lab": "Hz",
                "id1": "Frequency response by flexmb: response and reference in lines 4 and 5",
                "id4": output, "id5": source,
                **_about(output_port, numbers, "rsp", "ordinate"), **_about(source_port, numbers, "ref", "orddenom"),
            })  # fmt: skip
    if not even:
        _warn_rounding(hertz)
    pyuff.UFF(os.fspath(target)).write_sets(sets, "overwrite")


def read_responses(path: str | os.PathLike) -> tuple[Any, ...]:
    """Read all frequency responses of a file: the fields of a FrequencyResponse; see :meth:`FrequencyResponse.load`."""
    pyuff = for_files("pyuff")
    if not Path(path).is_file():
        raise FileNotFoundError(f"There is no file '{printable(path)}'.")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            file = pyuff.UFF(os.fspath(path))
            kinds = [int(kind) for kind in file.get_set_types()]
            sets, units = (
                [file.read_sets(n) for n, set_kind in enumerate(kinds) if set_kind == kind] for kind in (58, 164)
            )
        except Exception as error:
            raise ValueError(
                f"'{printable(path)}' is no universal file that pyuff can read: {printable(error)}"
            ) from error
    sets = [data_set for data_set in sets if data_set["func_type"] == RESPONSE]
    if not sets:
        raise ValueError(f"'{printable(path)}' contains no frequency response (data set 58, function type {RESPONSE}).")
    if len({(data_set["length"], data_set["force"]) for data_set in units}) > 1:
        raise ValueError(f"'{printable(path)}' contains several systems of units (data set 164).")
    responses, outputs, inputs = {}, {}, {}
    hertz = np.asarray(sets[0]["x"], float)
    for data_set in sets:
        output, source = _name(data_set, "rsp", "id4"), _name(data_set, "ref", "id5")
        if np.shape(data_set["x"]) != hertz.shape or not np.allclose(data_set["x"], hertz, rtol=1e-9, atol=0):
            raise ValueError(f"The responses of '{printable(path)}' are given at different frequencies.")
        if (output, source) in responses:
            raise ValueError(f"'{printable(path)}' contains the response of '{output}' to '{source}' twice.")
        factor = _to_si(path, data_set, units[0]) if units else None
        responses[output, source] = np.asarray(data_set["data"], complex) * (factor or 1.0)
        ports = _port(data_set, "rsp", "ordinate"), _port(data_set, "ref", "orddenom")
        if factor is not None:
            # Labels of units are those of the file.
            ports = tuple(port._replace(unit="") for port in ports)
        outputs.setdefault(output, ports[0])
        inputs.setdefault(source, ports[1])
    if len(responses) < len(outputs) * len(inputs):
        missing = next((y, u) for y in outputs for u in inputs if (y, u) not in responses)
        raise ValueError(f"'{printable(path)}' lacks the response of '{missing[0]}' to '{missing[1]}'.")
    response = np.stack([np.stack([responses[y, u] for u in inputs], axis=-1) for y in outputs], axis=1)
    return hertz, response, tuple(outputs), tuple(inputs), tuple(outputs.values()), tuple(inputs.values())


def _to_si(path: Any, data_set: dict[str, Any], units: dict[str, Any]) -> float | None:
    """Factor of a response in the units of a file, data set 164; None if they are SI units."""
    length, force = float(units["length"]), float(units["force"])
    if length == force == 1.0:
        return None
    sizes = []
    for point, ordinate in (("rsp", "ordinate"), ("ref", "orddenom")):
        turns = abs(int(data_set[f"{point}_dir"])) > 3
        kind = data_set.get(f"{ordinate}_spec_data_type")
        if kind in (TYPES["position"], TYPES["velocity"], TYPES["acceleration"]):
            sizes.append(1.0 if turns else length)
        elif kind in (TYPES["force"], TYPES["reaction"]):
            sizes.append(force * length if turns else force)
        else:
            raise ValueError(
                f"'{printable(path)}' is not in SI units and does not state the quantities of its signals."
            )
    return sizes[1] / sizes[0]


def _node_numbers(nodes: list[str]) -> dict[str, int]:
    """A number for each node: its name where that is one, otherwise the next that is free."""
    numbers = {name: int(name) for name in nodes if name.isascii() and name.isdecimal() and 0 < int(name) < 10**9}
    free = max(numbers.values(), default=0)
    for name in nodes:
        if name and name not in numbers:
            numbers[name] = free = free + 1
    return numbers


def _about(port: Port, numbers: dict[str, int], point: str, ordinate: str) -> dict[str, Any]:
    """Fields of a data set that say what a signal is about."""
    return {
        f"{point}_ent_name": port.node[:ENTITY].replace(" ", "_") or "NONE",
        f"{point}_node": numbers.get(port.node, 0),
        f"{point}_dir": DIRECTIONS.get(port.axis, 0),
        f"{ordinate}_spec_data_type": TYPES.get(port.quantity, 0),
        f"{ordinate}_axis_units_lab": port.unit.replace("²", "^2")[:UNIT] or "NONE",
    }


def _text(data_set: dict[str, Any], field: str) -> str:
    text = str(data_set.get(field, "")).strip()
    return "" if text.upper() == "NONE" else text


def _name(data_set: dict[str, Any], point: str, line: str) -> str:
    """Name of a signal, as it was written; of another program its node and direction."""
    if "flexmb" in _text(data_set, "id1") and _text(data_set, line):
        return _text(data_set, line)
    return f"{data_set[f'{point}_node']} {_axis(data_set, point)}".strip()


def _axis(data_set: dict[str, Any], point: str) -> str:
    direction = int(data_set[f"{point}_dir"])
    axis = next((name for name, number in DIRECTIONS.items() if number == abs(direction)), "")
    return f"-{axis}" if direction < 0 else axis


def _port(data_set: dict[str, Any], point: str, ordinate: str) -> Port:
    quantity = next(
        (name for name, number in TYPES.items() if number == data_set.get(f"{ordinate}_spec_data_type")), ""
    )
    unit = _text(data_set, f"{ordinate}_axis_units_lab").replace("^2", "²")
    node = _text(data_set, f"{point}_ent_name") or str(data_set[f"{point}_node"])
    return Port(node, _axis(data_set, point), quantity, unit)


def _as_written(values: np.ndarray) -> np.ndarray:
    return np.array([float(f"{value:.{DIGITS}e}") for value in values])


def _is_even(hertz: np.ndarray) -> bool:
    """Whether the first frequency and a step of as many digits as the format has give all frequencies."""
    first, step = _as_written(np.array([hertz[0], hertz[1] - hertz[0]]))
    return bool(np.allclose(first + step * np.arange(len(hertz)), hertz, rtol=1e-12, atol=0))


def _warn_rounding(hertz: np.ndarray) -> None:
    off = np.abs(_as_written(hertz) - hertz)
    worst = int(np.argmax(off))
    if off[worst] > 1e-12 * hertz[worst]:
        warn(
            f"A universal file stores six digits of a frequency: {hertz[worst]:.9g} Hz becomes"
            f" {_as_written(hertz[worst : worst + 1])[0]:.6g} Hz, while the response has twelve digits. Use equal"
            " steps, or frequencies of six digits."
        )
