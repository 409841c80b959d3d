"""Random input files: shipped mechanisms and made-up ones, mutated. Only an answer or a named refusal may leave.

``cases(seed)`` yields cases without end, the same for the same seed; ``run(case)`` takes one through the reader, the
builder, for a share the writer or the command line, and, where the mutation left all shapes alone (so that nothing is
compiled for one case), an analysis. It returns what happened in a word, and raises what must not.
"""

import contextlib
import dataclasses
import functools
import io
import json
import os
import random
import re
import signal
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest import mock

import jax
import numpy as np

import flexmb as fm
from flexmb.answers import mode_1_simulate as motion
from flexmb.answers.answer_files import to_json
from flexmb.answers.answers import answer
from flexmb.answers.tables import log, table
from flexmb.mechanisms import mechanism_path, mechanisms
from flexmb.spacar.keywords import DRAWN, KEYWORDS, REFUSED, ROWS
from flexmb.spacar.kinds import FORMS
from flexmb.spacar.lines import BLOCKS

# A case takes milliseconds, or where an analysis is compiled for the first time, seconds.
LIMIT_S = 120
MODES = (0, 7, 8, 9, 10, 1)
SHARE_GENTLE, SHARE_ANALYSED, SHARE_WRITTEN, SHARE_CALLED = 0.3, 0.2, 0.1, 0.03
# Where numbers alone change; what these compile is little.
GENTLE = ("moved", "plane", "pf1dtrx", "pf1dinternal", "pf2d", "pf2d3dof", "pf2db", "pf3d", "pf3dover")

NUMBERS = (
    *("0", "-0", "1", "-1", "2", "3", "7", "1.5", "-2.5e-3", "1D-1", ".5", "5.", "1e-300", "1e300", "1e308", "-1e308"),
    *(
        "1e999",
        "-1e999",
        "1e-999",
        "5e-324",
        "1e50",
        "1e51",
        "-1e50",
        "1e-100",
        "1e-101",
        "1e20",
        "1e-20",
        "nan",
        "inf",
    ),
    *(
        "-inf",
        "Infinity",
        "0x10",
        "1_0",
        "+-1",
        "--1",
        "1,5",
        "1e",
        "e5",
        "1e+",
        "0b1",
        "1j",
        "True",
        "None",
        "1/2",
        "²",
    ),
    *(
        "٣",
        "１",
        "½",
        "9" * 9,
        "1" + "0" * 9,
        "9" * 400,
        "-9" * 9,
        "0.1.2",
        "1e1e1",
        "1d400",
        "d5",
        "'1'",
        '"1"',
        "(1)",
    ),
)
PLACEHOLDERS = (
    *(
        "{t}",
        "{w}",
        "{t*w}",
        "{1/0}",
        "{0**-1}",
        "{t**t**t}",
        "{(-1)**0.5}",
        "{9**9**9}",
        "{}",
        "{ }",
        "{{t}}",
        "{t",
        "t}",
    ),
    *("{t}{w}", "{-t}", "{+-t}", "{1e400}", "{1_0}", "{0x10}", "{True}", "{t.real}", "{t()}", "{'t'}", "{pi}", "{t;w}"),
    *(
        "{lambda: 1}",
        "{__import__('os')}",
        "{t if t else w}",
        "{[t]}",
        "{nothing}",
        "{1e200*1e200}",
        "{t/1e-320}",
        "{\n}",
    ),
    "{" + "1+" * 3000 + "1}",
    "{" + "(" * 3000 + "1" + ")" * 3000 + "}",
)
PARAMETERS = (None, {}, {"t": 0.5e-3, "w": 0.018}, {"t": 0.0, "w": -1e300})
LETTERS = (
    "\x00",
    "\x07",
    "\x1b[2J",
    "\x85",
    "\xa0",
    "\u2028",
    "\ufeff",
    "é",
    "ﬁ",
    "٣",
    "\t",
    "\x0b",
    "\x0c",
    "\r",
    "{",
    "%",
)
WORDS = ("END", "HALT", "end", "%", "#", ";", "\\", "/", "*", "nodes", "=", "X", "wall", "x" * 10**4)
OPTIONS = (
    *(["--mode", mode] for mode in ("0", "7", "-7", "77", "frequencies", "2", "", "٣")),
    *(["--json", path] for path in ("-", "a.json", "", "none/a.json", "/dev/null", "model.dat", "/dev/full")),
    *(["--set", text] for text in ("t=1", "t=nan", "t", "=", "t=1e999", "ü=1", "t=2", "w=0x1")),
    *(["--save", path] for path in ("a.npz", "a.mat", "a.txt", "model.dat")),
    *(["--release", text] for text in ("auto", "none", "all", "\x1b")),
    *(["--max-steps", text] for text in ("1", "0", "-1", "1e9", "99999999999999999999")),
    *(["--log", path] for path in ("a.log", "model.dat", "/")),
    *(["--debug"], ["--nope"], ["-h"], ["model.dat"], ["--"], [""], ["\udcff"]),
)


@dataclasses.dataclass(frozen=True)
class Case:
    """One input file and what is done with it.

    Attributes:
        name: Where it comes from.
        content: Of the file.
        numbers: Parameters, or None.
        mode: Analysis that is run if the shapes are those of a known model, or None.
        written: Whether what was read is written and read again.
        call: Arguments of the command line instead, or None.
    """

    name: str
    content: bytes
    numbers: dict[str, float] | None = None
    mode: int | None = None
    written: bool = False
    call: tuple[str, ...] | None = None


# -- files that are right -----------------------------------------------------------------------------------------

PLANE = """PLBEAM 1 1 2 3 4
PLSBEAM 2 3 4 5 6 3
PLRBEAM 3 5 6 7
PLTRUSS 4 7 9
PLTOR 5 4 8
X 1 0 0
X 3 1 0
X 5 2 0
X 7 2 0.5
X 9 3 1
FIX 1
FIX 2
FIX 9
FIX 8
RLSE 4 1
RLSE 5 1
DYNE 1 1 2 3
DYNE 2 1 2
END
HALT
ESTIFF 1 1e5 1
ESTIFF 2 1e5 1
ESTIFF 4 10
ESTIFF 5 0.1
EM 1 0.1 1e-5
EM 2 0.1
EDAMP 1 1 1e-3
XM 5 1
XM 6 0.01
XM 7 0.5
XF 5 0 -0.1
ESIG 4 0.1
EINIT 4 0.01
GRAVITY 0 -9.81
ITERSTEP 10 9 5e-7 1 3 0
TIMESTEP 0.01 3
ERROR 1e-4 1e-4
STARTDE 1 2 0.01 0.1
END
HALT
INPUTF 1 5 1
OUTX 1 5 2
OUTE 2 1 2
END
END
VISUALIZATION
BEAMPROPS 1 2
"""
MOVED = """PLTRUSS 1 1 2
X 1 0 0
X 2 0.1 0
FIX 1
FIX 2 2
RLSE 1 1
DYNX 2 1
END
HALT
XM 2 1
ESTIFF 1 10
TIMESTEP 0.1 4
STARTDX 2 1 0.11 0.1
DELXF 2 0.2
END
END
"""


@functools.cache
def originals() -> dict[str, str]:
    """Texts that mutations start from, by name: small ones, shipped ones, and one with parameters."""
    shipped = {name: mechanism_path(name).read_text() for name in mechanisms()}
    with_parameters = re.sub("(?m)^XM 3 .*$", "XM 3 {t*206}", shipped["pf2d"])
    return {"moved": MOVED, "plane": PLANE, **shipped, "parameters": with_parameters}


@functools.cache
def _shape_of_originals() -> dict[str, Any]:
    return {n: shape_of(fm.read_spacar(text, numbers={"t": 5e-4}).builder) for n, text in originals().items()}


def shape_of(builder) -> Any:
    """What compiled code depends on: structure and sizes."""
    leaves, structure = jax.tree.flatten(builder.build(check=False))
    return structure, tuple((np.shape(leaf), getattr(leaf, "dtype", type(leaf))) for leaf in leaves)


def made_up(r: random.Random) -> str:
    """Lines of a grammar that knows the forms of keywords, and little of what they mean."""
    dimension = r.choice(("PL", ""))
    keywords = [k for k in FORMS if k.startswith("PL") is (dimension == "PL")]
    lines = [_filled(r, r.choice(keywords), i + 1) for i in range(r.randint(1, 5))]
    for block in BLOCKS:
        lines += ["END", "HALT"] * (block != BLOCKS[0])
        others = [row for row in ROWS if row.block == block and row.keyword not in FORMS]
        lines += [_line(r, row.keyword, row.form) for row in r.choices(others, k=r.randint(0, 8))]
    return "\n".join([*lines, "END", "END", ""])


def _filled(r: random.Random, keyword: str, number: int) -> str:
    return _line(r, keyword, r.choice(FORMS[keyword].split(" | ")), element=str(number))


def _line(r: random.Random, keyword: str, form: str, **given: str) -> str:
    words = [w for w in re.sub(r"[\[\]]", " ", form).split() if w != "..."]
    values = {
        "coordinate": 4,
        "component": 4,
        "deformation": 6,
        "node": 8,
        "element": 3,
        "number": 3,
        "steps": 5,
        "p": 4,
    }
    found = [keyword]
    for word in words[: r.choice((len(words), len(words), r.randint(0, len(words))))]:
        odd = {**dict.fromkeys(("xp", "xq"), 1), **dict.fromkeys(("rotp", "rotq"), 0)}.get(word)
        if word in given:
            found.append(given[word])
        elif odd is not None:
            found.append(str(2 * r.randint(1, 4) - odd))
        elif word in values:
            found.append(str(r.randint(1, values[word])))
        elif word == "law":
            found.append(r.choice(("quintic", "septic", "scurve", "linear")))
        else:
            found.append(f"{r.choice((0.0, 1.0, 0.1, r.gauss(0, 1))):.4g}")
    return " ".join(found)


# -- mutations ----------------------------------------------------------------------------------------------------


def _line_at(r: random.Random, lines: list[str]) -> int:
    """Number of a line that says something, if there is one."""
    said = [i for i, line in enumerate(lines) if line.strip() and line.lstrip()[0] not in "%#;"]
    return r.choice(said) if said else r.randrange(len(lines))


def _in_words(change):
    """A mutation of the words of one line."""

    def mutate(r: random.Random, text: str) -> str:
        lines = text.split("\n")
        i = _line_at(r, lines)
        words = lines[i].split()
        change(r, words)
        lines[i] = " ".join(words)
        return "\n".join(lines)

    return mutate


def _any_word(r: random.Random) -> str:
    pool = r.choice((NUMBERS, NUMBERS, PLACEHOLDERS, WORDS, LETTERS))
    return r.choice(pool)


def _replace(r, words):
    if len(words) > 1:
        words[r.randrange(1, len(words))] = r.choice(NUMBERS)


def _odd(r, words):
    if words:
        words[r.randrange(len(words))] = _any_word(r)


def _remove(r, words):
    if words:
        del words[r.randrange(len(words))]


def _insert(r, words):
    words.insert(r.randint(0, len(words)), _any_word(r))


def _repeat(r, words):
    words.extend(words[1:] * r.choice((1, 2, 1000)))


def _scale(r, words):
    for _ in range(10):
        if len(words) > 1:
            i = r.randrange(1, len(words))
            with contextlib.suppress(ValueError):
                words[i] = repr(float(words[i]) * 10.0 ** r.choice((-60, -20, -9, -3, -1, 1, 3, 9, 20, 60)))
                return


def _nudge(r, words):
    """A number that stays one, so that the shapes stay what they are."""
    for _ in range(10):
        if len(words) > 1:
            i = r.randrange(1, len(words))
            if re.fullmatch(r"-?\d*\.\d+(e-?\d+)?|-?\d+e-?\d+|-?\d{2,}", words[i]):
                factor = r.choice((-1.0, 0.0, r.gauss(1, 0.5), 10.0 ** r.uniform(-8, 8), r.choice((1e30, 1e-30))))
                words[i] = f"{float(words[i]) * factor:.17g}"
                return


def _whole(r, words):
    for _ in range(10):
        if len(words) > 1:
            i = r.randrange(1, len(words))
            if words[i].isdigit():
                words[i] = str(max(int(words[i]) + r.choice((-2, -1, 1, 2, 5, 10**9)), -1))
                return


def _keyword(r, words):
    if words:
        known = r.choice((KEYWORDS, list(REFUSED), DRAWN))
        word = words[0]
        i = r.randrange(len(word))
        words[0] = r.choice((r.choice(known), word.lower(), word[:i] + word[i + 1 :], word + word[i], word[:i] + "é"))


def _lines(change):
    """A mutation of the list of lines."""

    def mutate(r: random.Random, text: str) -> str:
        lines = text.split("\n")
        change(r, lines)
        return "\n".join(lines)

    return mutate


def _drop_line(r, lines):
    del lines[_line_at(r, lines)]


def _double_line(r, lines):
    i = _line_at(r, lines)
    lines[i:i] = [lines[i]] * r.choice((1, 1, 2, 500))


def _swap_lines(r, lines):
    i, j = _line_at(r, lines), _line_at(r, lines)
    lines[i], lines[j] = lines[j], lines[i]


def _foreign_line(r, lines):
    other = originals()[r.choice(list(originals()))].split("\n")
    lines.insert(_line_at(r, lines), other[_line_at(r, other)])


def _new_line(r, lines):
    row = r.choice(ROWS)
    lines.insert(_line_at(r, lines), _line(r, row.keyword, row.form))


def _shuffle(r, lines):
    i, j = sorted((_line_at(r, lines), _line_at(r, lines)))
    part = lines[i:j]
    r.shuffle(part)
    lines[i:j] = part


def _letter(r: random.Random, text: str) -> str:
    i = r.randint(0, len(text))
    return text[:i] + r.choice(LETTERS) + text[i + r.randint(0, 1) :]


def _truncate(r: random.Random, text: str) -> str:
    return text[: r.randint(0, len(text))]


def _all_magnitudes(r: random.Random, text: str) -> str:
    """All positions, or all of some other keyword, made larger or smaller together."""
    keyword, factor = r.choice(("X", "X", "ESTIFF", "EM", "XM", "XF")), 10.0 ** r.randint(-60, 60)

    def scaled(match):
        words = match[0].split()
        with contextlib.suppress(ValueError):
            words[2:] = [repr(float(w) * factor) for w in words[2:]]
        return " ".join(words)

    return re.sub(rf"(?m)^{keyword} .*$", scaled, text)


TEXT = (
    *(
        _in_words(f)
        for f in (_nudge, _nudge, _nudge, _replace, _odd, _remove, _insert, _repeat, _scale, _whole, _keyword)
    ),
    *(_lines(f) for f in (_drop_line, _double_line, _swap_lines, _foreign_line, _new_line, _shuffle)),
    *(_letter, _truncate, _all_magnitudes),
)
BYTES = (
    lambda r, b: b.replace(b"\n", b"\r\n"),
    lambda r, b: b.replace(b"\n", b"\r"),
    lambda r, b: b"\xef\xbb\xbf" + b,
    lambda r, b: b"\xff\xfe" + b.decode("latin-1").encode("utf-16-le"),
    lambda r, b: b.decode("latin-1").encode("utf-16-le"),
    lambda r, b: b"% F\xfchrung\n" + b,
    lambda r, b: bytes(r.randrange(256) for _ in range(r.choice((1, 10, 300)))) + b,
    lambda r, b: b + bytes(r.randrange(256) for _ in range(100)),
    lambda r, b: bytes(c ^ (1 << r.randrange(8)) if r.random() < 0.002 else c for c in b),
    lambda r, b: b * r.choice((2, 5)),
    lambda r, b: b"%" + b"x" * 10**5 + b"\n" + b,
    lambda r, b: b"",
)


def cases(seed: int) -> Iterator[Case]:
    """Cases without end.

    Args:
        seed: The same cases for the same seed.
    """
    r = random.Random(seed)
    names = list(originals())
    while True:
        if r.random() < SHARE_GENTLE:
            yield _gentle(r)
            continue
        # The small ones are quick and have most kinds of lines; the shipped ones take turns.
        name = r.choice(("moved", "plane", "parameters", "made up", *names))
        text = made_up(r) if name == "made up" else originals()[name]
        for _ in range(r.choice((1, 1, 1, 2, 2, 3, 5))):
            text = r.choice(TEXT)(r, text)
        content = text.encode(r.choice(("utf-8", "utf-8", "latin-1")), errors="replace")
        if r.random() < 0.1:
            content = r.choice(BYTES)(r, content)
        numbers = r.choice(PARAMETERS) if name == "parameters" or r.random() < 0.2 else None
        if r.random() < SHARE_CALLED:
            words = [word for option in r.sample(OPTIONS, r.randint(1, 4)) for word in option]
            yield Case(name, content, call=(r.choice(("run", "run", "check")), "model.dat", *words))
            continue
        mode = r.choice(MODES) if r.random() < SHARE_ANALYSED else None
        yield Case(name, content, numbers, mode, r.random() < SHARE_WRITTEN)


def _gentle(r: random.Random) -> Case:
    """Other numbers in a mechanism that is right otherwise, for an analysis."""
    name = r.choice(GENTLE)
    text, mode = originals()[name], r.choice(MODES)
    if mode == 1 and "TIMESTEP" not in text:
        text = text.replace("HALT\n", "HALT\nTIMESTEP 0.01 3\n", 1)
    for _ in range(r.choice((1, 1, 2, 3, 8))):
        text = r.choice((_in_words(_nudge), _in_words(_nudge), _in_words(_scale), _all_magnitudes))(r, text)
    return Case(name, text.encode(), mode=mode)


# -- what may leave -----------------------------------------------------------------------------------------------


def run(case: Case) -> str:
    """What becomes of a case: "refused", "read", "answered", "failed" (with a status), "called".

    Args:
        case: Case.

    Raises:
        AssertionError: A message or an answer is not as it must be; anything else: it must not leave the package.
    """
    with _limited(), tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.dat"
        path.write_bytes(case.content)
        if case.call is not None:
            return _called(case, folder)
        try:
            read = fm.read_spacar(path, numbers=case.numbers)
        except fm.SpacarError as fault:
            _check_faults(str(fault))
            return "refused"
        assert all(w.isprintable() for w in read.warnings), read.warnings
        if case.written:
            _written(read, Path(folder) / "again.dat")
        shape = shape_of(read.builder)
        if case.mode is None or shape not in _shape_of_originals().values():
            return "read"
        return _analysed(read, case.mode)


@contextlib.contextmanager
def _limited() -> Iterator[None]:
    """Raise TimeoutError in what computes too long, whatever else the machine does, where the process can be told."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def late(*_):
        raise TimeoutError(f"a case takes more than {LIMIT_S} s")

    before = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, LIMIT_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def _check_faults(text: str) -> None:
    """One printable line of a reader's length each, with file and line."""
    for line in text.split("\n"):
        assert line.isprintable(), line
        assert len(line) < 1000, len(line)
        assert re.match(r"model\.dat:(\d+:)? ", line), line


def _written(read, path: Path) -> None:
    """What was read can be written and read again, or there is a name for what cannot."""
    try:
        fm.write_spacar(read, path)
    except fm.ModelError:
        return
    again = fm.read_spacar(path)
    assert again.builder.dofs == read.builder.dofs
    assert list(again.builder.nodes) == list(read.builder.nodes)


def _analysed(read, mode: int) -> str:
    # A motion that is stiff beyond reason takes all steps that it is allowed, which a few thousand show as well.
    quick = functools.partial(fm.simulate, max_steps=2000)
    try:
        with mock.patch.object(motion, "simulate", quick):
            found = answer(
                read.builder, read.name, mode, read.warnings, max_steps=50, settings=_shortened(read.settings)
            )
    except fm.SpacarError as fault:
        _check_faults(str(fault))
        return "refused"
    data = json.loads(to_json(found.data))
    assert (found.exit_status == 0) is (data["status"] == "ok" or mode == 0)
    assert bool(data["message"]) or data["status"] == "ok"
    assert not _nothings(data), _nothings(data)
    assert table(found.data)
    # It has all matrices and is slow: two modes have all its parts.
    assert mode not in (0, 7) or log(found, read.text)
    return "answered" if found.exit_status == 0 else "failed"


def _shortened(settings: dict[str, Any]) -> dict[str, Any]:
    """At most ten steps of a motion: more say no more."""
    if "TIMESTEP" in settings:
        settings["TIMESTEP"]["steps"] = min(settings["TIMESTEP"]["steps"], 10)
    return settings


def _nothings(data: Any, key: str = "") -> list[str]:
    """Keys where null stands for no number; frequencies of unstable motions and compliances may be null."""
    if data is None:
        return [key]
    items = data.items() if isinstance(data, dict) else ((key, v) for v in data) if isinstance(data, list) else ()
    return [
        k for name, v in items if name not in ("frequencies_hz", "compliance", "release") for k in _nothings(v, name)
    ]


def _called(case: Case, folder: str) -> str:
    """The command line in this process: exit status, one line a fault, the input file as it was."""
    from flexmb.cli import app

    assert case.call is not None
    out, err, status = io.StringIO(), io.StringIO(), None
    before = os.getcwd()
    os.chdir(folder)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            app(list(case.call))
    except SystemExit as end:
        status = end.code
    finally:
        os.chdir(before)
    assert status in (0, 1, 2), status
    assert (status == 0) is (not err.getvalue()), err.getvalue()
    assert all(line.isprintable() and len(line) < 1000 for line in err.getvalue().splitlines()), err.getvalue()
    assert "Traceback" not in err.getvalue()
    assert (Path(folder) / "model.dat").read_bytes() == case.content
    return "called"
