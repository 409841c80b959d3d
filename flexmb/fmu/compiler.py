"""The C compiler of this machine, if there is one."""

import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

SYSTEMS = {"linux": ("linux", ".so"), "darwin": ("darwin", ".dylib"), "win32": ("windows", ".dll")}
PROCESSORS = {"amd64": "x86_64", "x86_64": "x86_64", "arm64": "aarch64", "aarch64": "aarch64"}
LONGEST = 600


def place_of_binary(identifier: str, fmi: int) -> str | None:
    """Path of the binary for this platform in a unit; None if FMI has no name for the platform."""
    system, processor = SYSTEMS.get(sys.platform), PROCESSORS.get(platform.machine().lower())
    if system is None or processor is None:
        return None
    folder = f"{processor}-{system[0]}"
    if fmi == 2 and processor == "x86_64":
        folder = {"linux": "linux64", "darwin": "darwin64", "windows": "win64"}[system[0]]
    return f"binaries/{folder}/{identifier}{system[1]}"


def found_compiler() -> list[str] | None:
    """Command of a C compiler: $CC, or else cc, gcc or clang; None without any."""
    words = shlex.split(os.environ.get("CC", ""))
    for candidate in [words] if words else [["cc"], ["gcc"], ["clang"]]:
        if shutil.which(candidate[0]):
            return candidate
    return None


def compiled(files: dict[str, bytes], main: str) -> tuple[bytes | None, str]:
    """A shared library of C sources, reproducible to the byte; or None, and why there is none."""
    command = found_compiler()
    if command is None:
        given = os.environ.get("CC")
        return None, f"there is no C compiler '{given}'" if given else "there is no C compiler (cc, gcc, clang, or $CC)"
    # The library contains no paths, times or build numbers, and no fused multiply-adds.
    options = ["-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-shared"]
    if sys.platform != "win32":
        options.append("-fPIC")
    if sys.platform.startswith("linux"):
        options += ["-s", "-Wl,--build-id=none"]
    with tempfile.TemporaryDirectory(prefix="flexmb") as folder:
        for name, content in files.items():
            (Path(folder) / name).write_bytes(content)
        call = [*command, *options, "-o", "library", main, "-lm"]
        try:
            run = subprocess.run(call, cwd=folder, capture_output=True, timeout=LONGEST, check=False)
        except (OSError, subprocess.TimeoutExpired) as fault:
            return None, f"{command[0]} did not work: {fault}"
        if run.returncode:
            lines = run.stderr.decode(errors="replace").strip().splitlines() or ["no reason given"]
            return None, f"{command[0]} refused them: {next((line for line in lines if 'error' in line), lines[0])}"
        return (Path(folder) / "library").read_bytes(), ""
