"""Freeze the answers of all that is shipped, and compare a later version of the package with them.

    python tests/frozen.py list [--all]                       # what there is to ask
    python tests/frozen.py write FILE [--all] [--only NAME]   # ask, and write the answers to FILE (.npz)
    python tests/frozen.py compare FILE [--all] [--only NAME] # ask again, and compare; status 1 where something differs

Asked are the modes of the command line for `flexmb/mechanisms/*.dat`; the mechanisms of `tests/cases/` and
`benchmarks/scenes.py` that need no argument; the manuals; with --all or where named the cases of
`benchmarks/questions.py`, the notebooks and the tests that `tests/REFERENCES.md` names. They are found by looking
(`shipped.py`). Each runs in a fresh process. Answers are what public functions of the package return to it
(`recorded.py`), and the numbers in its namespace. FILE keeps what it had of mechanisms that are not asked anew.

Numbers agree where they differ by less than 1e-9 of the largest entry of their answer. Modes may change their sign, and
those of a repeated eigenvalue their basis. `write` asks twice. The second time the processor's newer instructions are
left out, motions have `rtol=1e-11`, and searches of `fm.tune` begin slightly elsewhere. An answer that then differs by
more than 1e-9 depends on round-off, on a motion or on a search, and has a tolerance of its own:
- of a motion and what follows from it: 10 rtol from the second answer, or twice what the first one is off;
- of what follows from a search: ten times the difference, or 1e-6; objectives agree within the search's tolerance;
- of all else: ten times the difference. The tables count these answers as loose. A difference of their own size says
  that they are round-off, or modal coordinates, whose sign is free: they are not compared.
"""

import argparse
import contextlib
import io
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
import shipped
from recorded import TOLERANCE, Recorder

ROOT = Path(__file__).resolve().parents[1]
CLOSE = 1e-9
# Values that differ relatively by less are one value, whose modes have no basis of their own.
REPEATED = 1e-6
# Asked with --all or where named: they take most of the time.
LONG = ("question", "notebook", "tests")
# Other instructions, other round-off.
OLD_PROCESSOR = {"XLA_FLAGS": "--xla_cpu_max_isa=SSE4_2", "OPENBLAS_CORETYPE": "Nehalem"}


def answer(job: str, tight: bool, file: str) -> None:
    """Ask one mechanism in this process, and write its answers."""
    recorder, (kind, _, name), fault = Recorder(tight), job.partition(":"), ""
    try:
        if kind != "tests":
            import flexmb as fm

            warnings.simplefilter("ignore")
            fm.enable_x64()
            fm.enable_cache(thorough=False)
            recorder.install()
        with contextlib.redirect_stdout(io.StringIO()):
            getattr(shipped, f"ask_{kind}")(name, recorder)
    except (Exception, SystemExit) as error:
        fault = f"{type(error).__name__}: {error}".partition("\n")[0]
    index = {path: tell for path, (_, tell) in recorder.out.items()}
    told = {"answers": index, "rtol": recorder.rtol, "tuned": recorder.tuned, "fault": fault}
    np.savez(file, index=json.dumps(told), **{f"{i}": array for i, (array, _) in enumerate(recorder.out.values())})


def asked(job: str, tight: bool, limit: float) -> tuple[dict, dict[str, np.ndarray]]:
    """What is known of a mechanism's answers, and the answers by path, from a fresh process."""
    began, fault = time.monotonic(), ""
    with tempfile.TemporaryDirectory() as folder, open(f"{folder}/said", "w+", encoding="utf-8") as said:
        paths = os.pathsep.join(f"{ROOT / name}" for name in (".", "tests", "benchmarks"))
        environment = {**os.environ, "PYTHONPATH": paths, "JAX_PLATFORMS": "cpu", "MPLBACKEND": "Agg"}
        environment |= OLD_PROCESSOR if tight else {}
        command = [sys.executable, __file__, "answer", f"{folder}/answers.npz", "--only", job, *["--tight"] * tight]
        try:
            subprocess.run(command, cwd=folder, env=environment, stdout=said, stderr=subprocess.STDOUT, timeout=limit)
        except subprocess.TimeoutExpired:
            fault = f"ran longer than {limit:.0f} s"
        told, answers = {"answers": {}, "rtol": 0.0, "tuned": False, "fault": fault}, {}
        if Path(f"{folder}/answers.npz").exists():
            with np.load(f"{folder}/answers.npz") as found:
                told = json.loads(str(found["index"]))
                answers = {path: found[str(i)] for i, path in enumerate(told["answers"])}
        elif not fault:
            said.seek(0)
            told["fault"] = " ".join(said.read()[-300:].split())
    return told | {"seconds": time.monotonic() - began}, answers


def largest(array: np.ndarray) -> float:
    """Largest magnitude among the finite entries."""
    return float(np.max(np.abs(array[np.isfinite(array)]), initial=0.0))


def apart(new: np.ndarray, old: np.ndarray, values: list | None = None) -> float:
    """Largest difference over the largest entry; of modes up to sign and up to the basis of a repeated value."""
    if new.shape != old.shape or np.any(np.isfinite(new) != np.isfinite(old)):
        return np.inf
    if values is not None:
        new = aligned(new, old, np.asarray(values))
    with np.errstate(invalid="ignore"):
        return largest(np.where(new == old, 0.0, new - old)) / (largest(old) or 1.0)


def aligned(new: np.ndarray, old: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The modes in the columns of ``new`` with the signs of ``old``; repeated ones in its basis, where they span it."""
    new, start = new.copy(), 0
    for end in range(1, len(values) + 1):
        if end < len(values) and abs(values[end] - values[end - 1]) <= REPEATED * abs(values[end]):
            continue
        one, other, start = new[:, start:end], old[:, start:end], end
        if one.shape[1] == 1:
            one *= -1 if np.nan_to_num(one[:, 0]) @ np.nan_to_num(other[:, 0]) < 0 else 1
        elif np.linalg.matrix_rank(np.nan_to_num(one), tol=REPEATED * largest(one)) == one.shape[1]:
            one[:] = one @ np.linalg.lstsq(one, other, rcond=None)[0]
    return new


def compared(old: dict, stored: dict[str, np.ndarray], new: dict[str, np.ndarray]) -> tuple[int, float, list[str]]:
    """How many answers are loose, the largest difference of the others, and in words which differ.

    Args:
        old: What is known of a mechanism's stored answers.
        stored: These by path, and behind "~" where they differed the second time.
        new: Answers by path.
    """
    loose, worst, wrong = 0, 0.0, []
    for path, tell in old["answers"].items():
        if path not in new:
            wrong.append(f"{path} is not there")
            continue
        first, second, values = stored[path], stored.get(f"{path}~"), tell.get("by")
        rtol = tell.get("rtol", old["rtol"])
        off, limit = apart(new[path], first, values), CLOSE
        if "objective" in tell:
            off, limit = off * largest(first), tell["objective"] * max(1.0, largest(first))
        elif second is not None or "rtol" in tell:
            noise = 0.0 if second is None else apart(first, second, values)
            limit = max(CLOSE, 10 * noise, TOLERANCE * old["tuned"])
            if rtol and not old["tuned"]:
                off, limit = apart(new[path], first if second is None else second, values), max(10 * rtol, 2 * noise)
            loose += 1
        else:
            worst = max(worst, off)
        if not off <= limit:
            wrong.append(f"{path} differs by {off:.1e}, allowed are {limit:.1e}")
    return loose, worst, wrong


def row(job: str, told: dict, loose: int, worst: float, wrong: list[str]) -> str:
    """A line of the table, and the first answers that differ."""
    count = len(told["answers"])
    line = f"{job:<44}{count:>8}{loose:>7}{len(wrong):>8}{worst:>10.1e}{told['seconds']:>7.0f} s  {told['fault']}"
    return "\n    ".join([line.rstrip(), *wrong[:8]])


def main() -> int:
    """Do what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("list", "write", "compare", "answer"))
    parser.add_argument("file", type=Path, nargs="?")
    parser.add_argument("--only", default="", help="only mechanisms whose name contains this")
    parser.add_argument("--all", action="store_true", help=f"those that take long too: {', '.join(LONG)}")
    parser.add_argument("--limit", type=float, default=600.0, help="for one mechanism [s]")
    parser.add_argument("--tight", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.what == "answer":
        answer(given.only, given.tight, f"{given.file}")
        return 0
    stored = dict(np.load(given.file)) if given.file and given.file.exists() else {}
    index, status, begin = json.loads(str(stored.pop("index", "{}"))), 0, time.monotonic()
    chosen = [job for job in (index if given.what == "compare" else shipped.jobs()) if given.only in job]
    chosen = [job for job in chosen if given.all or given.only or not job.startswith(LONG)]
    if given.what == "list":
        print("\n".join(chosen))
        return 0
    print(f"{'mechanism':<44}{'answers':>8}{'loose':>7}{'differ':>8}{'largest':>10}{'time':>9}")
    for job in chosen:
        told, new = asked(job, False, given.limit)
        if given.what == "write":
            again, second = asked(job, True, given.limit)
            index[job] = told | {"fault": told["fault"] or again["fault"]}
            stored = {path: array for path, array in stored.items() if not path.startswith(f"{job}|")}
            stored |= {f"{job}|{path}": array for path, array in new.items()}
            for path, tell in told["answers"].items():
                if path in second and CLOSE < apart(second[path], new[path], tell.get("by")) < np.inf:
                    stored[f"{job}|{path}~"] = second[path]
            np.savez_compressed(given.file, index=json.dumps(index), **stored)
        old = index[job]
        result = compared(old, {p.partition("|")[2]: a for p, a in stored.items() if p.startswith(f"{job}|")}, new)
        status |= bool(result[2]) or (told["fault"] != old["fault"] and given.what == "compare")
        print(row(job, told, *result), flush=True)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = f"{time.monotonic() - begin:.0f} s, {used.ru_utime + used.ru_stime:.0f} s of the processor"
    print(f"{len(chosen)} mechanisms, {seconds}, {given.file.stat().st_size / 1e6:.1f} MB")
    return status


if __name__ == "__main__":
    sys.path[:0] = [f"{ROOT}", f"{ROOT / 'tests'}", f"{ROOT / 'benchmarks'}"]
    sys.exit(main())
