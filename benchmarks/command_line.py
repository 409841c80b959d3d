"""What whole commands take from the cache, beside ``import jax.numpy``.

``python benchmarks/command_line.py`` prints the table that README quotes and writes results/command_line.json:
processor time of the whole process, medians of interleaved runs on all cores, three of what takes more than a second.
Each mode has been asked once before, which filled the cache.
"""

import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
FILES = HERE.parent / "flexmb" / "mechanisms"
RUNS, RUNS_OF_LONG, LONG = 7, 3, 1.0
IMPORT = "import jax.numpy"
MAIN = "from flexmb.cli import main; main()"
QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
ASKED = {
    "pf2d": (0, 7, 8, 9, 10),
    "pf3d": (7, 10),
    "manipulator": (1, 2, 3, 4),
}


def taken(words: list[str], folder: str) -> float:
    """Processor time of a process of Python [s].

    Args:
        words: Code, and its arguments.
        folder: Where it runs, and keeps compiled code.
    """
    # Python's own compiled code lies beside the text of an installed package.
    around = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    paths = os.pathsep.join([str(HERE.parent), os.environ.get("PYTHONPATH", "")])
    environment = {**around, "PYTHONPATH": paths, "JAX_PLATFORMS": "cpu", "FLEXMB_CACHE": folder}
    process = subprocess.Popen([sys.executable, "-c", *words], env=environment, cwd=folder, **QUIET)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, words
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Measure, print and save."""
    from record import save, side_by_side

    commands = {IMPORT: [IMPORT]}
    for name, modes in ASKED.items():
        commands |= {f"mode {i} of {name}": [MAIN, "run", "--mode", str(i), str(FILES / f"{name}.dat")] for i in modes}
    with tempfile.TemporaryDirectory() as folder:

        def run(words: list[str]) -> float:
            return taken(words, folder)

        first = dict(zip(commands, side_by_side(run, commands.values()), strict=True))
        times = {name: [] for name in commands}
        for _ in range(RUNS):
            due = [name for name in commands if len(times[name]) < RUNS_OF_LONG or min(times[name]) < LONG]
            for name, own in zip(due, side_by_side(run, [commands[name] for name in due]), strict=True):
                times[name].append(own)
    found = {name: statistics.median(own) for name, own in times.items()}
    for name, own in found.items():
        print(f"{name:<24}{own:6.2f} s{own / found[IMPORT]:8.2f} times; from nothing {first[name]:6.2f} s")
    save("command_line", {"processor [s]": found, "from nothing [s]": first})


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
