"""Global settings of JAX. A call of the user switches them on; importing flexmb changes none."""

import contextlib
import os
import sys
import time
from pathlib import Path

from .errors import warn

LARGEST_CACHE = 2_000_000_000
# Time between two counts of the cache's files [s]: thousands of files take a twentieth of a command.
BETWEEN = 3600.0


def enable_x64() -> None:
    """Switch JAX to double precision, for the whole process."""
    import jax

    jax.config.update("jax_enable_x64", True)


def cache_folder() -> Path:
    """Default folder of compiled code: ``$FLEXMB_CACHE``, or flexmb in the user's cache folder."""
    folder = os.environ.get("FLEXMB_CACHE")
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(folder) if folder else Path(base) / "flexmb"


def _prepared(path: Path) -> None:
    """Make the folder; refuse one that others may write to; remove its oldest files beyond the limit once an hour."""
    path.mkdir(parents=True, exist_ok=True, mode=0o700)
    if hasattr(os, "getuid"):
        for folder in filter(Path.exists, (path, path / "programs")):
            state = folder.stat()
            if state.st_uid != os.getuid():
                raise PermissionError(f"The folder '{folder}' belongs to another user, who could put code into it.")
            if state.st_mode & 0o022:
                raise PermissionError(f"Others may write code into '{folder}', which would run: call chmod 700 first.")
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
            with os.scandir(folder) as entries:
                for file in entries:
                    # Another process may meanwhile rename or remove it.
                    with contextlib.suppress(FileNotFoundError):
                        state = file.stat()
                        # A leftover of a stopped process.
                        if file.name.endswith(PART) and time.time() - state.st_mtime > BETWEEN:
                            Path(file.path).unlink()
                        elif file.is_file():
                            files.append((state, file.path))
    files.sort(key=lambda entry: -max(entry[0].st_atime, entry[0].st_mtime))
    total_size = 0
    for state, file in files:
        total_size += state.st_size
        if total_size > LARGEST_CACHE:
            Path(file).unlink(missing_ok=True)


def enable_cache(folder: str | os.PathLike | None = None, *, thorough: bool = True) -> Path:
    """Keep compiled code on disk, so that a new process starts quickly.

    A new process loads programs of this package without tracing them. Only programs that contain functions or objects
    of yours are traced again.
    flexmb does not notice if you replace functions or numbers inside packages: choose another folder then.

    Errors that equinox and diffrax check at run time become NaN in the whole process, because code that raises cannot
    be kept; the environment variable ``EQX_ON_ERROR`` overrides this. Once an hour this call removes files beyond 2 GB
    in total, longest unused first.

    Args:
        folder: Folder for this purpose alone, which belongs to you and to which no one else can write; by default
            :func:`cache_folder`.
        thorough: Compile with optimisation. Compiled code then runs in half the time, and the compilation takes twice
            as long. This is worthwhile for code that is stored on disk.

    Returns:
        The folder.

    Raises:
        PermissionError: The folder belongs to another user, or others may write to it.
        OSError: The folder cannot be made.
    """
    import jax
    from jax.experimental.compilation_cache.compilation_cache import reset_cache

    from .compilation.compile import compile_thoroughly

    path = Path(folder) if folder is not None else cache_folder()
    _prepared(path)
    compile_thoroughly(thorough, keep=True)
    # diffrax checks errors by calling Python, and such code is never kept on disk; flexmb checks that answers are
    # finite instead. Equinox reads this variable once, at import.
    if "equinox" in sys.modules and "EQX_ON_ERROR" not in os.environ:
        warn(
            "Equinox was imported before enable_cache(), so that motions compiled now are not kept on disk. Call"
            " enable_cache() first, or set the environment variable EQX_ON_ERROR=nan."
        )
    os.environ.setdefault("EQX_ON_ERROR", "nan")
    jax.config.update("jax_compilation_cache_dir", str(path))
    # JAX looks for the folder only once, when it first compiles.
    reset_cache()
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    return path
