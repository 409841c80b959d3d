"""Fits to measured structures: ``python benchmarks/measured_fits.py [NAME ..]`` prints and stores them.

Each NAME is the beginning of the name of a fit, such as "strip" or "wing with skin, all".

Modulus and offset of the rotating strip, a fit for each sweep. Places of the masses of the Pazy wing and its root
compliance from its readings; the wing's own weight acts, and displacement is read at mid-chord. See REFERENCES.md
V1-strip and V3-wing.
"""

import json
import sys
import time
import warnings
from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
import measured_structures as structures
import numpy as np
from record import RESULTS, save
from scipy.optimize import least_squares
from scipy.stats import norm

import flexmb as fm

DRAWN = {"modulus": 73.08e9, "thickness": 0.063, "length": 37.5}
# Deviations of the readings of the wing [mm, deg], and of the frequencies of its vibration test.
OF_DISPLACEMENT, OF_TWIST, OF_FREQUENCY = 1.0, np.degrees(1 / 95) / 2, 0.01
SPAN = 1e3 * structures.SPAN
# Start, lower and upper value. "outboard": how far beyond the tip the masses hang; those at mid-chord may hang
# elsewhere. "clamp": compliance of the root. "zero": error of the reading without mass.
PARAMETERS = {
    "lever [m]": (0.11, 0.05, 0.2),
    "outboard [m]": (0.05, -0.05, 0.15),
    "outboard at mid-chord [m]": (0.03, -0.05, 0.15),
    "clamp [rad/(N m)]": (1e-3, 0.0, 2e-2),
    "zero [mm]": (0.0, -20.0, 20.0),
    "zero at mid-chord [mm]": (0.0, -20.0, 20.0),
}
LEVER, OUTBOARD, MIDDLE_OUTBOARD, CLAMP, ZERO, MIDDLE_ZERO = PARAMETERS
# Kind of wing, fitted parameters, and whether readings at mid-chord are among the data.
WINGS = {
    "without skin": ("without skin", (LEVER, OUTBOARD, ZERO, MIDDLE_ZERO), True),
    "without skin, clamp": ("without skin", (LEVER, CLAMP, ZERO, MIDDLE_ZERO), True),
    "with skin, behind the edge": ("with skin", (LEVER, OUTBOARD), False),
    "with skin, behind the edge, clamp": ("with skin", (LEVER, CLAMP), False),
    "with skin, all": ("with skin", tuple(PARAMETERS), True),
}


def strip(sweep: int) -> dict[str, Any]:
    """Modulus [Pa] and offset [inches] of the strip from nine frequencies, with 95 % intervals, by differences.

    "thickness" and "length" [inches]: values that give the same frequencies with the modulus of the drawing. Bending
    depends on E t^2, frequencies on E/L^4 and the ratio of offset and length.
    """
    measured = np.array(structures.FLAPPING[sweep])
    deviation = 0.01 * measured + 0.05

    def computed(logarithms: np.ndarray) -> np.ndarray:
        modulus, offset = np.exp(logarithms)
        model = structures.strip(sweep, modulus, offset * structures.INCH)
        return np.array([structures.out_of_plane(model, rpm)[:3] for rpm in structures.RPM])

    def differences(logarithms: np.ndarray) -> np.ndarray:
        return ((computed(logarithms) - measured) / deviation).ravel()

    found = least_squares(differences, np.log([80e9, 5.0]), diff_step=1e-3, xtol=1e-4, ftol=1e-4, gtol=1e-4)
    width = norm.ppf(0.975) * np.sqrt(np.diag(np.linalg.inv(found.jac.T @ found.jac)))
    modulus, offset = np.exp(found.x[:, None] + width[:, None] * [0, -1, 1])
    shares = modulus / DRAWN["modulus"]
    return {
        "modulus [Pa]": modulus.tolist(),
        "offset [inches]": offset.tolist(),
        "thickness [inches]": (DRAWN["thickness"] * shares**0.5).tolist(),
        "length [inches]": (DRAWN["length"] * shares[[0, 2, 1]] ** -0.25).tolist(),
        "chi-squared": float(np.sum(found.fun**2)),
        "freedom": found.fun.size - found.x.size,
        "computed less measured [%]": (100 * (computed(found.x) / measured - 1)).tolist(),
    }


def readings(kind: str) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...]]:
    """Masses [kg] and displacement [mm] at mid-chord; masses, displacement and twist [deg] behind the edge."""
    if kind == "without skin":
        masses, edge = structures.READ_MASSES, (structures.READ_TORSION, structures.READ_TWIST)
        return (masses, structures.READ_BENDING), (masses, *edge)
    middle, edge = (np.array(structures.WING[kind][key]).T for key in ("at_mid_chord", "behind_trailing_edge"))
    return (middle[0], SPAN * middle[1] / 100), (edge[0], SPAN * edge[1] / 100, edge[2])


def wing(kind: str, free: Sequence[str], middle: bool) -> dict[str, Any]:
    """Fitted parameters of a wing, with 95 % intervals by the misfit, and what remains between the values."""
    (masses, bent), (masses_behind, moved, twisted) = readings(kind)
    measured = structures.WING["frequencies_measured"]
    hertz = np.array([*measured["out of plane"], *measured["torsion"]])
    vibrates = kind == "with skin" and CLAMP in free and middle

    def answers(place: Any) -> dict[str, Any]:
        own = dict.fromkeys(PARAMETERS, 0.0) | dict(zip(free, place, strict=True))
        at = {"clamp": own[CLAMP], "weight": True}
        behind = structures.wing_loaded(kind, own[LEVER], masses_behind, outboard=own[OUTBOARD], **at)
        found = {
            "behind the edge [mm]": SPAN * behind["at mid-chord"] / 100 - own[ZERO],
            "twist [deg]": behind["twist"],
        }
        if middle:
            outboard = own[MIDDLE_OUTBOARD if MIDDLE_OUTBOARD in free else OUTBOARD]
            values = structures.wing_loaded(kind, structures.MID_CHORD, masses, outboard=outboard, **at)
            found["at mid-chord [mm]"] = SPAN * values["at mid-chord"] / 100 - own[MIDDLE_ZERO]
        if vibrates:
            # Torsion is the third frequency.
            order = np.array([0, 1, 3, 2])
            found["frequencies [Hz]"] = fm.frequencies(structures.wing(kind, own[CLAMP]).build(), count=4)[order]
        return found

    values = {
        "behind the edge [mm]": moved,
        "twist [deg]": twisted,
        "at mid-chord [mm]": bent,
        "frequencies [Hz]": hertz,
    }
    deviations = dict(zip(values, (OF_DISPLACEMENT, OF_TWIST, OF_DISPLACEMENT, OF_FREQUENCY * hertz), strict=True))
    names = [
        name for name in values if (name != "at mid-chord [mm]" or middle) and (name != "frequencies [Hz]" or vibrates)
    ]

    def in_deviations(model: fm.Model, place: Any) -> Any:
        found = answers(place)
        return jnp.concatenate([found[name] / deviations[name] for name in names])

    scaled = np.concatenate([values[name] / deviations[name] for name in names])
    data = fm.measured(in_deviations, scaled, name="readings")
    start, lower, upper = np.array([PARAMETERS[name] for name in free]).T
    model = structures.wing(kind).build()
    found = fm.fit(lambda place: model, data, {"place": start}, {"place": (lower, upper)}, scales={"place": "linear"})
    fitted = {
        name: [float(value), *found.interval(f"place[{i}]")]
        for i, (name, value) in enumerate(zip(free, found.parameters["place"], strict=True))
    }
    computed = answers(jnp.asarray(found.parameters["place"]))
    differences = {name: (np.asarray(computed[name]) - values[name]).tolist() for name in names}
    shares = {
        name.replace("mm", "%").replace("Hz", "%"): (100 * (np.asarray(computed[name]) / values[name] - 1)).tolist()
        for name in names
        if name != "twist [deg]"
    }
    first = float(fm.frequencies(structures.wing(kind, fitted.get(CLAMP, [0.0])[0]).build(), count=1)[0])
    return {
        "fitted": fitted,
        "misfit": found.noise,
        "first frequency [Hz]": first,
        "less": differences | shares,
    }


def main() -> None:
    """Print the fits and keep them; with names of structures only theirs."""
    fm.enable_x64()
    fm.enable_cache(thorough=False)
    warnings.simplefilter("ignore", fm.FlexmbWarning)
    begins = tuple(sys.argv[1:]) or ("strip", "wing")
    path = RESULTS / "measured_fits.json"
    kept = json.loads(path.read_text()) if path.exists() else {}
    work = {f"strip, sweep {sweep}": lambda sweep=sweep: strip(sweep) for sweep in structures.FLAPPING}
    work |= {f"wing {name}": lambda case=case: wing(*case) for name, case in WINGS.items()}
    for name, fit in work.items():
        if not name.startswith(begins):
            continue
        begin = time.process_time()
        kept[name] = fit() | {"seconds of the processor": round(time.process_time() - begin)}
        print(name, json.dumps(kept[name]), flush=True)
        save("measured_fits", {key: value for key, value in kept.items() if key != "about"})


if __name__ == "__main__":
    main()
