"""Table of the fields of SPACAR Light (form, bounds, choices, default), and reader of the structures of a script."""

import dataclasses
import difflib
import types
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from ..arguments import Range, is_concrete
from ..build.assemble import stack
from ..errors import ModelError, printable
from .lines import LARGEST, MOST, SMALLEST, within

AXES = ("x", "y", "z")
INPUTS = tuple(f"force_{axis}" for axis in AXES)
OUTPUTS = tuple(f"{quantity}_{axis}" for quantity in ("displ", "veloc") for axis in AXES)
# The cost grows with the square of the number of beams. Each step keeps its matrices.
MOST_BEAMS, MOST_STEPS = 1000, 10_000


class Struct(types.SimpleNamespace):
    """Named fields as attributes: ``opt = Struct(); opt.gravity = [0, 0, -9.81]``."""


class StructArray:
    """Array of structures, numbered from 1 as in MATLAB. The first use of a number creates its structure.

    Lines of a MATLAB script stay as they are: ``nprops(3).force = [0, 1, 0]`` or ``nprops[3].force = [0, 1, 0]``. A
    field whose name is a keyword of Python has an underscore: ``rls(1).def_ = [1, 2]``.
    """

    def __init__(self):
        self._structs: dict[int, Struct] = {}

    def __getitem__(self, number: int) -> Struct:
        if int(number) != number or number < 1:
            raise IndexError(f"Structure {number} does not exist. Structures are numbered from 1.")
        return self._structs.setdefault(int(number), Struct())

    def __call__(self, number: int) -> Struct:
        """Return the structure with a number, in MATLAB's notation.

        Args:
            number: Number from 1.
        """
        return self[number]

    def __len__(self) -> int:
        return max(self._structs, default=0)

    def items(self) -> Iterator[tuple[int, Struct]]:
        """Return numbers and structures, ascending."""
        return iter(sorted(self._structs.items()))


class OutOfRange(ValueError):
    """A number is outside the range of double precision mechanics."""


class FieldForm(NamedTuple):
    """The form of a field: words for messages, and a function that reads the value or raises ValueError, TypeError."""

    wanted: str
    read: Callable[[Any], Any]


def _flag(value: Any) -> bool:
    if np.size(value) != 1 or np.ravel(value)[0] not in (0, 1):
        raise ValueError
    return bool(np.ravel(value)[0])


def _words(value: Any) -> tuple[str, ...]:
    words = (value,) if isinstance(value, str) else tuple(value)
    if not all(isinstance(word, str) for word in words):
        raise TypeError
    return words


def _real(value: Any) -> np.ndarray:
    """Numbers; NumPy would also read texts."""
    if np.asarray(value).dtype.kind in "US":
        raise TypeError
    return np.ravel(np.asarray(value, float))


def are_counts(numbers: np.ndarray) -> bool:
    """Whether all numbers are whole and small enough for a count, of either sign."""
    return bool(np.all(np.abs(numbers) <= MOST) and np.all(numbers == np.round(numbers)))


def _counts(value: Any) -> tuple[int, ...]:
    numbers = _real(value)
    if not are_counts(numbers) or np.any(numbers < 1):
        raise ValueError
    return tuple(int(n) for n in numbers)


def _only(values: Any) -> Any:
    if len(values) != 1:
        raise ValueError
    return values[0]


def _numbers(*lengths: int) -> FieldForm:
    def read(value: Any) -> Any:
        if is_concrete(value):
            array = _real(value)
        else:
            array = jnp.ravel(stack(value) if isinstance(value, list | tuple) else jnp.asarray(value, float))
        if array.shape[0] not in lengths or (is_concrete(array) and not np.all(np.isfinite(array))):
            raise ValueError
        if is_concrete(array) and not np.all(within(array)):
            raise OutOfRange
        return array

    return FieldForm(f"{' or '.join(map(str, lengths))} finite numbers", read)


FLAG = FieldForm("true or false", _flag)
COUNT = FieldForm(f"a whole number from 1 to {MOST}", lambda value: _only(_counts(value)))
COUNTS = FieldForm(f"whole numbers from 1 to {MOST}", _counts)
NUMBER = FieldForm("a finite number", lambda value: _numbers(1).read(value)[0])
WORD = FieldForm("a word", lambda value: _only(_words(value)))
WORDS = FieldForm("a word or a list of words", _words)
ANYTHING = FieldForm("", lambda value: value)


class Field(NamedTuple):
    """One field of a structure.

    Attributes:
        form: Form of its value.
        default: Value if it is not given.
        bounds: Bounds of its numbers.
        choices: Allowed values, or allowed entries of lists, each once.
        wanted: The choices in words.
        idle: Whether it has no effect: it is for pictures and stresses of the predecessor.
    """

    form: FieldForm
    default: Any = None
    bounds: Range | None = None
    choices: Sequence[Any] = ()
    wanted: str = ""
    idle: bool = False

    def fault(self, value: Any) -> str:
        """What a value of the right form must be too; empty if it is."""
        entries = value if isinstance(value, tuple) else (value,)
        if self.choices and (not set(entries) <= set(self.choices) or len(set(entries)) < len(entries)):
            return self.wanted or " or ".join(map(repr, self.choices))
        if self.bounds is not None and is_concrete(value) and not np.all(self.bounds.holds(value)):
            return self.bounds.words()
        return ""


_HELD, _VECTOR, _IDLE, _POSITIVE = Field(FLAG), Field(_numbers(3)), Field(ANYTHING, idle=True), Range(above=0)
_NOT_NEGATIVE = Range(least=0)
_TURN = Field(_numbers(4))

FIELDS: dict[str, dict[str, Field]] = {
    "nprops": {
        **dict.fromkeys(("fix", "fix_pos", "fix_orien", "fix_x", "fix_y", "fix_z", "fix_warp"), _HELD),
        "mass": Field(NUMBER, bounds=_NOT_NEGATIVE),
        "mominertia": Field(_numbers(6)),
        **dict.fromkeys(("force", "force_initial", "moment", "moment_initial"), _VECTOR),
        **{f"{load}{when}_{axis}": Field(NUMBER)
           for load in ("displ", "rot") for when in ("", "_initial") for axis in AXES},
        **dict.fromkeys(("rot", "rot_initial"), _TURN),
        "transfer_in": Field(WORDS, (), choices=INPUTS, wanted=f"some of {', '.join(INPUTS)}"),
        "transfer_out": Field(WORDS, (), choices=OUTPUTS, wanted=f"some of {', '.join(OUTPUTS)}"),
    },
    "eprops": {
        "elems": Field(COUNTS, ()),
        "emod": Field(NUMBER, bounds=_POSITIVE),
        "smod": Field(NUMBER, bounds=_POSITIVE),
        "dens": Field(NUMBER, bounds=_NOT_NEGATIVE),
        "cshape": Field(WORD, choices=("rect", "circ")),
        "type": Field(WORD, "beam", choices=("hinge", "beam"), wanted="'hinge' or left out"),
        "dim": Field(_numbers(1, 2), bounds=_POSITIVE),
        "orien": Field(_numbers(3), np.array([0.0, 1.0, 0.0])),
        "nbeams": Field(COUNT, 1, Range(most=MOST_BEAMS)),
        "flex": Field(COUNTS, (), choices=range(1, 7), wanted="some of 1 to 6, each once"),
        **dict.fromkeys(("warping", "cw"), _HELD),
        **dict.fromkeys(("color", "opacity", "hide"), _IDLE),
    },
    "opt": {
        "gravity": _VECTOR,
        **dict.fromkeys(("silent", "calcbuck", "showinputonly"), Field(FLAG, False)),
        "calccompl": Field(FLAG, True),
        "loadsteps": Field(COUNT, 10, Range(most=MOST_STEPS)),
        "mode": Field(COUNT, 10, choices=(10,), wanted="10 (equilibrium at load steps) or left out"),
        **dict.fromkeys(("rls", "transfer", "filename", "customdyn", "customkin"), Field(ANYTHING)),
        **dict.fromkeys(("customvis", "spavisual", "rigidstress", "stressperelement"), _IDLE),
    },
}  # fmt: skip


def field_value(given: Mapping[str, Any], part: str, name: str) -> Any:
    """Value of a field, or its default."""
    return given.get(name, FIELDS[part][name].default)


def field_faults(given: Mapping[str, Any], part: str, label: str) -> Iterator[str]:
    """Faults of fields out of their bounds or choices; ``label`` has "{}" for their names."""
    for name, value in given.items():
        if expected := FIELDS[part][name].fault(value):
            text = np.asarray(value).tolist() if isinstance(value, tuple | np.ndarray) else printable(repr(value))
            yield f"{label.format(name)} must be {expected}, but is {text}."


def structures_by_number(given: Any, what: str, faults: list[str]) -> list[tuple[int, Any]]:
    """Structures by number, from a StructArray, a dictionary by number, or a list; add faults."""
    if isinstance(given, StructArray | Mapping):
        pairs = list(given.items())
    elif given is None or (isinstance(given, Sequence) and not isinstance(given, str)):
        pairs = list(enumerate(given or (), 1))
    else:
        faults.append(
            f"{what}: must be a StructArray, a dictionary by number or a list, but is {printable(repr(given))}."
        )
        return []
    for number, _ in pairs:
        if isinstance(number, bool) or not isinstance(number, int | np.integer) or not 1 <= number <= MOST:
            faults.append(f"{what}: structures are numbered from 1, but one is {printable(repr(number))}.")
            return []
    return [(int(number), struct) for number, struct in pairs]


def read_fields(struct: Any, part: str, where: str, faults: list[str], idle: list[str]) -> dict[str, Any]:
    """Fields of a structure of "nprops", "eprops" or "opt" in their forms; add faults and names of idle fields."""
    known, fields = FIELDS[part], {}
    if not isinstance(struct, Mapping) and not hasattr(struct, "__dict__"):
        faults.append(
            f"{where}: must be fields by name, as a dictionary or a Struct, but is {printable(repr(struct))}."
        )
        return {}
    for key, value in (struct if isinstance(struct, Mapping) else vars(struct)).items():
        name = str(key).rstrip("_")
        field = known.get(name)
        if field is None:
            similar = difflib.get_close_matches(name[:40], known, 1)
            hint = f" Did you mean {similar[0]}?" if similar else f" It takes: {', '.join(known)}."
            faults.append(f"{where}.{printable(name)}: there is no such field.{hint}")
        elif value is None or (field.form is not ANYTHING and _is_empty(value)):
            continue
        elif field.idle:
            idle.append(f"{where}.{name}")
        else:
            try:
                fields[name] = field.form.read(value)
            except (ValueError, TypeError, OverflowError) as fault:
                size = f"0 or from {SMALLEST:g} to {LARGEST:g} in size"
                expected = size if isinstance(fault, OutOfRange) else field.form.wanted
                faults.append(f"{where}.{name}: must be {expected}, but is {printable(repr(value))}.")
    # "fix = false" is the default.
    return {name: value for name, value in fields.items() if value is not False or part == "opt"}


def _is_empty(value: Any) -> bool:
    """Whether a value is MATLAB's ``[]``."""
    return 0 in value.shape if hasattr(value, "shape") else isinstance(value, Sequence) and len(value) == 0


@dataclasses.dataclass
class Script:
    """A script that has been read.

    Attributes:
        nodes: Positions, (n, 3) [m].
        elements: Numbers of the two nodes of each element, (m, 2).
        nprops: Fields of each node that has any, by number.
        eprops: Fields of each element set, by number.
        opt: Options.
        sets: Number of the set of each element that is in one.
        warnings: What is unusual or without effect.
    """

    nodes: Any
    elements: np.ndarray
    nprops: dict[int, dict[str, Any]]
    eprops: dict[int, dict[str, Any]]
    opt: dict[str, Any]
    sets: dict[int, int]
    warnings: list[str]

    def properties(self, element: int) -> dict[str, Any]:
        """Fields of an element's set; none for an element that is in no set."""
        return self.eprops.get(self.sets.get(element, 0), {})

    def is_hinge(self, element: int) -> bool:
        """Whether an element is a hinge."""
        return self.properties(element).get("type") == "hinge"

    def flexible(self, element: int) -> tuple[int, ...]:
        """Deformations that may change, numbers from 1; none for a rigid element."""
        return (1,) if self.is_hinge(element) else tuple(self.properties(element).get("flex", ()))

    def warps(self, element: int) -> bool:
        """Whether the warping of an element's nodes counts: of strips that can be twisted, where that is asked for."""
        fields = self.properties(element)
        return bool(fields.get("warping")) and fields.get("cshape") == "rect" and 2 in self.flexible(element)

    def ends(self, element: int) -> tuple[int, int]:
        """Numbers of an element's nodes."""
        p, q = self.elements[element - 1].tolist()
        return p, q

    def at(self, node: int) -> list[int]:
        """Elements at a node."""
        return [k for k in self.numbers() if node in self.ends(k)]

    def numbers(self) -> range:
        """Numbers of the elements."""
        return range(1, len(self.elements) + 1)


PARTS = {"coordinates": "nodes", "connect": "elements", "nprops": "nprops", "eprops": "eprops", "opt": "opt"}


def _parts(nodes: Any, elements: Any, nprops: Any, eprops: Any, opt: Any) -> dict[str, Any]:
    """The five parts of a script, which may be given in one struct."""
    parts = {"nodes": nodes, "elements": elements, "nprops": nprops, "eprops": eprops, "opt": opt}
    spelling = {name: name for name in parts}
    if isinstance(nodes, Mapping | Struct):
        if any(part is not None for part in (elements, nprops, eprops, opt)):
            raise ModelError("A script in one struct is given alone: its fields are " + ", ".join(PARTS) + ".")
        fields = dict(nodes) if isinstance(nodes, Mapping) else vars(nodes)
        for name in fields:
            if name not in PARTS:
                raise ModelError(f"{name}: there is no such field. It takes: {', '.join(PARTS)}.")
        parts = {part: fields.get(name) for name, part in PARTS.items()}
        spelling = {part: name for name, part in PARTS.items()}
    missing = [spelling[part] for part, value in parts.items() if value is None and part != "opt"]
    if missing:
        raise ModelError(
            f"{', '.join(missing)}: {'is' if len(missing) == 1 else 'are'} not given. Give nodes, elements, nprops,"
            f" eprops and, if wanted, opt; or one struct with {', '.join(PARTS)}."
        )
    return parts


def read_script(nodes: Any, elements: Any, nprops: Any, eprops: Any, opt: Any) -> Script:
    """Read a script; every field must be known and have its form. Raise ModelError with one line a fault."""
    faults: list[str] = []
    nodes, elements, nprops, eprops, opt = _parts(nodes, elements, nprops, eprops, opt).values()
    positions, pairs = _rows(nodes), _rows(elements)
    if positions is None or positions.shape[1] != 3:
        faults.append(f"nodes: must be one row of x, y and z per node, but is {_seen_value(nodes, positions)}.")
    if pairs is None or pairs.shape[1] != 2 or not are_counts(pairs):
        faults.append(
            f"elements: must be one row of two node numbers per element, but is {_seen_value(elements, pairs)}."
        )
    if faults or positions is None or pairs is None:
        raise ModelError("\n".join(faults))
    script, idle = Script(positions, pairs.astype(int), {}, {}, {}, {}, []), []
    for part, structs, fields in (("nprops", nprops, script.nprops), ("eprops", eprops, script.eprops)):
        for number, struct in structures_by_number(structs, part, faults):
            fields[number] = read_fields(struct, part, f"{part}({number})", faults, idle)
    script.opt.update(read_fields(opt or {}, "opt", "opt", faults, idle))
    if idle:
        script.warnings.append(f"No effect here, since they are for pictures and stresses: {', '.join(idle)}")
    if faults:
        raise ModelError("\n".join(faults))
    return script


def _rows(values: Any) -> Any:
    """Rows of numbers, (n, m), which may be traced; None if they are none."""
    if isinstance(values, str):
        return None
    try:
        rows = [list(row) for row in values] if isinstance(values, Sequence) else values
        if is_concrete(rows):
            matrix = np.asarray(rows, float)
        else:
            matrix = jnp.stack([stack(row) for row in rows]) if isinstance(rows, list) else jnp.asarray(rows, float)
    except (ValueError, TypeError, OverflowError):
        return None
    return matrix if matrix.ndim == 2 else None


def _seen_value(values: Any, rows: Any) -> str:
    return printable(repr(values)) if rows is None or rows.size < 10 else f"of shape {rows.shape}"
