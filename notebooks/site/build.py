"""Build the documentation site: ``python notebooks/site/build.py [FOLDER]`` (FOLDER is ``build/site`` by default).

The site consists of the manuals, the pages beside this file, the notebooks with their pictures, an API reference from
docstrings and signatures, and a gallery. Open ``index.html`` in FOLDER; no server and no network are needed.
"""

import argparse
import base64
import html
import importlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import types
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SITE = Path(__file__).parent.relative_to(ROOT)
# Pages load this file from another host, so that their search works without a server; the site has its own.
SHIM = "https://unpkg.com/iframe-worker/shim"
LINK = re.compile(r"(?<=\]\()([^)\s]+)(?=\))")
# A block of code with the name of its file.
NAMED = re.compile(r"^```(\w+) (\S+)$", re.MULTILINE)
# What docstrings contain and pages would show wrongly: roles of Sphinx, and placeholders that look like tags.
ROLE = re.compile(r":(?:func|class|meth|mod|attr|exc):<code>")
PLACEHOLDER = re.compile(r"<(name|number|sign)>")
# An equation in TeX: in a line, or in a line of its own.
EQUATION = re.compile(r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.DOTALL)
FENCE = re.compile(r"^```.*?^```$", re.DOTALL | re.MULTILINE)
ROOMS = ("flexmb", "tests", "benchmarks", "notebooks")
# The rooms of the API reference beside the names that `fm` offers itself.
API_ROOMS = (
    *("blocks", "control", "design", "identification", "linear", "motion", "plot", "spacar", "trajectory"),
    *("planar", "spatial", "sections", "rotations"),
)
# Rooms with classes of results; `fm` does not offer them by name.
RESULT_ROOMS = ("checks", "paths", "statics")
NAVIGATION = {
    "Start": [
        "README.md",
        *(f"notebooks/{name}.md" for name in ("24_first_guide", "25_first_stroke", "26_first_tuning")),
    ],
    "Gallery": ["gallery.md"],
    "Python": ["notebooks/README.md"],
    "Input files": ["flexmb/spacar/README.md"],
    "Workbench": ["flexmb/workbench/README.md"],
    "Coming from": [f"{SITE}/{name}.md" for name in ("words", "spacar", "exudyn", "mujoco_pyelastica")],
    "Theory": ["flexmb/THEORY.md"],
    "Validation": ["tests/README.md", "tests/REFERENCES.md", "benchmarks/README.md"],
    "Notebooks": [],
    "Reference": ["api/index.md"],
    "Development": ["flexmb/README.md", "CONTRIBUTING.md", "CHANGELOG.md"],
}


def manuals() -> list[Path]:
    """Paths of all manuals, relative to the root of the repository."""
    inside = (path for room in ROOMS for path in (ROOT / room).rglob("*.md") if "node_modules" not in path.parts)
    return sorted(path.relative_to(ROOT) for path in [*ROOT.glob("*.md"), *inside])


def outside_code(text: str, change: Callable[[str], str]) -> str:
    """Text with ``change`` applied to what stands outside blocks of code."""
    parts, last = [], 0
    for block in FENCE.finditer(text):
        parts += [change(text[last : block.start()]), block[0]]
        last = block.end()
    return "".join([*parts, change(text[last:])])


def shown(file: Path) -> str:
    """Name of the copy of a file: a browser shows the source of a program if its name ends with .txt."""
    return f"{file.name}.txt" if file.suffix in (".py", ".pyi", ".sh", ".toml", ".dat") else file.name


def listing(folder: Path, link: str, page: Path, pages: Path) -> str:
    """Write a page that lists the files of a folder; returns the link to it."""
    target = pages / page.parent / link
    target.mkdir(parents=True, exist_ok=True)
    files = sorted(path for path in folder.iterdir() if path.is_file())
    for file in files:
        shutil.copy(file, target / shown(file))
    lines = [f"# {folder.name}", "", *(f"- [{file.name}]({shown(file)})" for file in files), ""]
    (target / "index.md").write_text("\n".join(lines), encoding="utf-8")
    return f"{link}/index.md"


def stage(page: Path, pages: Path) -> None:
    """Copy a manual and the files that it links to; links to notebooks lead to their pages."""

    def followed(match: re.Match[str]) -> str:
        link = match[1]
        target, _, anchor = link.partition("#")
        if not target or ":" in target:
            return link
        file = (ROOT / page.parent / target).resolve()
        if file.is_dir():
            folder = target.rstrip("/")
            return f"{folder}/README.md" if (file / "README.md").exists() else listing(file, folder, page, pages)
        if file.suffix == ".ipynb":
            return f"{target.removesuffix('.ipynb')}.md" + (f"#{anchor}" if anchor else "")
        if file.suffix != ".md" and file.is_file():
            copy = (pages / page.parent / target).with_name(shown(file))
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, copy)
            return f"{target.rpartition('/')[0]}/{copy.name}".lstrip("/")
        return link

    text = (ROOT / page).read_text(encoding="utf-8")
    target = pages / page
    target.parent.mkdir(parents=True, exist_ok=True)
    text = outside_code(text, lambda part: LINK.sub(followed, part))
    target.write_text(NAMED.sub(r'```\1 title="\2"', text), encoding="utf-8")


def notebook_page(source: Path, pages: Path) -> str:
    """Write the page of a notebook with its outputs; returns its title."""
    lines, count = [], 0
    title = source.stem
    for cell in json.loads(source.read_text(encoding="utf-8"))["cells"]:
        text = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            text = re.sub(r"\.ipynb(?=[)#])", ".md", text)
            if text.startswith("# "):
                title = text.partition("\n")[0].removeprefix("# ")
            lines += [text, ""]
            continue
        lines += ["```python", text, "```", ""]
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            if "image/png" in data:
                name = f"{source.stem}_{count}.png"
                count += 1
                (pages / "notebooks").mkdir(exist_ok=True)
                (pages / "notebooks" / name).write_bytes(base64.b64decode("".join(data["image/png"])))
                lines += [f"![Picture {count} of this notebook]({name})", ""]
            elif "text/html" in data and "<script" not in "".join(data["text/html"]):
                lines += ['<div class="output" markdown="0">', "".join(data["text/html"]), "</div>", ""]
            else:
                plain = "".join(output.get("text") or data.get("text/plain") or "")
                lines += ["```text", plain.rstrip("\n"), "```", ""] if plain.strip() else []
    script = f"{source.stem}.py.txt"
    download = f"[Notebook]({source.name}){{ download }} · [Python script]({script}){{ download={source.stem}.py }}\n"
    (pages / "notebooks").mkdir(exist_ok=True)
    (pages / "notebooks" / f"{source.stem}.md").write_text("\n".join([*lines, download]), encoding="utf-8")
    shutil.copy(source, pages / "notebooks" / source.name)
    shutil.copy(source.with_suffix(".py"), pages / "notebooks" / script)
    return title


def api_pages(pages: Path) -> list[tuple[str, str]]:
    """Write the pages of the API reference; returns their titles and paths."""
    import flexmb as fm
    from flexmb.lazy import offered

    (pages / "api").mkdir()
    written = []

    def write(title: str, intro: str, names: dict[str, str], options: str = "") -> None:
        options = f"    options:\n      heading_level: 2\n{options}"
        entries = [f"::: {where}.{name}\n{options}" for name, where in sorted(names.items())]
        path = f"api/{title.replace('.', '_')}.md"
        (pages / path).write_text("\n".join([f"# {title}", intro, "", *entries]), encoding="utf-8")
        written.append((title, path))

    def functions_of(module: types.ModuleType, package: str) -> dict[str, str]:
        """Public names of a module that can be called, and the module that defines each."""
        sources = offered(package) if package else dict.fromkeys(module.__all__, module.__name__)
        found = {name: where for name, where in sources.items() if callable(getattr(module, name))}
        # Each plot is a file of its room.
        return {name: f"{where}.{name}" if where == "flexmb.plot" else where for name, where in found.items()}

    write("flexmb", "The names of `import flexmb as fm`.", functions_of(fm, "flexmb"))
    for room in (*API_ROOMS, *RESULT_ROOMS):
        module = getattr(fm, room) if room in API_ROOMS else importlib.import_module(f"flexmb.{room}")
        package = module.__name__ if Path(module.__file__).with_suffix(".pyi").exists() else ""
        title = f"{'fm' if room in API_ROOMS else 'flexmb'}.{room}"
        # The gallery links to the code of the blocks.
        options = "      show_source: true\n" if room == "blocks" else ""
        write(title, (module.__doc__ or "").partition("\n\n")[0], functions_of(module, package), options)
    rows = [f"- [{title}]({Path(path).name})" for title, path in written]
    text = "Each page lists public names with their arguments, shapes, units and errors.\n"
    (pages / "api/index.md").write_text("\n".join(["# Reference", "", text, *rows, ""]), encoding="utf-8")
    return written


def equation(match: re.Match[str]) -> str:
    """MathML of an equation in TeX, which browsers draw without a program."""
    from latex2mathml.converter import convert

    text = html.unescape(match[2])
    drawn = convert(text, display="inline" if match[1] == "span" else "block")
    if unknown := re.search(r"\\\w+", re.sub("<.*?>", "", drawn)):
        raise ValueError(f"An equation contains {unknown[0]}, which has no MathML: {text}")
    return drawn


def main() -> None:
    """Gather the pages and build the site."""
    parser = argparse.ArgumentParser(description="Build the documentation site.")
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT / "build/site")
    folder = parser.parse_args().folder.resolve()
    with tempfile.TemporaryDirectory() as scratch:
        pages = Path(scratch) / "pages"
        pages.mkdir()
        for page in manuals():
            stage(page, pages)
        titles = {p.stem: notebook_page(p, pages) for p in sorted((ROOT / "notebooks").glob("[0-9][0-9]_*.ipynb"))}
        (pages / SITE).mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / SITE / "site.css", pages / SITE)
        sys.path.insert(0, str(ROOT))
        from gallery import write_gallery

        write_gallery(titles, pages)
        reference = api_pages(pages)
        navigation = {
            **NAVIGATION,
            "Notebooks": [f"notebooks/{stem}.md" for stem in titles if stem not in str(NAVIGATION["Start"])],
        }
        navigation["Reference"] = [*navigation["Reference"], *(path for _, path in reference)]
        nav = ", ".join(f"{{ {json.dumps(title)} = {json.dumps(paths)} }}" for title, paths in navigation.items())
        own = f"[project]\ndocs_dir = 'pages'\nsite_dir = 'site'\nnav = [{nav}]\n"
        base = (ROOT / SITE / "zensical.toml").read_text(encoding="utf-8")
        configuration = Path(scratch) / "zensical.toml"
        configuration.write_text(base.replace("[project]\n", own, 1), encoding="utf-8")
        command = [sys.executable, "-m", "zensical", "build", "--strict", "--config-file", str(configuration)]
        done = subprocess.run(command, cwd=scratch, env={**os.environ, "PYTHONPATH": str(ROOT)})
        if done.returncode:
            sys.exit(done.returncode)
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(Path(scratch) / "site", folder)
        shutil.copy(ROOT / SITE / "worker.js", folder)
        for page in folder.rglob("*.html"):
            text = page.read_text(encoding="utf-8")
            own = "../" * (len(page.relative_to(folder).parts) - 1) + "worker.js"
            text = PLACEHOLDER.sub(r"&lt;\1&gt;", ROLE.sub("<code>", text.replace(SHIM, own)))
            text = EQUATION.sub(equation, text)
            page.write_text(text, encoding="utf-8")
        print(f"The site is in {folder}: open index.html.")


if __name__ == "__main__":
    main()
