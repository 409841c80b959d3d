"""Places of the masses of the Pazy wing, or its root compliance, from static readings: ``python benchmarks/wing.py``.

Least squares by differences, with the wing's own weight and readings at mid-chord. See REFERENCES.md V3-wing. It takes
about five minutes on two cores.
"""

import warnings

import measured_structures as structures
import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t

import flexmb as fm

# Steps of the reading [mm, deg] weigh displacement and twist.
WEIGHTS = 1.0, np.degrees(1 / 95) / 2
# Units of the parameters: the search sees numbers near one.
UNITS = {"lever": 0.01, "outboard": 0.01, "clamp": 1e-3}
NAMES = {"lever": "lever [cm]", "outboard": "masses beyond the tip [cm]", "clamp": "root compliance [1e-3 rad/(N m)]"}


def differences(kind: str, other: str, parameters: np.ndarray) -> np.ndarray:
    """Computed minus read values in steps of the reading, with fitted errors of the zero readings without skin."""
    lever, place = UNITS["lever"] * parameters[0], {other: UNITS[other] * parameters[1], "weight": True}
    bare = kind == "without skin"
    if bare:
        masses, moved, twist = structures.READ_MASSES, structures.READ_TORSION, structures.READ_TWIST
    else:
        masses, percent, twist = np.array(structures.WING[kind]["behind_trailing_edge"]).T
        moved = 10 * structures.SPAN * percent
    behind = structures.wing_loaded(kind, lever, masses, **place)
    rows = [(10 * structures.SPAN * behind["at mid-chord"] - moved - (parameters[2] if bare else 0.0)) / WEIGHTS[0]]
    rows.append((behind["twist"] - twist) / WEIGHTS[1])
    if bare:
        middle = structures.wing_loaded(kind, structures.MID_CHORD, masses, **place)
        rows.append(
            (10 * structures.SPAN * middle["at mid-chord"] - structures.READ_BENDING - parameters[3]) / WEIGHTS[0]
        )
    return np.concatenate(rows)


def main() -> None:
    """Print fitted numbers with 95 % intervals; the scatter follows from the misfit."""
    fm.enable_x64()
    fm.enable_cache(thorough=False)
    warnings.simplefilter("ignore", fm.FlexmbWarning)
    for other in ("outboard", "clamp"):
        for kind, start in (("without skin", [9.8, 5.0, 2.0, 4.0]), ("with skin", [12.4, 5.0])):
            found = least_squares(
                lambda x, kind=kind, other=other: differences(kind, other, x),
                start,
                diff_step=0.05,
                xtol=1e-3,
                ftol=1e-3,
            )
            free = len(found.fun) - len(start)
            spread = np.sqrt(np.diag(np.linalg.inv(found.jac.T @ found.jac)) * np.sum(found.fun**2) / free)
            names = NAMES["lever"], NAMES[other], "zero reading behind the edge [mm]", "zero reading at mid-chord [mm]"
            for name, value, width in zip(names, found.x, t.ppf(0.975, free) * spread, strict=False):
                print(f"{kind}: {name} {value:.2f} ± {width:.2f}", flush=True)
            misfit = np.sqrt(np.mean(found.fun**2))
            print(f"{kind}: root mean square of the differences {misfit:.2f} steps of the reading", flush=True)


if __name__ == "__main__":
    main()
