"""Equilibrium paths: limit and bifurcation points, branches, stability (A2, A7) and the derivative of a limit load."""

import functools
import json
import re

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.commands import command
from cases.snapping import BASE, EULER, column, limit_of, load_at, toggle, truss
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.progress import Stopped

# Height of the apex at the limit load: dP/dy = 0 where l^3 = L0 b^2.
HIGHEST = np.sqrt((np.hypot(BASE, 1.0) * BASE**2) ** (2 / 3) - BASE**2)


def test_path_of_the_flat_truss():
    path = fm.path(truss())
    y, load = np.asarray(path.at("apex")[:, 1]), 5 * np.asarray(path.load_factor)
    # Closed form; round-off of the forces of the bars, 1e-16 EA.
    np.testing.assert_allclose(load, load_at(y), atol=1e-9)
    assert path.load_factor[-1] == 1.0
    assert y[-1] < -1
    # Limit points up and down, at y and -y. Half a unit of the last printed digit; then closed form.
    assert [c.kind for c in path.critical_points] == ["limit", "limit"]
    up, down = path.critical_points
    assert 5 * up.load_factor == approx(3.8108719042, abs=5e-11)
    assert 5 * up.load_factor == approx(limit_of(1e4, 1.0), rel=1e-10)
    assert down.load_factor == approx(-up.load_factor, rel=1e-10)
    height = up.x[path.labels.coordinates("apex")[1]]
    # Located to 1e-12 of a step, by the load's rate.
    assert height == approx(HIGHEST, abs=1e-10)
    # Stable outside the limit points alone.
    np.testing.assert_array_equal(path.stable, np.abs(y) > height)
    assert np.all(np.diff(y) < 0)  # no point is visited twice
    np.testing.assert_array_equal(path.eigenvalues[:, 0] > 0, path.stable)
    np.testing.assert_allclose(path.reactions[:, path.labels.coordinates("left")[1]], load / 2, atol=1e-9)


@pytest.mark.slow
def test_derivative_of_a_limit_load():
    """Forward mode; reverse for the beams below."""

    def limit(p):
        return 5 * fm.limit_load(truss(*p))

    at = np.array([1e4, 1.0])
    assert limit(at) == approx(limit_of(*at), rel=1e-12)
    found = jax.jacfwd(limit)(jnp.asarray(at))
    # Central differences of the closed form: truncation and round-off below 1e-9 of the value.
    for k, step in enumerate((1.0, 1e-4)):
        up, down = (limit_of(*(at + s * step * np.eye(2)[k])) for s in (1, -1))
        assert float(found[k]) == approx((up - down) / (2 * step), rel=1e-7)
    with pytest.raises(NotImplementedError, match="no second one"):
        jax.grad(jax.grad(lambda h: limit((1e4, h))))(1.0)
    # The displacement's own derivative has no bound there: dP/dw = 0.
    assert abs(load_at(HIGHEST + 1e-6) - load_at(HIGHEST - 1e-6)) / 2e-6 < 1e-6


@pytest.mark.slow
def test_derivative_of_the_limit_load_of_beams():
    # Bending, rotations and deformations as degrees of freedom; moving the foot breaks the symmetry.
    def limit(p):
        return fm.limit_load(toggle(*p))

    at = np.array([1.0, 1.0, 0.05])
    found = jax.jacrev(limit)(jnp.asarray(at))
    # Central differences: truncation 1e-8, round-off 1e-13 over the step.
    for k, step in enumerate((1e-4, 1e-4, 1e-4)):
        up, down = (limit(jnp.asarray(at + s * step * np.eye(3)[k])) for s in (1, -1))
        assert float(found[k]) == approx(float(up - down) / (2 * step), rel=1e-6)


@pytest.mark.slow
def test_snap_back_under_a_prescribed_displacement():
    # A spring k between the apex and the driven point: travel u = w + P(w)/k, closed form, turns back where
    # P' = -k. The bars alone fall by more than the spring is stiff.
    k, travel = 1.0, 6.0
    b = fm.Builder()
    for name, position in {"left": (-BASE, 0), "right": (BASE, 0), "apex": (0, 1), "drive": (0, 6)}.items():
        b.node(name, position)
    for ends in (("left", "apex"), ("apex", "right")):
        b.add(planar.truss, *ends, section=fm.Rigidity(EA=1e4, mass=1.0))
    b.add(planar.truss, "apex", "drive", section=fm.Rigidity(EA=5 * k, mass=0.1))
    b.fix("left")
    b.fix("right")
    b.fix("apex", "x")
    b.fix("drive", "x")
    b.prescribe("drive", "y", -travel)
    path = fm.path(b.build())
    y = np.asarray(path.at("apex")[:, 1])

    def driven(y):
        return 1 - y + load_at(y) / k

    # Round-off of the forces of the bars, 1e-16 EA over k.
    np.testing.assert_allclose(travel * path.load_factor, driven(y), atol=1e-9)
    # du/dy = 0 where b^2/l^3 = 1/L0 + k/2EA.
    height = np.sqrt((BASE**2 / (1 / np.hypot(BASE, 1.0) + k / 2e4)) ** (2 / 3) - BASE**2)
    assert [c.kind for c in path.critical_points] == ["limit", "limit"]
    assert travel * path.critical_points[0].load_factor == approx(driven(height), rel=1e-10)
    assert path.load_factor[-1] == 1.0


@pytest.mark.slow
def test_steep_truss_goes_sideways_first():
    # Lateral stiffness 2 EA/(L0 l^2) (b^2 + (1 - L0/l) y^2) = 0 with y^2 = l^2 - b^2: l^3 - L0 l^2 + L0 b^2 = 0. The
    # larger root comes first on the way down, the smaller one after the limit point l^3 = L0 b^2. Half that way down
    # the apex passes the base and all comes again with the other sign.
    slope, base = 4.0, 1.0
    l0 = np.hypot(base, slope)
    roots = np.sort(np.roots([1, -l0, 0, l0 * base**2]).real)[1:]
    first, late = (load_at(np.sqrt(length**2 - base**2), 1.0, slope, base) for length in roots[::-1])
    top = load_at(np.sqrt((l0 * base**2) ** (2 / 3) - base**2), 1.0, slope, base)
    path = fm.path(truss(1.0, slope, base, load=1.0, sideways=True))
    assert [c.kind for c in path.critical_points] == [
        "bifurcation",
        "limit",
        *["bifurcation"] * 2,
        "limit",
        "bifurcation",
    ]
    loads = [c.load_factor for c in path.critical_points]
    # Closed form. Beside a bifurcation the corrector is singular; the zero between states 1e-6 apart is off by its
    # square.
    expected = np.array([first, top, late, -late, -top, -first])
    np.testing.assert_allclose(loads, expected, rtol=1e-10)
    uncertainties = [c.uncertainty for c in path.critical_points]
    assert np.all(np.abs(loads - expected) <= np.array(uncertainties) + 1e-12)
    assert max(uncertainties) < 1e-6
    y = np.asarray(path.at("apex")[:, 1])
    np.testing.assert_array_equal(path.stable, np.abs(y) > np.sqrt(roots[-1] ** 2 - base**2))
    sideways = path.critical_points[0].phi[np.array(path.labels.coordinates("apex"))]
    # Round-off has left the symmetric path by 1e-16 over the distance to the point, which is located to 1e-10.
    np.testing.assert_allclose(sideways / np.max(np.abs(sideways)), [1, 0], atol=1e-6)


@pytest.mark.slow
def test_euler_column():
    path = fm.path(column(8, 1.3 * EULER))
    (found,) = path.critical_points
    assert found.kind == "bifurcation"
    # Cubic beams overestimate by O(n^-4): 5.1e-4 with 4, 16 times less with 8; strain of the column 1e-8.
    assert 1.3 * found.load_factor - 1 == approx(5.1e-4 / 16, rel=0.1)
    # Straight to the end, and said to be unstable there.
    for i in range(9):
        np.testing.assert_allclose(path.at(str(i))[:, 1], 0, atol=1e-9)
    np.testing.assert_array_equal(path.stable, path.load_factor < found.load_factor)
    np.testing.assert_array_equal(path.frequencies[:, 0] > 0, path.stable)
    # Linear buckling about every stable state foretells it: multipliers are counted from the load at the step.
    foretold = np.asarray(path.load_factor * path.multipliers[:, 0])[1:]
    np.testing.assert_allclose(foretold, found.load_factor, rtol=1e-6)


@pytest.mark.slow
def test_post_buckling_by_both_branches():
    # A2, tip angle 40 degrees, closed form: half the column is the cantilever.
    ratio, shortened, lateral = 1.0636632664, 0.8812035117, 0.4222403401
    up, down = (fm.path(column(8, ratio * EULER), switch=sign) for sign in (1, -1))
    assert up.load_factor[-1] == 1.0
    assert up.stable[-1]
    end = np.array([up.at("8")[-1, 0] / 2, up.at("4")[-1, 1]])
    mirrored = np.array([down.at("8")[-1, 0] / 2, -down.at("4")[-1, 1]])
    # Both end at factor 1 by the same equations: round-off times EA/EI.
    np.testing.assert_allclose(mirrored, end, rtol=1e-7)
    assert end[1] > 0
    # Of order two under any large bending: a halving divides the errors by 5.2 and 4.7 here, the next by 4.2 and 4.1.
    np.testing.assert_allclose(end, [shortened, lateral], rtol=0.2)


@pytest.mark.slow
def test_no_jump_past_a_nearby_branch():
    # A bow of 1e-4: the path bends away just below the critical load and passes no critical point; the straight,
    # unstable branch is a millimetre away.
    path = fm.path(column(8, 1.3 * EULER, bow=1e-4))
    assert path.critical_points == ()
    assert np.all(path.stable)
    deflection = np.asarray(path.at("4")[:, 1])
    assert np.all(np.diff(deflection) > 0)
    assert deflection[-1] > 0.5


@pytest.mark.slow
def test_preload_and_increment_are_told_apart():
    other = fm.path(column(8, 2.6, preload=0.4))
    path = fm.path(column(8, 2.0, preload=1.0))
    # The same total load, Euler's of eight cubic beams: located to 1e-10.
    whole = 1.0 + 2.0 * path.critical_points[0].load_factor
    assert 0.4 + 2.6 * other.critical_points[0].load_factor == approx(whole, rel=1e-10)
    assert whole / EULER - 1 == approx(5.1e-4 / 16, rel=0.1)
    # Multipliers are of what more of the increment; strain of the column 1e-8.
    foretold = path.load_factor[path.stable] + path.multipliers[path.stable, 0]
    np.testing.assert_allclose(foretold, path.critical_points[0].load_factor, rtol=1e-6)


def cantilever(force=(0.0, 0.0), moment=0.0, beams=4):
    section = fm.Rigidity(EA=1e6, EIy=1.0, mass=1.0)
    b = fm.Builder()
    for i in range(beams + 1):
        b.node(str(i), (i / beams, 0))
    for i in range(beams):
        b.add(planar.beam, str(i), str(i + 1), section=section)
    b.fix("0")
    b.force(str(beams), force)
    b.moment(str(beams), moment)
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize("load", [{"force": (0.0, 3.0)}, {"moment": 1.5}])
def test_path_without_critical_points_ends_at_the_equilibrium(load):
    model = cantilever(**load)
    path, equilibrium = fm.path(model), fm.equilibrium(model)
    assert path.critical_points == ()
    assert np.all(path.stable)
    assert np.max(np.diff(path.load_factor)) <= 0.125  # the last step a little longer than the others
    # Round-off of x times EA.
    np.testing.assert_allclose(path.x[-1], equilibrium.x, atol=1e-12)
    np.testing.assert_allclose(path.sigma[-1], equilibrium.sigma, atol=1e-8)
    np.testing.assert_allclose(path.reactions[-1], equilibrium.reactions, atol=1e-8)
    lin, last = fm.linearize(model), path.linearization()
    for name in ("M0", "K0", "G0", "DFx"):
        expected = np.asarray(getattr(lin, name))
        np.testing.assert_allclose(getattr(last, name), expected, atol=1e-9 * np.max(np.abs(expected)))


@pytest.mark.slow
def test_hanging_body_gains_stiffness_with_its_load():
    # A rigid pendulum has none without load: omega^2 = P/(m a), closed form, also at the first state.
    b = fm.Builder()
    b.node("joint", (0, 0))
    b.node("body", (0, -2.0))
    b.add(planar.rigid_beam, "joint", "body")
    b.fix("joint", "x", "y")
    b.mass("body", 3.0)
    b.dof("joint", "phi")
    b.force("body", (0, -12.0))
    path = fm.path(b.build())
    np.testing.assert_allclose(path.eigenvalues[:, 0], 12.0 * path.load_factor / (3.0 * 2.0), atol=1e-12)
    assert path.load_factor[-1] == 1.0


def strut(axial, moment):
    """Spatial cantilever with a moment about a fixed axis: no potential, no symmetric stiffness."""
    section = fm.Rigidity(EA=1e6, EIy=1.0, EIz=100.0, GIt=1.0, mass=1.0, Jx=0.1)
    b = fm.Builder()
    for i in range(3):
        b.node(str(i), (i / 2, 0, 0))
    for i in range(2):
        b.add(spatial.beam, str(i), str(i + 1), section=section, y=(0, 1, 0))
    b.fix("0")
    b.force("2", (-axial, 0, 0))
    b.moment("2", (0, 0, moment))
    return b.build()


@pytest.mark.slow
def test_stability_without_a_potential():
    # Divergence by the sign of the determinant: weak axis, pi^2 EI/4; 2 cubic beams, 5.1e-4 as the column with 4.
    path = fm.path(strut(1.2 * EULER, 0.0))
    assert [c.kind for c in path.critical_points] == ["bifurcation"]
    assert 1.2 * path.critical_points[0].load_factor - 1 == approx(5.1e-4, rel=0.1)
    np.testing.assert_array_equal(path.stable, path.load_factor < path.critical_points[0].load_factor)
    # Flutter: a pair of eigenvalues of (K, M) turns complex, which no determinant tells.
    path = fm.path(strut(0.0, 4.0))
    assert path.critical_points == ()
    values = [np.linalg.eigvals(np.linalg.solve(m, k)) for k, m in zip(path.K, path.M0, strict=True)]
    # Real to round-off times the spread of the eigenvalues.
    real = [bool(np.all(v.real > 0) and np.all(np.abs(v.imag) < 1e-6 * np.abs(v))) for v in values]
    assert path.stable[0]
    assert not path.stable[-1]
    np.testing.assert_array_equal(path.stable, real)


def cosine_beam(arcs, order, *, half=False, height=5e-3, load=300.0, thickness=0.5e-3):
    """Clamped beam, a period of a cosine 100 mm long, its middle guided; or its left half under half of the load."""
    x = np.linspace(0, 0.1, arcs + 1)
    y, slope = height / 2 * (1 - np.cos(20 * np.pi * x)), np.arctan(10 * np.pi * height * np.sin(20 * np.pi * x))
    chords, turns = np.hypot(np.diff(x), np.diff(y)), np.diff(slope)
    section = fm.Rectangle(0.01, thickness, fm.Material(E=210e9, G=80e9, rho=7850.0))
    b = fm.Builder()
    middle = arcs // 2
    for i in range(middle + 1 if half else arcs + 1):
        b.node(str(i), (x[i], y[i]))
    for i in range(middle if half else arcs):
        curvature = 2 * np.sin(turns[i] / 2) / chords[i]
        b.add(planar.spectral_beam(order), str(i), str(i + 1), section=section, curvature=curvature)
    for end in (0,) if half else (0, arcs):
        b.fix(str(end))
    b.fix(str(middle), "x", "phi")
    b.force(str(middle), (0, -load / 2 if half else -load))
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize(("height", "load"), [(5e-3, 300.0), (8e-3, 300.0)])
def test_a_cosine_beam_passes_all_its_bifurcations(height, load):
    """Beside some of them the corrector finds no state for a long way; half of the beam, of higher order, tells them.

    Of the whole beam a bifurcation of the half is one of both halves at once; others, which leave the middle at its
    place, are none of the half's.
    """
    path = fm.path(cosine_beam(8, 4, height=height, load=load), step=0.05)
    half = fm.path(cosine_beam(8, 6, half=True, height=height, load=load), step=0.05)
    assert path.load_factor[-1] == half.load_factor[-1] == 1.0
    limits, expected = ([c.load_factor for c in p.critical_points if c.kind == "limit"] for p in (path, half))
    # Eight arcs of order four stand for a beam that snaps to four times its height: up to 1.5e-3 off here, order six
    # against seven 1e-5.
    np.testing.assert_allclose(limits, expected, rtol=5e-3)
    found = np.array([c.load_factor for c in path.critical_points if c.kind == "bifurcation"])
    for c in half.critical_points:
        if c.kind == "bifurcation":
            assert np.sum(np.isclose(found, c.load_factor, rtol=5e-3, atol=0)) == 2
    assert all(c.uncertainty < 1e-5 for c in path.critical_points)
    # The feet and the guide carry the load in every state; round-off of elongations, 1e-14 of them, times EA.
    reactions = np.asarray(path.reactions)
    across = [path.labels.coordinates(node)[1] for node in ("0", "8")]
    np.testing.assert_allclose(np.sum(reactions[:, across], axis=1), load * path.load_factor, atol=1e-5 * load)
    # No state is far from the last: nothing was stepped over.
    middle = np.asarray(path.at("4")[:, 1])
    assert np.max(np.abs(np.diff(middle))) < 0.25 * height


def shallow_cosine_arch(thrust, ratio):
    """Load and displacement of a shallow clamped cosine arch at a thrust, closed form (A7-bistable).

    Thrust as N = sqrt(P L^2/EI), load over EI h/L^3, displacement over h, ratio h/t. W' = A cos(2 pi s) + F/(2 N^2) (1
    - cos(N s)/cos(N/4)), s from the quarter point; N^2 = 12 ratio^2 times the length that the arch has lost.
    """
    s, weights = np.polynomial.legendre.leggauss(40)
    s, weights = s / 4, weights / 4
    before, of_load = np.pi * np.cos(2 * np.pi * s), (1 - np.cos(thrust * s) / np.cos(thrust / 4)) / (2 * thrust**2)
    of_thrust = before * 4 * np.pi**2 / (4 * np.pi**2 - thrust**2)
    lost = np.array([-weights @ of_load**2, -2 * weights @ (of_load * of_thrust), weights @ (before**2 - of_thrust**2)])
    loads = np.roots(lost - [0, 0, thrust**2 / (12 * ratio**2)])
    return sorted((load, 1 - weights @ (of_thrust + load * of_load)) for load in loads)[::-1]


@pytest.mark.slow
def test_a_bistable_beam_snaps_by_its_third_mode():
    """A7-bistable: the beam of Qiu, Lang and Slocum, its second mode suppressed; h/t = 10 gives what they print."""
    height, thickness, most = 2e-3, 0.2e-3, 900.0
    unit = 210e9 * 0.01 * thickness**3 / 12 * height / 0.1**3
    model = cosine_beam(8, 6, half=True, height=height, load=most * unit, thickness=thickness)
    # Leaves for the third mode, and comes back from it to the straight state upside down, which follows the load.
    path = fm.path(model, switch={1: 1, 2: 1}, stop={"4.y": -2 * height})
    assert path.stopped_by == "4.y"
    assert [c.kind for c in path.critical_points] == ["bifurcation"] * 2
    index = path.labels.coordinates("4")[1]
    found = np.array([(most * c.load_factor, 1 - c.x[index] / height) for c in path.critical_points])
    # To what is printed: a unit of the last digit but for zeros.
    assert np.all(np.abs(found - [[740, 0.16], [-370, 1.92]]) < [10, 0.01])
    # The shallow arch leaves out squares of the slope, 0.06^2; eight arcs are 1e-3 off.
    expected = np.array(shallow_cosine_arch(4 * np.pi, 10.0))
    np.testing.assert_allclose(found, expected, rtol=4e-3)


@pytest.mark.slow
def test_two_bifurcations_at_once():
    """Two steep trusses side by side: a branch leaves along one of them, or along both, but not along any sum."""
    section = fm.Rigidity(EA=1.0, mass=1.0)
    b = fm.Builder()
    for k in (0, 10):
        for name, position in {"left": (k - 1, 0), "right": (k + 1, 0), "apex": (k, 4)}.items():
            b.node(f"{name} {k}", position)
        b.add(planar.truss, f"left {k}", f"apex {k}", section=section)
        b.add(planar.truss, f"apex {k}", f"right {k}", section=section)
        b.fix(f"left {k}")
        b.fix(f"right {k}")
        b.dof(f"apex {k}", "x", "y")
        b.force(f"apex {k}", (0, -0.3))
    model = b.build()
    one, other = fm.path(model, max_steps=20, throw=False).critical_points[:2]
    assert one.load_factor == approx(other.load_factor, abs=2e-6)
    # Both motions are told.
    assert abs(one.phi @ other.phi) < 1e-2 * np.linalg.norm(one.phi) * np.linalg.norm(other.phi)
    with pytest.raises(fm.AnalysisError, match="came back") as caught:
        fm.path(model, switch=1)
    aside = np.asarray(caught.value.path.x[:, [model.labels.coordinates(f"apex {k}")[0] for k in (0, 10)]]) - [0, 10]
    steepest = np.abs(aside[np.argmax(np.abs(aside[:, 0]))])
    assert steepest[0] > 1
    assert steepest[1] == approx(steepest[0], rel=1e-6) or steepest[1] < 1e-6


@pytest.mark.slow
def test_a_closed_branch_ends_where_it_began():
    # The sideways branch joins the two bifurcations at P and -P (closed form above) and comes back on the other side.
    l0 = np.hypot(1.0, 4.0)
    length = np.max(np.roots([1, -l0, 0, l0]).real)
    first = load_at(np.sqrt(length**2 - 1), 1.0, 4.0, 1.0)
    with pytest.raises(fm.AnalysisError, match="came back") as caught:
        fm.path(truss(1.0, 4.0, 1.0, load=1.0, sideways=True), switch=1)
    path = caught.value.path
    assert caught.value.code == fm.RESULTS(int(path.result)).name == "closed_path"
    assert [c.kind for c in path.critical_points] == ["bifurcation"] * 3
    np.testing.assert_allclose([c.load_factor for c in path.critical_points], [first, -first, first], rtol=1e-9)
    # It ends in a state that it has; no other comes twice.
    x = np.asarray(path.x)
    apart = np.max(np.abs(x[:, None] - x), axis=2) + np.abs(path.load_factor[:, None] - path.load_factor)
    again = np.argwhere(np.triu(apart < 1e-6, 1))
    assert again.tolist() == [[again[0][0], len(x) - 1]]
    apex = np.asarray(path.at("apex"))
    assert np.min(apex[:, 0]) == approx(-np.max(apex[:, 0]), rel=0.1)


@pytest.mark.slow
def test_a_closed_branch_points_to_an_imperfection():
    """A steep truss leaves sideways and comes back; bent by what the error says, it snaps through."""
    model = truss(1.0, 4.0, 1.0, load=1.0, sideways=True)
    words = r"came back .* bifurcation 1 by `switch`\. Give imperfection=\{1: ([\d.]+)\} \[m\] .*=\{1: 1, 2: 1\}"
    with pytest.raises(fm.AnalysisError, match=words) as caught:
        fm.path(model, switch=1)
    assert "imperfection" in fm.RESULTS.closed_path.message
    size = float(re.findall(words, str(caught.value))[0])
    for path in (fm.path(model, imperfection={1: size}), fm.path(model, switch={1: 1, 2: 1})):
        assert path.load_factor[-1] == approx(1.0, rel=1e-12)
        assert path.stable[-1]
        assert path.at("apex")[-1, 1] < -4
    # Who follows no branch, or is bent already, is told of neither.
    for given in ({}, {"imperfection": {1: size}}):
        with pytest.raises(fm.AnalysisError, match="did not reach its end") as caught:
            fm.path(model, max_steps=5, **given)
        assert "imperfection" not in str(caught.value)


@pytest.mark.slow
def test_no_jump_to_a_branch_that_ends_in_a_fold():
    """A tower of trusses: beside the branch lies another, which a long step reaches; its fold is no critical point."""
    section = fm.Rigidity(EA=1e4, mass=1.0)
    b = fm.Builder()
    for i in range(5):
        b.node(f"l{i}", (0, i))
        b.node(f"r{i}", (0.5, i))
    for i in range(4):
        for ends in (("l", "l"), ("r", "r"), ("l", "r"), ("r", "l")):
            b.add(planar.truss, f"{ends[0]}{i}", f"{ends[1]}{i + 1}", section=section)
        b.add(planar.truss, f"l{i + 1}", f"r{i + 1}", section=section)
    b.fix("l0")
    b.fix("r0")
    for top in ("l4", "r4"):
        b.force(top, (0, -1000.0))
    paths = [fm.path(b.build(), switch=1, step=step, throw=False) for step in (0.1, 0.03)]
    for path in paths:
        # It comes back the way it went, mirrored, whatever the steps: by symmetry.
        assert fm.RESULTS(int(path.result)) == fm.RESULTS.closed_path
        kinds, loads = [c.kind for c in path.critical_points], [c.load_factor for c in path.critical_points]
        assert kinds == ["bifurcation", "limit", "limit", "bifurcation", "limit", "limit", "bifurcation"]
        np.testing.assert_allclose(loads, loads[::-1], rtol=1e-6)
        np.testing.assert_allclose(loads, [c.load_factor for c in paths[0].critical_points], rtol=1e-6)


def round_bar(turn):
    """A column that buckles to any side at once; its local axes are turned about it."""
    b = fm.Builder()
    b.node("base", (0, 0, 0))
    b.node("tip", (0, 0, 1.0))
    section = fm.Rigidity(EA=1e6, EIy=4 / np.pi**2, EIz=4 / np.pi**2, GIt=0.3)
    y = (-np.sin(turn), np.cos(turn), 0)
    b.add(spatial.spectral_beam(order=4), "base", "tip", section=section, y=y)
    b.fix("base")
    b.force("tip", (0, 0, -1.1))
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize("sparse", [False, True])
def test_a_branch_of_a_round_bar_that_may_turn_is_told(sparse):
    """It buckles to any side at once, pi^2 EI/(4 L^2): where a branch goes is said by an imperfection alone."""
    model = round_bar(0.0)
    with pytest.raises(fm.AnalysisError, match="may buckle to any side") as caught:
        fm.path(model, switch=1, sparse=sparse)
    assert caught.value.code == "neutral_branch"
    found = caught.value.path
    # That of the extensible column, by EI pi^2/(4 L^2)/EA.
    assert [point.load_factor for point in found.critical_points] == [approx(1 / 1.1, rel=3e-6)]
    assert np.all(found.stable)
    bent = fm.path(model, imperfection={1: 1e-6}, sparse=sparse)
    assert bent.critical_points == ()


@pytest.mark.slow
def test_a_round_bar_is_neutral_whatever_the_round_off():
    """Turned about its axis the column is the same, and its numbers are rounded in another way."""
    for turn in np.linspace(0.0, 3.0, 13):
        with pytest.raises(fm.AnalysisError, match="may buckle to any side"):
            fm.path(round_bar(turn), switch=1)


@pytest.mark.slow
def test_ends_that_are_refused_by_name():
    with pytest.raises(fm.AnalysisError, match="max_steps") as caught:
        fm.path(truss(), max_steps=5)
    path = fm.path(truss(), max_steps=5, throw=False)
    assert fm.RESULTS(int(path.result)) == fm.RESULTS.max_steps
    assert path.x.shape[0] == 6
    # What was found is not lost.
    np.testing.assert_array_equal(caught.value.path.x, path.x)
    assert fm.AnalysisError("max_steps", "").path is None
    # A truss in tension alone has no limit point.
    with pytest.raises(fm.AnalysisError, match="max_steps"):
        fm.limit_load(truss(load=-5.0), max_steps=20)
    assert np.isnan(fm.limit_load(truss(load=-5.0), max_steps=20, throw=False))
    with pytest.raises(TypeError, match="concrete"):
        jax.grad(lambda h: fm.path(truss(height=h)).load_factor[-1])(1.0)
    with pytest.raises(ValueError, match="positive"):
        fm.path(truss(), max_steps=0)
    with pytest.raises(KeyError, match="nowhere"):
        path.at("nowhere")


@pytest.mark.slow
def test_nothing_is_compiled_twice(compilations):
    models = column(8, 1.1 * EULER, bow=1e-3), column(8, 1.1 * EULER), column(3, 0.5 * EULER)
    fm.path(column(8, 1.05 * EULER), switch=1)
    compilations.clear()
    fm.path(models[0], max_steps=100)
    fm.path(models[1], step=0.2)
    assert not compilations
    fm.path(models[2])
    # Its steps, by which it begins too, and what is told about them, once each; there is no critical point.
    assert len(compilations) == 2


FLAT = """
PLTRUSS 1 1 2
PLTRUSS 2 2 3
X 1 -10 0
X 2 0 1
X 3 10 0
FIX 1
FIX 3
FIX 2 1
RLSE 1 1
RLSE 2 1
DYNX 2 2
END
HALT

XM 2 1
ESTIFF 1 1e4
ESTIFF 2 1e4
XF 2 0 -5
END
END
"""
STEP = {"load_factor", "x", "stable", "eigenvalues", "frequencies_hz", "load_multipliers", "e", "sig", "reactions"}
STEP |= {"m0", "c0", "d0", "k0", "n0", "g0", "compliance"}


@pytest.mark.slow
def test_command_line(tmp_path):
    model = tmp_path / "flat.dat"
    model.write_text(FLAT)
    saved = tmp_path / "flat.npz"
    result = command("run", model, "--mode", 10, "--json", "-", "--save", saved)
    assert result.exit_code == 0
    data = json.loads(result.stdout)
    assert (data["status"], data["mode"], data["stable"]) == ("ok", 10, True)
    assert [c["kind"] for c in data["critical_points"]] == ["limit", "limit"]
    assert 5 * data["critical_points"][0]["load_factor"] == approx(3.8108719042, abs=5e-11)
    assert all(set(step) >= STEP for step in data["path"])
    first, last = data["path"][0], data["path"][-1]
    assert (first["load_factor"], last["load_factor"]) == (0.0, 1.0)
    assert data["x"] == last["x"]
    assert data["sig"] == last["sig"]
    assert data["reactions"]["1"][1] == approx(2.5, abs=1e-9)
    unstable = [step for step in data["path"] if not step["stable"]]
    assert unstable
    assert all(step["frequencies_hz"] == [None] for step in unstable)
    # Deflection under a unit force: 1/K.
    assert first["compliance"]["2"][1] == approx(1 / first["k0"][0][0], rel=1e-12)
    with np.load(saved) as arrays:
        np.testing.assert_array_equal(arrays["path_x_2"], [step["x"]["2"] for step in data["path"]])

    table = command("run", model, "--analysis", "path", "--max-steps", 5)
    assert table.exit_code == 1
    assert "status max_steps" in table.stdout
    assert "path (6 states)" in table.stdout


@pytest.mark.slow
def test_a_path_tells_how_far_it_is_and_keeps_what_it_has_when_it_is_stopped():
    told = []

    def five(states, load):
        if states > 5:
            raise Stopped

    whole = fm.path(truss(), progress=lambda *now: told.append(now))
    # A step that is tried again, shorter, is told again.
    states, loads = np.array(told).T
    np.testing.assert_array_equal(loads, whole.load_factor[states.astype(int) - 1])
    assert set(np.diff(states)) == {0, 1}
    part = fm.path(truss(), progress=five)
    assert (int(part.result), len(part.x)) == (fm.RESULTS.stopped, 6)
    np.testing.assert_array_equal(part.x, whole.x[:6])


def loose(what):
    """An arm with a load at its end, of which nothing holds one motion, and its name."""
    b = fm.Builder()
    b.node("A", (0.0, 0.0))
    b.node("B", (0.1, 0.0))
    b.add(planar.beam, "A", "B", name="arm", section=fm.Rigidity(EA=1e5, EIy=1.0, mass=0.1))
    b.force("B", (0.0, 1.0))
    if what.startswith("a node"):
        b.fix("A")
        b.node("C", (0.1, 0.05))
    else:
        b.fix("A", "x", "y")
    return b.build(), "C.x" if what.startswith("a node") else "A.rotation.phi"


@pytest.mark.slow(
    "a node that nothing joins-ask2",
    "a node that nothing joins-equilibrium",
    "a node that nothing joins-path",
    "a rotation that is not clamped-ask2",
    "a rotation that is not clamped-path",
)
@pytest.mark.parametrize("ask", [fm.equilibrium, fm.path, functools.partial(fm.path, sparse=True)])
@pytest.mark.parametrize("what", ["a rotation that is not clamped", "a node that nothing joins"])
def test_what_nothing_elastic_resists_is_named(what, ask):
    model, name = loose(what)
    with pytest.raises(fm.AnalysisError, match=f"nothing elastic resists .*{name}") as info:
        ask(model)
    assert info.value.code == "singular_stiffness"
    if ask is fm.path:
        # Round-off may tell it as the other.
        ends = fm.RESULTS.singular_stiffness, fm.RESULTS.not_converged, fm.RESULTS.max_steps
        assert fm.path(model, throw=False).result in ends


@pytest.mark.slow
@pytest.mark.parametrize("what", ["a rotation that is not clamped", "a node that nothing joins"])
def test_a_limit_load_of_what_nothing_elastic_resists_is_refused_by_its_name(what):
    model, name = loose(what)
    with pytest.raises(fm.AnalysisError, match=f"nothing elastic resists .*{name}") as info:
        fm.limit_load(model)
    assert info.value.code == "singular_stiffness"


@pytest.mark.slow
@pytest.mark.parametrize("sparse", [False, True])
def test_damping_takes_stability_of_a_load_that_follows(sparse):
    """Ziegler's column (1952): bars of one length, masses 2 and 1, hinges of stiffness 1 and one small damping.

    Without damping it flutters from P l = 7/2 - sqrt(2) = 2.086, with from 41/28 = 1.464, to the square of the damping
    over two.
    """

    def stable(damping):
        b = fm.Builder()
        for i, name in enumerate(("foot", "knee", "tip")):
            b.node(name, (float(i), 0.0))
        b.rotation("lower")
        b.add(planar.rigid_beam, "foot", "lower", "knee")
        b.add(planar.rigid_body, "knee", "tip")
        for p, q in (("foot.rotation", "lower"), ("lower", "knee.rotation")):
            b.add(planar.hinge, p, q, stiffness=1.0, damping=damping)
        b.mass("knee", 2.0)
        b.mass("tip", 1.0)
        b.fix("foot")
        b.force("tip", (-2.5, 0.0), follower=True)
        path = fm.path(b.build(check=not sparse), step=0.1, sparse=sparse)
        return 2.5 * np.asarray(path.load_factor), np.asarray(path.stable)

    for damping, limit in ((0.0, 3.5 - np.sqrt(2)), (1e-3, 41 / 28)):
        load, rests = stable(damping)
        np.testing.assert_array_equal(rests, load < limit)
        assert np.any((41 / 28 < load) & (load < 3.5 - np.sqrt(2)))
