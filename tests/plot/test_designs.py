"""Pictures of sweeps, searches and sensitivities, by the numbers in them."""

import matplotlib as mpl
import numpy as np
import pytest

import flexmb as fm
from flexmb import plot
from flexmb.design.sensitivities import Sensitivities
from flexmb.design.tolerance import Tolerances
from flexmb.design.tuned import Tuned

mpl.use("Agg")
import matplotlib.pyplot as plt


@pytest.fixture(autouse=True)
def _figures_are_closed():
    yield
    plt.close("all")


def swept(designs, fails=()):
    """f = a b^2 of every design."""
    f = np.asarray(designs["a"]) * np.asarray(designs.get("b", 1.0)) ** 2 * np.asarray(designs.get("c", 1.0))
    f[list(fails)] = np.nan
    codes = np.isnan(f).astype(int)
    return fm.design.Sweep(designs, {"f": f, "g": np.stack([f, f], axis=1)}, codes, {"f": "Hz", "a": "m"})


def test_a_map_of_a_grid():
    found = swept(fm.design.grid(a=[1.0, 2.0, 3.0], b=[1.0, 3.0], c=[1.0, 10.0, 100.0]), fails=[1])
    ax = plot.sweep(found, "f", ["a", "b"])
    mesh = ax.collections[0]
    # The third axis is held at its middle value.
    np.testing.assert_allclose(mesh.get_array(), [[np.nan, 20, 30], [90, 180, 270]], equal_nan=True)
    assert ax.get_title() == "c = 10, 1 of 6 designs failed"
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("a [m]", "b")
    np.testing.assert_allclose(ax.lines[-1].get_xydata(), [[1.0, 1.0]])
    assert ax.figure.axes[1].get_ylabel() == "f [Hz]"


@pytest.mark.parametrize("a", [[3.0, 2.0, 1.0], [1.0, 3.0, 2.0]])
def test_axes_of_a_grid_in_any_order_make_the_same_map(a):
    found = swept(fm.design.grid(a=a, b=[3.0, 1.0], c=[100.0, 1.0, 10.0]))
    ax = plot.sweep(found, "f", ["a", "b"])
    np.testing.assert_allclose(ax.collections[0].get_array(), [[10, 20, 30], [90, 180, 270]])
    assert ax.get_title() == "c = 10"


def test_axes_are_used_or_refused():
    designs = fm.design.grid(a=[3.0, 4.0, 5.0], b=[1.0, 2.0])
    found = swept(designs)
    _, ax = plt.subplots()
    assert plot.sweep(found, over="a", ax=ax) is ax
    assert ax.lines[0].get_label() == "f [Hz]"
    two = fm.design.Sweep(designs, {"f": found["f"].ravel(), "g": found["f"].ravel()}, found.codes, {})
    with pytest.raises(ValueError, match=r"Argument `ax` needs `answer`: there are 2 answers .*Choose one of f, g"):
        plot.sweep(two, over="a", ax=ax)


def test_a_front_is_marked_in_the_picture_of_each_answer():
    found = swept(fm.design.grid(a=[3.0, 4.0, 5.0], b=[1.0, 2.0]))
    figure = plot.sweep(found.pareto(minimize="a", maximize="f"), over="a")
    assert "front" in [line.get_label() for line in figure.axes[0].lines]


def test_a_curve():
    found = swept(fm.design.grid(a=[3.0, 4.0, 5.0]), fails=[1])
    ax = plot.sweep(found, "f")
    np.testing.assert_allclose(ax.lines[0].get_xydata(), [[3, 3], [4, np.nan], [5, 5]], equal_nan=True)
    np.testing.assert_allclose(ax.lines[1].get_xydata(), [[4, 3]])
    assert ax.get_ylabel() == "f [Hz]"


def test_points_of_other_designs():
    found = swept(fm.design.latin_hypercube(12, seed=3, a=(1.0, 2.0), b=(1.0, 3.0)))
    ax = plot.sweep(found, "f", ("b", "a"))
    drawn = ax.collections[0]
    np.testing.assert_allclose(drawn.get_offsets(), np.stack([found["b"], found["a"]], axis=1))
    np.testing.assert_allclose(drawn.get_array(), found["f"])


def test_an_answer_over_another_and_the_front():
    """f = a b^2 should be large and a small: of equal b the whole grid, and the largest b alone is the front."""
    found = swept(fm.design.grid(a=[1.0, 2.0, 3.0], b=[1.0, 3.0]), fails=[3])
    front = found.pareto(maximize="f", minimize="a")
    ax = plot.sweep(front, x="a", y="f")
    points, line = ax.lines
    np.testing.assert_allclose(points.get_xydata(), [[1, 1], [1, 9], [2, 2], [3, 3], [3, 27]])
    np.testing.assert_allclose(line.get_xydata(), [[1, 9], [3, 27]])
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_title()) == ("a [m]", "f [Hz]", "1 of 6 designs failed")
    assert line.get_label() == "front, 2 designs"
    # Of a front its criteria, unless others are named; entries of arrays have names too.
    assert plot.sweep(front).get_xlabel() == "a [m]"
    assert plot.sweep(found, x="g[1]", y="b").get_xlabel() == "g[1]"
    np.testing.assert_allclose(plot.sweep(front, "f", ["a", "b"]).lines[-1].get_xydata(), [[1, 3], [3, 3]])
    with pytest.raises(ValueError, match="both `x` and `y`"):
        plot.sweep(found, x="f")
    with pytest.raises(ValueError, match="either"):
        plot.sweep(found, "f", x="f", y="a")


def test_many_designs_are_hexagons():
    found = swept(fm.design.latin_hypercube(4000, seed=3, a=(1.0, 2.0), b=(1.0, 3.0)), fails=range(0, 4000, 8))
    counts = plot.sweep(found, x="a", y="f").collections[0].get_array()
    assert len(counts) < 1000
    assert counts.sum() == 3500
    ax = plot.sweep(found, "f", ("a", "b"))
    drawn = ax.collections[0]
    # The mean of a hexagon is near to the value in its middle, within its size.
    x, y = drawn.get_offsets().T
    off = drawn.get_array() / (x * y**2) - 1
    assert np.max(np.abs(off)) < 0.25
    assert abs(np.mean(off)) < 0.02
    assert ax.get_title() == "500 of 4000 designs failed"
    assert len(ax.lines[0].get_xdata()) == 500


@pytest.mark.parametrize(
    ("answer", "over", "expected"),
    [("h", None, KeyError), ("g", None, ValueError), ("f", "d", KeyError), ("f", ["a", "b", "c"], ValueError)],
)
def test_sweeps_that_cannot_be_drawn(answer, over, expected):
    found = swept(fm.design.grid(a=[1.0, 2.0], b=[1.0, 3.0], c=[1.0, 10.0]))
    with pytest.raises(expected):
        plot.sweep(found, answer, over)
    # No picture without a curve.
    with pytest.raises(ValueError, match=r"name an entry, such as 'g\[0\]'"):
        plot.sweep(fm.design.Sweep(found.designs, {"g": found.answers["g"]}, found.codes, {}))


def test_the_run_of_a_search():
    history = {
        "a": np.array([2.0, 1.0, 1.5]),
        "b": np.array([[1.0, 4.0], [2.0, 2.0], [3.0, 1.0]]),
        "f": np.array([10.0, 30.0, 20.0]),
        "objective": np.array([1.0, 0.5, 0.7]),
        "violation": np.array([0.1, 0.0, 1e-9]),
    }
    a, b = 1.0, np.array([2.0, 2.0])
    ended = (fm.RESULTS.successful, "the end", (), 0.5, 0.0, history, np.zeros((1, 2)))
    figure = plot.tuning(Tuned({"a": a, "b": b}, {"f": 30.0}, {"f": 10.0}, *ended))
    objective, violation, dimensions, answers = figure.axes
    np.testing.assert_allclose(objective.lines[0].get_xydata(), [[1, 1], [2, 0.5], [3, 0.7]])
    np.testing.assert_allclose(violation.lines[0].get_xydata(), [[1, 0.1], [3, 1e-9]])
    lines = {line.get_label(): line.get_ydata() for line in dimensions.lines[:3]}
    np.testing.assert_allclose(lines["a"], [1, 0.5, 0.75])
    np.testing.assert_allclose(lines["b[1]"], [1, 0.5, 0.25])
    np.testing.assert_allclose(answers.lines[0].get_ydata(), [1, 3, 2])
    # The second evaluation is the one returned.
    np.testing.assert_allclose(objective.lines[1].get_xdata(), [2, 2])


def test_a_curve_that_was_a_target():
    history = {"a": np.ones(2), "f": np.array([[1.0, 2.0], [3.0, 5.0]]), "objective": np.ones(2)}
    ended = (fm.RESULTS.successful, "the end", (), 0.5, 0.0, {**history, "violation": np.zeros(2)}, np.zeros((1, 2)))
    curve = fm.design.Curve([0.0, 0.1], [3.0, 4.0], "stroke [m]")
    found = Tuned({"a": 1.0}, {"f": history["f"][1]}, {"f": history["f"][0]}, *ended, {"f": curve})
    # Nothing was violated, and no answer is anything else than a curve: no panel for either.
    objective, dimensions, drawn = plot.tuning(found).axes
    assert (objective.get_ylabel(), dimensions.get_ylabel()) == ("objective [-]", "dimension over its start [-]")
    assert (drawn.get_xlabel(), drawn.get_ylabel()) == ("stroke [m]", "f")
    lines = {line.get_label(): line.get_ydata().tolist() for line in drawn.lines}
    assert lines == {"wanted": [3, 4], "start": [1, 2], "found": [3, 5]}


def bars(ax):
    return {group.get_label(): [bar.get_width() for bar in group.patches] for group in ax.containers[::1]}


def test_bars_of_sensitivities():
    table = np.array([[1.0, -2.0], [0.5, np.nan]])
    found = Sensitivities(
        ("f", "k"), ("t", "l"), np.ones(2), np.ones(2), table, table, None, "forward", fm.RESULTS.successful
    )
    ax = plot.sensitivities(found)
    # The dimension that matters most stands on top, which is last.
    assert [text.get_text() for text in ax.get_yticklabels()] == ["t", "l"]
    assert {name: widths for name, widths in bars(ax).items() if name in "fk"} == {"f": [1, -2], "k": [0.5, 0]}
    assert "no value" in {text.get_text() for text in ax.texts}
    shares = np.array([[0.25, 0.75]])
    ax = plot.sensitivities(Tolerances(("f",), ("t", "l"), np.ones(1), np.ones(1), shares, None, None, None, None))
    assert bars(ax)["f"] == [25, 75]


@pytest.mark.slow("<lambda>")
@pytest.mark.parametrize("draw", [plot.sensitivities, plot.tuning, lambda found: plot.sweep(found, "f")])
def test_what_is_not_a_result_is_refused(draw):
    with pytest.raises(TypeError, match="found"):
        draw(3)
