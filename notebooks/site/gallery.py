"""The gallery of the site: every building block and every notebook as a picture, and three mechanisms in the viewer."""

import warnings
from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("agg")

import flexmb as fm
from flexmb import blocks

STEEL = fm.Material(E=210e9, G=80e9, rho=7850)
LEAF = fm.Rectangle(18e-3, 0.5e-3, STEEL)
GUIDE = {"length": 0.1, "section": LEAF, "spacing": 0.08}
NOTCH = {"width": 10e-3, "height": 6e-3, "neck": 0.5e-3, "radius": 3e-3, "material": STEEL}
SLIDE, TURN = {"x": 0.01}, {"rotation": np.radians(10)}
# Sizes of each block, and the motion of its stage in the picture.
SHOWN = {
    "parallel_guide": (GUIDE, SLIDE),
    "double_parallel_guide": ({**GUIDE, "inner": 0.04}, SLIDE),
    "straight_line_stage": ({**GUIDE, "inner": 0.04, "height": 0.03}, SLIDE),
    "xy_stage": ({**GUIDE, "inner": 0.04}, {"x": 0.01, "y": 0.01}),
    "cross_pivot": ({"length": 0.1, "section": LEAF}, TURN),
    "butterfly_pivot": ({"length": 0.1, "section": LEAF, "radius": 0.02}, TURN),
    "cartwheel": ({"length": 0.1, "section": LEAF}, TURN),
    "folded_leaf_spring": ({"length": 0.1, "section": LEAF}, SLIDE),
    "wire_flexure": ({"length": 0.1, "section": fm.Circle(1e-3, STEEL)}, SLIDE),
    "notch_hinge": (NOTCH, {"rotation": np.radians(5)}),
    "notch_four_bar": ({"length": 0.05, "spacing": 0.04, **NOTCH}, {"x": 0.004}),
}
IN_VIEWER = ("parallel_guide", "cross_pivot", "cartwheel")


def pushed(name: str) -> fm.Model:
    """A block on the ground, with its stage moved the way that it is free to go."""
    sizes, motion = SHOWN[name]
    b = fm.Builder()
    b.node("ground", (0, 0))
    getattr(blocks, name)(b, "ground", "stage", **sizes)
    b.fix("ground")
    for component, value in motion.items():
        b.prescribe("stage", component, value)
    return b.build()


def write_gallery(titles: dict[str, str], pages: Path) -> None:
    """Write ``gallery.md`` and its pictures.

    Args:
        titles: Title of each notebook, by the name of its file.
        pages: Folder of the site's pages; the pictures of the notebooks are there.

    Raises:
        LookupError: A building block has no entry in this file.
    """
    import matplotlib.pyplot as plt

    if missing := set(fm.lazy.offered("flexmb.blocks")) ^ set(SHOWN):
        raise LookupError(f"The gallery and flexmb.blocks differ in: {', '.join(sorted(missing))}.")
    fm.enable_x64()
    folder = pages / "gallery"
    folder.mkdir()
    lines = ["# Gallery", "", "A picture links to its code.", "", "## Building blocks", "", '<div class="gallery">']
    for name in SHOWN:
        with warnings.catch_warnings():
            # A notch hinge in the plane is a plain beam; the picture needs no more.
            warnings.simplefilter("ignore", fm.BeamTheoryWarning)
            model = pushed(name)
            state = fm.equilibrium(model)
        ax = fm.plot.mechanism(model, at=state, dofs=False, loads=False)
        ax.set_axis_off()
        ax.figure.savefig(folder / f"{name}.png", dpi=110, bbox_inches="tight")
        plt.close(ax.figure)
        label = name.replace("_", " ")
        link = f"api/fm_blocks.html#flexmb.blocks.{block_module(name)}.{name}"
        lines.append(f'<a href="{link}"><img src="gallery/{name}.png" alt="{label}">{label}</a>')
        if name in IN_VIEWER:
            fm.view(model, at=state).save(folder / f"{name}.html")
    lines += ["</div>", "", "## Mechanisms to turn", ""]
    for name in IN_VIEWER:
        lines += [f"### {name.replace('_', ' ').capitalize()}", "", f'<iframe src="gallery/{name}.html"></iframe>', ""]
    lines += ["## Notebooks", "", '<div class="gallery">']
    for stem, title in titles.items():
        pictures = sorted((pages / "notebooks").glob(f"{stem}_*.png"))
        if pictures:
            shown = f'<img src="notebooks/{pictures[0].name}" alt="{title}">'
            lines.append(f'<a href="notebooks/{stem}.html">{shown}{title}</a>')
    lines += ["</div>", ""]
    (pages / "gallery.md").write_text("\n".join(lines), encoding="utf-8")


def block_module(name: str) -> str:
    """Name of the file that holds a block."""
    return getattr(blocks, name).__module__.rpartition(".")[2]
