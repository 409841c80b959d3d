"""The beginning of a session: from a file, a mechanism, or the journal of a killed process."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import printable
from .document import Document, EditError
from .filing import opened
from .session import Session
from .undo import History, Storage, file_place, new_place, recover, unreadable, unsaved_storage


class TakenError(OSError):
    """Another workbench, at an address, has the file open."""

    def __init__(self, path: Path, address: str | None):
        where = f": {address}" if address else ""
        super().__init__(f"'{printable(path.name)}' is already open in another workbench{where}")


def session_of_file(path: Path) -> Session:
    """A session on a file, with the edits that a killed process did not save."""
    path = path.expanduser().absolute()
    place = file_place(path)
    if place.is_taken():
        raise TakenError(path, place.address())
    history, notes = _recovered(place)
    recovered = history is not None
    if history is None:
        document, more = opened(path)
        history, notes = History(document, place.journal, file=str(path)), [*notes, *more]
    session = Session(history, place=place, notes=notes)
    session.file.recovered = recovered
    session.file.know()
    return session


def session_of_new(document: Document | None = None, notes: list[str] | None = None) -> Session:
    """A session on a document, or else on the new mechanism that a killed process left last."""
    notes = list(notes or ())
    while document is None and (place := unsaved_storage()) is not None:
        history, damage = _recovered(place)
        notes += damage
        if history is not None:
            session = Session(history, place=place, notes=notes)
            session.file.recovered = True
            return session
        place.leave()
    place = new_place()
    return Session(History(document, place.journal), place=place, notes=notes)


def session_of(model: Any, names: Mapping[str, Any]) -> Session:
    """A session on any argument of :func:`flexmb.edit`."""
    if model is None:
        return session_of_new()
    if isinstance(model, str | os.PathLike):
        return session_of_file(Path(model))
    if isinstance(model, Document):
        return session_of_new(model)
    from .from_builder import document_of

    document, left_out = document_of(model, names)
    return session_of_new(document, left_out)


def _recovered(place: Storage) -> tuple[History | None, list[str]]:
    """History of a journal with unsaved edits, and notes about a damaged one."""
    if not place.journal.exists():
        return None, []
    try:
        history = recover(place.journal)
    except EditError:
        backup = place.journal.replace(unreadable(place.journal))
        return None, [f"The journal of unsaved edits cannot be read. It is kept as '{backup}'."]
    damage = [history.damage] if history.damage else []
    if history.is_saved:
        history.close()
        return None, damage
    return history, damage
