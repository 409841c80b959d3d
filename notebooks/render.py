"""Run the notebooks' sources and write each as .ipynb with its outputs: ``python notebooks/render.py [name ...]``.

The ``.py`` files in jupytext's percent form are the source; the ``.ipynb`` files are made from them and not edited.
What changes from run to run without meaning anything (times, ids, versions) is left out.
"""

import os
import sys
import time
from pathlib import Path

import jupytext
import nbformat
from nbclient import NotebookClient

FOLDER = Path(__file__).parent
KERNEL = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}


def render(source: Path) -> float:
    """Run one source and write its notebook; returns the seconds that it took."""
    notebook = jupytext.read(source, fmt="py:percent")
    notebook.metadata = nbformat.from_dict({**KERNEL, "language_info": {"name": "python"}})
    start = time.perf_counter()
    # Notebooks run where no file of theirs is in the way, and see the package as it is installed or on the path.
    NotebookClient(notebook, timeout=600, kernel_name="python3", record_timing=False).execute()
    seconds = time.perf_counter() - start
    notebook.metadata = nbformat.from_dict({**KERNEL, "language_info": {"name": "python"}})
    for number, cell in enumerate(notebook.cells):
        cell.id = f"cell-{number}"
        cell.metadata = nbformat.from_dict({})
        for output in cell.get("outputs", []):
            output.pop("metadata", None) if output.output_type == "stream" else output.update(metadata={})
            if output.output_type == "stream" and output.name == "stderr":
                raise RuntimeError(f"{source.name}, cell {number}, writes to stderr:\n{output.text}")
    text = nbformat.writes(notebook, version=4)
    for private in {str(Path.home()), str(FOLDER.parent), sys.prefix}:
        if f"{private}/" in text:
            raise RuntimeError(f"{source.name}: a path of this machine is in its output: {private}")
    source.with_suffix(".ipynb").write_text(text + "\n", encoding="utf-8")
    return seconds


def main(names: list[str]) -> None:
    """Render the named sources, or all of them."""
    os.environ["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"
    sources = sorted(FOLDER.glob("[0-9][0-9]_*.py"))
    for source in sources:
        if not names or any(source.name.startswith(name) for name in names):
            print(f"{source.stem}: {render(source):.1f} s", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
