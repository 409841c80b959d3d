"""Global settings of JAX that a user switches on by one call; importing flexmb changes none."""

import contextlib
import os
import sys
import time
from pathlib import Path

from .errors import warn

LARGEST_CACHE = 2_000_000_000
# So often files are counted [s]: of thousands it takes a twentieth of a command.
BETWEEN = 3600.0


def enable_x64() -> None:
    """Switch JAX to double precision, for the whole process."""
    import jax

    jax.config.update("jax_enable_x64", True)


def cache_folder() -> Path:
    """Default folder of compiled code: ``$FLEXMB_CACHE``, or flexmb in the user's cache folder."""
    given = os.environ.get("FLEXMB_CACHE")
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(given) if given else Path(base) / "flexmb"


def _prepared(path: Path) -> None:
    """Make the folder; refuse one others may have written code into; once an hour drop the oldest beyond the limit."""
    path.mkdir(parents=True, exist_ok=True, mode=0o700)
    if hasattr(os, "getuid"):
        for folder in filter(Path.exists, (path, path / "programs")):
            state = folder.stat()
            if state.st_uid != os.getuid():
                raise PermissionError(f"The folder '{folder}' is another user's: compiled code in it could be theirs.")
            if state.st_mode & 0o022:
                raise PermissionError(
                    f"Others may write into '{folder}', whose code would be run: take chmod 700 first."
                )
    from .compilation.kept import PART

    looked_at = path / "looked_at"
    with contextlib.suppress(FileNotFoundError):
        if 0 <= time.time() - looked_at.stat().st_mtime < BETWEEN:
            return
    with contextlib.suppress(OSError):
        looked_at.touch()
    files = []
    for folder in (path, path / "programs"):
        if folder.is_dir():
            with os.scandir(folder) as found:
                for file in found:
                    # Another process may rename or remove it meanwhile.
                    with contextlib.suppress(FileNotFoundError):
                        state = file.stat()
                        # Part of a file whose process was stopped.
                        if file.name.endswith(PART) and time.time() - state.st_mtime > BETWEEN:
                            Path(file.path).unlink()
                        elif file.is_file():
                            files.append((state, file.path))
    files.sort(key=lambda one: -max(one[0].st_atime, one[0].st_mtime))
    kept = 0
    for state, file in files:
        kept += state.st_size
        if kept > LARGEST_CACHE:
            Path(file).unlink(missing_ok=True)


def enable_cache(folder: str | os.PathLike | None = None, *, thorough: bool = True) -> Path:
    """Keep compiled code on disk, so that a fresh process starts quickly.

    Programs of this package are found there without being traced, except where functions or objects of yours take part.
    Whoever replaces functions or numbers of this package or of a library chooses another folder: it is not looked for.

    What equinox and diffrax check while they run then answers NaN instead of raising, in the whole process, unless the
    environment variable ``EQX_ON_ERROR`` says otherwise: code that raises cannot be kept. Once an hour this call
    removes files beyond 2 GB in all, those that were not used for the longest time first.

    Args:
        folder: Where, a folder of its own that belongs to you and that no other can write into; by default
            :func:`cache_folder`.
        thorough: Compile for half the run time in twice the compile time, as code that is kept deserves.

    Returns:
        The folder.

    Raises:
        PermissionError: The folder is another user's, or others may write into it.
        OSError: It cannot be made.
    """
    import jax
    from jax.experimental.compilation_cache.compilation_cache import reset_cache

    from .compilation.compile import compile_thoroughly

    path = Path(folder) if folder is not None else cache_folder()
    _prepared(path)
    compile_thoroughly(thorough, keep=True)
    # What checks for errors by calling back into Python is never kept on disk, and diffrax does; its answers are
    # checked for finiteness here. Equinox reads this once, when it is imported.
    if "equinox" in sys.modules and "EQX_ON_ERROR" not in os.environ:
        warn(
            "Equinox was imported before enable_cache(), so that motions compiled now are not kept on disk. Call"
            " enable_cache() first, or set the environment variable EQX_ON_ERROR=nan."
        )
    os.environ.setdefault("EQX_ON_ERROR", "nan")
    jax.config.update("jax_compilation_cache_dir", str(path))
    # JAX looks for a folder once, when it compiles for the first time.
    reset_cache()
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    return path
