"""What a SPACAR Light script says: its structures and fields, read and checked before anything is built.

Names and rules are those of the predecessor's interface (nodes, elements, nprops, eprops, opt). A fault names the node,
element or field and says what is right; all faults are told at once.
"""

import dataclasses
import difflib
import types
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np

from ..arguments import is_concrete
from ..build.assemble import stack
from ..errors import ModelError, clean
from .lines import LARGEST, MOST, SMALLEST, within

AXES = ("x", "y", "z")


class Struct(types.SimpleNamespace):
    """Named fields, set and read as attributes: ``opt = Struct(); opt.gravity = [0, 0, -9.81]``."""


class StructArray:
    """Structures by number from 1, each made when it is first asked for.

    A script in MATLAB carries over by its lines: ``nprops(3).force = [0, 1, 0]`` or ``nprops[3].force = [0, 1, 0]``.
    A field whose name is a word of Python takes an underscore: ``rls(1).def_ = [1, 2]``.
    """

    def __init__(self):
        self._structs: dict[int, Struct] = {}

    def __getitem__(self, number: int) -> Struct:
        if int(number) != number or number < 1:
            raise IndexError(f"Structures are numbered from 1, so that there is no number {number}.")
        return self._structs.setdefault(int(number), Struct())

    def __call__(self, number: int) -> Struct:
        """The structure with a number, as MATLAB writes it.

        Args:
            number: From 1.
        """
        return self[number]

    def __len__(self) -> int:
        return max(self._structs, default=0)

    def items(self) -> Iterator[tuple[int, Struct]]:
        """Numbers and structures, ascending."""
        return iter(sorted(self._structs.items()))


# What the value of a field must be.
FLAG, COUNT, COUNTS, NUMBER, WORD, WORDS, ANYTHING = "flag", "count", "counts", "number", "word", "words", "anything"
# Vectors are given by their length.
Form = str | tuple[int, ...]

NODE_FIELDS: dict[str, Form] = {
    **dict.fromkeys(("fix", "fix_pos", "fix_orien", "fix_x", "fix_y", "fix_z", "fix_warp"), FLAG),
    "mass": NUMBER,
    "mominertia": (6,),
    **dict.fromkeys(("force", "force_initial", "moment", "moment_initial"), (3,)),
    **{f"{kind}{when}_{axis}": NUMBER for kind in ("displ", "rot") for when in ("", "_initial") for axis in AXES},
    **dict.fromkeys(("rot", "rot_initial"), (4,)),
    **dict.fromkeys(("transfer_in", "transfer_out"), WORDS),
}
SET_FIELDS: dict[str, Form] = {
    "elems": COUNTS,
    **dict.fromkeys(("emod", "smod", "dens"), NUMBER),
    **dict.fromkeys(("cshape", "type"), WORD),
    "dim": (1, 2),
    "orien": (3,),
    "nbeams": COUNT,
    "flex": COUNTS,
    **dict.fromkeys(("warping", "cw"), FLAG),
    **dict.fromkeys(("color", "opacity", "hide"), ANYTHING),
}
OPTIONS: dict[str, Form] = {
    "gravity": (3,),
    **dict.fromkeys(("silent", "calcbuck", "calccompl", "showinputonly"), FLAG),
    **dict.fromkeys(("loadsteps", "mode"), COUNT),
    **dict.fromkeys(("rls", "transfer", "filename", "customdyn", "customkin"), ANYTHING),
    **dict.fromkeys(("customvis", "spavisual", "rigidstress", "stressperelement"), ANYTHING),
}
WITHOUT_EFFECT = ("color", "opacity", "hide", "customvis", "spavisual", "rigidstress", "stressperelement")
INPUTS = tuple(f"force_{axis}" for axis in AXES)
OUTPUTS = tuple(f"{quantity}_{axis}" for quantity in ("displ", "veloc") for axis in AXES)


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
        own = self.properties(element)
        return bool(own.get("warping")) and own.get("cshape") == "rect" and 2 in self.flexible(element)

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
    given = {"nodes": nodes, "elements": elements, "nprops": nprops, "eprops": eprops, "opt": opt}
    spelling = {name: name for name in given}
    if isinstance(nodes, Mapping | Struct):
        if any(part is not None for part in (elements, nprops, eprops, opt)):
            raise ModelError("A script in one struct is given alone: its fields are " + ", ".join(PARTS) + ".")
        fields = dict(nodes) if isinstance(nodes, Mapping) else vars(nodes)
        for name in fields:
            if name not in PARTS:
                raise ModelError(f"{name}: there is no such field. It takes: {', '.join(PARTS)}.")
        given = {part: fields.get(name) for name, part in PARTS.items()}
        spelling = {part: name for name, part in PARTS.items()}
    missing = [spelling[part] for part, value in given.items() if value is None and part != "opt"]
    if missing:
        raise ModelError(
            f"{', '.join(missing)}: {'is' if len(missing) == 1 else 'are'} not given. Give nodes, elements, nprops,"
            f" eprops and, if wanted, opt; or one struct with {', '.join(PARTS)}."
        )
    return given


def read(nodes: Any, elements: Any, nprops: Any, eprops: Any, opt: Any) -> Script:
    """Read what a script says; every field must be known and have its form.

    Args:
        nodes: Positions, (n, 3) [m]; or all of the script in one struct.
        elements: Numbers of the nodes of each element, (m, 2).
        nprops: Properties of nodes.
        eprops: Properties of element sets.
        opt: Options, or None.

    Returns:
        Script.

    Raises:
        ModelError: One line a fault.
    """
    faults: list[str] = []
    nodes, elements, nprops, eprops, opt = _parts(nodes, elements, nprops, eprops, opt).values()
    positions, pairs = _rows(nodes), _rows(elements)
    if positions is None or positions.shape[1] != 3:
        faults.append(f"nodes: must be one row of x, y and z a node, but is {_seen(nodes, positions)}.")
    if pairs is None or pairs.shape[1] != 2 or not _are_counts(pairs):
        faults.append(f"elements: must be one row of two node numbers an element, but is {_seen(elements, pairs)}.")
    if faults or positions is None or pairs is None:
        raise ModelError("\n".join(faults))
    script = Script(positions, pairs.astype(int), {}, {}, {}, {}, [])
    for what, given, fields, found in (
        ("nprops", nprops, NODE_FIELDS, script.nprops),
        ("eprops", eprops, SET_FIELDS, script.eprops),
    ):
        for number, struct in numbered(given, what, faults):
            found[number] = _fields(struct, fields, f"{what}({number})", faults, script.warnings)
    script.opt.update(_fields(opt or {}, OPTIONS, "opt", faults, script.warnings))
    if faults:
        raise ModelError("\n".join(faults))
    return script


def _rows(given: Any) -> Any:
    """Rows of numbers, (n, m), which may be traced; None if they are none."""
    if isinstance(given, str):
        return None
    try:
        rows = [list(row) for row in given] if isinstance(given, Sequence) else given
        if is_concrete(rows):
            found = np.asarray(rows, float)
        else:
            found = jnp.stack([stack(row) for row in rows]) if isinstance(rows, list) else jnp.asarray(rows, float)
    except (ValueError, TypeError, OverflowError):
        return None
    return found if found.ndim == 2 else None


def _are_counts(numbers: np.ndarray) -> bool:
    """Whether all are whole numbers that something can have, of either sign."""
    return bool(np.all(np.abs(numbers) <= MOST) and np.all(numbers == np.round(numbers)))


def _seen(given: Any, rows: Any) -> str:
    return clean(repr(given)) if rows is None or rows.size < 10 else f"of shape {rows.shape}"


def numbered(given: Any, what: str, faults: list[str]) -> list[tuple[int, Any]]:
    """Structures by number, of a StructArray, a dictionary by number, or a list whose first is number 1.

    Args:
        what: Name of them all, for the faults.
        faults: What is wrong is added here.
    """
    if isinstance(given, StructArray | Mapping):
        pairs = list(given.items())
    elif given is None or (isinstance(given, Sequence) and not isinstance(given, str)):
        pairs = list(enumerate(given or (), 1))
    else:
        faults.append(f"{what}: must be a StructArray, a dictionary by number or a list, but is {clean(repr(given))}.")
        return []
    for number, _ in pairs:
        if isinstance(number, bool) or not isinstance(number, int | np.integer) or not 1 <= number <= MOST:
            faults.append(f"{what}: structures are numbered from 1, but one is {clean(repr(number))}.")
            return []
    return [(int(number), struct) for number, struct in pairs]


def _fields(struct: Any, known: dict[str, Form], where: str, faults: list[str], warnings: list[str]) -> dict[str, Any]:
    """Fields that are given, in the form they should have."""
    found: dict[str, Any] = {}
    if not isinstance(struct, Mapping) and not hasattr(struct, "__dict__"):
        faults.append(f"{where}: must be fields by name, as a dictionary or a Struct, but is {clean(repr(struct))}.")
        return found
    for key, value in (struct if isinstance(struct, Mapping) else vars(struct)).items():
        name = str(key).rstrip("_")
        if name not in known:
            near = difflib.get_close_matches(name[:40], known, 1)
            hint = f" Did you mean {near[0]}?" if near else f" It takes: {', '.join(known)}."
            faults.append(f"{where}.{clean(name)}: there is no such field.{hint}")
        elif value is None or (known[name] is not ANYTHING and _is_empty(value)):
            continue
        elif name in WITHOUT_EFFECT:
            text = "Without effect here, since they are for pictures and stresses:"
            listed = next((i for i, w in enumerate(warnings) if w.startswith(text)), None)
            if listed is None:
                warnings.append(f"{text} {where}.{name}")
            else:
                warnings[listed] += f", {where}.{name}"
        else:
            try:
                read_value = in_form(value, known[name])
            except (ValueError, TypeError, OverflowError) as fault:
                wanted = f"0 or from {SMALLEST:g} to {LARGEST:g} in size" if isinstance(fault, OutOfRange) else None
                faults.append(f"{where}.{name}: must be {wanted or _wanted(known[name])}, but is {clean(repr(value))}.")
            else:
                # "fix = false" says nothing, but an option may be on unless it is said to be off.
                if read_value is not False or known is OPTIONS:
                    found[name] = read_value
    return found


def _is_empty(value: Any) -> bool:
    """Whether a value is MATLAB's ``[]``, which says nothing."""
    return 0 in value.shape if hasattr(value, "shape") else isinstance(value, Sequence) and len(value) == 0


def _wanted(form: Form) -> str:
    if isinstance(form, str):
        return {
            FLAG: "true or false",
            COUNT: f"a whole number from 1 to {MOST}",
            COUNTS: f"whole numbers from 1 to {MOST}",
            NUMBER: "a finite number",
            WORD: "a word",
            WORDS: "a word or a list of words",
        }[form]
    return f"{' or '.join(str(n) for n in form)} finite number{'' if form == (1,) else 's'}"


class OutOfRange(ValueError):
    """A number is beyond what mechanics in double precision survives."""


def in_form(value: Any, form: Form) -> Any:
    """A field's value as it is used.

    Returns:
        A bool for a flag, an int, a tuple of ints, a scalar, an array, a string or a tuple of strings.

    Raises:
        ValueError, TypeError: It is something else.
    """
    if form is ANYTHING:
        return value
    if form is WORD or form is WORDS:
        words = (value,) if isinstance(value, str) else tuple(value)
        if not all(isinstance(word, str) for word in words) or (form is WORD and len(words) != 1):
            raise TypeError
        return words[0] if form is WORD else words
    if form is FLAG:
        if np.size(value) != 1 or np.ravel(value)[0] not in (0, 1):
            raise ValueError
        return bool(np.ravel(value)[0])
    if form is COUNT or form is COUNTS:
        numbers = np.ravel(_real(value))
        if not _are_counts(numbers) or np.any(numbers < 1) or (form is COUNT and numbers.size != 1):
            raise ValueError
        return int(numbers[0]) if form is COUNT else tuple(int(n) for n in numbers)
    array: Any = np.ravel(_real(value)) if is_concrete(value) else jnp.ravel(_flat(value))
    lengths = (1,) if form is NUMBER else form
    if array.shape[0] not in lengths or (is_concrete(array) and not np.all(np.isfinite(array))):
        raise ValueError
    if is_concrete(array) and not np.all(within(array)):
        raise OutOfRange
    return array[0] if form is NUMBER else array


def _real(value: Any) -> np.ndarray:
    """Numbers, of which a text is none though numpy would read it."""
    if np.asarray(value).dtype.kind in "US":
        raise TypeError
    return np.asarray(value, float)


def _flat(value: Any) -> Any:
    return stack(value) if isinstance(value, list | tuple) else jnp.asarray(value, float)
