"""Names fitted to a table of measurements: against another root finder, and one line for a wrong table."""

import json
import re

import pytest
from cases import mechanisms
from cases.documents import planar_guide
from cases.tolerances import approx
from scipy.optimize import brentq

import flexmb as fm
from flexmb.workbench.document import apply
from flexmb.workbench.fit_table import fitted_names

DEVIATION = 0.05


def frequency(t):
    return float(fm.frequencies(mechanisms.planar_guide(t).build())[0])


@pytest.mark.slow
def test_a_thickness_from_a_frequency_is_that_of_another_root_finder():
    document = planar_guide()
    table = f"answer;value;deviation\n# by ear\nfrequency 1;11.2;{DEVIATION}\n"
    found = fitted_names(document, "ear.csv", table, ["t"])
    # Strict JSON: no infinite numbers.
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    t = float(brentq(lambda t: frequency(t) - 11.2, 0.4e-3, 1.2e-3, xtol=1e-16))  # pyright: ignore
    (row,) = found["rows"]
    assert found["status"] == "done"
    assert float(row["fitted"]) == approx(t, rel=1e-5)
    slope = (frequency(1.001 * t) - frequency(0.999 * t)) / (0.002 * t)
    assert float(row["deviation"]) == approx(DEVIATION / slope, rel=1e-3)
    assert float(row["95 % from"]) < t < float(row["to"])
    assert "chi-squared" in found["text"]
    assert "<svg" in found["picture"]
    after = apply(document, found["ops"])[0]
    assert float(after.names["t"]["value"]) == approx(t, rel=1e-6)
    assert {**after.names["t"], "value": ""} == {**document.names["t"], "value": ""}


@pytest.mark.slow
def test_an_undetermined_name_has_an_infinite_deviation():
    table = f"answer,value,deviation\nfrequency 1,{frequency(0.5e-3)},{DEVIATION}\nfrequency 1,10.6,0.05\n"
    found = fitted_names(planar_guide(), "ear.csv", table, ["t", "L"])
    assert "do not determine t and L" in found["text"]
    assert {row["deviation"] for row in found["rows"]} == {"inf"}
    json.dumps(found, allow_nan=False)


WRONG = [
    ("", "'a.csv' is empty"),
    ("1,2,3\n", "'a.csv' has no column answer or hertz"),
    ("answer,value\nfrequency 1,10\n", "'a.csv' has no column 'deviation'"),
    ("answer,value,deviation\nfrequency 1,ten,0.1\n", "'a.csv', line 2: value is 'ten', which is no finite number"),
    ("answer,value,deviation\n\nfrequency 1,,0.1\n", "'a.csv', line 3: value is empty"),
    ("answer,value,deviation\nfrequency 1,nan,0.1\n", "'a.csv', line 2: value is 'nan'"),
    ("answer,value,deviation\nfrequency 1,10,-0.1\n", "Measurement 'a.csv' has a deviation of -0.1"),
    ("answer,value,deviation\nfrequenzy 1,10,0.1\n", "'frequenzy 1' has no derivatives"),
    ("value,deviation,answer\n10,0.1\n", "'a.csv', line 2: there is no column 3 for answer"),
    ("answer,value,deviation\nfrequency 1,10600,50\n", "'a.csv' are about 1e+03 times"),
    ("answer,value,deviation\n", "'a.csv' has no line of numbers"),
    ("hertz,real\n1,2\n", "give imaginary"),
    ("\ufeffhertz,real\n1,2\n", "give imaginary"),
    ("answer,value,deviation\nfrequency 1,10,5,0,1\n", "'a.csv', line 2 has 5 cells for 3 columns"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("table", "words"), WRONG)
def test_a_wrong_table_is_one_error(table, words):
    with pytest.raises(ValueError, match=re.escape(words)) as fault:
        fitted_names(planar_guide(), "a.csv", table, ["t"])
    assert "\n" not in str(fault.value)
