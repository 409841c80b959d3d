"""A motion with forces and energies as a file."""

import os

import numpy as np

from .. import __version__
from ..display import kind_of
from ..files import save_arrays
from ..motion.motion import Motion
from ..results import RESULTS


def save_motion(motion: Motion, path: str | os.PathLike) -> None:
    """Save a motion with its times, coordinates, rates, deformations, stresses, reactions, energies, and their names.

    The file stores the arrays of :class:`flexmb.motion.Motion` and :class:`flexmb.motion.Observed` under their names;
    times are the first axis. "x_names" and "e_names" are the names of the columns, "u_names" of the columns of a
    controller's inputs. "about" is JSON with units, form, solver, steps and result. Times that the motion did not reach
    are left out.

    Args:
        motion: Motion.
        path: Path of the file; it ends in .npz or .mat.

    Raises:
        ValueError: The path has another ending.
        OSError: The folder is missing or not writable.
    """
    if not isinstance(motion, Motion):
        raise TypeError(f"fm.save_motion takes a Motion, of fm.simulate(..), not {kind_of(motion)}.")
    reached = np.all(np.isfinite(np.asarray(motion.x)), axis=1)
    if not reached.all():
        motion = motion.until(int(np.argmin(reached)))
    arrays = {name: np.asarray(getattr(motion, name)) for name in ("t", "x", "xd", "u")}
    if len(arrays["t"]):
        seen = motion.observe()
        arrays |= {name: np.asarray(getattr(seen, name)) for name in UNITS if name not in arrays}
    labels = motion.labels
    arrays["x_names"] = np.array([str(entry) for entry in labels.x])
    arrays["e_names"] = np.array([str(entry) for entry in labels.e])
    names = [signal.name for signal in labels.inputs]
    # Without a controller there is no column.
    arrays["u_names"] = np.array(names if arrays["u"].shape[1] else [], dtype=str)
    about = {
        "flexmb": __version__,
        "units": {name: unit for name, unit in UNITS.items() if name in arrays},
        "form": motion.form,
        "solver": motion.solver,
        "steps": int(motion.steps),
        "result": RESULTS(int(motion.result)).name,
    }
    save_arrays(path, arrays, about)


UNITS = {
    "t": "s",
    "x": "m, rad, -",
    "xd": "m/s, rad/s, 1/s",
    "u": "N, N m",
    "xdd": "m/s^2, rad/s^2, 1/s^2",
    "e": "m, rad",
    "ed": "m/s, rad/s",
    "sigma": "N, N m",
    "reactions": "N, N m",
    "kinetic": "J",
    "elastic": "J",
    "potential": "J",
    "power": "W",
}
