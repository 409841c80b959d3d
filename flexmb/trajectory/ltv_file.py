"""Files of linear time-varying systems, under the names of SPACAR's ltv files."""

import os
from typing import Any

import numpy as np

from .. import __version__
from ..files import save_arrays

DESCRIPTIONS = {
    "NNOM": "number of nominal inputs, columns of U0",
    "NX": "number of states",
    "NU": "number of inputs",
    "NY": "number of outputs",
    "DFT": "1 where D is not zero at some time",
    "X0": "states of the motion itself at the first time: degrees of freedom or amplitudes, then their rates",
    "T": "times [s]; A to Y0 have a row for each, matrices in it column by column",
    "A": "NX by NX",
    "B": "NX by NU",
    "C": "NY by NX",
    "D": "NY by NU",
    "M0": "mass of the first half of the states",
    "C0B": "C0 + D0 of them",
    "K0B": "K0 + N0 + G0 of them",
    "SIG0": "stress resultants along the motion [N, N m]",
    "U0": "inputs along it",
    "Y0": "outputs along it",
}
LEFT_OUT = (
    "G, NYS and NRBM are missing: the outputs are not expanded to second order, and the two numbers are not documented."
)


def save_time_varying(system: Any, path: str | os.PathLike) -> None:
    """Save a linear time-varying system as .npz or .mat under SPACAR's names.

    The file also contains the names "states", "inputs" and "outputs", and "about": JSON that describes each array and
    what is left out (the second-order output tensor G, NYS and NRBM).

    Raises:
        ValueError: Another ending.
        OSError: The folder is missing or not writable.
    """
    about = {"flexmb": __version__, "arrays": DESCRIPTIONS, "left out": LEFT_OUT}
    save_arrays(path, arrays_of(system), about)


def arrays_of(system: Any) -> dict[str, np.ndarray]:
    """Arrays of the file by name."""
    n = system.M.shape[1]
    a, b, c, d, mass = (np.asarray(getattr(system, name)) for name in "ABCDM")
    rows = {
        "A": a,
        "B": b,
        "C": c,
        "D": d,
        "M0": mass,
        "C0B": -mass @ a[:, n : 2 * n, n : 2 * n],
        "K0B": -mass @ a[:, n : 2 * n, :n],
        "SIG0": np.asarray(system.sigma),
        "U0": np.asarray(system.u0),
        "Y0": np.asarray(system.y0),
    }
    numbers = {"NNOM": system.u0.shape[1], "NX": a.shape[1], "NU": b.shape[2], "NY": c.shape[1], "DFT": int(np.any(d))}
    return {
        **{name: np.asarray(number) for name, number in numbers.items()},
        "X0": np.asarray(system.z0),
        "T": np.asarray(system.t),
        # Column by column: the last axis varies slowest.
        **{name: np.swapaxes(row, 1, -1).reshape(len(row), -1) for name, row in rows.items()},
        **{f"{name}s": np.array(getattr(system, f"{name}_labels"), dtype=str) for name in ("state", "input", "output")},
    }
