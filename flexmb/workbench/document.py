"""The document of a workbench, and its edits: each gives another document, which shares what has not changed."""

from __future__ import annotations

from typing import Any

from ..arguments import shown
from .content import Document as Document
from .content import EditError as EditError
from .content import Report as Report
from .copies import OPERATIONS as COPIES
from .edits import OPERATIONS as EDITS
from .explode import OPERATIONS as EXPLODE
from .mirror import OPERATIONS as MIRROR


def apply(document: Document, ops: Any) -> tuple[Document, Report]:
    """Edit a document: all of the operations, or none.

    Args:
        document: Not changed.
        ops: Operations, one after the other, each a dictionary with "op" and what that takes, see :mod:`.edits`,
            :mod:`.copies`, :mod:`.mirror` and :mod:`.explode`.

    Raises:
        EditError: An operation that there is not, or that cannot be done.
    """
    known = EDITS | COPIES | MIRROR | EXPLODE
    if not isinstance(ops, list | tuple):
        raise EditError("", f"Edits are a list of operations, not {shown(ops)}.")
    ids: list[str] = []
    also: list[str] = []
    labels: list[str] = []
    for op in ops:
        kind = op.get("op") if isinstance(op, dict) else None
        if not isinstance(kind, str) or kind not in known:
            raise EditError("", f"There is no operation {shown(kind)}. There are: {', '.join(known)}.")
        try:
            document, report = known[kind](document, op)
        except KeyError as fault:
            raise EditError("", f"The operation '{kind}' needs {fault}.") from None
        ids += report.ids
        also += report.also
        labels.append(report.label)
    return document, Report(ids, also, "; ".join(dict.fromkeys(labels)))
