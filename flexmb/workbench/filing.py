"""Documents from files and to files, and what a format cannot contain."""

from __future__ import annotations

import base64
import errno
import io
import json
import re
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from ..display import counted
from ..errors import AnalysisError, ModelError, printable
from ..files import read_whole, write_whole
from .document import Document

OPENED, SAVED = (".dat", ".json"), (".dat", ".py", ".json")


def files_of(path: Path | None) -> list[Path]:
    """Files of a document: the study with names and bounds belongs to an input file."""
    if path is None:
        return []
    return [path, path.with_suffix(".toml")] if path.suffix == ".dat" else [path]


def opened(path: Path) -> tuple[Document, list[str]]:
    """The document of a file, and notes about it; nothing in it is run."""
    if path.suffix == ".json":
        content = read_whole(path)
        try:
            data = json.loads(content)
        except (ValueError, RecursionError) as fault:
            raise ValueError(f"'{printable(path.name)}' is no JSON: {fault}.") from None
        return Document.from_data(data), []
    if path.suffix == ".dat":
        from .dat_file import open_dat

        return open_dat(path)
    raise ValueError(f"'{printable(path.name)}' cannot be opened. The workbench opens {' and '.join(OPENED)}.")


def received(name: str, text: str) -> tuple[Document, list[str]]:
    """The document of a text from a page, and notes about it."""
    with tempfile.TemporaryDirectory() as folder:
        plain = re.sub(r"[^\w.-]", "_", Path(name).name)[-80:] or "mechanism"
        path = Path(folder) / plain
        write_whole(path, text.encode())
        return opened(path)


def lost_in(document: Document, path: Path) -> list[str]:
    """What a file of this format cannot contain, in words."""
    if path.suffix != ".dat":
        return []
    from .dat_file import cannot_hold

    return cannot_hold(document)


def write_document(document: Document, path: Path) -> list[str]:
    """Write a document; notes about it."""
    for file in files_of(path):
        if file.exists() and not file.is_file():
            raise OSError(errno.EINVAL, "it is no regular file", str(file))
    if path.suffix == ".json":
        write_whole(path, f"{document.text}\n".encode())
    elif path.suffix == ".py":
        from .python_file import python_of

        write_whole(path, python_of(document).encode())
    elif path.suffix == ".dat":
        from .dat_file import save_dat

        return save_dat(document, path)
    else:
        raise ValueError(f"'{printable(path.name)}' cannot be saved. The workbench saves {', '.join(SAVED)}.")
    return []


def exported(document: Document, kind: str, name: str, deformed: bool = False) -> dict[str, Any]:
    """Content of a file: "name", "text" or "base64", "notes", and "left_out" (what the format cannot contain)."""
    if kind in ("py", "dat", "json"):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"{name}.{kind}"
            lost = lost_in(document, path)
            notes = write_document(document, path)
            files = [file for file in files_of(path) if file.exists()]
            if len(files) == 1:
                return {"name": path.name, "text": path.read_text(encoding="utf-8"), "left_out": lost, "notes": notes}
            buffer = io.BytesIO()
            with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
                for file in files:
                    archive.write(file, file.name)
        return {"name": f"{name}.zip", **_bytes(buffer.getvalue()), "left_out": lost, "notes": notes}
    from .building import build

    if kind not in ("html", "step", "dxf"):
        raise ValueError(f"There is no export '{printable(kind)}'. There are py, dat, json, html, step and dxf.")
    built = build(document)
    notes = [problem["message"] for problem in built.problems]
    model = built.builder.build(check=False)
    if kind == "html":
        from ..linear.modes import modes
        from ..viewer.view import view

        try:
            page = view(modes(built.model()))
        except (AnalysisError, ModelError, NotImplementedError):
            # A mechanism without modes.
            page = view(model)
        return {"name": f"{name}.html", "text": page.html(), "notes": notes}
    from ..statics.equilibrium import equilibrium
    from .cad import dxf, step

    x = np.asarray(equilibrium(model).x) if deformed else None
    content, more = step(model, x, name) if kind == "step" else dxf(model, x)
    return {"name": f"{name}.{kind}", **_bytes(content), "notes": [*notes, *more]}


def _bytes(content: bytes) -> dict[str, str]:
    return {"base64": base64.b64encode(content).decode()}


def difference(here: Document, there: Document) -> str:
    """Difference of a document from another, in a few words; "" if both build the same."""
    names = [name for name in {**here.names, **there.names} if here.names.get(name) != there.names.get(name)]

    def plain(document: Document) -> list[str]:
        return [repr((item["call"], item.get("name"), sorted(item["args"].items()))) for item in document.things]

    ours, theirs = plain(here), plain(there)
    n_different = max(sum(text not in theirs for text in ours), sum(text not in ours for text in theirs))
    parts = [counted(n_different, "thing")] if n_different else []
    if names:
        names_text = ", ".join(map(printable, names[:5])) + (" and more" if len(names) > 5 else "")
        parts.append(f"the {'name' if len(names) == 1 else 'names'} {names_text}")
    verb = "differs" if len(names) + n_different == 1 else "differ"
    return f"{' and '.join(parts)} {verb} from what is here." if parts else ""
