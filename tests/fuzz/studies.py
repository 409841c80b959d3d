"""Random studies, right ones and mutated ones: only an answer or a named refusal may leave, and answers are right.

``cases(seed)`` yields cases without end, the same for the same seed; ``run(case)`` reads one and computes it: most of
them design by design, where the kernels of the models are compiled once for all cases, a share compiled, as a search or
by the command line. It returns what happened in a word, and raises what must not.
"""

import contextlib
import copy
import dataclasses
import datetime
import functools
import io
import json
import math
import os
import random
import tempfile
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import flexmb as fm
from flexmb.answers.answer_files import to_json
from flexmb.design.study import Study, sweep_answer, sweep_table, tune_answer
from flexmb.design.study_file import read_study
from flexmb.errors import StudyError

# Shares of what costs a compilation.
SHARE_COMPILED, SHARE_TUNED, SHARE_CALLED = 0.02, 0.03, 0.03
# What is not mutated is checked against closed forms; the rest may be anything.
SHARE_RIGHT, SHARE_GENTLE = 0.25, 0.4
MOST_DESIGNS = 30

OWN = """
import jax.numpy as jnp
import flexmb as fm
from flexmb import planar

LEAF = {"E": 210e9, "G": 80e9, "rho": 7850.0}
NUMBER = 3


def plain(a, b=2.0):
    return {"a": a, "b": b}


def total(made):
    return made["a"] + made["b"]


def several(made):
    return jnp.stack([jnp.asarray(made["a"]), made["b"] ** 2])


def cart(k, m):
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("cart", (1, 0))
    b.add(planar.truss, "wall", "cart", section=fm.Rigidity(EA=k))
    b.fix("wall")
    b.fix("cart", "y")
    b.mass("cart", m)
    return b.build()


def leaf(t, l):
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (0, l))
    b.add(planar.beam, "foot", "tip", section=fm.Rectangle(0.02, t, fm.Material(**LEAF)), released=(2, 3))
    b.fix("foot")
    b.mass("tip", 0.1)
    b.force("tip", (0, -1.0))
    return b.build()


def branching(t, l):
    return leaf(t, l) if l > 0.1 else leaf(2 * t, l)


def tripled(model):
    return 3 * fm.frequencies(model)[0]


def raising(*arguments, **named):
    raise RuntimeError("a\\x1b[31mb\\nc" + 9 * "long ")


def leaving(*arguments, **named):
    raise SystemExit(3)


def word(*arguments, **named):
    return "stiff"


def imaginary(*arguments, **named):
    return 1j


def nothing(*arguments, **named):
    return None


def no_number(model):
    return jnp.nan


def refused(model):
    raise fm.AnalysisError("unstable", "It is.")
"""
FILE = """PLBEAM 1 1 2 3 4
X 1 0 0
X 3 0 {l}
FIX 1
FIX 2
RLSE 1 2 3
END
HALT
XM 3 {m}
ESTIFF 1 0 {210e9*w*t**3/12}
END
END
"""
MODULES = {"own.py": OWN, "broken.py": "def (\n", "stopping.py": "raise SystemExit(1)\n", "empty.py": ""}


@dataclasses.dataclass(frozen=True)
class Case:
    """A study.

    Attributes:
        content: Of the file.
        how: "one by one", "compiled", "tune" or "call".
        base: Name of the study that it was made of, if nothing was changed but numbers.
    """

    content: bytes
    how: str
    base: str | None


# Until the process ends.
_KEPT: list[tempfile.TemporaryDirectory] = []


@functools.cache
def folder() -> Path:
    """Where the modules and the input file lie, for this process."""
    _KEPT.append(tempfile.TemporaryDirectory())
    place = Path(_KEPT[0].name)
    for name, text in MODULES.items():
        (place / name).write_text(text)
    (place / "leaf.dat").write_text(FILE)
    return place


# -- right studies --------------------------------------------------------------------------------------------------


def _between(r: random.Random, low: float, high: float) -> dict[str, float]:
    """A parameter within bounds, some of which reach where no design can be built."""
    a, b = sorted(r.uniform(low, high) for _ in range(2))
    lower = -a if r.random() < 0.2 else a
    return {"value": r.uniform(a, b), "lower": lower, "upper": b + 1e-3 * high}


def _plan(r: random.Random) -> dict[str, Any]:
    if r.random() < 0.6:
        return {"points": r.randint(1, 4)}
    return {"kind": r.choice(["latin-hypercube", "monte-carlo"]), "samples": r.randint(1, 9), "seed": r.randint(0, 9)}


def _plain(r: random.Random) -> dict[str, Any]:
    return {
        "model": "own:plain",
        "parameters": {"a": _between(r, 1, 2), "b": r.choice([1.5, _between(r, 1, 3)])},
        "answers": {"s": "own:total", "v": "own:several"},
        "targets": {"s": r.uniform(2, 5)},
        "limits": {"v": {"lower": [r.uniform(-5, 1), 0.0]}},
        "tune": {"starts": r.randint(1, 2), "max_evaluations": 20},
        "sweep": _plan(r),
    }


def _cart(r: random.Random) -> dict[str, Any]:
    return {
        "model": "own:cart",
        "parameters": {"k": _between(r, 1, 1e4), "m": r.choice([0.5, _between(r, 0.1, 2)])},
        "answers": {
            "f": {"frequency": 1},
            "m_all": {"mass": True},
            "k_x": {"stiffness": "cart", "axis": "x"},
            "x": {"coordinate": "cart", "component": 1},
        },
        "targets": {"f": r.uniform(1, 100)},
        "tune": {"max_evaluations": 5},
        "sweep": _plan(r),
    }


def _leaf(r: random.Random) -> dict[str, Any]:
    return {
        "model": r.choice(["own:leaf", "own:leaf", "own:branching"]),
        "parameters": {"t": _between(r, 0.2e-3, 1e-3), "l": r.choice([0.1, _between(r, 0.05, 0.2)])},
        "answers": {
            "f": {"frequency": r.randint(1, 2)},
            "p": {"load_multiplier": 1},
            "s": {"stress": True},
            "g": "own:tripled",
        },
        "limits": {"f": {"lower": 1.0}},
        "tune": {"minimize": "s", "max_evaluations": 3},
        "sweep": _plan(r),
    }


def _file(r: random.Random) -> dict[str, Any]:
    return {
        "model": "leaf.dat",
        "parameters": {"t": _between(r, 0.2e-3, 1e-3), "w": 0.02, "l": 0.1, "m": r.choice([1.0, _between(r, 0.1, 2)])},
        "answers": {
            "k": {"stiffness": 3, "axis": "x"},
            "f": {"frequency": 1},
            "y": {"coordinate": "3", "component": 2},
        },
        "equal": {"f": r.uniform(1, 5)},
        "tune": {"minimize": "k", "max_evaluations": 5},
        "sweep": _plan(r),
    }


BASES = {"plain": _plain, "cart": _cart, "leaf": _leaf, "file": _file}


# -- mutations --------------------------------------------------------------------------------------------------------

ODD: tuple[Any, ...] = (
    *(True, False, 0, -0.0, 1, -1, 2, 99, 10**11, 10**30, 10**400, 0.5, 1.0, -0.3, 1e-300, 1e300, -1e308),
    *(math.nan, math.inf, -math.inf, "", " ", "x", "f", "a", "own", ":", "own:", ":total", "own:NUMBER", "own:none"),
    *("own:raising", "own:leaving", "own:word", "own:imaginary", "own:nothing", "own:no_number", "own:refused"),
    *("none:f", "broken:f", "stopping:f", "empty:f", "own.none:f", "..own:f", "math:sqrt", "os:getcwd", "own:total"),
    *(
        "leaf.dat",
        "none.dat",
        ".",
        "/",
        "own.py",
        "leaf.dat/x",
        "x" * 300,
        "x" * 10_000,
        "é",
        "\x00",
        "\x1b[31m",
        "a\nb",
    ),
    *("grid", "monte-carlo", "latin-hypercube", "log", "linear", "auto", "none", "all", "wall", "cart", "3", "tip"),
    *([], [1], [1, 2], [[1], [2, 3]], ["x"], [True], {}, {"a": 1}, {"lower": 1}, {"value": 1}, {"frequency": 1}),
    *(datetime.date(2012, 1, 1), datetime.time(1, 2), datetime.datetime(2012, 1, 1)),
)
KEYS = (
    *("model", "release", "parameters", "answers", "targets", "limits", "equal", "tune", "sweep", "value", "lower"),
    *(
        "upper",
        "scale",
        "frequency",
        "load_multiplier",
        "mass",
        "stiffness",
        "axis",
        "coordinate",
        "component",
        "stress",
    ),
    *("minimize", "maximize", "starts", "seed", "tolerance", "max_evaluations", "kind", "points", "samples", "chunk"),
    *(
        "a",
        "b",
        "k",
        "t",
        "pi",
        "codes",
        "about",
        "result",
        "objective",
        "violation",
        "",
        " ",
        "a b",
        "é",
        "\x1b",
        "x" * 200,
    ),
)


def _places(data: Any) -> list[tuple[Any, Any]]:
    """Every table or list with each of its keys."""
    items = list(data.items()) if isinstance(data, dict) else list(enumerate(data)) if isinstance(data, list) else []
    return [(data, key) for key, _ in items] + [place for _, value in items for place in _places(value)]


def _tables(data: dict[str, Any]) -> list[dict[str, Any]]:
    return [data] + [inner for value in data.values() if isinstance(value, dict) for inner in _tables(value)]


def _replace(r: random.Random, data: dict[str, Any]) -> None:
    table, key = r.choice(_places(data))
    table[key] = copy.deepcopy(r.choice(ODD))


def _scale(r: random.Random, data: dict[str, Any]) -> None:
    places = [(t, k) for t, k in _places(data) if isinstance(t[k], float | int) and not isinstance(t[k], bool)]
    if places:
        table, key = r.choice(places)
        table[key] = r.choice([-1, 0, 2, 0.1, 1e-9, 1e9, 1e200, 1e-200]) * table[key]


def _remove(r: random.Random, data: dict[str, Any]) -> None:
    table, key = r.choice(_places(data))
    del table[key]


def _add(r: random.Random, data: dict[str, Any]) -> None:
    r.choice(_tables(data))[r.choice(KEYS)] = copy.deepcopy(r.choice(ODD))


def _rename(r: random.Random, data: dict[str, Any]) -> None:
    table = r.choice([table for table in _tables(data) if table])
    key = r.choice(list(table))
    new = r.choice([r.choice(KEYS), key + "x", key[:-1], key.upper()])
    table[new] = table.pop(key)


def _swap(r: random.Random, data: dict[str, Any]) -> None:
    (one, i), (other, j) = r.choice(_places(data)), r.choice(_places(data))
    # A table within itself would be no TOML.
    one[i], other[j] = copy.deepcopy(other[j]), copy.deepcopy(one[i])


def _copy(r: random.Random, data: dict[str, Any]) -> None:
    table, key = r.choice(_places(data))
    r.choice(_tables(data))[r.choice(KEYS)] = copy.deepcopy(table[key])


def _other_answer(r: random.Random, data: dict[str, Any]) -> None:
    answers = data.get("answers")
    if isinstance(answers, dict) and answers:
        answers[r.choice([*answers, "more"])] = copy.deepcopy(r.choice(ANSWERS))


def _other_plan(r: random.Random, data: dict[str, Any]) -> None:
    data["sweep"] = {**_plan(r), **r.choice(({}, {"chunk": r.randint(1, 9)}))}


def _other_parameter(r: random.Random, data: dict[str, Any]) -> None:
    parameters = data.get("parameters")
    if isinstance(parameters, dict) and parameters:
        low = r.choice((-1.0, 0.0, 1e-4, 1.0))
        parameters[r.choice(list(parameters))] = r.choice(
            (low, _between(r, abs(low), abs(low) + r.choice((1e-3, 10.0))))
        )


ANSWERS: tuple[Any, ...] = (
    *({"frequency": 1}, {"frequency": 2}, {"frequency": 3}, {"load_multiplier": 1}, {"mass": True}, {"stress": True}),
    *({"stiffness": node, "axis": axis} for node in ("cart", "tip", 3, 4, "wall") for axis in ("x", "y", "phi", "z")),
    *({"coordinate": node, "component": i} for node in ("cart", "tip", 3, 4, "foot", 1) for i in (1, 2, 3)),
    *("own:total", "own:several", "own:tripled", "own:no_number", "own:refused", "own:raising", "own:word"),
)
GENTLE: tuple[Callable[[random.Random, dict[str, Any]], None], ...] = (
    *(_other_answer, _other_answer, _other_plan, _other_parameter, _scale),
)
CHANGES: tuple[Callable[[random.Random, dict[str, Any]], None], ...] = (
    *(_replace, _replace, _replace, _scale, _scale, _remove, _add, _rename, _swap, _copy),
)


def _text(r: random.Random, content: bytes) -> bytes:
    """The text itself damaged."""
    at = r.randrange(len(content) + 1)
    lines = content.split(b"\n")
    i, j = r.randrange(len(lines)), r.randrange(len(lines))
    swapped = list(lines)
    swapped[i], swapped[j] = lines[j], lines[i]
    return r.choice(
        (
            content[:at]
            + r.choice((b"\xff", b"\0", b"=", b"[", b"]", b"'", b'"', b"\n", b"#", b"{", b"9" * 5000))
            + content[at:],
            content[:at],
            content[:at] + content[at + 1 :],
            b"\n".join(swapped),
            b"\n".join([*lines, lines[i]]),
            b"\xef\xbb\xbf" + content,
            content.decode().encode("utf-16"),
            content + b"\nx = " + b"[" * r.choice((10, 100_000)),
            b"",
        )
    )


def toml(data: dict[str, Any]) -> str:
    """A study as TOML.

    Args:
        data: Tables, with what TOML has.
    """
    plain = {key: value for key, value in data.items() if not isinstance(value, dict)}
    lines = [f"{_quoted(key)} = {_value(value)}" for key, value in plain.items()]
    for table, content in data.items():
        if isinstance(content, dict):
            lines += [
                "",
                f"[{_quoted(table)}]",
                *(f"{_quoted(key)} = {_value(value)}" for key, value in content.items()),
            ]
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    return json.dumps(text).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return f"{value:d}"
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_quoted(k)} = {_value(v)}" for k, v in value.items()) + "}"
    return value.isoformat()


def cases(seed: int) -> Iterator[Case]:
    """Studies.

    Args:
        seed: Of the random numbers.
    """
    r = random.Random(seed)
    while True:
        shares = {"compiled": SHARE_COMPILED, "tune": SHARE_TUNED, "call": SHARE_CALLED}
        (how,) = r.choices([*shares, "one by one"], [*shares.values(), 1 - sum(shares.values())])
        # What is compiled for one case is small but for a few.
        base = r.choice(list(BASES) if how == "one by one" or r.random() < 0.1 else ["plain", "plain", "plain", "cart"])
        data = BASES[base](r)
        if r.random() < SHARE_RIGHT:
            # A search needs derivatives, which a model that branches has not.
            is_right = how != "tune" or data["model"] != "own:branching"
            yield Case(toml(data).encode(), how, base if is_right else None)
            continue
        changes = GENTLE if r.random() < SHARE_GENTLE else CHANGES
        for _ in range(r.choice((1, 1, 1, 2, 3, 6))):
            with contextlib.suppress(IndexError, OverflowError):
                r.choice(changes)(r, data)
        content = toml(data).encode()
        if r.random() < 0.1:
            content = _text(r, content)
        yield Case(content, how, None)


# -- what must hold ---------------------------------------------------------------------------------------------------


def run(case: Case) -> str:
    """What happened: "refused", "failed", "answered", "too many" or "called".

    Args:
        case: Study.
    """
    path = folder() / "study.toml"
    path.write_bytes(case.content)
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        # Numbers of any size overflow on their way to a named error.
        warnings.simplefilter("ignore", RuntimeWarning)
        # Loads of any size meet states that are not stable.
        warnings.filterwarnings("ignore", ".*not stable", fm.errors.FlexmbWarning)
        try:
            study = read_study(path)
            if _designs(study) > MOST_DESIGNS:
                return "too many"
            if case.how == "call":
                return _called(path)
            if case.how == "tune":
                return _tuned(study)
            found = study.sweep(**({} if case.how == "compiled" else {"compiled": False}))
        except StudyError as fault:
            return _refused(str(fault), case)
        except (fm.SpacarError, fm.ModelError, fm.AnalysisError) as fault:
            for line in str(fault).splitlines():
                _check_line(line)
            return "refused"
    data = json.loads(to_json(sweep_answer(study, found, "0")))
    assert len(data["results"]) == len(found.codes) > 0
    assert sweep_table(found).isprintable() or "\n" in sweep_table(found)
    for name, values in found.answers.items():
        failed = found.codes != fm.RESULTS.successful
        # These have answers all the same.
        answered = np.isin(found.codes, [fm.RESULTS.critical_state, fm.RESULTS.unstable_state])
        assert np.all(np.isnan(values[failed & ~answered])), name
        assert not np.any(np.isnan(values[~failed])), name
    if case.base is not None:
        _check_right(case.base, found)
    return "answered" if data["status"] == "ok" else "failed"


def _refused(text: str, case: Case) -> str:
    _check_line(text)
    assert text.startswith("study.toml: "), text
    assert case.base is None, text
    return "refused"


def _designs(study: Study) -> float:
    """How many designs it asks for, none of which is made."""
    points = study.plan.get("points", 11)
    if "samples" in study.plan or study.plan.get("kind", "grid") != "grid":
        return study.plan.get("samples", 100)
    return math.prod(points[n] if isinstance(points, dict) else points for n in study.bounds)


def _check_line(text: str) -> None:
    assert text.isprintable(), text
    assert len(text) < 1000, len(text)


def _check_right(base: str, found: fm.design.Sweep) -> None:
    """Answers are those of closed forms; what cannot be built has its code, and nothing else has."""
    p = {**{"w": 0.02, "l": 0.1, "m": 1.0, "b": 1.5}, **found.designs}
    good = found.codes == fm.RESULTS.successful
    if base == "cart":
        p = {**{"m": 0.5}, **found.designs}
        possible = (p["k"] >= 0) & (p["m"] >= 0)
        expected = np.sqrt(p["k"] / p["m"]) / (2 * np.pi) if np.all(possible) else None
        np.testing.assert_array_equal(
            found.codes == fm.RESULTS.impossible_design, ~(possible & np.ones(len(good), bool))
        )
        if expected is not None:
            np.testing.assert_allclose(found["f"].ravel()[good], np.broadcast_to(expected, good.shape)[good], rtol=1e-9)
    elif base == "leaf":
        possible = np.broadcast_to(p["t"] > 0, good.shape)
        np.testing.assert_array_equal(found.codes == fm.RESULTS.impossible_design, ~possible)
    elif base == "file":
        possible = np.broadcast_to((p["t"] >= 0) & (p["m"] >= 0), good.shape)
        np.testing.assert_array_equal(found.codes == fm.RESULTS.impossible_design, ~possible)
        # A cantilever without mass of its own: 12 EI/l^3 with its end kept from turning, a quarter of that if not.
        stiffness = 3 * 210e9 * p["w"] * p["t"] ** 3 / 12 / p["l"] ** 3
        np.testing.assert_allclose(found["k"].ravel()[good], np.broadcast_to(stiffness, good.shape)[good], rtol=1e-8)
    else:
        np.testing.assert_allclose(found["s"].ravel(), np.broadcast_to(p["a"] + p["b"], good.shape), rtol=1e-14)


def _tuned(study: Study) -> str:
    """A search of a few evaluations ends within its bounds, with a reason."""
    limits = {"max_evaluations": 5, "starts": min(study.wanted.get("starts", 1), 2)}
    found = study.tune(throw=False, **limits)
    json.loads(to_json(tune_answer(study, found, "0")))
    assert found.reason
    for name, value in found.dimensions.items():
        assert study.bounds[name][0] <= value <= study.bounds[name][1], name
    return "answered" if found.result is fm.RESULTS.successful else "failed"


def _called(path: Path) -> str:
    """The command line in this process: exit status, one line a fault, files whole or not at all."""
    from typer.testing import CliRunner

    from flexmb.cli import app

    with tempfile.TemporaryDirectory() as place:
        saved, answer = Path(place) / "a.npz", Path(place) / "a.json"
        result = CliRunner().invoke(app, ["sweep", str(path), "--json", str(answer), "--save", str(saved)])
        assert result.exit_code in (0, 1, 2), result.exit_code
        assert "Traceback" not in result.stderr
        for line in result.stderr.splitlines():
            _check_line(line)
        if result.exit_code == 0:
            assert not result.stderr
            with np.load(saved) as file:
                assert file["codes"].size == len(json.loads(answer.read_text())["results"])
        assert set(os.listdir(place)) <= {"a.npz", "a.json"}
    return "called"
