"""Answers of many designs, and the best of them: their Pareto front."""

import dataclasses
import os
import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from ..display import Column, Labelled, Quantities, Summary, span
from ..errors import printable, warn
from ..files import save_arrays
from ..results import ANSWERED, RESULTS
from .checkpoint import read_sweep
from .designs import Designs

# Number of rows of a table on the terminal.
ROWS = 20


@dataclasses.dataclass(frozen=True, repr=False)
class Sweep(Labelled):
    """Answers of many designs.

    Attributes:
        designs: Dimensions by name, each (designs, ...) [SI]. ``designs.axes`` contains the values along each axis of a
            grid.
        answers: Answers by name, each (designs, ...), NaN for failed designs [their units].
        codes: Code of RESULTS of every design, (designs,).
        units: Units by name, as given.
    """

    designs: Designs
    answers: dict[str, np.ndarray]
    codes: np.ndarray
    units: dict[str, str]

    def __getitem__(self, name: str) -> np.ndarray:
        """An answer or a dimension by name, with the axes of a grid first."""
        values = self.answers[name] if name in self.answers else self.designs.get(name)
        if values is None:
            raise KeyError(f"no answer or dimension '{name}'; there are {', '.join((*self.designs, *self.answers))}")
        return values.reshape(self._lengths + values.shape[1:]) if self.axes else values

    def column(self, name: str) -> np.ndarray:
        """Return one number of every design.

        Args:
            name: Name of a dimension or an answer, or of an entry of an array, such as "frequencies[0]".

        Returns:
            (designs,), also for a grid [its unit].

        Raises:
            KeyError: There is no such name.
            ValueError: The dimension or answer has several numbers per design.
        """
        known = {**self.designs, **self.answers}
        entry = re.fullmatch(r"(.+)\[(\d+(?:, ?\d+)*)\]", name) if isinstance(name, str) else None
        if entry and name not in known and entry[1] in known:
            at = tuple(map(int, entry[2].split(",")))
            shape = known[entry[1]].shape[1:]
            if len(at) != len(shape) or any(i >= n for i, n in zip(at, shape, strict=True)):
                raise KeyError(f"'{entry[1]}' has shape {shape} a design, and no entry {list(at)}")
            return known[entry[1]][(slice(None), *at)]
        if name not in known:
            raise KeyError(f"no answer or dimension '{printable(name)}'; there are {', '.join(known)}")
        if known[name].ndim > 1:
            first = ", ".join("0" * (known[name].ndim - 1))
            raise ValueError(f"'{name}' has several numbers a design. Name one of them, such as '{name}[{first}]'.")
        return known[name]

    def unit_of(self, name: str) -> str:
        """Return the unit of one number of a design; empty if none was given.

        Args:
            name: Name as in :meth:`column`.
        """
        return self.units.get(name, self.units.get(name.rpartition("[")[0], ""))

    def selected(self, rows: Any) -> "Sweep":
        """Return a sweep of some of the designs; its ``axes`` are empty.

        Args:
            rows: Numbers of the designs from 0, or True for each wanted design, (k,).
        """
        designs = Designs({name: values[rows] for name, values in self.designs.items()})
        answers = {name: values[rows] for name, values in self.answers.items()}
        return Sweep(designs, answers, self.codes[rows], dict(self.units))

    def pareto(self, *, minimize: str | Sequence[str] = (), maximize: str | Sequence[str] = ()) -> "Front":
        """Return the designs that no other design beats in all criteria (the Pareto front).

        The front leaves out failed designs and designs with NaN in a criterion, and counts them.

        Args:
            minimize: Names to minimise: answers, dimensions, or entries as "frequencies[0]".
            maximize: Names to maximise.

        Returns:
            Front, sorted by the first criterion, the best first.

        Raises:
            KeyError: There is no such name.
            ValueError: There is no criterion, a criterion is repeated, an array has no entry number, or no design has
                answers.

        Source:
            Definition: a design is left out if another design is no worse in all criteria and better in one criterion.
        """
        senses = {"minimize": minimize, "maximize": maximize}
        pairs = [(n, sense) for sense, names in senses.items() for n in ([names] if isinstance(names, str) else names)]
        criteria = dict(pairs)
        if not pairs:
            raise ValueError("The front has no criteria. Give `minimize`, `maximize` or both, by names of answers.")
        if len(criteria) < len(pairs):
            twice = next(name for i, (name, _) in enumerate(pairs) if name in dict(pairs[:i]))
            raise ValueError(f"'{printable(twice)}' is given twice. Give it once.")
        costs = np.stack([self.column(n) * (1 if sense == "minimize" else -1) for n, sense in pairs], axis=1)
        known = np.flatnonzero(np.isin(self.codes, ANSWERED) & ~np.any(np.isnan(costs), axis=1))
        if not len(known):
            raise ValueError(f"There is no front: none of the {len(self.codes)} designs has an answer.")
        rows = known[nondominated(costs[known])]
        return Front(self, rows[np.lexsort(costs[rows].T[::-1])], criteria, len(self.codes) - len(known))

    def table(self, rows: int = ROWS) -> str:
        """Return dimensions, answers of one number and results as text, with one row per design.

        Args:
            rows: Largest number of rows.
        """
        columns = {n: v for n, v in {**self.designs, **self.answers}.items() if v.ndim == 1}
        widths = [max(16, len(printable(name)) + 2) for name in columns]
        lines = ["".join(f"{printable(n):>{w}}" for n, w in zip(columns, widths, strict=True)) + "  result"]
        for i, code in enumerate(self.codes[:rows]):
            cells = [f"{v[i]:>{w}.7g}" for v, w in zip(columns.values(), widths, strict=True)]
            lines.append("".join(cells) + f"  {RESULTS(int(code)).name}")
        if len(self.codes) > rows:
            lines.append(f"... {len(self.codes) - rows} more designs")
        return "\n".join(lines)

    @property
    def axes(self) -> dict[str, np.ndarray]:
        """Values along each axis of a grid, by name; empty without a grid."""
        return self.designs.axes

    @property
    def _lengths(self) -> tuple[int, ...]:
        """Lengths of the axes of a grid; (-1,) without a grid."""
        return tuple(len(axis) for axis in self.axes.values()) or (-1,)

    def failures(self) -> dict[str, int]:
        """Return the number of failed designs by the name of the code."""
        return {RESULTS(c).name: int(np.sum(self.codes == c)) for c in np.unique(self.codes) if c not in ANSWERED}

    def quantities_by_name(self) -> Quantities:
        """Dimensions, answers and outcomes: of a grid over its axes, otherwise over "design"."""
        along = tuple(self.axes) or ("design",)
        grid = {name: Column((name,), values, self.units.get(name, "")) for name, values in self.axes.items()}
        named = (*(() if self.axes else self.designs), *self.answers)
        columns = {name: Column(along, self[name], self.units.get(name, "")) for name in named}
        columns["result"] = Column(along, self.codes.reshape(self._lengths), meaning="code of flexmb.RESULTS")
        return Quantities(along, grid, columns)

    def save(self, path: str | os.PathLike) -> None:
        """Write a .npz or .mat with all dimensions and answers by name, "codes", and "about" (units) as JSON.

        Args:
            path: Path of the file; it ends in .npz or .mat.

        Raises:
            ValueError: The path has another ending.
            OSError: The folder is missing or not writable.
        """
        arrays = {name: self[name] for name in (*self.designs, *self.answers)}
        about = {
            "units": self.units, "axes": list(self.axes), "failures": self.failures(),
            "dimensions": list(self.designs), "shapes": {name: array.shape for name, array in arrays.items()},
        }  # fmt: skip
        save_arrays(path, {**arrays, "codes": self.codes.reshape(self._lengths)}, about)

    @staticmethod
    def load(path: str | os.PathLike) -> "Sweep":
        """Read a file of :meth:`save`, or a checkpoint of ``fm.sweep``.

        Args:
            path: Path of a .npz, a .mat, or a checkpoint. The content decides which it is.

        Returns:
            Sweep; of an unfinished checkpoint the computed designs, without axes of a grid.

        Raises:
            ValueError: The file is no saved sweep, or is damaged.
            OSError: The file cannot be read.

        Warns:
            FlexmbWarning: The checkpoint is unfinished.
        """
        designs, answers, codes, units, planned = read_sweep(path)
        if len(codes) < planned:
            warn(
                f"Checkpoint '{printable(path)}' contains {len(codes)} of {planned} designs; these are loaded. Call"
                " fm.sweep with the same arguments to compute the others."
            )
        return Sweep(designs, answers, codes, units)

    def summary(self) -> Summary:
        """Return failures, and the range of each answer."""
        failures = ", ".join(f"{count} {name}" for name, count in self.failures().items())
        rows = {"designs": str(len(self.codes)), "failed": failures or "none"}
        rows |= {name: span(values, self.units.get(name, "")) for name, values in self.answers.items()}
        over = ", ".join(f"{name} {span(values, self.units.get(name, ''))}" for name, values in self.designs.items())
        drawn = [n for n, values in self.answers.items() if values.ndim == 1 and np.any(np.isfinite(values))]
        varied = [n for n, values in self.designs.items() if np.ndim(values) == 1 and np.ptp(values) > 0]
        small = {"answer": drawn[0], "over": varied[:2]} if drawn and varied else None
        return Summary(f"Sweep over {over}", rows, "sweep", small)


@dataclasses.dataclass(frozen=True, repr=False)
class Front(Labelled):
    """Designs of a sweep that no other design beats in all criteria.

    Attributes:
        whole: Sweep with all designs.
        rows: Indices of the designs on the front in ``whole``, from 0, (front,). The first design is the best in the
            first criterion.
        criteria: "minimize" or "maximize" by name.
        left_out: Number of designs without answers.
    """

    whole: Sweep
    rows: np.ndarray
    criteria: dict[str, str]
    left_out: int

    def __getitem__(self, name: str) -> np.ndarray:
        """An answer or a dimension of the designs on the front, (front, ...)."""
        return self.sweep[name]

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def sweep(self) -> Sweep:
        """Sweep of the designs on the front."""
        return self.whole.selected(self.rows)

    def quantities_by_name(self) -> Quantities:
        """Dimensions and answers of the designs on the front."""
        return self.sweep.quantities_by_name()

    def summary(self) -> Summary:
        """Return the number of designs on the front, and their range in each criterion."""
        alone, rows = self.sweep, {}
        for name, sense in self.criteria.items():
            rows[f"{sense} {name}"] = span(alone.column(name), alone.unit_of(name))
        if self.left_out:
            rows["left out, without answer"] = str(self.left_out)
        title = f"Pareto front: {len(self)} of {len(self.whole.codes)} designs"
        return Summary(title, rows, "sweep", {} if len(self.criteria) > 1 else None)

    def __str__(self) -> str:
        title, rows, *_ = self.summary()
        lines = [title, *(f"  {name}: {text}" for name, text in rows.items())]
        chosen = np.unique(np.linspace(0, len(self) - 1, min(ROWS, len(self))).round().astype(int))
        if len(chosen) < len(self):
            lines.append(f"{len(chosen)} of them, from one end to the other:")
        return "\n".join([*lines, self.whole.selected(self.rows[chosen]).table()])


# Number of designs compared with the front at once: some MiB.
BLOCK = 512


def nondominated(costs: Float[np.ndarray, "n k"]) -> Bool[np.ndarray, "n"]:
    """Designs that no other design dominates: that is, none is as good in all costs and better in one cost.

    Sorted by the costs, a design can be dominated only by earlier designs. If it is dominated, a design of the front so
    far dominates it. The number of compared pairs is therefore n times the size of the front. Equal designs all stay.
    """
    different, places = np.unique(costs, axis=0, return_inverse=True)
    front = different[:0]
    good = np.zeros(len(different), bool)
    for first in range(0, len(different), BLOCK):
        block = different[first : first + BLOCK]
        # In this order without equals an earlier design that is no worse is better in one cost.
        open_ = ~_no_worse(front, block).any(axis=0)
        candidates = np.flatnonzero(open_)
        worse = _no_worse(block[candidates], block[candidates])
        np.fill_diagonal(worse, val=False)
        undominated = candidates[~worse.any(axis=0)]
        good[first + undominated] = True
        front = np.concatenate([front, block[undominated]])
    return good[places.ravel()]


def _no_worse(some: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Whether each of some is no worse in all costs than each of the others, (some, others)."""
    no_worse = np.ones((len(some), len(others)), bool)
    for a, b in zip(some.T, others.T, strict=True):
        no_worse &= a[:, None] <= b
    return no_worse
