"""Sums and signs of texts have the value that numbers have, and numbers stay short."""

import pytest
from cases.tolerances import approx
from hypothesis import given
from hypothesis import strategies as st

from flexmb.spacar.arithmetic import arithmetic_result, is_number_text, names_in, renamed
from flexmb.workbench import values as sums

NAMES = {"a": 1.5, "b": -0.25, "e1": 3.0}
LEAVES = st.sampled_from(["0", "1", "2.5", "-3", "1e-3", ".5", "a", "b", "e1", "-a", " 4 ", "- 2"])
TEXTS = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.builds("({})".format, inner),
        st.builds("-({})".format, inner),
        st.builds("{} + {}".format, inner, inner),
        st.builds("{}*({})".format, inner, inner),
        st.builds("({}) - ({})".format, inner, inner),
        st.builds("({})**2".format, inner),
    ),
    max_leaves=5,
)


def value(text):
    return arithmetic_result(text, NAMES)


@given(TEXTS, TEXTS, TEXTS)
def test_texts_have_the_values_of_numbers(a, b, c):
    x, y, z = value(a), value(b), value(c)
    size = max(abs(x), abs(y), abs(z), 1.0) ** 3
    for found, expected in (
        (sums.plus(a, b), x + y),
        (sums.minus(a, b), x - y),
        (sums.text_product(a, b), x * y),
        (sums.negated(a), -x),
        (sums.negated(sums.negated(a)), x),
        (sums.reflected(a, b), 2 * y - x),
        (sums.text_between(a, b, c), x + z * (y - x)),
    ):
        assert value(found) == approx(expected, abs=1e-13 * size), (a, b, c, found)


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (sums.plus("0.1", "0.2"), "0.3"),
        (sums.plus("t", "0"), "t"),
        (sums.plus("t", "-2"), "t - 2"),
        (sums.minus("L", "t"), "L - t"),
        (sums.text_product("3", "d"), "3*d"),
        (sums.text_product("1", "L/2"), "L/2"),
        (sums.negated("-(a + b)"), "a + b"),
        (sums.negated("0"), "0"),
        (sums.negated("L"), "-L"),
        (sums.reflected("0.1", "0"), "-0.1"),
        (sums.reflected("x", "0"), "-x"),
        (sums.text_between("0", "0.1", "0.5"), "0.05"),
        (sums.text_between("0", "L", "0.5"), "0.5*L"),
        (sums.plus("1e-9", "1e-12"), "1.001e-9"),
        (sums.text_product("2", "50e9"), "1e11"),
    ],
)
def test_texts_are_as_one_would_write_them(found, expected):
    assert found == expected


def test_names_are_found_and_changed_where_they_are_names():
    assert names_in("2*t + 1e-3*te/(t2 - pi)") == ["t", "te", "t2", "pi"]
    assert renamed("2*t + 1e-3*te/(t2 - t)", "t", "e") == "2*e + 1e-3*te/(t2 - e)"
    assert renamed("t $ t", "t", "e") == "e $ t"
    assert [is_number_text(text) for text in ("1", " -1e-3 ", "+ .5", "1.", "1e", "t", "1+1", "", "nan")] == [
        *(True, True, True, True),
        *(False,) * 5,
    ]
