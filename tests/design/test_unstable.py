"""Designs beyond their buckling load: their answers are of a state in which no mechanism stays, and that is said."""

import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.results import ANSWERED, RESULTS, worst_of

EULER = np.pi**2 / 4


def column(bending, check=True):
    """A clamped column of length 1 under a load of 1, which it bears from EI = 4/pi^2 on."""
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (0.0, i / 2))
    for i in range(2):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e4, EIy=bending, mass=1.0))
    b.fix("n0")
    b.force("n2", (0.0, -1.0))
    return b.build(check=check)


ANSWERS = {
    "equilibrium": lambda m: fm.equilibrium(m).at("n2")[1],
    "equilibria": lambda m: fm.equilibria(m, load_factor=np.array([0.5, 1.0])).at("n2")[-1, 1],
    "compliance": lambda m: fm.compliance(m, "n2")[0, 0],
    # Of a higher frequency no sign tells it.
    "frequency": lambda m: fm.frequencies(m)[1],
    "linearisation": lambda m: fm.linearize(m).K0[0, 0],
}


@pytest.mark.slow("equilibrium", "equilibria", "frequency", "linearisation")
@pytest.mark.parametrize("name", ANSWERS)
def test_a_sweep_that_is_not_compiled_says_so_too(name):
    with pytest.warns(fm.FlexmbWarning, match="not stable"):
        found = fm.sweep(column, {name: ANSWERS[name]}, {"bending": np.array([1.1, 0.9]) / EULER}, compiled=False)
    np.testing.assert_array_equal(found.codes, [0, RESULTS.unstable_state])


@pytest.mark.slow("equilibrium", "linearisation")
@pytest.mark.parametrize("name", ANSWERS)
def test_a_sweep_says_which_designs_are_unstable(name):
    with pytest.warns(fm.FlexmbWarning, match=r"Of 3 designs 1 are at an equilibrium that is not stable .*number 1"):
        found = fm.sweep(column, {name: ANSWERS[name]}, {"bending": np.array([1.1, 0.9, 4.0]) / EULER})
    np.testing.assert_array_equal(found.codes, [0, RESULTS.unstable_state, 0])
    assert found.failures() == {}
    assert np.all(np.isfinite(found[name]))


SPARSE = {
    "equilibrium": lambda m: fm.equilibrium(m, sparse=True).at("n2")[1],
    "compliance": lambda m: fm.compliance(m, "n2", sparse=True)[0, 0],
    "frequency": lambda m: fm.frequencies(m, count=2, sparse=True)[1],
}


@pytest.mark.slow("equilibrium-False", "equilibrium-True")
@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("name", SPARSE)
def test_a_sweep_by_sparse_factors_says_so(name, compiled):
    designs = {"bending": np.array([1.1, 0.9, 4.0]) / EULER}
    with pytest.warns(fm.FlexmbWarning, match="not stable"):
        found = fm.sweep(lambda bending: column(bending, False), {name: SPARSE[name]}, designs, compiled=compiled)
    np.testing.assert_array_equal(found.codes, [0, RESULTS.unstable_state, 0])
    assert np.all(np.isfinite(found[name]))


@pytest.mark.slow
def test_derivatives_and_optima_in_unstable_states_say_so():
    answers = {"height": ANSWERS["equilibrium"]}
    with pytest.warns(fm.FlexmbWarning, match=r"not stable.* affects the sensitivities of height"):
        fm.sensitivities(column, answers, {"bending": 0.9 / EULER})
    # The tip sinks by 1/EA however soft the column is: nothing but the bound holds it.
    answers["rigidity"] = lambda m: m.parameters.properties[0]["section"].EIy[0]
    bounds = {"bending": (0.9 / EULER, 4.0)}
    with pytest.warns(fm.FlexmbWarning, match="The design is at an equilibrium that is not stable"):
        found = fm.tune(column, answers, {"bending": 2.0}, bounds, minimize="rigidity")
    assert found.dimensions["bending"] == approx(0.9 / EULER, rel=1e-6)


def test_a_failure_is_worse_than_what_has_an_answer():
    code = int(RESULTS.not_converged)
    assert int(worst_of([])) == 0
    for codes in ([code, int(RESULTS.singular_mass)], [*ANSWERED, code], [np.array([0, 17, code]), 8]):
        assert int(worst_of(codes)) == code
    assert int(worst_of([17, 8, 0])) == RESULTS.unstable_state
    assert int(worst_of([np.array([0, 8]), 0])) == RESULTS.critical_state
