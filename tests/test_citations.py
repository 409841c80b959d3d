"""What is cited exists: files, sections and equations of THEORY.md, keys of REFERENCES.md, tests by their names."""

import ast
import functools
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
THEORY, REFERENCES = ROOT / "flexmb/THEORY.md", ROOT / "tests/REFERENCES.md"
ROOMS = ("flexmb", "tests", "benchmarks", "notebooks")
FOUND = [*ROOT.glob("*.*"), *(path for room in ROOMS for path in (ROOT / room).rglob("*.*"))]
FILES = {path.relative_to(ROOT).as_posix() for path in FOUND if not {"node_modules", "__pycache__"} & {*path.parts}}
# Paths without their first folders: "step_control.py", "motion/step_control.py".
ENDS = {"/".join(file.split("/")[i:]) for file in FILES for i in range(file.count("/") + 1)}
# Texts in which one cites; this one makes some up.
TEXTS = sorted(name for name in FILES if name.endswith((".py", ".md")) and name != "tests/test_citations.py")

# Pages that the documentation site makes.
MADE = ("gallery.md", "index.md", "api/index.md")
GAP = r"[\s#]+"  # a citation may go on in the next line of a comment
NUMBER = rf"\(?\d+(?:\.\d+[a-z]?)?\)?(?:{GAP}\([a-z]\))?"
WORD = r"(?:sections?|eqs?\.|equations?)"
JOIN = rf"(?:[,;]?{GAP}(?:and|or|to){GAP}|[,;]{GAP})"
NUMBERS = rf"(?:{WORD}{GAP})?{NUMBER}(?:{JOIN}(?:{WORD}{GAP})?{NUMBER})*"
KEY = r"[A-Z]\d+[a-z]?(?:-[a-z]\w*)*"
KEYS = rf"{KEY}\b(?:{JOIN}{KEY}\b)*"
CLOSE = rf"(?:`|\]\([^)\s]*\))*,?{GAP}"
# Word, number or number of an equation, and the letter of an item.
PLACE = re.compile(rf"({WORD}{GAP})?(\()?(\d+(?:\.\d+[a-z]?)?)\)?(?:{GAP}\(([a-z])\))?")


@functools.cache
def text_of(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


@functools.cache
def theory() -> tuple[dict[str, str], set[str]]:
    """Sections of THEORY.md by number, each with its text, and the numbers that stand behind its equations."""
    text = THEORY.read_text(encoding="utf-8") if THEORY.exists() else ""
    parts = re.split(r"(?m)^#+ (\d+(?:\.\d+)?)\.? ", text)
    equations = re.findall(r"(?:  |` |`\. )\((\d+\.\d+[a-z]?)\)", text)
    return dict(zip(parts[1::2], parts[2::2], strict=True)), set(equations)


@functools.cache
def keys() -> set[str]:
    """Keys of the problems, whole and without the word that tells what they are about."""
    whole = re.findall(rf"(?m)^### ({KEY})$|^\| ({KEY}) \|", REFERENCES.read_text(encoding="utf-8"))
    return {short for pair in whole for key in pair if key for short in (key, key.split("-")[0])}


@functools.cache
def names_in(name: str) -> set[str]:
    return {n.name for n in ast.walk(ast.parse(text_of(name))) if isinstance(n, ast.FunctionDef | ast.ClassDef)}


def wrong_sections(name: str, text: str):
    """Numbers after "THEORY.md", or before "of THEORY.md", which it does not have."""
    if "THEORY.md" not in text:
        return
    sections, equations = theory()
    for match in re.finditer(rf"THEORY\.md{CLOSE}({NUMBERS})|({NUMBERS}){GAP}of{GAP}`?(?:flexmb/)?THEORY\.md", text):
        for word, bracket, number, item in PLACE.findall(match[1] or match[2]):
            an_equation = bool(bracket) or word.startswith("eq")
            known = number in equations or (number in sections and not an_equation)
            if not known or (item and f"({item})" not in sections.get(number, "")):
                yield match


def wrong_keys(name: str, text: str):
    """Keys after "REFERENCES.md", and those whose word stands with them, as D5-pendulum."""
    for match in re.finditer(
        rf"(?:REFERENCES(?:\.md)?|[Rr]eference problems?){CLOSE}({KEYS})|\b[A-Z]\d+[a-z]?(?:-[a-z]\w*)+", text
    ):
        if not keys().issuperset(re.findall(KEY, match[1] or match[0])):
            yield match
    for match in re.finditer(r"REFERENCES\.md#([\w-]+)", text):
        if match[1] not in {key.lower() for key in keys()}:
            yield match


def wrong_tests(name: str, text: str):
    """Tests by path and name; a name without a path is in the file named before it."""
    place = ""
    for match in re.finditer(r"`([\w/]+\.py)?(?:::(\w+))?`", text):
        place = match[1] or place
        if match[2] and (place not in FILES or match[2] not in names_in(place)):
            yield match


def wrong_files(name: str, text: str):
    """Texts by name, files of the rooms by path, what is set as code and ends as a Python file does, and links."""
    path = rf"\b(?:{'|'.join(ROOMS)})/[\w/]+\.\w+\b"
    for match in re.finditer(rf"(?<![\w/:.{{}}*-])[\w./-]*\w\.md\b|{path}|`(?:python )?([\w/]+\.py)\b", text):
        file = match[1] or match[0]
        if name.startswith("notebooks/site/") and file in MADE:
            continue
        if not any((place / file).exists() for place in (ROOT, (ROOT / name).parent)) and file not in ENDS:
            yield match
    for match in re.finditer(r"\]\(([^)#\s:]+)[)#]", text if name.endswith(".md") else ""):
        if not ((ROOT / name).parent / match[1]).exists():
            yield match


@pytest.mark.parametrize("check", [wrong_sections, wrong_keys, wrong_tests, wrong_files], ids=lambda c: c.__name__)
def test_citations(check):
    found = []
    for name in TEXTS:
        text = text_of(name)
        found += [
            f"{name}:{text.count(chr(10), 0, m.start()) + 1}: {' '.join(m[0].split())}" for m in check(name, text)
        ]
    assert not found, "\n" + "\n".join(found)
