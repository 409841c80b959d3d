"""What messages show of a user's text, and which failure of a batch is raised."""

import numpy as np
import pytest

from flexmb.errors import LONGEST, AnalysisError, printable
from flexmb.results import RESULTS, check


class Unwilling:
    def __str__(self):
        raise RuntimeError


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("top plate", "top plate"),
        ("Führung 3", "Führung 3"),
        (0.5, "0.5"),
        ("a\nb\x1b[31m\0", r"a\nb\x1b[31m\x00"),
        # A lone surrogate and a mark that turns the direction of writing.
        ("\udcff\u202e", r"\udcff\u202e"),
        ("x" * LONGEST, "x" * LONGEST),
        ("x" * 10**6, "x" * (LONGEST // 2) + "..." + "x" * (LONGEST // 2) + " (1000000 characters)"),
        # Python refuses to print an integer of so many digits.
        (10**6000, "<int>"),
        (Unwilling(), "<Unwilling>"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_users_text_is_one_printable_line(text, expected):
    assert printable(text) == expected
    assert printable(text).isprintable()


def test_the_worst_of_a_batch_is_raised():
    codes = [RESULTS.critical_state.value, RESULTS.not_converged.value, RESULTS.successful.value]
    with pytest.raises(AnalysisError) as raised:
        check(np.array(codes), True)
    assert raised.value.code == "not_converged"
    # A critical state is a success.
    check(np.array(codes)[[0, 2]], True)
