"""The log says once what differs where a function is compiled for the third time."""

import logging

import jax.numpy as jnp
import numpy as np
import pytest

from flexmb.compilation import by_meaning, compile, recompiled


@pytest.fixture
def notices(caplog):
    caplog.set_level(logging.INFO, logger="flexmb")
    return lambda: [r.getMessage() for r in caplog.records if "third time" in r.getMessage()]


def asked(name):
    """A compiled function of this name, which no other test counts."""

    def total(design, power=1):
        return jnp.sum(design["thickness"] ** power) + jnp.sum(design["width"])

    total.__name__ = name
    recompiled._last.pop(compile.program_name(total), None)
    return total


def design(count, width=2):
    return {"thickness": np.ones(count), "width": np.ones(width)}


@pytest.mark.parametrize("room", [compile, by_meaning], ids=("structure", "meaning"))
def test_the_third_shape_is_told_once_by_name(room, notices):
    run = room.jit(asked(f"shapes_{room.__name__}"))
    for count in (3, 4):
        run(design(count))
    assert notices() == []
    for count in (5, 6, 5):
        run(design(count))
    (text,) = notices()
    assert "argument[0]['thickness'] float64[4] -> float64[5]" in text
    assert "width" not in text


@pytest.mark.parametrize("room", [compile, by_meaning], ids=("structure", "meaning"))
def test_another_option_is_named(room, notices):
    run = room.jit(asked(f"options_{room.__name__}"))
    # Code is shared by meaning: other tests have no arrays of this size.
    for power in (1, 2, 3):
        run(design(13), power=power)
    (text,) = notices()
    assert text.endswith("option power 2 -> 3")


def test_arguments_that_come_and_go_are_named(notices):
    run = compile.jit(asked("structure"))
    run(design(3))
    run({**design(3), "length": np.ones(1)})
    run({**design(3), "mass": np.ones(1)})
    (text,) = notices()
    assert "argument[0]['length'] is gone; argument[0]['mass'] float64[1]" in text


def test_other_numbers_compile_nothing(notices):
    run = compile.jit(asked("numbers"))
    for number in range(5):
        run({name: number * array for name, array in design(3).items()})
    assert notices() == []


def test_functions_within_another_are_not_counted(notices):
    inner = compile.jit(asked("inner"))
    outer = compile.jit(lambda design: 2 * inner(design))
    for count in (3, 4, 5):
        outer(design(count))
    assert len(notices()) == 1
    assert "inner" not in notices()[0]
