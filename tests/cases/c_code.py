"""C that the package writes: compiled by the compiler of this machine, called with arrays of NumPy."""

import ctypes
import subprocess
from pathlib import Path

import numpy as np
import pytest

from flexmb.fmu.save import compiler_command

needs_compiler = pytest.mark.skipif(
    compiler_command() is None, reason="there is no C compiler: install gcc, or set $CC"
)


def compiled(source: str, folder: Path) -> ctypes.CDLL:
    """Shared library of a file in C99; warnings are errors."""
    (folder / "code.c").write_text(source)
    options = "-std=c99 -pedantic -Wall -Wextra -Werror -O1 -ffp-contract=off -shared -fPIC".split()
    run = subprocess.run(
        [*(compiler_command() or []), *options, "code.c", "-o", "code.so", "-lm"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    return ctypes.CDLL(str(folder / "code.so"))


def pointer(array: np.ndarray) -> ctypes.c_void_p:
    """Where an array stands."""
    return ctypes.c_void_p(array.ctypes.data)


def called(library: ctypes.CDLL, translated, *arguments) -> list[np.ndarray]:
    """Results of a translated function; workspace and results hold nothing of use before."""

    def like(kind):
        return float if kind.kind == "f" else np.int64

    given = [np.ascontiguousarray(a, like(kind)) for a, (_, _, kind) in zip(arguments, translated.inputs, strict=True)]
    found = [np.full(shape, 77, like(kind)) for _, shape, kind in translated.outputs]
    room = [np.full(translated.work[0], np.nan), np.full(translated.work[1], -(2**40))]
    getattr(library, translated.name)(*map(pointer, [*given, *found, *room]))
    return found
