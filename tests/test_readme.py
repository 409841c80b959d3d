"""The manuals: their code runs as written and prints what they say, their links lead somewhere, the door is small.

In a manual, a block of ``python`` or ``sh`` runs, and a block of ``text`` holds what the block before it prints; there
``...`` stands for anything, and a number is right to the digits that it has. A block with a file name behind its
language, as ``toml study.toml``, is that file, in the folder where the others run.
"""

import ast
import contextlib
import io
import math
import re
import shlex
from pathlib import Path
from typing import NamedTuple

import control
import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from cases.commands import command
from cases.tolerances import approx

from flexmb.setup import cache_folder
from flexmb.spacar.keywords import DRAWN, REFUSED, ROWS

ROOT = Path(__file__).parents[1]
ROOMS = ("flexmb", "tests", "benchmarks", "notebooks")
MANUALS = [
    path.relative_to(ROOT).as_posix()
    for path in [*ROOT.glob("*.md"), *(path for room in ROOMS for path in sorted((ROOT / room).rglob("*.md")))]
    if "node_modules" not in path.parts
]
LONGEST_DOOR = 200
NUMBER = r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?(?!\w)"


class Block(NamedTuple):
    """A block of code: its language, the file that it is or nothing, and its text."""

    language: str
    file: str
    text: str


def blocks_of(manual: str) -> list[Block]:
    found = re.findall(r"^```(\w*) ?(\S*)\n(.*?)^```$", (ROOT / manual).read_text(), re.DOTALL | re.MULTILINE)
    return [Block(*parts) for parts in found]


def unit(number: str) -> float:
    """What a one in the last digit of a printed number is worth."""
    digits, _, power = number.partition("e")
    return 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))


def agree(number: str, other: str) -> bool:
    """Whether two printed numbers may be one, each rounded to the digits that it has; counts are equal."""
    counts = not re.search("[.e]", number + other)
    return abs(float(number) - float(other)) <= (0 if counts else (unit(number) + unit(other)) / 2 * (1 + 1e-6))


def check_printed(printed: str, said: str) -> None:
    """Compare what was printed with what a manual says, word for word, and numbers to the digits that both have."""
    printed, said = (re.sub(r" ?([\[\]]) ?", r"\1", " ".join(text.split())) for text in (printed, said))
    parts = re.split(f"({NUMBER}| ?\\.\\.\\. ?)", said)
    numbers = [part for part in parts[1::2] if "..." not in part]
    words = [re.escape(part) for part in parts[::2]] + [""]
    kinds = [".*?" if "..." in part else f"({NUMBER})" for part in parts[1::2]] + [""]
    match = re.fullmatch("".join(word + kind for word, kind in zip(words, kinds, strict=False)), printed)
    assert match, f"printed:\n{printed}\nbut the manual says:\n{said}"
    for number, other in zip(match.groups(), numbers, strict=True):
        assert agree(number, other), f"printed {number}, but the manual says {other}:\n{printed}"


def run_commands(text: str) -> str:
    """Run the program's commands of a block; those of others set up a machine, and are not for a test."""
    printed = []
    for line in text.splitlines():
        words = shlex.split(line, comments=True)
        if words[:1] == ["flexmb"]:
            result = command(*words[1:])
            assert result.exit_code == 0, f"{line}\n{result.output}"
            printed.append(result.stdout)
    return "\n".join(printed)


def check_guide(scope):
    # Mass of the stage 0.2 kg instead of the tutorial's 0.206: 945 N/m less 12 N/m under the load of 1 N.
    mass = 0.2 + 26 / 35 * 7850 * 0.018 * 0.0005 * 0.1
    expected = ((945 - 12) / mass) ** 0.5 / (2 * math.pi)
    assert float(scope["fm"].frequencies(scope["model"])[0]) == approx(expected, rel=1e-6)


def check_python(scope):
    # A strut under 1.235 times its buckling load, pushed aside by a millinewton: between two rows of A2.
    tip, load = scope["path"].at("tip")[-1], 12.0 / (2.4674011003 * 0.039375 / 0.1**2)
    assert 1.1517 < load < 1.2939
    assert 0.593 < tip[0] / 0.1 < 0.72
    assert 0.559 < tip[1] / 0.1 < 0.741
    assert Path("modes.png").stat().st_size > 1000
    assert Path("modes.html").stat().st_size > 500_000
    # A mass of 2 kg on a spring of 5000 N/m and a damper of 2 Ns/m under a controller, on a floor that follows sin^3.
    late, w, t = scope["late"], 10 * np.pi, np.linspace(0, 0.4, 4001)
    floor = 1e-4 * w**2 * (6 * np.sin(w * t) * np.cos(w * t) ** 2 - 3 * np.sin(w * t) ** 3)
    loop = control.feedback(control.ss(control.tf([1], [2, 2, 5000])), control.ss(late.A, late.B, late.C, late.D))
    gap = control.forced_response(loop, t, -2 * floor).outputs[::50]
    # Some ten times the tolerance of a step, 1e-6 of the motion of the floor.
    np.testing.assert_allclose(scope["gap"], gap, rtol=0, atol=1e-9)


def check_light(scope):
    # Driven from -5 to 5 mm: the support stiffness is largest in between, near that of two leaf springs in tension.
    stiffness = 1 / scope["out"].node(3).CMglob[1, 1]
    assert stiffness.argmax() == 0
    assert stiffness[0] == approx(210e9 * 50e-3 * 0.5e-3 / 0.1, rel=0.01)
    assert scope["out"].load_factors.shape == (2, 7)
    # A leaf spring bent by 1 N at the end of a bar: the moment at its foot is as large as that end is far. The
    # clamp bends the middle of its width 1 + 0.65 nu times as much, and adds nu times that across: THEORY.md (2.28).
    bent, nu = scope["bent"], 210 / 80.77 / 2 - 1
    clamp = (1 + 0.65 * nu) * (1 - nu + nu**2) ** 0.5
    # Lifted fibres add half a per cent: (2.59).
    assert bent["stress"]["maximum"] == approx(clamp * bent["x"]["5"][0] / (0.018 * 0.5e-3**2 / 6), rel=1e-2)


def check_workbench(scope):
    # Clamped leaf springs in sway with 26/35 of their mass, between those of a beam and those of a wide plate.
    mass = 0.1 + 7850 * 1e-5 + 2 * 26 / 35 * 7850 * 0.018 * 0.0005 * 0.1
    beam = (24 * 210e9 * 0.018 * 0.0005**3 / 12 / 0.1**3 / mass) ** 0.5 / (2 * math.pi)
    nu = 210 / 80 / 2 - 1
    found = scope["fm"].frequencies(scope["build"](scope["again"]).builder.build())[0]
    assert beam < float(found) < beam / (1 - nu**2) ** 0.5


# What is right by another source than the manual, asked of what its code leaves behind.
INDEPENDENT = {
    "README.md": check_guide,
    "notebooks/README.md": check_python,
    "flexmb/spacar/README.md": check_light,
    "flexmb/workbench/README.md": check_workbench,
}


@pytest.mark.slow("flexmb/spacar/README.md", "flexmb/workbench/README.md", "notebooks/README.md")
@pytest.mark.timeout(900)
@pytest.mark.parametrize(
    "manual", [name for name in MANUALS if any(b.language in ("python", "text") for b in blocks_of(name))]
)
def test_what_a_manual_shows_runs(manual, tmp_path, monkeypatch):
    # Pictures are drawn without a screen, and left in a folder of this test.
    mpl.use("Agg")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("FLEXMB_CACHE", str(cache_folder() / "tests"))
    scope: dict = {}
    printed = None
    for block in blocks_of(manual):
        if block.file:
            (tmp_path / block.file).write_text(block.text)
        elif block.language == "python":
            with contextlib.redirect_stdout(io.StringIO()) as stream:
                exec(compile(block.text, manual, "exec"), scope)  # the one place where text is run
            printed = stream.getvalue()
        elif block.language == "sh":
            printed = run_commands(block.text)
        elif block.language == "text":
            assert printed is not None, f"{manual}: nothing is run before:\n{block.text}"
            check_printed(printed, block.text)
            printed = None
    INDEPENDENT.get(manual, lambda _: None)(scope)
    plt.close("all")


def anchors(path: Path) -> set[str]:
    """Names by which links lead to the headings of a manual."""
    headings = re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading).lower().replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("manual", MANUALS)
def test_links_and_pictures_exist(manual):
    text = re.sub(r"^```.*?^```$", "", (ROOT / manual).read_text(), flags=re.DOTALL | re.MULTILINE)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if target.startswith("http"):
            continue
        name, _, anchor = target.partition("#")
        path = (ROOT / manual).parent / name if name else ROOT / manual
        assert path.exists(), target
        assert not anchor or anchor in anchors(path), target


def test_the_door_is_small():
    assert len((ROOT / "README.md").read_text().splitlines()) <= LONGEST_DOOR


@pytest.mark.slow
def test_the_map_lists_every_file():
    """With the first paragraph of its docstring."""
    rows = re.findall(r"^\| \[\w+\]\((\S+\.py)\) \| (.*) \|$", (ROOT / "flexmb/README.md").read_text(), re.MULTILINE)
    files = {}
    for path in (ROOT / "flexmb").rglob("[!_]*.py"):
        said = " ".join((ast.get_docstring(ast.parse(path.read_text())) or "").partition("\n\n")[0].split())
        files[path.relative_to(ROOT / "flexmb").as_posix()] = re.sub(
            r":\w+:`\.?(\w+)`", r"`\1`", said.replace("``", "`")
        )
    assert dict(rows) == files
    assert len(rows) == len(files)


def test_the_manual_of_files_lists_every_keyword():
    text = (ROOT / "flexmb/spacar/README.md").read_text()
    rows = re.findall(r"^\| (kinematics|dynamics|inputs and outputs) \| ([A-Z, ]+) \| (.*?) \|", text, re.MULTILINE)
    told = {(keyword, block, form.replace("`", "")) for block, names, form in rows for keyword in names.split(", ")}
    assert told == {(row.keyword, row.block, row.form.replace(" | ", " or ")) for row in ROWS}
    assert {keyword for keyword in (*REFUSED, *DRAWN) if not re.search(rf"\b{keyword}\b", text)} == set()
