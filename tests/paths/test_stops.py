"""Paths that end where a designer wants, and leave their branch where one says, against closed forms."""

import numpy as np
import pytest
from cases.snapping import EULER, column, load_at, truss
from cases.tolerances import approx
from scipy.optimize import fsolve

import flexmb as fm
from flexmb import planar, spatial
from flexmb.paths.imperfection import bent_by_modes

FLAT = truss()


def test_a_displacement_is_met_on_the_way_back():
    # The apex comes down by 1.3, past the base, under a load that has turned back and is negative.
    path = fm.path(FLAT, stop={"apex.y": -1.3, "critical_points": 5})
    assert path.stopped_by == "apex.y"
    assert "stopped by: apex.y, at load factor" in str(path)
    # The coordinate is held to the last digit; the load is the closed form, round-off of EA.
    assert float(path.at("apex")[-1, 1]) == approx(-0.3, abs=1e-15)
    assert 5 * float(path.load_factor[-1]) == approx(float(load_at(-0.3)), abs=1e-9)
    assert np.all(np.asarray(path.at("apex")[:-1, 1]) > -0.3)
    # A load factor just below the limit point is met before that, within a step that ends beyond it.
    top = path.critical_points[0].load_factor
    path = fm.path(FLAT, stop={"load_factor": top * (1 - 1e-7)})
    assert path.critical_points == ()
    assert float(path.load_factor[-1]) == top * (1 - 1e-7)


def test_load_factors_and_critical_points_that_end_a_path():
    # Back to no load: the unstable state, both bars in line.
    path = fm.path(FLAT, stop={"load_factor": 0})
    assert (path.stopped_by, float(path.load_factor[-1])) == ("load_factor", 0.0)
    np.testing.assert_allclose(path.at("apex")[-1], 0, atol=1e-12)
    # Beyond 1: closed form.
    path = fm.path(FLAT, stop={"load_factor": 2.0, "apex.y": 1.0})
    assert (path.stopped_by, float(path.load_factor[-1])) == ("load_factor", 2.0)
    assert float(load_at(np.asarray(path.at("apex")[-1, 1]))) == approx(10.0, abs=1e-9)
    # At the second limit point itself.
    path = fm.path(FLAT, stop={"critical_points": 2})
    assert path.stopped_by == "critical_points"
    assert [c.kind for c in path.critical_points] == ["limit", "limit"]
    np.testing.assert_array_equal(path.x[-1], path.critical_points[-1].x)
    assert float(path.load_factor[-1]) == path.critical_points[-1].load_factor


STEEPNESS = 1.0, 4.0, 1.0
STEEP = truss(*STEEPNESS, load=1.0, sideways=True)


def out_of_balance(path):
    """Largest force on the apex of the steep truss that is not balanced: gradient of (l - l0)^2 / (2 l0), less load."""
    apex, l0 = np.asarray(path.at("apex")), np.hypot(1.0, 4.0)
    force = np.stack([np.zeros(len(apex)), np.asarray(path.load_factor)], axis=1)
    for foot in (-1.0, 1.0):
        bar = apex - [foot, 0.0]
        length = np.linalg.norm(bar, axis=1)[:, None]
        force += (length - l0) / l0 * bar / length
    return np.max(np.abs(force))


def test_a_coordinate_that_turns_back_within_a_step():
    # On the sideways branch the apex goes out until it is between both bars, pulled by one as the other pushes, at
    # l0 = sqrt(17) and no load, closed form. It passes the micrometre before that within a step that ends beyond.
    target = np.sqrt(17.0) - 1e-6
    path = fm.path(STEEP, switch=1, stop={"apex.x": target})
    assert path.stopped_by == "apex.x"
    assert float(path.at("apex")[-1, 0]) == approx(target, abs=1e-15)
    assert float(path.load_factor[-1]) > 0
    assert out_of_balance(path) < 1e-12
    # A little more is out of reach; the path closes, and says so.
    with pytest.raises(fm.AnalysisError, match="came back"):
        fm.path(STEEP, switch=1, stop={"apex.x": target + 2e-6})


def test_any_bifurcation_is_left_to_either_side():
    # The first displacement on a branch is met too, although the first step goes beyond it. Closed form of the balance;
    # beside a bifurcation it is off by 1e-6, the distance to it, times the bars' stiffness.
    for number, side, first in ((1, -1, -1e-3), (2, 1, 0.4), (3, -1, -0.4)):
        path = fm.path(STEEP, switch={number: side}, stop={"apex.x": first})
        assert path.stopped_by == "apex.x"
        assert float(path.at("apex")[-1, 0]) == approx(first, abs=1e-15)
        assert sum(c.kind == "bifurcation" for c in path.critical_points) == number
        # Not where it comes to the axis again, under the opposite load.
        assert path.load_factor[-1] * path.critical_points[-1].load_factor > 0
        assert out_of_balance(path) < 1e-6
    # One after the other: the sideways branch comes back to the axis at -P, upside down. From there the straight state
    # leads on with a rising load through none at all into tension, or with a falling one to its limit point, -top.
    path = fm.path(STEEP, switch={1: 1, 2: 1})
    apex, load = np.asarray(path.at("apex")), np.asarray(path.load_factor)
    assert [c.kind for c in path.critical_points] == ["bifurcation"] * 2
    assert abs(apex[-1, 0]) < 1e-9
    assert apex[-1, 1] < -4
    assert load_at(apex[-1, 1], *STEEPNESS) == approx(load[-1], abs=1e-12)
    assert path.stable[-1]
    path = fm.path(STEEP, switch={1: 1, 2: -1}, stop={"critical_points": 3})
    assert [c.kind for c in path.critical_points] == ["bifurcation"] * 2 + ["limit"]
    l0 = np.hypot(1.0, 4.0)
    top = load_at(np.sqrt(l0 ** (2 / 3) - 1), *STEEPNESS)
    assert path.critical_points[-1].load_factor == approx(-top, rel=1e-9)


@pytest.mark.slow
def test_a_stress_is_met():
    # A cantilever of square section under a moment at its tip, a fifth of it before the path begins: sigma = M/W in
    # every section.
    modulus = 0.01**3 / 6
    b = fm.Builder()
    b.node("foot", (0.0, 0.0))
    b.node("tip", (0.1, 0.0))
    steel = fm.Material(E=210e9, G=80e9, rho=7850.0, strength=200e6)
    b.add(planar.beam, "foot", "tip", section=fm.Rectangle(0.01, 0.01, steel))
    b.fix("foot")
    b.moment("tip", 10.0)
    b.moment("tip", 40.0, increment=True)
    model = b.build()
    # Above the strength on the way there, of which a path does not warn.
    path = fm.path(model, stop={"stress": 250e6, "tip.y": 1.0})
    assert path.stopped_by == "stress"
    with pytest.warns(fm.FlexmbWarning, match="strength"):
        found = fm.stress(path.model, at=path.linearization())
    assert float(found.maximum) == approx(250e6, rel=1e-9)
    # The moment is that of a beam but for round-off of its elongation, 1e-16 of its length, over its depth.
    assert float(path.load_factor[-1]) == approx((250e6 * modulus - 10.0) / 40.0, rel=1e-9)
    with pytest.raises(ValueError, match=r"stress.* is 5e\+07 Pa, but the path begins with 6e\+07 Pa"):
        fm.path(model, stop={"stress": 50e6})


@pytest.mark.slow
@pytest.mark.parametrize("sparse", [False, True])
def test_any_question_ends_a_path(sparse):
    # Half of the stiffness at rest, before the limit point; the frequency falls as its root.
    start = fm.path(FLAT, max_steps=1, sparse=sparse, throw=False).along("stiffness apex.y").values[0]
    path = fm.path(FLAT, sparse=sparse, stop={"stiffness apex.y": start / 2, "apex.y": -0.9})
    assert path.stopped_by == "stiffness apex.y"
    assert path.along("stiffness apex.y").values[-1] == approx(start / 2, rel=1e-6)
    hertz = path.along("frequency 1").values
    assert hertz[-1] / hertz[0] == approx(np.sqrt(0.5), rel=1e-3)
    by_frequency = fm.path(FLAT, sparse=sparse, stop={"frequency 1": float(hertz[-1])})
    assert float(by_frequency.load_factor[-1]) == approx(float(path.load_factor[-1]), rel=1e-5)


def test_what_is_not_met_is_said():
    with pytest.warns(
        fm.FlexmbWarning, match=r"apex.y reached 0 m, not 1 m, and ended at -[0-9.]+ m; critical_points are 2, not 7"
    ):
        path = fm.path(FLAT, stop={"apex.y": 1.0, "critical_points": 7})
    assert path.stopped_by is None
    assert float(path.load_factor[-1]) == 1.0
    with pytest.warns(fm.FlexmbWarning, match="names bifurcation 1, but there are 0 of them"):
        fm.path(FLAT, switch=True)
    for wrong, match in (
        ({"stop": {"apex": 1.0}}, "apex.x, apex.y"),
        ({"stop": {"top.y": 1.0}}, "no coordinate 'top.y'"),
    ):
        with pytest.raises(KeyError, match=match):
            fm.path(FLAT, **wrong)
    for wrong, match in (
        ({"stop": {"apex.y": np.nan}}, "apex.y"),
        ({"stop": {"critical_points": 0}}, "critical_points"),
        ({"stop": {"stress": 0.0}}, "positive"),
        ({"switch": 2}, "False, True, 1 or -1"),
        ({"switch": {1: 2}}, "1 or -1 for bifurcation 1"),
        ({"switch": {0: 1}}, "switch"),
        ({"imperfection": {4: 1e-3}}, "buckling mode 4"),
    ):
        with pytest.raises(ValueError, match=match):
            fm.path(STEEP, **wrong)
    for wrong, match in (({"stop": 1.0}, "values by name"), ({"imperfection": 1e-3}, "lengths by mode")):
        with pytest.raises(TypeError, match=match):
            fm.path(STEEP, **wrong)
    with pytest.raises(fm.ModelError, match="without a shape"):
        fm.path(FLAT, stop={"stress": 1e6})


@pytest.mark.slow
def test_imperfect_column():
    # Pinned, EI = 1, length 2, pressed by the displacement of its end: under a force P its middle is w0/(1 - P/Pcr)
    # aside. Cubic beams overestimate Pcr by 5.1e-4/16 (test_path.py), a tenth of which is told ten times here; the
    # second order of a deflection of ten times w0 is 1e-8.
    bow, critical = 1e-5, EULER * (1 + 5.1e-4 / 16)
    path = fm.path(column(8, 0.0, shortening=0.98 * 2 * EULER / 1e8), imperfection={1: bow})
    assert path.critical_points == ()
    pressed = -np.asarray(path.reactions)[:, path.labels.coordinates("8")[0]]
    assert 0.8 < pressed[-1] / EULER < 0.98
    np.testing.assert_allclose(path.at("4")[:, 1] * (1 - pressed / critical), bow, rtol=2e-5)
    # It begins bent, a sine, and without stress: round-off of elongations, 1e-16, times EA.
    places = np.linspace(0, np.pi, 9)
    np.testing.assert_allclose([path.at(str(i))[0, 1] for i in range(9)], bow * np.sin(places), atol=1e-4 * bow)
    assert np.max(np.abs(path.sigma[0])) < 1e-6


@pytest.mark.slow
def test_modes_of_an_imperfection_are_those_before_any_load():
    """Whatever load the path ends at, and whether some of it follows: as where loads are said to grow from zero."""

    def bent(load, increment=False):
        b = fm.Builder()
        for name, place in {"l": (-1.0, 0.0), "m": (-0.5, 0.15), "top": (0.0, 0.3), "r": (1.0, 0.0)}.items():
            b.node(name, place)
        for p, q in (("l", "m"), ("m", "top"), ("top", "r")):
            b.add(planar.beam, p, q, section=fm.Rigidity(EA=1e3, EIy=1.0))
        b.fix("l")
        b.fix("r")
        b.force("top", (0.0, -load), increment=increment)
        b.force("m", (0.3 * load, 0.0), follower=True, increment=increment)
        return bent_by_modes(b.build(), {1: 1e-3}).parameters.strain

    expected = bent(1.0, increment=True)
    assert np.max(np.abs(expected)) > 1e-4
    # Ten newtons bend it by degrees; modes are told to round-off.
    np.testing.assert_allclose(bent(10.0), expected, atol=1e-9)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*flexmb reads (metres|SI units):flexmb.FlexmbWarning")
def test_an_imperfection_has_its_side_in_every_unit():
    """A clamped column bows to the side where its top, not the angle there, grows."""

    def top(metre):
        b = fm.Builder()
        b.node("foot", (0.0, 0.0))
        b.node("top", (0.0, metre))
        b.add(planar.beam, "foot", "top", section=fm.Rigidity(EA=1e6, EIy=metre**2))
        b.fix("foot")
        b.force("top", (0.0, -1.0))
        bent = bent_by_modes(b.build(), {1: 1e-3 * metre})
        return float(fm.equilibrium(bent, load_factor=0.0).at("top")[0]) / metre

    # Found by Newton's method from a cubic shape: its share of second order.
    np.testing.assert_allclose([top(1.0), top(1e-4), top(1e4)], 1e-3, rtol=1e-5)


@pytest.mark.slow
def test_an_imperfection_turns_a_bifurcation_into_a_limit_point():
    # The steep truss, its apex aside without stress, bars of the stiffness EA/l0: gradient and determinant of the
    # Hessian of the potential of two bars are zero, solved by scipy.
    aside = 0.02
    path = fm.path(STEEP, imperfection={1: -aside}, stop={"critical_points": 1})
    (found,) = path.critical_points
    assert found.kind == "limit"
    np.testing.assert_allclose(path.at("apex")[0], [-aside, 4.0], atol=1e-12)

    def equations(unknown):
        gradient, hessian = np.array([0.0, unknown[2]]), np.zeros((2, 2))
        for foot in (-1.0, 1.0):
            bar, l0 = unknown[:2] - [foot, 0.0], np.hypot(-aside - foot, 4.0)
            length = np.linalg.norm(bar)
            gradient += (length - l0) * bar / length
            hessian += (1 - l0 / length) * np.eye(2) + l0 / length**3 * np.outer(bar, bar)
        return [*gradient, np.linalg.det(hessian)]

    apex = found.x[path.labels.coordinates("apex")]
    expected, _, success, _ = fsolve(
        equations, [*apex, found.load_factor * np.hypot(1, 4)], xtol=1e-13, full_output=True
    )
    assert success == 1
    assert found.load_factor == approx(expected[2] / np.hypot(1.0, 4.0), rel=1e-9)
    # The load is stationary there: half the digits of the place.
    np.testing.assert_allclose(apex, expected[:2], atol=1e-6)


def leaning(start=None, more=None):
    """An upright leaf spring under a mass, which a growing load will press, 0.1 m long."""
    b = fm.Builder()
    b.node("foot", (0.0, 0.0))
    b.node("top", (0.0, 0.1))
    b.add(planar.beam, "foot", "top", name="leaf", section=fm.Rigidity(EA=1e6, EIy=0.04, mass=0.07))
    b.fix("foot")
    b.mass("top", 0.1)
    b.force("top", (0.0, -1.0), increment=True)
    for component in ("x", "y", "phi"):
        b.dof("top", component)
    if start is not None:
        b.start("top", "phi", 0.0, velocity=start)
    if more is not None:
        more(b)
    return b.build()


@pytest.mark.slow
def test_a_motion_of_an_imperfect_mechanism_starts_in_its_shape():
    """Nothing acts on it, so that it stays: in the equilibrium without loads, where nothing is stressed."""
    times, still = np.linspace(0.0, 0.1, 11), {"increment": lambda t: 0.0}
    bent = fm.path(leaning(), imperfection={1: 1e-3}).model
    motion = fm.simulate(bent, times, **still)
    # The mode, and what is of second order of it.
    np.testing.assert_allclose(motion.at("top")[:, 0], 1e-3, rtol=1e-3)
    np.testing.assert_allclose(motion.x, fm.equilibrium(bent, increment=0.0).x[None].repeat(11, 0), atol=1e-12)
    np.testing.assert_allclose(motion.observe().elastic, 0.0, atol=1e-15)
    # Start values are counted from there, whichever way it was found.
    for sparse in (False, True):
        moving = fm.path(leaning(start=1.0), imperfection={1: 1e-3}, sparse=sparse).model
        np.testing.assert_allclose(moving.parameters.start[0], bent.parameters.start[0], atol=1e-8)
        np.testing.assert_allclose(moving.parameters.start[1], [0.0, 0.0, 1.0])


@pytest.mark.slow
def test_a_motion_that_would_start_stressed_says_so():
    def driven(b):
        """Something else, which is prescribed."""
        b.node("far", (1.0, 0.0))
        b.node("end", (1.5, 0.0))
        b.add(planar.truss, "far", "end", section=fm.Rigidity(EA=1.0, mass=1.0))
        b.fix("far")
        b.fix("end", "y")
        b.prescribe("end", "x", 0.01)

    for more in (None, driven):
        bent = fm.path(leaning(more=more), imperfection={1: 1e-3}, sparse=True).model
        with pytest.warns(fm.FlexmbWarning, match="starts from the positions of the nodes"):
            fm.simulate(bent, [0.0, 1e-3], increment=lambda t: 0.0)
        given = fm.equilibrium(bent, increment=0.0)
        assert float(given.at("top")[0]) == approx(1e-3, rel=1e-3)
        fm.simulate(bent, [0.0, 1e-3], increment=lambda t: 0.0, initial=given)


@pytest.mark.slow
def test_an_imperfection_is_no_strain_of_what_is_held():
    """Of norms of Euler parameters, by round-off."""
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (0.05 * i, 0.0, 0.0))
    section = fm.Rectangle(0.018, 0.5e-3, fm.Material(E=210e9, G=80e9, rho=7850.0))
    for i in range(2):
        b.add(spatial.beam, f"n{i}", f"n{i + 1}", section=section, y=(0.0, 1.0, 0.0))
    b.fix("n0")
    b.force("n2", (-1.0, 0.0, 0.0))
    bent = bent_by_modes(b.build(), {1: 1e-3})
    strain = np.asarray(bent.parameters.strain)
    assert np.max(np.abs(strain)) > 1e-4
    assert np.all(strain[np.asarray(bent.topology.e.held)] == 0)
