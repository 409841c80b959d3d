"""A SPACAR Light script as it is read: nodes, elements, and the fields of nprops, eprops and opt."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np

from ..arguments import is_concrete
from ..build.assemble import stack
from ..errors import ModelError, clean
from .light_fields import Struct, are_counts, numbered, read_fields


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
    """Read a script; every field must be known and have its form. Raise ModelError with one line a fault."""
    faults: list[str] = []
    nodes, elements, nprops, eprops, opt = _parts(nodes, elements, nprops, eprops, opt).values()
    positions, pairs = _rows(nodes), _rows(elements)
    if positions is None or positions.shape[1] != 3:
        faults.append(f"nodes: must be one row of x, y and z per node, but is {_seen(nodes, positions)}.")
    if pairs is None or pairs.shape[1] != 2 or not are_counts(pairs):
        faults.append(f"elements: must be one row of two node numbers per element, but is {_seen(elements, pairs)}.")
    if faults or positions is None or pairs is None:
        raise ModelError("\n".join(faults))
    script, idle = Script(positions, pairs.astype(int), {}, {}, {}, {}, []), []
    for part, structs, fields in (("nprops", nprops, script.nprops), ("eprops", eprops, script.eprops)):
        for number, struct in numbered(structs, part, faults):
            fields[number] = read_fields(struct, part, f"{part}({number})", faults, idle)
    script.opt.update(read_fields(opt or {}, "opt", "opt", faults, idle))
    if idle:
        script.warnings.append(f"No effect here, since they are for pictures and stresses: {', '.join(idle)}")
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


def _seen(given: Any, rows: Any) -> str:
    return clean(repr(given)) if rows is None or rows.size < 10 else f"of shape {rows.shape}"
