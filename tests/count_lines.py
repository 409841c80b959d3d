"""Count the lines of the package, room by room: `python tests/count_lines.py [FOLDER ..]`.

A line of code is a line with a token of Python. Comments, blank lines and statements that are one bare string, such as
docstrings, are no code. Counted is every `.py` file that the repository ships: those below the folders,
`flexmb/` of this repository unless given. Stubs (`.pyi`) and other languages are not counted.

To count a former commit:

    mkdir /tmp/old && git archive COMMIT flexmb | tar -x -C /tmp/old && python tests/count_lines.py /tmp/old/flexmb
"""

import ast
import io
import sys
import tokenize
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LAYOUT = {getattr(tokenize, name) for name in ("COMMENT", "NL", "NEWLINE", "INDENT", "DEDENT", "ENDMARKER", "ENCODING")}


def bare_strings(text: str) -> list[ast.Expr]:
    """Statements that are one string, of which nothing is made."""
    statements = [one for one in ast.walk(ast.parse(text)) if isinstance(one, ast.Expr)]
    return [one for one in statements if isinstance(one.value, ast.Constant) and isinstance(one.value.value, str)]


def code_lines(text: str) -> int:
    """Lines of code in the text of a module."""
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    code = {line for token in tokens if token.type not in LAYOUT for line in range(token.start[0], token.end[0] + 1)}
    return len(code.difference(*(range(one.lineno, (one.end_lineno or 0) + 1) for one in bare_strings(text))))


def counts(packages: list[Path]) -> dict[str, Counter]:
    """Files, lines of code and lines in all by room, the packages' own files under "root"."""
    rooms: dict[str, Counter] = {}
    for package in packages:
        for path in sorted(package.rglob("*.py")):
            parts, text = path.relative_to(package).parts, path.read_text(encoding="utf-8")
            count = rooms.setdefault(parts[0] if len(parts) > 1 else "root", Counter())
            count.update(files=1, code=code_lines(text), lines=len(text.splitlines()))
    return rooms


def table(rooms: dict[str, Counter]) -> str:
    """Rooms by lines of code, and their sum."""
    rows = [*sorted(rooms.items(), key=lambda row: -row[1]["code"]), ("total", sum(rooms.values(), Counter()))]
    lines = [f"{name:<14}{count['files']:>6}{count['code']:>8}{count['lines']:>8}" for name, count in rows]
    return "\n".join([f"{'room':<14}{'files':>6}{'code':>8}{'lines':>8}", *lines])


if __name__ == "__main__":
    print(table(counts([Path(name) for name in sys.argv[1:]] or [ROOT / "flexmb"])))
