"""Sensitivities against closed forms (E1) and central differences; tolerances against the law of propagation."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import design_cases, mechanisms
from cases.tolerances import approx
from scipy.stats import norm

import flexmb as fm
from flexmb import planar

T, WIDTH = mechanisms.THICKNESS, mechanisms.WIDTH
DISTRIBUTED = 26 / 35 * 7850 * mechanisms.WIDTH * T * mechanisms.LENGTH


def guide(thickness, width=WIDTH):
    b = mechanisms.planar_guide(dofs=False, force=(0.0, -1.0))
    for name in ("left 1", "right 1"):
        b.members[name].properties["section"] = mechanisms.leaf(thickness, width)
    return b.build()


ANSWERS = {"frequency": lambda model: fm.frequencies(model)[0], "load": lambda model: fm.buckling_loads(model)[0]}


@pytest.mark.slow("forward")
@pytest.mark.parametrize("mode", ["forward", "reverse"])
def test_table_is_the_closed_form(mode):
    found = fm.sensitivities(design_cases.unloaded_guide, fm.frequencies, {"thickness": T, "width": WIDTH}, mode=mode)
    # E1: f ~ sqrt(w t^3/(m + c w t)), so that d ln f/d ln t = (3 - s)/2 with the share s of the leaf springs' mass.
    share = DISTRIBUTED / (0.206 + DISTRIBUTED)
    # Round-off of a frequency times its condition; the closed form is exact for one cubic beam.
    np.testing.assert_allclose(found.table, [[(3 - share) / 2, (1 - share) / 2]], rtol=1e-8)
    assert found.answers == ("frequencies[0]",)
    assert found.dimensions == ("thickness", "width")
    assert found.mode == mode
    assert found.slopes[0, 0] == approx(31670.0798802, rel=1e-8)  # printed in E1


@pytest.mark.slow
def test_several_answers_against_central_differences():
    point = {"thickness": T, "width": WIDTH}
    found = fm.sensitivities(guide, ANSWERS, point)
    assert found.mode == "forward"
    h = 1e-5
    for j, name in enumerate(point):
        up, down = ({**point, name: point[name] * (1 + s * h)} for s in (1, -1))
        for i, answer in enumerate(ANSWERS.values()):
            difference = (float(answer(guide(**up))) - float(answer(guide(**down)))) / (2 * h * found.values[i])
            # Truncation h^2, round-off eps/h times the condition of the answer.
            assert found.table[i, j] == approx(difference, rel=1e-6)
    assert "thickness" in str(found)
    assert "load" in str(found)
    assert found.table[list(ANSWERS).index("load"), 0] == approx(3, rel=1e-8)  # P ~ w t^3


@pytest.mark.slow
def test_table_for_pandas():
    pytest.importorskip("pandas")
    frame = fm.sensitivities(guide, ANSWERS, {"thickness": T, "width": WIDTH}).to_pandas()
    assert frame.loc["load", "thickness"] == approx(3, rel=1e-8)


@pytest.mark.slow
def test_second_order_is_the_closed_form():
    found = fm.sensitivities(
        design_cases.unloaded_guide, fm.frequencies, {"thickness": T}, second_order=True, mode="reverse"
    )
    f, s = found.values[0], DISTRIBUTED / (0.206 + DISTRIBUTED)
    # ln f = 3/2 ln t - ln(m + c t)/2: d2 f = f ((ln f)'' + (ln f)'^2).
    second = f * ((-1.5 + s**2 / 2) + ((3 - s) / 2) ** 2) / T**2
    assert found.curvatures[0, 0, 0] == approx(second, rel=1e-7)


def placed(x, y):
    """A mass of which only the place is asked."""
    b = fm.Builder()
    b.node("ground", (0, 0))
    b.node("mass", (0.1 + x, y))
    b.add(planar.truss, "ground", "mass", name="s", section=fm.Rigidity(EA=9.0))
    b.fix("ground")
    b.fix("mass", "y")
    return b.build()


def test_a_second_derivative_that_is_not_finite_raises():
    """|p|^1.5 has the slope zero at p = 0, and no second derivative."""

    def bent(model):
        return 1 + jnp.abs(model.parameters.reference[3]) ** 1.5

    asked = partial(placed, 0.0), {"bent": bent}, {"y": 0.0}
    found = fm.sensitivities(*asked, second_order=True, throw=False)
    assert found.slopes[0, 0] == 0
    assert found.result is fm.RESULTS.not_finite
    with pytest.raises(fm.AnalysisError, match="'bent' has no finite derivative"):
        fm.design.tolerances(*asked, {"y": 1e-5}, second_order=True)


def test_random_designs_without_an_answer_warn():
    """One in five has none: a corner that one deviation of each dimension alone does not reach."""

    def linear(model):
        x, y = model.parameters.reference[2:4]
        return jnp.where(x - 0.1 + y > 1.2e-5, jnp.nan, 1 + x + y)

    with pytest.warns(fm.FlexmbWarning, match=r"Of 16 random designs within the tolerances \d+ have no answer"):
        fm.design.tolerances(placed, {"a": linear}, {"x": 0.0, "y": 0.0}, {"x": 1e-5, "y": 1e-5})


@pytest.mark.slow
def test_second_order_by_several_dimensions_is_the_closed_form():
    """By reverse mode, whose derivatives must know the matrix that was factorised as well as its factors."""
    L = 0.1

    def cantilever(thickness, length, width):
        b = fm.Builder()
        b.node("A", (0, 0))
        b.node("B", (0, length))
        b.add(planar.beam, "A", "B", name="leaf", section=fm.Rectangle(width, thickness, fm.Material(E=210e9, G=80e9)))
        b.fix("A")
        b.dof("leaf", 1, 2, 3)
        return b.build()

    sizes = {"thickness": T, "length": L, "width": WIDTH}
    answer = {"stiffness": lambda m: fm.stiffness(m, "B", "x")}
    found = fm.sensitivities(cantilever, answer, sizes, second_order=True)
    assert found.mode == "reverse"
    # k = 3 EI/L^3 goes as t^3, L^-3 and w.
    power = np.array([3.0, -3.0, 1.0])
    k = 3 * 210e9 * WIDTH * T**3 / 12 / L**3
    of_logarithms = found.curvatures[0] * np.outer(list(sizes.values()), list(sizes.values())) / k
    np.testing.assert_allclose(of_logarithms, np.outer(power, power) - np.diag(power), rtol=0, atol=1e-9)


@pytest.mark.slow
def test_second_order_of_a_loaded_equilibrium_is_that_of_its_equation():
    """A bar of stiffness k that its spring c guides sideways: k (l - 1) y/l + c y = F with l^2 = 1 + y^2."""

    def pulled(force, k, c):
        b = fm.Builder()
        b.node("A", (0, 0))
        b.node("B", (1.0, 0))
        b.node("C", (1.0, -1.0))
        b.add(planar.truss, "A", "B", section=fm.Rigidity(EA=k))
        b.add(planar.truss, "C", "B", section=fm.Rigidity(EA=c))
        b.fix("A")
        b.fix("C")
        b.fix("B", "x")
        b.dof("B", "y")
        b.force("B", (0, force))
        return b.build()

    sizes = {"force": 1.5, "k": 20.0, "c": 1.0}
    found = fm.sensitivities(pulled, {"y": lambda m: fm.equilibrium(m).at("B")[1]}, sizes, second_order=True)
    assert found.mode == "reverse"

    def left(y, force, k, c):
        return k * (1 - 1 / jnp.sqrt(1 + y**2)) * y + c * y - force

    def solved(p):
        y = float(found.values[0])
        # From a number on each step of Newton's method has one more derivative right, and more.
        for _ in range(3):
            y = y - left(y, *p) / jax.grad(left)(y, *p)
        return y

    expected = jax.jit(jax.hessian(solved))(jnp.array([*sizes.values()]))
    np.testing.assert_allclose(found.curvatures[0], expected, rtol=1e-9)


@pytest.mark.slow
def test_arrays_of_dimensions_have_their_own_labels():
    def answer(made):
        return fm.compliance(made, "3")[1, 1]

    found = fm.sensitivities(lambda h: design_cases.cantilever(h, 1), {"compliance": answer}, {"h": np.ones(3)})
    assert found.dimensions == ("h[0]", "h[1]", "h[2]")
    # Compliance is the integral of (1 - x)^2/I: each piece's share, closed form.
    edges = 1 - np.linspace(0, 1, 4)
    np.testing.assert_allclose(found.table[0], -(edges[:-1] ** 3 - edges[1:] ** 3), rtol=1e-9)
    assert found.mode == "reverse"


@pytest.mark.slow
def test_a_failing_analysis_is_told():
    def build(thickness):
        return mechanisms.planar_guide(thickness, elongation=True, force=(0.0, -500.0)).build()

    with pytest.raises(fm.AnalysisError, match="static equilibrium was not found"):
        fm.sensitivities(build, ANSWERS["load"], {"thickness": T})
    found = fm.sensitivities(build, {"load": ANSWERS["load"]}, {"thickness": T}, throw=False)
    assert found.result is fm.RESULTS.not_converged


@pytest.mark.parametrize(
    ("dimensions", "words"),
    [({"thicknes": T}, "Did you mean 'thickness'"), ({"width": WIDTH}, "Dimension 'thickness' of guide")],
)
def test_wrong_dimensions_are_named(dimensions, words):
    with pytest.raises(ValueError, match=words):
        fm.sensitivities(guide, ANSWERS, dimensions)


def test_wrong_answers_are_named():
    with pytest.raises(TypeError, match="Answer 'poles' is complex"):
        fm.sensitivities(guide, {"poles": lambda model: jnp.array([1j])}, {"thickness": T})
    with pytest.raises(ValueError, match="same name"):
        fm.sensitivities(guide, [lambda m: 1.0, lambda m: 2.0], {"thickness": T})


def test_tolerances_by_the_law_of_propagation_and_by_samples():
    point, spread = {"thickness": T, "width": WIDTH}, {"thickness": 1e-3 * T, "width": 2e-3 * WIDTH}
    answers = {"stiffness": lambda model: fm.linearize(model).K0[0, 0]}
    found = fm.design.tolerances(design_cases.unloaded_guide, answers, point, spread, samples=400, seed=3)
    # k ~ w t^3: relative deviation sqrt(3^2 1^2 + 2^2) per thousand, shares 9 to 4.
    assert found.deviations[0] / found.values[0] == approx(np.sqrt(13) * 1e-3, rel=1e-8)
    np.testing.assert_allclose(found.shares[0], [9 / 13, 4 / 13], rtol=1e-8)
    # A sampled deviation scatters by 1/sqrt(2 n) = 3.5 %; three of those.
    np.testing.assert_allclose(found.sampled_deviations, found.deviations, rtol=3 / np.sqrt(800))
    assert np.all(found.sampled_interval[:, 0] < found.values)
    assert np.all(found.values < found.sampled_interval[:, 1])
    with pytest.raises(ValueError, match="Deviation of 'length'"):
        fm.design.tolerances(design_cases.unloaded_guide, answers, point, {"length": 1e-3})


def test_frequencies_that_cross_by_many_dimensions_together_are_warned_of():
    """Five springs in parallel carry each of two carts. No single spring crosses the frequencies; all together do."""
    distance, sigma = 6.0, 10.0
    near = {"first": np.full(5, 200.0), "second": np.full(5, 200.0 + distance / 5)}
    spread = dict.fromkeys(near, sigma / np.sqrt(5))

    def build(first, second):
        return design_cases.two_carts(jnp.sum(first), jnp.sum(second))

    with pytest.warns(fm.FlexmbWarning, match="two frequencies nearly coincide"):
        found = fm.design.tolerances(build, "frequency 1", near, spread, samples=1000)
    # The mean of the smaller of two normal numbers with different means: Clark 1961.
    apart = distance / sigma / np.sqrt(2)
    shift = -np.sqrt(2) * (norm.pdf(apart) - apart * norm.sf(apart))
    # Of the mean of 1000 samples, three deviations: 3/sqrt(1000) = 0.1.
    assert (found.sampled_mean[0] - found.values[0]) / found.deviations[0] == approx(shift, abs=0.1)


@pytest.mark.slow
def test_scatter_where_two_frequencies_nearly_coincide_is_not_linear():
    """The lowest of two: the mean of the smaller of two normal numbers is sigma/sqrt(pi) below theirs."""
    near, spread = {"first": 1000.0, "second": 1000.1}, {"first": 10.0, "second": 10.0}

    def lowest(model):
        return fm.frequencies(model)[0]

    with pytest.warns(fm.FlexmbWarning, match=r"'lowest' .* two frequencies nearly coincide.* samples=1000"):
        found = fm.design.tolerances(design_cases.two_carts, lowest, near, spread, samples=1000)
    # sqrt(k)/(2 pi) has a slope of sqrt(k)/(4 pi k).
    sigma = np.sqrt(1000.0) / (4 * np.pi * 1000.0) * 10.0
    assert found.deviations[0] == approx(sigma, rel=1e-4)
    # Of the mean of 1000 samples, three deviations: 3/sqrt(1000) = 0.1.
    assert (found.sampled_mean[0] - found.values[0]) / sigma == approx(-1 / np.sqrt(np.pi), abs=0.1)
    fm.design.tolerances(design_cases.two_carts, lowest, {"first": 1000.0, "second": 1300.0}, spread)
