"""Global settings of JAX that a user switches on by one call; importing flexmb changes none."""

import os
import sys
from pathlib import Path


def enable_x64() -> None:
    """Switch JAX to double precision, for the whole process."""
    import jax

    jax.config.update("jax_enable_x64", True)


def cache_folder() -> Path:
    """Default folder of compiled code: ``$FLEXMB_CACHE``, or flexmb in the user's cache folder."""
    given = os.environ.get("FLEXMB_CACHE")
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(given) if given else Path(base) / "flexmb"


def enable_cache(folder: str | os.PathLike | None = None, *, thorough: bool = True) -> Path:
    """Keep compiled code on disk, so that a fresh process starts quickly.

    What equinox and diffrax check while they run then answers NaN instead of raising, in the whole process, unless the
    environment variable ``EQX_ON_ERROR`` says otherwise: code that raises cannot be kept.

    Args:
        folder: Where; by default :func:`cache_folder`.
        thorough: Compile for half the run time in twice the compile time, as code that is kept deserves.

    Returns:
        The folder.
    """
    import jax

    from .math.compile import compile_thoroughly
    from .math.kept import keep_traces

    compile_thoroughly(thorough)
    # What checks for errors by calling back into Python is never kept on disk, and diffrax does; its answers are
    # checked for finiteness here. Equinox reads this once, when it is imported, which may have been before.
    on_error = os.environ.setdefault("EQX_ON_ERROR", "nan")
    if "equinox._errors" in sys.modules:
        vars(sys.modules["equinox._errors"])["EQX_ON_ERROR"] = on_error
    path = Path(folder) if folder is not None else cache_folder()
    path.mkdir(parents=True, exist_ok=True)
    keep_traces(path / "traces" if thorough else None)
    jax.config.update("jax_compilation_cache_dir", str(path))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    return path
