"""Keep what public functions of the package return, as arrays by path; `frozen.py` says what for."""

import contextlib
import functools
import inspect
import types
from collections import Counter
from pathlib import Path
from typing import Any

import jax
import jax.core
import numpy as np

# Relative tolerance of motions that others are compared with; the defaults of `fm.simulate` and `fm.tune`.
TIGHT, RTOL, TOLERANCE = 1e-11, 1e-5, 1e-6
# Entries kept of an answer; calls kept of one function.
MOST, CALLS = 2000, 60
# Structure, counts and what measures round-off are no answers.
LEFT = {
    *("model", "labels", "lin", "topology", "parameters", "driven", "near", "start", "asked_of"),
    *("matrices", "factors", "by_sparse"),
    *("iterations", "steps", "history", "runs", "evaluations", "condition", "energy_error", "violation", "settings"),
}
UNRECORDED = {
    "jit",
    "read_spacar",
    "write_spacar",
    "view",
    "edit",
    "enable_x64",
    "enable_cache",
    "save_fmu",
    "save_motion",
}
UNRECORDED_ROOMS = {"flexmb.plot", "flexmb.blocks", "flexmb.viewer", "flexmb.workbench"}
MODES = {"shapes", "q_shapes", "modes"}
VALUES = ("eigenvalues", "multipliers", "load_multipliers")
NUMBERS = (bool, int, float, complex, np.ndarray, np.generic, jax.Array, list, tuple)
PASSIVE = (str, bytes, types.ModuleType, types.FunctionType, type, Path, jax.core.Tracer)


def array_of(value: Any) -> np.ndarray | None:
    """A number, an array or a rectangular list as an array of numbers; otherwise None."""
    if not isinstance(value, NUMBERS) or isinstance(value, jax.core.Tracer) or hasattr(value, "_fields"):
        return None
    with contextlib.suppress(Exception):
        found = np.asarray([np.nan if one is None else one for one in value] if isinstance(value, list) else value)
        if found.dtype.kind in "biufc" and found.size:
            return found.astype(complex if found.dtype.kind == "c" else float)
    return None


def entries_of(value: Any) -> dict[str, Any]:
    """What a container, a record or a result holds, by public name or number."""
    if isinstance(value, dict):
        return {str(key): one for key, one in value.items()}
    if isinstance(value, list | tuple) and not hasattr(value, "_fields"):
        return {str(i): one for i, one in enumerate(value[:MOST])}
    kind = type(value)
    if kind.__name__ == "Motion":
        names = ["t", "x", "xd", "u"]
    elif kind.__name__ == "StateSpace":
        names = list("ABCD")
    elif fields := getattr(value, "_fields", None) or getattr(value, "__dataclass_fields__", None):
        names = [*fields, *(n for n in dir(kind) if not callable(inspect.getattr_static(kind, n)))]
    else:
        names = []
    found = {}
    for name in names:
        if not name.startswith("_") and name not in LEFT:
            with contextlib.suppress(Exception):
                found[name] = getattr(value, name)
    return found


def columns(modes: Any) -> np.ndarray | None:
    """Modes as columns: an array, or the command line's list of components by node."""
    if isinstance(modes, list) and modes and isinstance(modes[0], dict):
        return np.array([np.concatenate([np.ravel(part) for part in mode.values()]) for mode in modes], float).T
    return array_of(modes)


def collect(value: Any, path: str, out: dict[str, tuple[np.ndarray, dict]], tell: dict | None = None, depth: int = 0):
    """Add the numbers in a value to ``out``.

    Args:
        value: Anything.
        path: Its name.
        out: Arrays by path, each with what is known of it: "rtol" of the motion it belongs to, "tolerance" of the
            search, "objective" (that tolerance) of an objective, "by": the values of modes.
        tell: What is known of the value.
        depth: How far it is within another one.
    """
    tell = tell or {}
    if depth > 8 or value is None or isinstance(value, PASSIVE):
        return
    if (found := array_of(value)) is not None:
        out[path] = found if found.size <= MOST else found.ravel()[:: -(-found.size // MOST)], tell
        return
    entries = entries_of(value)
    # Numbers of nodes or elements, as the command line names them: all of them are one answer.
    if entries and all(name.isdecimal() for name in entries) and isinstance(value, dict):
        parts = [array_of(one) for one in entries.values()]
        if all(part is not None for part in parts):
            return collect(np.concatenate([np.ravel(part) for part in parts]), path, out, tell, depth)
    values = next((found for name in VALUES if (found := array_of(entries.get(name))) is not None), None)
    for name, one in entries.items():
        if name in MODES and values is not None:
            modes = columns(one)
            if modes is not None and modes.ndim == 2 and modes.shape[1] == len(values):
                out[f"{path}/{name}"] = modes, {"by": np.real(values).tolist()}
                continue
        more = {"objective": tell["tolerance"]} if name == "objective" and "tolerance" in tell else {}
        if name not in LEFT and not callable(one):
            collect(one, f"{path}/{name}", out, tell | more, depth + 1)


class Recorder:
    """Keeps what public functions return to a script, by their names and numbers.

    Attributes:
        tight: Whether motions are integrated as closely as possible, and searches begin elsewhere.
        out: Answers by path; see :func:`collect`.
        prefix: Of the paths.
        rtol: Largest tolerance of a motion, 0 without one.
        tuned: Whether a design was searched.
    """

    def __init__(self, tight: bool):
        self.tight, self.out, self.prefix, self.rtol, self.tuned = tight, {}, "", 0.0, False
        self.inside, self.count, self.known = False, Counter(), {}

    def install(self) -> None:
        """Put itself in front of the public functions."""
        import flexmb as fm

        rooms = [room for name in dir(fm) if hasattr(room := getattr(fm, name), "__path__")]
        for module in [fm, *(room for room in rooms if room.__name__ not in UNRECORDED_ROOMS)]:
            for name in set(dir(module)) - UNRECORDED:
                if not name.startswith("_") and isinstance(function := getattr(module, name), types.FunctionType):
                    setattr(module, name, self.recorded(function, name))

    def recorded(self, function: types.FunctionType, name: str):
        """A public function whose answers are kept."""

        @functools.wraps(function)
        def call(*args, **keywords):
            if self.inside:
                return function(*args, **keywords)
            key, tell = f"{self.prefix}{name}", {}
            if name == "simulate":
                tell = {"rtol": float(keywords.get("rtol", getattr(keywords.get("integrator"), "rtol", RTOL)))}
                self.rtol = max(self.rtol, tell["rtol"])
            elif name == "tune":
                self.tuned, tell = True, {"tolerance": keywords.get("tolerance", TOLERANCE)}
            self.inside = True
            try:
                found = otherwise(function, name, args, keywords) if self.tight else function(*args, **keywords)
                self.keep(found, f"{key}#{self.count[key]}", tell)
            except Exception as error:
                self.keep(1, f"{key}#{self.count[key]}/raises {type(error).__name__}", {})
                raise
            finally:
                self.inside = False
                self.count[key] += 1
            return found

        return call

    def keep(self, value: Any, path: str, tell: dict) -> None:
        """Keep the numbers of a value, once, and of the first calls."""
        with contextlib.suppress(Exception):
            if id(value) not in self.known and self.count[path.partition("#")[0]] < CALLS:
                collect(value, path, self.out, tell)
                if entries_of(value):
                    # Held, so that nothing else takes its number.
                    self.known[id(value)] = value


def otherwise(function: types.FunctionType, name: str, args: tuple, keywords: dict) -> Any:
    """Call a function: a motion by a small tolerance, a search from another start, all else as it is."""
    given, changed = inspect.signature(function).bind(*args, **keywords), {}
    if name == "simulate":
        changed = {"rtol": TIGHT} | ({"atol": TIGHT} if "atol" in keywords else {})
    elif name == "tune":
        starts, bounds = given.arguments["dimensions"], given.arguments["bounds"]
        middle = {n: (np.asarray(bounds[n][0]) + np.asarray(bounds[n][1])) / 2 for n in starts}
        changed = {"dimensions": {n: one + 1e-3 * (middle[n] - one) for n, one in starts.items()}}
    with contextlib.suppress(Exception):
        if changed:
            return function(**{n: one for n, one in given.arguments.items() if n != "keywords"} | keywords | changed)
    return function(*args, **keywords)
