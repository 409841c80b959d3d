"""What a notebook shows of a result: a small table of the numbers that matter, and a small picture."""

import base64
import html
import io
from collections.abc import Callable
from typing import Any

import jax
import jax.core
import numpy as np

from .. import plot
from ..design.sweep import Sweep
from ..linear.buckling import Buckling
from ..linear.linearize import Linearization
from ..linear.modes import Modes
from ..model.model import Model
from ..motion.motion import Motion
from ..paths.path import Path
from ..results import RESULTS

Rows = dict[str, str]
# Rows of one kind, such as frequencies.
AT_MOST = 6
DOTS_PER_INCH = 60
COLOURS = 32


def card(shown: Any) -> str | None:
    """A result as a table beside a picture, as HTML.

    Args:
        shown: Model, Linearization, Modes, Buckling, Path, Motion or Sweep.

    Returns:
        HTML without a script; None where the result is traced or holds several at once, so that its text is shown.
    """
    vector, tell = _TELL[type(shown)]
    if any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves(shown)) or np.ndim(vector(shown)) != 1:
        return None
    rows, draw = tell(shown)
    cells = "".join(
        f'<tr><th style="text-align: left">{html.escape(name)}</th>'
        f'<td style="text-align: left">{html.escape(text)}</td></tr>'
        for name, text in rows.items()
    )
    name = type(shown).__name__
    image = "" if draw is None else f'<img alt="{name}" src="data:image/png;base64,{_picture(draw)}">'
    return (
        '<div style="display: flex; flex-wrap: wrap; gap: 1em; align-items: center">'
        f"<table><caption>{name}</caption>{cells}</table>{image}</div>"
    )


def _picture(draw: Callable[[], Any]) -> str:
    """A figure as PNG in base64."""
    import matplotlib

    with matplotlib.rc_context({"backend": "agg", "font.size": 9}):
        import matplotlib.pyplot as plt

        figure = draw()
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=DOTS_PER_INCH)
        plt.close(figure)
    return base64.b64encode(_small(buffer)).decode()


def _small(picture: io.BytesIO) -> bytes:
    """A PNG with a palette: a notebook keeps every picture that it shows."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.open(picture).convert("RGB").quantize(COLOURS).save(buffer, format="png", optimize=True)
    return buffer.getvalue()


def _number(value: Any) -> str:
    return f"{float(value):.5g}"


def _listed(values: Any, unit: str = "") -> str:
    found = [_number(value) for value in np.asarray(values).tolist()[:AT_MOST]]
    more = ", …" if len(np.asarray(values)) > AT_MOST else ""
    return f"{', '.join(found)}{more} {unit}".strip() if found else "none"


def _of_model(model: Model) -> tuple[Rows, Callable[[], Any]]:
    names = [str(entry) for entry in model.q_labels]
    positions = {entry.of for entry in model.labels.x if entry.kind == "position"}
    rows = {
        "elements": str(len(model.labels.elements)),
        "nodes": str(len(positions)),
        "degrees of freedom": f"{len(names)}: {', '.join(names[:AT_MOST])}{', …' if len(names) > AT_MOST else ''}",
        "NDOF = NX - NXO - NEO": "{ndof} = {nx} - {nxo} - {neo}".format(**model.counts()),
    }
    return rows, lambda: plot.mechanism(model).figure


def _of_linearization(lin: Linearization) -> tuple[Rows, Callable[[], Any]]:
    moved = np.asarray(lin.matrices.x - lin.model.parameters.reference)
    positions = np.array([entry.kind == "position" for entry in lin.labels.x])
    rows = {
        "result": RESULTS(int(lin.matrices.result)).name,
        "degrees of freedom": str(lin.matrices.M0.shape[0]),
        "largest displacement": f"{_number(np.max(np.abs(moved[positions]), initial=0.0))} m",
        "diagonal of M0": _listed(np.diag(np.asarray(lin.matrices.M0))),
        "diagonal of K0 + N0 + G0": _listed(np.diag(np.asarray(lin.matrices.K))),
    }
    return rows, lambda: plot.mechanism(lin).figure


def _of_modes(found: Modes) -> tuple[Rows, Callable[[], Any]]:
    rows = {"frequencies": _listed(found.frequencies, "Hz"), "stable": "yes" if found.stable else "no"}
    if found.massless:
        rows["motions without mass"] = str(found.massless)
    return rows, _shapes(found, lambda: plot.mechanism(found.lin).figure)


def _of_buckling(found: Buckling) -> tuple[Rows, Callable[[], Any]]:
    return {"load multipliers": _listed(found.multipliers)}, _shapes(found, lambda: plot.mechanism(found.lin).figure)


def _shapes(found: Modes | Buckling, otherwise: Callable[[], Any]) -> Callable[[], Any]:
    """The first shapes, or what else is drawn where there is none."""
    count = min(found.shapes.shape[1], 3)
    return (lambda: plot.modes(found, range(count))) if count else otherwise


def _of_path(found: Path) -> tuple[Rows, Callable[[], Any]]:
    points = [f"{point.kind} at {point.load_factor:.5g}" for point in found.critical_points]
    stable = np.asarray(found.stable)
    rows = {
        "result": RESULTS(int(found.result)).name,
        "steps": f"{len(stable)}, {int(np.sum(stable))} of them stable",
        "load factor": f"up to {_number(np.max(np.asarray(found.load_factor)))}",
        "critical points": ", ".join(points[:AT_MOST]) or "none",
    }
    return rows, lambda: plot.path(found).figure


def _of_motion(found: Motion) -> tuple[Rows, Callable[[], Any]]:
    t = np.asarray(found.t)
    rows = {
        "result": RESULTS(int(found.result)).name,
        "time": f"{_number(t[0])} to {_number(t[-1])} s, {len(t)} times",
        "steps": str(int(found.steps)),
        "solver": f"{found.solver}, {found.form}",
    }
    return rows, lambda: plot.history(found).figure


def _of_sweep(found: Sweep) -> tuple[Rows, Callable[[], Any] | None]:
    failures = ", ".join(f"{count} {name}" for name, count in found.failures().items())
    rows = {"designs": str(len(found.codes)), "failed": failures or "none"}
    for name, values in found.answers.items():
        finite = values[np.isfinite(values)]
        unit = found.units.get(name, "")
        rows[name] = f"{_number(finite.min())} to {_number(finite.max())} {unit}".strip() if finite.size else "none"
    drawn = [n for n, values in found.answers.items() if values.ndim == 1 and np.any(np.isfinite(values))]
    varied = [n for n, values in found.designs.items() if np.ndim(values) == 1 and np.ptp(values) > 0]
    return rows, (lambda: plot.sweep(found, drawn[0], varied[:2]).figure) if drawn and varied else None


# What has one axis where a result is that of one mechanism, and what tells about it.
_TELL: dict[type, tuple[Callable[[Any], Any], Callable[[Any], tuple[Rows, Callable[[], Any] | None]]]] = {
    Model: (lambda model: model.parameters.reference, _of_model),
    Linearization: (lambda lin: lin.matrices.x, _of_linearization),
    Modes: (lambda found: found.eigenvalues, _of_modes),
    Buckling: (lambda found: found.multipliers, _of_buckling),
    Path: (lambda found: found.load_factor, _of_path),
    Motion: (lambda found: found.t, _of_motion),
    Sweep: (lambda found: found.codes, _of_sweep),
}
