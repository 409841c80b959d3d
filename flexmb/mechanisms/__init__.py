"""Mechanisms that ship with the package, as SPACAR input files."""

from importlib import resources
from pathlib import Path


def mechanisms() -> dict[str, str]:
    """Return the shipped mechanisms, with one line on each: the first comment of its file.

    Returns:
        Description by name.
    """
    found = sorted((f for f in resources.files(__name__).iterdir() if f.name.endswith(".dat")), key=lambda f: f.name)
    return {f.name[:-4]: f.read_text(encoding="utf-8").splitlines()[0].lstrip("% ") for f in found}


def mechanism_path(name: str) -> Path:
    """Return the file of a shipped mechanism.

    Args:
        name: Its name.

    Returns:
        Path of the .dat file.

    Raises:
        KeyError: No such mechanism.
    """
    known = mechanisms()
    if name not in known:
        raise KeyError(f"no mechanism '{name}'; there are {', '.join(known)}")
    return Path(str(resources.files(__name__) / f"{name}.dat"))
