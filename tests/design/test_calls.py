"""Wrong calls of the design functions: one error that names the argument; nothing is cut, wrapped or taken for true."""

import jax
import numpy as np
import pytest

import flexmb as fm
from flexmb.mechanisms import mechanism_path


def same(a):
    return a


def double(made):
    return 2 * made


ONE, START, BOUNDS = {"a": [1.0]}, {"a": 1.0}, {"a": (0.0, 2.0)}
TWICE = fm.scatter({"a": 0.1}, nominal={"a": 1.5})
A = np.array([[0.0, 1.0], [-1.0, -0.1]])


def sweep(**options):
    return fm.sweep(same, {"y": double}, ONE, **options)


def tune(start=START, bounds=BOUNDS, **options):
    return fm.tune(same, {"y": double}, start, bounds, **{"minimize": "y", **options})


def settle(**changed):
    given = {"matrix": A, "start": np.ones(2), "output": np.ones(2), "level": 0.1, "horizon": 9.0, **changed}
    return fm.design.settling_time(**given)


def scattered(deviation=0.1, **options):
    return fm.design.tolerances(same, {"y": double}, START, {"a": deviation}, **options)


WRONG = [
    (lambda: fm.design.grid(a="abc"), "Axis 'a' of a grid must be numbers, but got 'abc'"),
    (lambda: fm.design.grid(a=["x"]), "Axis 'a' of a grid must be numbers"),
    (lambda: fm.design.grid(a=[1j]), "Axis 'a' of a grid must be numbers"),
    (lambda: fm.design.grid(**{n: np.ones(1000) for n in "abcdef"}), "`count` must be .*at most 1e.07"),
    (lambda: fm.design.Designs({"a": [True]}), "Dimension 'a' must be numbers"),
    (lambda: fm.design.Designs({"a": [[1, 2], [3]]}), "Dimension 'a' must be numbers"),
    (lambda: fm.design.latin_hypercube(2.5, a=(0, 1)), "`count` must be a whole number, not 2.5"),
    (lambda: fm.design.latin_hypercube(True, a=(0, 1)), "`count` must be a whole number, not True"),
    (lambda: fm.design.latin_hypercube(10**11, a=(0, 1)), "at most 1e.07"),
    (lambda: fm.design.monte_carlo(10**11, a=(0, 1)), "at most 1e.07"),
    (lambda: fm.design.latin_hypercube(3, a=(np.zeros(2), np.ones(2))), "Bounds of 'a' must be two numbers"),
    (lambda: fm.design.monte_carlo(3, seed=-1, a=(0, 1)), "`seed` must be at least 0"),
    (lambda: sweep(chunk=True), "`chunk` must be a whole number"),
    (lambda: sweep(chunk=2.5), "`chunk` must be a whole number"),
    (lambda: sweep(together=0), "`together` must be at least 1"),
    (lambda: sweep(units={"z": "m"}), "Unit of 'z': there is no such"),
    (lambda: sweep()["z"], "no answer or dimension 'z'; there are a, y"),
    (lambda: fm.sweep(same, {"a": double}, ONE), "Answer 'a' has the name of a dimension"),
    (lambda: fm.sweep(same, {"codes": double}, ONE), "Answer 'codes' must have another name"),
    (lambda: fm.sweep(same, {"about": double}, ONE), "Answer 'about' must have another name"),
    (lambda: fm.sweep(lambda result: result, {"y": double}, {"result": [1.0]}), "Dimension 'result' must have another"),
    (lambda: fm.sweep(same, {"": double}, ONE), "must have a name of printable letters"),
    (lambda: fm.sweep(same, {"a\0b": double}, ONE), r"Answer 'a\\x00b' must have a name of printable"),
    (lambda: fm.sweep(same, {1: double}, ONE), "Answer '1' must have a name"),
    (lambda: fm.sensitivities(same, {"y": double}, {"a": "x"}), "Dimension 'a' must be numbers"),
    (lambda: fm.sensitivities(lambda: 1.0, {"y": double}, {}), "at least one dimension"),
    (lambda: scattered(np.inf), "Deviation of 'a'"),
    (lambda: scattered(np.nan), "Deviation of 'a'"),
    (lambda: scattered("x"), "Deviation of 'a' must be numbers"),
    (lambda: scattered([0.1, 0.2]), "'a' has shape"),
    (lambda: scattered(samples=2.5), "`samples` must be a whole number"),
    (lambda: scattered(samples=-3), "`samples` must be at least 0"),
    (lambda: scattered(samples=True), "`samples` must be a whole number"),
    (lambda: tune({"a": "x"}), "Dimension 'a' must be numbers"),
    (lambda: tune(bounds={"a": ("0", "2")}), "Bounds of 'a' must be two numbers"),
    (lambda: tune(bounds={"a": (np.zeros(2), np.ones(2))}), "'a' has shape"),
    (lambda: tune(starts=True), "`starts` must be a whole number"),
    (lambda: tune(starts=1.5), "`starts` must be a whole number"),
    (lambda: tune(max_evaluations=2.5), "`max_evaluations` must be a whole number"),
    (lambda: tune(together=0), "`together` must be at least 1"),
    (lambda: tune(tolerance=True), "`tolerance` must be one number"),
    (lambda: tune(tolerance="x"), "`tolerance` must be one number"),
    (lambda: tune(tolerance=np.inf), "`tolerance` must be positive"),
    (lambda: tune(minimize=["y"]), "must be names of answers"),
    (lambda: tune(targets={"y": True}), "The target of 'y'"),
    (lambda: tune(equal={"y": None}), "The value of 'y'"),
    (lambda: tune(limits={"y": "12"}), "Limits of 'y' must be two values"),
    (lambda: fm.tune(same, {"objective": double}, START, BOUNDS, minimize="objective"), "must have another name"),
    (lambda: tune(samples=1000), "`samples` is the number of made mechanisms .*with `scatter`"),
    (lambda: tune(scatter=fm.scatter({"a": 0.1})), "`scatter` has no effect.*Ask for a statistic"),
    (lambda: tune(minimize="mean y", scatter=TWICE), "'a' has two nominal values: 1.0 as a dimension, and 1.5"),
    (lambda: fm.design.tolerances(same, {"y": double}, START, TWICE), "'a' has two nominal values"),
    (lambda: fm.design.robustness(same, {"y": double}, START, TWICE, samples=10), "'a' has two nominal values"),
    (lambda: fm.design.monte_carlo(3, TWICE, a=1.0), "'a' has two nominal values"),
    (lambda: settle(samples=2.5), "`samples` must be a whole number"),
    (lambda: settle(horizon=np.inf), "`horizon` must be positive"),
    (lambda: settle(start=np.ones(3)), r"`matrix` must have shape \(3, 3\), but has shape \(2, 2\)"),
]


@pytest.mark.parametrize(("call", "words"), WRONG, ids=[f"{i}" for i in range(len(WRONG))])
def test_wrong_calls_name_the_argument(call, words):
    with pytest.raises((ValueError, TypeError, KeyError), match=words):
        call()


@pytest.mark.slow
@pytest.mark.parametrize("changed", [{"level": np.nan}, {"matrix": A * np.nan}, {"output": np.array([1.0, np.nan])}])
def test_nothing_settles_that_is_no_number(changed):
    with pytest.raises(ValueError, match=r"finite|positive"):
        settle(**changed)
    # Of many designs at once only that one has no answer.
    name, value = next(iter(changed.items()))
    assert np.isnan(jax.jit(lambda value: settle(**{name: value}))(value))


WRONG_QUESTIONS = [
    ({"bandwidth": np.nan}, "`bandwidth` must be positive"),
    ({"bandwidth": np.inf}, "`bandwidth` must be positive"),
    ({"bandwidth": True}, "`bandwidth` must be one number"),
    ({"bandwidth": "100"}, "`bandwidth` must be one number"),
    ({"tolerance": np.nan}, "`tolerance` must be positive"),
    ({"nodes": ["Z"]}, "no node 'Z'"),
    ({"nodes": "3"}, "`nodes` must be a list of names"),
    ({"increments": ()}, "`increments` must be finite numbers"),
    ({"increments": [np.nan]}, "`increments` must be finite numbers"),
    ({"increments": ["0"]}, "`increments` must be numbers"),
    ({"finest": 2.5}, "`finest` must be a whole number"),
    ({"finest": 8}, "`finest` is for a function of the numbers of beams"),
]


@pytest.mark.parametrize(("changed", "words"), WRONG_QUESTIONS, ids=[f"{i}" for i in range(len(WRONG_QUESTIONS))])
def test_wrong_questions_about_leanness(changed, words):
    model = fm.read_spacar(mechanism_path("pf2d")).builder.build()
    for function in (fm.lean, fm.design.too_lean):
        if function is fm.lean or not {"increments", "finest"} & set(changed):
            with pytest.raises(fm.ModelError, match=words):
                function(model, **{"bandwidth": 100.0, **changed})


def test_leanness_is_asked_of_a_model():
    for function in (fm.lean, fm.design.too_lean):
        with pytest.raises(fm.ModelError, match=r"must be a Model.* not int"):
            function(3, bandwidth=100.0)


@pytest.mark.slow
def test_a_node_may_be_named_by_its_number():
    model = fm.read_spacar(mechanism_path("pf2d")).builder.build()
    assert fm.stiffness(model, 3, "x") == fm.stiffness(model, "3", "x")


@pytest.mark.slow
def test_dimensions_bear_any_name():
    bounds = {"count": (1.0, 2.0), "seed": (3.0, 4.0)}
    for draw in (fm.design.latin_hypercube, fm.design.monte_carlo):
        found = draw(5, bounds, seed=1)
        assert list(found) == ["count", "seed"]
        assert all(low <= found[name].min() <= found[name].max() <= high for name, (low, high) in bounds.items())
        np.testing.assert_array_equal(
            found["seed"], draw(5, {"count": (1.0, 2.0)}, seed=1, **{"seed ": (3, 4)})["seed "]
        )
    assert fm.design.grid({"self": [1.0, 2.0]}, axes=[3.0])["axes"].tolist() == [3.0, 3.0]
    with pytest.raises(TypeError, match="'a' is in the dictionary and a keyword"):
        fm.design.grid({"a": [1.0]}, a=[2.0])
    with pytest.raises(TypeError, match="a dictionary by name"):
        fm.design.latin_hypercube(3, (0.0, 1.0))
