"""The document of a workbench and its edits. Each edit returns a new document, which shares all unchanged parts."""

from __future__ import annotations

from typing import Any

from ..arguments import short_repr
from .content import Document as Document
from .content import EditError as EditError
from .content import Report as Report
from .copies import OPERATIONS as COPIES
from .edits import OPERATIONS as EDITS
from .mirror import OPERATIONS as MIRROR


def apply(document: Document, ops: Any) -> tuple[Document, Report]:
    """Apply operations, each as of :mod:`.edits`, :mod:`.copies` or :mod:`.mirror`: all or none."""
    known = EDITS | COPIES | MIRROR
    if not isinstance(ops, list | tuple):
        raise EditError("", f"Edits are {short_repr(ops)}. They must be a list of operations.")
    ids, also, labels = [], [], []
    for op in ops:
        kind = op.get("op") if isinstance(op, dict) else None
        if not isinstance(kind, str) or kind not in known:
            raise EditError("", f"There is no operation {short_repr(kind)}. There are: {', '.join(known)}.")
        try:
            document, report = known[kind](document, op)
        except KeyError as fault:
            raise EditError("", f"The operation '{kind}' lacks {fault}.") from None
        ids += report.ids
        also += report.also
        labels.append(report.label)
    return document, Report(ids, also, "; ".join(dict.fromkeys(labels)))
