"""Formulas read off a trace: they say what Python computes, to the last bit."""

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexmb.workbench.formulas import formulas, number_text

NUMBERS = {"t": 0.5e-3, "w": 0.018, "n": 3.25}


def texts(function) -> list:
    said = np.vectorize(lambda one: one.text, otypes=[object])
    return [said(found).tolist() for found in formulas(function, NUMBERS)[0]]


@pytest.mark.parametrize(
    ("function", "text"),
    [
        (lambda t, w, n: 210e9 * w * t**3 / 12, "210e9*w*t**3/12"),
        (lambda t, w, n: w - (t - n), "w-(t-n)"),
        (lambda t, w, n: w / (t * n), "w/(t*n)"),
        (lambda t, w, n: -(t**2), "-t**2"),
        (lambda t, w, n: (-t) ** 2, "(-t)**2"),
        (lambda t, w, n: t**-1, "t**(-1)"),
        (lambda t, w, n: (t + w) * -2.0, "(t+w)*-2"),
        (lambda t, w, n: 0.0 + 1.0 * w, "w"),
        (lambda t, w, n: np.pi * t**2 / 4, "pi*t**2/4"),
        (lambda t, w, n: jnp.sqrt(n), "n**0.5"),
        (lambda t, w, n: jnp.stack([t, 0.0, w])[::-1][2], "t"),
        (lambda t, w, n: jnp.sin(t), None),
        (lambda t, w, n: 2 * jnp.sin(t), None),
    ],
)
def test_formula(function, text):
    assert texts(lambda own: [function(**own)]) == [text]
    if text is not None:
        own = {name: np.float64(value) for name, value in NUMBERS.items()} | {"pi": np.pi}
        # Python has the same rules of precedence.
        np.testing.assert_allclose(eval(text, {}, own), float(function(**NUMBERS)), rtol=1e-15)


def test_arrays_and_constants():
    found = texts(lambda own: [jnp.array([own["t"], 2.0]), 7.5, own["w"] * np.ones(2)])
    assert found == [["t", "2"], "7.5", ["w", "w"]]


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_texts_of_numbers_read_back(value):
    assert float({"pi": np.pi}.get(number_text(value), number_text(value))) == value


@pytest.mark.slow
def test_texts_of_numbers_are_short():
    assert list(map(number_text, (210e9, 0.5e-3, 7850.0, 80.77e9, -3e-12, 1000.0))) == [
        "210e9",
        "0.0005",
        "7850",
        "80.77e9",
        "-3e-12",
        "1000",
    ]
