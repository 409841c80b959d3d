"""What whole commands take from the cache, beside ``import jax.numpy``.

``python benchmarks/command_line.py`` prints the table that README quotes and writes results/command_line.json:
processor time of the whole process, medians of interleaved runs, three of what takes more than a second. Each mode has
been asked once before, which filled the cache.
"""

import os
import resource
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

    def processor() -> float:
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    # Python's own compiled code lies beside the text of an installed package.
    around = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    paths = os.pathsep.join([str(HERE.parent), os.environ.get("PYTHONPATH", "")])
    environment = {**around, "PYTHONPATH": paths, "JAX_PLATFORMS": "cpu", "FLEXMB_CACHE": folder}
    before = processor()
    subprocess.run([sys.executable, "-c", *words], env=environment, cwd=folder, capture_output=True, check=True)
    return processor() - before


def main() -> None:
    """Measure, print and save."""
    from record import save

    commands = {IMPORT: [IMPORT]}
    for name, modes in ASKED.items():
        commands |= {f"mode {i} of {name}": [MAIN, "run", "--mode", str(i), str(FILES / f"{name}.dat")] for i in modes}
    with tempfile.TemporaryDirectory() as folder:
        first = {name: taken(words, folder) for name, words in commands.items()}
        times = {name: [] for name in commands}
        for _ in range(RUNS):
            for name, words in commands.items():
                if len(times[name]) < RUNS_OF_LONG or min(times[name]) < LONG:
                    times[name].append(taken(words, folder))
    found = {name: statistics.median(own) for name, own in times.items()}
    for name, own in found.items():
        print(f"{name:<24}{own:6.2f} s{own / found[IMPORT]:8.2f} times; from nothing {first[name]:6.2f} s")
    save("command_line", {"processor [s]": found, "from nothing [s]": first})


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    main()
