"""Measured structures beside what flexmb computes: ``python benchmarks/measured.py`` prints, keeps and draws both.

A rotating strip with a swept tip, two composite cantilevers under weights, and the Pazy wing: frequencies, displacement
and twist. Sections and clamps are those of the sources; only two levers of the wing are chosen by its twist. See
REFERENCES.md V1 to V3.
"""

import warnings
from typing import Any

import jax.numpy as jnp
import measured_structures as structures
import numpy as np
from record import RESULTS, save

import flexmb as fm
from flexmb import planar

# Beam 1 of Minguet and Dugundji: weights [N], displacement [m].
FIRST_WEIGHTS = structures.GRAVITY * 1e-3 * np.array([20.0, 50, 75, 100, 150, 200, 400])
FIRST_DISPLACEMENTS = np.array([0.014125, 0.035861, 0.053245, 0.069113, 0.10143, 0.13090, 0.21790])


def first_beam() -> np.ndarray:
    """Displacement of composite beam 1 under its weights [m]."""
    b = fm.Builder()
    for name, place in {"root": 0.0, "reading": 0.5, "tip": 0.55}.items():
        b.node(name, (place, 0))
    section = fm.Rigidity(EA=3.7e6, EIy=0.707)
    b.add(planar.spectral_beam(6), "root", "reading", name="inner", section=section)
    b.add(planar.spectral_beam(3), "reading", "tip", name="outer", section=section)
    b.fix("root")
    b.force("tip", (0, -1.0), increment=True)
    return -np.asarray(fm.equilibria(b.build(), increment=jnp.asarray(FIRST_WEIGHTS)).position("reading", "y"))


def pairs() -> dict[str, dict[str, Any]]:
    """Measured and computed values of each structure, with their unit."""
    found: dict[str, dict[str, Any]] = {}

    def add(name: str, unit: str, measured: Any, computed: Any) -> None:
        found[name] = {"unit": unit, "measured": np.ravel(measured).tolist(), "computed": np.ravel(computed).tolist()}

    for sweep, flapping in structures.FLAPPING.items():
        model = structures.strip(sweep)
        computed = np.array([structures.out_of_plane(model, rpm)[:6] for rpm in structures.RPM])
        add(f"strip, sweep {sweep}", "Hz", [*flapping, structures.COUPLED[sweep]], [*computed[:, :3], computed[2, 3:]])
    add("composite 1", "m", FIRST_DISPLACEMENTS, first_beam())
    add("composite 3", "m", structures.DISPLACEMENTS, structures.sunk(structures.composite()))
    measured = structures.WING["frequencies_measured"]
    hertz = np.asarray(fm.frequencies(structures.wing("with skin").build(), count=4))
    add("wing, frequencies", "Hz", [*measured["out of plane"], *measured["torsion"]], hertz[[0, 1, 3, 2]])
    for kind, lever in structures.LEVERS.items():
        mass, displacement = np.array(structures.WING[kind]["at_mid_chord"]).T
        own = structures.wing_loaded(kind, structures.MID_CHORD, mass)
        add(f"wing {kind}, mid-chord", "% of span", displacement, own["at the mass"])
        mass, displacement, twist = np.array(structures.WING[kind]["behind_trailing_edge"]).T
        own = structures.wing_loaded(kind, lever, mass)
        add(f"wing {kind}, behind its edge", "% of span", displacement, own["at the mass"])
        add(f"wing {kind}, twist", "deg", twist, own["twist"])
    return found


def draw(found: dict[str, dict[str, Any]]) -> None:
    """Chart of computed over measured, a colour for each structure."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.8, 4.2), layout="constrained")
    groups = {"strip": "rotating strip", "composite": "composite cantilevers", "wing": "Pazy wing"}
    kinds = {
        "Hz": ("o", "frequency"),
        "m": ("s", "displacement"),
        "% of span": ("s", "displacement"),
        "deg": ("^", "twist"),
    }
    seen = set()
    for name, own in found.items():
        group = next(key for key in groups if name.startswith(key))
        marker, what = kinds[own["unit"]]
        measured, computed = np.array(own["measured"]), np.array(own["computed"])
        label = f"{groups[group]}, {what}"
        style = {"color": f"C{list(groups).index(group)}", "label": None if label in seen else label}
        # All on one axis: frequencies in Hz, displacements in mm and in % of the span, twist in degrees.
        size = 1e3 if own["unit"] == "m" else 1.0
        axes.loglog(size * measured, 100 * computed / measured, marker, markersize=5, **style)
        seen.add(label)
    axes.set_yscale("linear")
    axes.axhline(100.0, color="0.4", linewidth=0.8)
    axes.set(xlabel="measured [Hz, mm, % of span, deg]", ylabel="computed / measured [%]", ylim=(70, 130))
    axes.legend(fontsize=8)
    figure.savefig(RESULTS / "measured.png", dpi=120)


def main() -> None:
    """Print, keep and draw."""
    fm.enable_x64()
    fm.enable_cache(thorough=False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fm.FlexmbWarning)
        found = pairs()
    for name, own in found.items():
        differences = 100 * (np.array(own["computed"]) / own["measured"] - 1)
        print(f"{name:32} computed less measured {differences.min():+.1f} to {differences.max():+.1f} %")
    save("measured", found)
    draw(found)


if __name__ == "__main__":
    main()
