"""Draws the picture at README's top: python notebooks/pictures/readme.py.

Left: a stage on two leaf springs at a stroke of a fifth of their length, one spectral beam each, with its stress.
Right: Lee's frame, which snaps through under a load on its beam, with its equilibrium path.
"""

import sys
from pathlib import Path

import flexmb as fm
from flexmb import planar, plot, spatial


def guide() -> fm.Model:
    """Two upright leaf springs of 100 x 18 x 0.5 mm, driven by 20 mm."""
    leaf = fm.Rectangle(width=0.018, thickness=0.5e-3, material=fm.Material(E=210e9, G=80e9, rho=7850))
    b = fm.Builder()
    for name, place in {"A": (0, 0, 0), "B": (0, 0, 0.1), "C": (0, 0.1, 0.1), "D": (0, 0.1, 0)}.items():
        b.node(name, place)
    b.add(spatial.spectral_beam(4), "A", "B", name="left", section=leaf, y=(1, 0, 0))
    b.add(spatial.spectral_beam(4), "D", "C", name="right", section=leaf, y=(1, 0, 0))
    b.add(spatial.beam, "B", "C", name="stage")
    b.fix("A")
    b.fix("D")
    b.mass("C", 0.2)
    b.prescribe("B", "y", 0.02)
    return b.build()


def frame() -> fm.Model:
    """Lee's frame: a column and a beam of length 120, EI = 1440, EA = 4320, loaded at a fifth of the beam."""
    section = fm.Rigidity(EA=4320.0, EIy=1440.0)
    b = fm.Builder()
    for name, place in {"foot": (0, 0), "corner": (0, 120), "load": (24, 120), "end": (120, 120)}.items():
        b.node(name, place)
    for p, q in (("foot", "corner"), ("corner", "load"), ("load", "end")):
        b.add(planar.spectral_beam(6), p, q, section=section)
    b.fix("foot", "x", "y")
    b.fix("end", "x", "y")
    b.mass("load", 1.0)
    b.force("load", (0, -3.0))
    return b.build()


def main(target: Path) -> None:
    """Draw both.

    Args:
        target: File to write.
    """
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    fm.enable_x64()
    fm.enable_cache()
    figure = plt.figure(figsize=(12, 4.2), layout="constrained")
    moved = fm.linearize(guide())
    ax = plot.stress(
        fm.stress(moved.model, points=25, at=moved), moved, ax=figure.add_subplot(1, 3, 1, projection="3d")
    )
    ax.set_title("leaf springs at a stroke of 20 mm")
    found = fm.path(frame(), step=0.05)
    ax = plot.path(found, "load.y", ax=figure.add_subplot(1, 3, 2))
    ax.set_title("Lee's frame snaps through")
    ax = plot.mechanism(found, ax=figure.add_subplot(1, 3, 3), names=False)
    ax.set_title("and ends here")
    figure.savefig(target, dpi=90)
    print(target, target.stat().st_size, "bytes")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_suffix(".png"))
