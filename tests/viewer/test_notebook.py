"""What notebooks show: tables with the numbers that matter, small pictures."""

import base64
import dataclasses
import html
import io
import re

import jax
import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
from cases.mechanisms import planar_guide
from PIL import Image

import flexmb as fm
from flexmb import RESULTS, planar


@pytest.fixture(scope="module")
def cart():
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("cart", (1, 0))
    b.add(planar.truss, "wall", "cart", name="<rod>", section=fm.Rigidity(EA=100.0))
    b.fix("wall")
    b.fix("cart", "y")
    b.mass("cart", 4.0)
    b.force("cart", (1.0, 0))
    b.start("cart", "x", 0.01)
    return b.build()


def spring(stiffness):
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("cart", (1, 0))
    b.add(planar.truss, "wall", "cart", section=fm.Rigidity(EA=stiffness))
    b.fix("wall")
    b.fix("cart", "y")
    b.mass("cart", 4.0)
    b.dof("cart", "x")
    return b.build()


def shown(result):
    """Rows of the table by name, and the picture."""
    text = result._repr_html_()
    assert "<script" not in text
    assert len(text) < 30_000
    cells = re.findall(r"<tr><th[^>]*>(.*?)</th><td[^>]*>(.*?)</td></tr>", text)
    (picture,) = re.findall(r'<img alt="\w+" src="data:image/png;base64,([^"]+)">', text)
    image = Image.open(io.BytesIO(base64.b64decode(picture)))
    # Something is drawn: many a pixel is not background.
    assert np.mean(np.asarray(image.convert("L")) < 200) > 0.002
    return {html.unescape(name): html.unescape(value) for name, value in cells}


@pytest.mark.slow
def test_model_linearization_and_modes(cart):
    rows = shown(cart)
    assert rows == {
        "elements": "1",
        "nodes": "2",
        "degrees of freedom": "1: cart.x",
        "NDOF = NX - NXO - NEO": "1 = 4 - 3 - 0",
    }
    rows = shown(fm.linearize(cart))
    assert rows["result"] == "successful"
    assert rows["largest displacement"] == "0.01 m"
    assert (rows["diagonal of M0"], rows["diagonal of K0 + N0 + G0"]) == ("4", "100")
    rows = shown(fm.modes(cart))
    assert rows == {"mode 1": f"{5 / (2 * np.pi):.5g} Hz, moves cart.x most", "stable": "yes"}


@pytest.mark.slow
def test_path_and_motion(cart):
    found = fm.path(cart)
    rows = shown(found)
    assert rows["steps"] == f"{len(found.load_factor)}, {len(found.load_factor)} of them stable"
    assert (rows["load factor"], rows["critical points"]) == ("up to 1", "none")
    motion = fm.simulate(cart, np.linspace(0, 1, 11))
    rows = shown(motion)
    assert rows["time"] == "0 to 1 s, 11 times"
    assert rows["steps"] == str(int(motion.steps))


@pytest.mark.slow
def test_sweep():
    found = fm.sweep(
        spring, {"f": lambda m: fm.frequencies(m)[0]}, fm.design.grid(stiffness=[100.0, 400.0]), units={"f": "Hz"}
    )
    assert shown(found) == {"designs": "2", "failed": "none", "f": "0.79577 to 1.5915 Hz"}
    # Nothing to draw where all designs failed.
    failed = dataclasses.replace(found, answers={"f": np.full(2, np.nan)}, codes=np.full(2, 2))
    text = failed._repr_html_()
    assert text is not None
    assert "<img" not in text
    assert f">2 {RESULTS(2).name}<" in text


def test_a_card_leaves_pictures_to_the_user(cart):
    # A backend that draws no window stays what it was, so that the next figure is shown where the user wants it.
    plt.close("all")
    before = matplotlib.get_backend()
    matplotlib.use("svg")
    try:
        assert cart._repr_html_() is not None
        assert matplotlib.get_backend() == "svg"
    finally:
        matplotlib.use(before)


@pytest.mark.slow
def test_buckling():
    found = fm.buckling(planar_guide(force=(0, -1.0)).build())
    assert shown(found)["mode 1"].startswith("load multiplier 78.75")


@pytest.mark.slow
def test_traced_and_stacked_results_keep_their_text(cart):
    seen = []

    @jax.jit
    def look(model):
        seen.append(model._repr_html_())
        return model.parameters.reference

    look(cart)
    assert seen == [None]
    many = jax.tree.map(lambda a: np.stack([a, a]), cart)
    assert many._repr_html_() is None
