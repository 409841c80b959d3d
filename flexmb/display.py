"""Display of results: a summary in words and numbers, and the states of the mechanism for pictures.

Terminal, notebooks, pictures and the viewer use these two and know no class of results.
"""

import difflib
import importlib
import operator
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple

import jax
import jax.core
import numpy as np

from .numerical_limits import OUTER_MOTION, POWER_OF_TEN

# Most entries of a list in a summary.
AT_MOST = 6
# Most names in an error message.
NAMED = 24
# Most lines of a result on the terminal, and their width.
LINES, WIDTH = 12, 120


class States(NamedTuple):
    """States of a mechanism: one, several in a row, or one with motions about it.

    Attributes:
        model: The mechanism.
        x: Nodal coordinates, (n_x,), or (states, n_x) for several states [m, rad, -].
        kind: How the viewer plays them: "state", "path", "motion", "modes" or "self-stress".
        along: Load factor or time of each of several states, (states,) [-, s].
        label: Name of ``along``, with its unit.
        moves: Modes about the state, one a column, (n_x, modes); None if the result has none.
        shares: Share of each element in each state of self-stress, by name, the largest 1; None likewise.
        titles: Title of each mode or state of self-stress.
    """

    model: Any
    x: Any
    kind: str = "state"
    along: Any = None
    label: str = ""
    moves: Any = None
    shares: Sequence[dict[str, float]] | None = None
    titles: Sequence[str] = ()

    def most_moving(self) -> int:
        """Index of the position that moves most; without one, of another coordinate or a degree of freedom."""
        moved = np.ptp(np.asarray(self.x), axis=0)
        positions = np.array([entry.kind == "position" for entry in self.model.labels.x])
        if np.any(moved[positions] > 0):
            return int(np.argmax(np.where(positions, moved, 0.0)))
        dofs = np.asarray(self.model.topology.x.dof)
        return int(np.argmax(moved)) if np.any(moved > 0) or not len(dofs) else int(dofs[0])


class Summary(NamedTuple):
    """A result in a few lines.

    Attributes:
        title: What the result is, with its size.
        rows: Facts by name.
        picture: Name of the function of :mod:`flexmb.plot` that draws the result; None without one.
        small: Arguments of that function for a small picture beside the rows; None for no picture.
    """

    title: str
    rows: dict[str, str]
    picture: str | None = None
    small: Mapping[str, Any] | None = MappingProxyType({})


class Column(NamedTuple):
    """Numbers of a result with their unit.

    Attributes:
        over: Names of the axes, or of the first of them.
        values: The numbers.
        unit: SI unit; of a quantity whose entries have several, a text for each entry along the last axes.
        meaning: What codes mean.
    """

    over: tuple[str, ...]
    values: Any
    unit: Any = ""
    meaning: str = ""


class Quantities(NamedTuple):
    """What a result holds, by name.

    Attributes:
        rows: Names of the axes that all quantities have in front, which make the rows of a table.
        coordinates: Values along axes: times, frequencies, names.
        quantities: The numbers themselves.
    """

    rows: tuple[str, ...]
    coordinates: dict[str, Column]
    quantities: dict[str, Column]


class Result:
    """Base class of what analyses return. A subclass has its own summary, and states if it holds some.

    Attributes:
        one_axis: Name of an array with one axis for a single mechanism. For batches, as ``jax.vmap`` returns them, only
            shapes are shown.
    """

    one_axis: ClassVar[str] = ""

    def summary(self) -> Summary:
        """A few lines about the result; of concrete numbers of one mechanism."""
        return Summary(f"{type(self).__name__}: {', '.join(_shapes(self))}", {})

    def states(self) -> States | None:
        """States of the mechanism; None if the result has none."""
        return None

    def __repr__(self) -> str:
        title, rows, *_ = self.summary() if is_single(self) else Result.summary(self)
        lines = [title, *(f"  {name}: {text}" for name, text in rows.items())]
        remaining = len(lines) - LINES + 1
        lines = [*lines[: LINES - 1], f"  … and {remaining} more"] if remaining > 1 else lines
        long = {"width": WIDTH, "subsequent_indent": "    ", "break_on_hyphens": False, "placeholder": " …"}
        # Outcome and advice are shown in full.
        unshortened = [len(lines) == 1 or line.startswith("  result: ") for line in lines]
        pairs = zip(lines, unshortened, strict=True)
        return "\n".join(textwrap.fill(line, max_lines=LINES if all_of else 1, **long) for line, all_of in pairs)

    def _repr_html_(self) -> str | None:
        """Table and picture in a notebook; None for batches and traced numbers, which are shown as text."""
        # An upward reference by name, as below, so that computing without a notebook loads no pictures.
        return importlib.import_module("flexmb.viewer.notebook").card(self) if is_single(self) else None


class Labelled(Result):
    """Base class of results that become arrays of xarray and tables of pandas, with names and units."""

    def quantities_by_name(self) -> Quantities | None:
        """Quantities of the result by name; None for a result with states, which answer questions."""
        return None

    def to_xarray(self, *names: str) -> Any:
        """Return an ``xarray.Dataset`` with coordinates; units are in ``attrs["units"]``, "1" for no unit.

        Args:
            names: Names of the wanted quantities; by default all. For a result with states (path, motion, equilibria),
                names are questions, such as "top.x", "reaction foot.x" or "frequency 1". The default is then the
                coordinates of all nodes.

        Raises:
            ImportError: xarray is not installed.
            KeyError: There is no such quantity.
        """
        return importlib.import_module("flexmb.answers.labelled").to_xarray(self, names)

    def to_pandas(self, *names: str) -> Any:
        """Return a ``pandas.DataFrame`` with one row per state, frequency or design; units are in ``attrs["units"]``.

        Args:
            names: As of :meth:`to_xarray`.

        Raises:
            ImportError: pandas is not installed.
            KeyError: There is no such quantity.
        """
        return importlib.import_module("flexmb.answers.labelled").to_pandas(self, names)


def is_single(found: Result) -> bool:
    """Whether the numbers of a result are concrete and belong to one mechanism."""
    leaves = jax.tree.leaves(found)
    if not (len(leaves) == 1 and leaves[0] is found):
        kinds = (np.ndarray, np.generic, jax.Array, int, float, str)
        if not all(isinstance(leaf, kinds) and not isinstance(leaf, jax.core.Tracer) for leaf in leaves):
            return False
    try:
        return not found.one_axis or np.ndim(operator.attrgetter(found.one_axis)(found)) == 1
    except AttributeError:
        return False


def _shapes(result: Any) -> Iterator[str]:
    """Shapes of all arrays by name; results within that have their own summary are only named."""
    fields = getattr(result, "_fields", None) or tuple(getattr(result, "__dataclass_fields__", ()))
    for name in fields:
        value: Any = getattr(result, name)
        shape = getattr(value, "shape", None)
        if shape is not None:
            yield f"{name}[{','.join(map(str, shape))}]"
        elif isinstance(value, Result) and type(value).summary is not Result.summary:
            yield f"{name} {type(value).__name__}"
        elif isinstance(value, bool | int | float | str):
            yield f"{name} {value!r}"
        else:
            yield from _shapes(value)


def kind_of(value: Any) -> str:
    """Kind of a value for an error message, as "a Path" or "an Equilibrium"."""
    name = type(value).__name__
    return f"{'an' if name[0] in 'AEIO' else 'a'} {name}"


def short(value: Any) -> str:
    """A number as a summary shows it."""
    return f"{float(value):.5g}"


def listed(values: Any, unit: str = "") -> str:
    """The first of some numbers or names, with their unit."""
    texts = [value if isinstance(value, str) else short(value) for value in list(values)[:AT_MOST]]
    more = ", …" if len(values) > AT_MOST else ""
    return f"{', '.join(texts)}{more} {unit}".strip() if texts else "none"


def among(names: Iterable[str], asked: str = "") -> str:
    """Names for an error message, at most NAMED, those most like ``asked`` first, and the number left out."""
    known = list(dict.fromkeys(map(str, names)))
    if asked and len(known) > NAMED:
        matcher = difflib.SequenceMatcher(b=str(asked), autojunk=False)

        def distance(name: str) -> float:
            matcher.set_seq1(name)
            return -matcher.ratio()

        known.sort(key=distance)
    more = f" and {len(known) - NAMED} more" if len(known) > NAMED else ""
    return f"{', '.join(known[:NAMED])}{more}" if known else "none"


def span(values: Any, unit: str = "") -> str:
    """Range of the finite numbers among some."""
    values = np.asarray(values, float)
    finite = values[np.isfinite(values)]
    return f"{short(finite.min())} to {short(finite.max())} {unit}".strip() if finite.size else "none"


def largest(values: Any, names: Sequence[Any], unit: str | Callable[[Any], str] = "", word: str = "at") -> str:
    """The finite number of largest size, with its unit and, after a word, its name."""
    values = np.asarray(values)
    sizes = np.where(np.isfinite(values), np.abs(values), -1.0)
    if np.max(sizes, initial=-1.0) < 0:
        return "none"
    index = int(np.argmax(sizes))
    named = len(names) == len(values)
    place = f" {word} {names[index]}" if values[index] and named else ""
    said_unit = unit if isinstance(unit, str) else unit(names[index]) if named else ""
    return f"{short(values[index])} {said_unit}".strip() + place


def prefix_of(value: float) -> tuple[float, str]:
    """Factor and letter of the unit prefix that keeps a number short."""
    size = abs(value) if np.isfinite(value) and value else 1.0
    # Round-off must not put a power of ten below its prefix.
    thousands = int(np.clip(np.floor(np.log10(size) / 3 + POWER_OF_TEN), -5, 4))
    return 1000.0**thousands, "fpnµm kMGT"[thousands + 5].strip()


def quantity_text(value: float, unit: str) -> str:
    """A number with its SI unit and a prefix that keeps it short, as "3.2 mm" or "210 MPa"."""
    by, prefix = prefix_of(float(value))
    return f"{short(value / by)} {prefix}{unit}"


def counted(count: int, thing: str) -> str:
    """How many things there are, as "1 element" or "3 elements"."""
    return f"{count} {thing}{'' if count == 1 else 's'}"


def unit_of(entry: Any) -> str:
    """Unit of a coordinate."""
    return "m" if entry.kind == "position" else "rad" if entry.symbol == "phi" else "-"


def unit_of_force(entry: Any) -> str:
    """Unit of the force dual to a coordinate."""
    return "N" if entry.kind == "position" else "N m" if entry.symbol == "phi" else ""


def unit_of_rate(entry: Any) -> str:
    """Unit of the rate of a coordinate."""
    return f"{unit_of(entry).replace('-', '1')}/s"


def numbered_quantities(axis: str, values: Mapping[str, tuple[Any, str]]) -> Quantities:
    """Quantities with one number each of things that are counted from 1, each given with its unit."""
    columns = {name: Column((axis,), numbers, unit) for name, (numbers, unit) in values.items()}
    count = len(next(iter(columns.values())).values)
    return Quantities((axis,), {axis: Column((axis,), np.arange(1, count + 1), "-")}, columns)


def course(states: States) -> str:
    """Number of states, the coordinate that moves most along them, and its range."""
    x, names = np.asarray(states.x), states.model.labels.x
    if not len(x) or len(names) != x.shape[1] or not np.any(np.ptp(x, axis=0)):
        return counted(len(x), "state")
    index = states.most_moving()
    return f"{counted(len(x), 'state')}, {names[index]} moves most, {span(x[:, index], unit_of(names[index]))}"


# Verbs for the deformations of an element, by the beginnings of their names.
STRAINING = {"elongation": "stretches", "curvature": "bends", "twist": "twists", "shear": "shears"}


def _moving(entry: Any, labels: Any) -> str:
    """Return a verb and the node or element that a coordinate moves."""
    if entry.kind == "internal":
        # The coefficients of the strains are the last deformations of their element.
        element = entry.of.removesuffix(".internal")
        names = [candidate.name for candidate in labels.e if candidate.of == element]
        count = sum(candidate.of == entry.of for candidate in labels.x)
        name = names[len(names) - count + entry.component - 1] if len(names) >= count else ""
        return f"{next((verb for field, verb in STRAINING.items() if name.startswith(field)), 'deforms')} '{element}'"
    turns = entry.kind == "rotation" and entry.symbol != "phi"
    return f"turns {entry.of.removesuffix('.rotation')}" if turns else f"moves {entry}"


def modal_summary(what: str, found: States, values: Sequence[str], rows: dict[str, str]) -> Summary:
    """Summary of modes with a value for each and rows for all; a small picture shows the first modes."""
    moves, names = np.asarray(found.moves), found.model.labels.x
    count = moves.shape[1]
    # Inner coordinates of elements mean nothing to a reader, unless nothing else moves.
    inner = np.array([entry.kind == "internal" for entry in names], bool)
    if inner.any() and not inner.all():
        outer = np.max(np.abs(moves[~inner]), axis=0) > OUTER_MOTION * np.max(np.abs(moves), axis=0)
        moves = np.where(inner[:, None] & outer, 0.0, moves)
    mode_rows = {}
    for i, value in enumerate(values[:AT_MOST]):
        moving = f", {_moving(names[int(np.argmax(np.abs(moves[:, i])))], found.model.labels)} most" if names else ""
        mode_rows[f"mode {i + 1}"] = f"{value}{moving}"
    if count > AT_MOST:
        mode_rows["more"] = listed(list(values[AT_MOST:]))
    of_all = found.model.topology.n_q
    title = f"{what}: {count} of {of_all}" if of_all else f"{what}: the lowest {count}"
    rows = {**mode_rows, **rows}
    return Summary(title, rows, "modes" if count else "mechanism", {"which": range(min(count, 3))} if count else {})
