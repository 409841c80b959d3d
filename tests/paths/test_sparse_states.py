"""Questions about states of a path by sparse factors: answers are those about the states of the dense path."""

import dataclasses

import matplotlib as mpl
import numpy as np
import pytest
from cases.tolerances import approx
from paths.test_sparse_path import HALF, arch

import flexmb as fm
from flexmb import planar, spatial

mpl.use("Agg")
STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0)


def strip(check, thickness=1e-3, preload=True):
    """A strip of spectral beams between hinges that is pressed, an input and an output, and its weight."""
    b = fm.Builder()
    for i in range(4):
        b.node(f"n{i}", (0.1 * i, 0.01 * (i % 3 > 0)))
    for i in range(3):
        section = fm.Rectangle(0.01, thickness, STEEL)
        b.add(planar.spectral_beam, f"n{i}", f"n{i + 1}", name=f"b{i}", section=section)
    b.fix("n0", "position")
    b.fix("n3", "position")
    b.force("n1", (0.0, -40.0), increment=preload)
    if preload:
        b.force("n2", (0.5, 2.0))
        b.gravity((0.0, -9.81))
    b.input("n1", "y")
    b.output("n2", "y")
    return b.build(check=check)


@pytest.fixture(scope="module")
def paths():
    """The same path by dense matrices and by sparse factors, short of its limit point."""
    how = {"step": 0.05, "stop": {"load_factor": 0.12}}
    return fm.path(strip(True), sparse=False, **how), fm.path(strip(False), sparse=True, **how)


def about(path, step=-1):
    return {"model": path.model, "at": path, "step": step}


QUESTIONS = {
    "frequencies": lambda of: fm.frequencies(**about(of), count=3),
    "eigenvalues": lambda of: fm.modes(**about(of), count=3).eigenvalues,
    "shapes": lambda of: np.abs(fm.modes(**about(of), count=3).shape("n1", "y")),
    "compliance": lambda of: fm.compliance(of.model, "n1", at=of, step=2),
    "multipliers": lambda of: fm.buckling_loads(**about(of, 1), count=3),
    "stress": lambda of: fm.stress(**about(of)).von_mises,
    "stress at all steps": lambda of: fm.stress(of.model, at=of).maximum,
    "response": lambda of: fm.frequency_response(of.model, [0.0, 30.0, 300.0], at=of, step=-1).response,
    "state space": lambda of: fm.to_statespace(**about(of), modes=3)([1j, 400j]),
    "reactions": lambda of: of.reaction("n0"),
    "forces": lambda of: of.force_needed("n1"),
}


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:The state space of 3")
@pytest.mark.parametrize("question", QUESTIONS)
def test_answers_about_a_state_are_those_of_the_dense_path(paths, question):
    # Both paths end within 1e-12 of each other; modes and buckling are round-off of a condition of 1e6.
    wanted, found = (np.asarray(QUESTIONS[question](of)) for of in paths)
    assert np.max(np.abs(wanted)) > 0
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * np.max(np.abs(wanted)))


@pytest.mark.slow
@pytest.mark.parametrize("text", ["n1.y", "reaction n0.x", "stress", "frequency 2", "stiffness n1.y", "load factor"])
def test_what_is_asked_along_the_path_is_as_along_the_dense_one(paths, text):
    wanted, found = (of.along(text) for of in paths)
    assert found[1:] == wanted[1:]
    np.testing.assert_allclose(found.values, wanted.values, rtol=1e-9, atol=1e-9 * np.max(np.abs(wanted.values)))


@pytest.mark.slow
def test_what_the_path_has_not_is_named(paths):
    dense, sparse = paths
    for ask, match in (
        (lambda: fm.poles(dense.model, at=sparse, step=1), "give `count`, the number of poles wanted"),
        (lambda: fm.compliance(dense.model, "n1", at=sparse), "Choose one by step="),
        (lambda: fm.frequencies(dense.model, at=sparse, step=1), "give `count`"),
        (lambda: fm.frequencies(dense.model, count=2, at=sparse, step=1, sparse=False), "contradicts sparse=False"),
        (lambda: fm.frequencies(arch(), count=2, at=sparse, step=1), "belongs to another model"),
        (lambda: sparse.K0, "has no K0. Use one state"),
        (lambda: sparse.frequencies, "has no frequencies"),
        (lambda: sparse.linearization(time=1.0), "no times"),
        (lambda: sparse.linearization(99), "Number 99 is none of them"),
        (sparse.linearizations, "one state at a time"),
        (sparse.at_critical_points, "no critical points. Follow it further"),
        (dense.at_critical_points, "no critical points. Follow it further"),
        (lambda: sparse.along("multiplier 1"), r"fm\.buckling_loads\(model"),
    ):
        with pytest.raises((TypeError, ValueError, AttributeError, IndexError, KeyError), match=match):
            ask()


@pytest.mark.slow
def test_critical_states_have_the_loads_of_their_points():
    path = fm.path(arch(4, sparse=True), sparse=True, stop={"critical_points": 2})
    at = path.at_critical_points()
    np.testing.assert_array_equal(at.load_factor, [point.load_factor for point in path.critical_points])
    assert len(at.load_factor) == 2


@pytest.mark.slow
def test_pictures_and_critical_states():
    stop = {"critical_points": 2}
    wanted, found = (fm.path(arch(4, sparse=of), sparse=of, stop=stop) for of in (False, True))
    at, own = wanted.at_critical_points(), found.at_critical_points()
    assert len(own.load_factor) == 2
    np.testing.assert_allclose(own.load_factor, at.load_factor, rtol=1e-9)
    # A state between two others is known to half the digits at bifurcations.
    np.testing.assert_allclose(own.sigma, at.sigma, rtol=1e-5, atol=1e-5 * np.max(np.abs(at.sigma)))
    lines = [[line.get_xydata() for line in fm.plot.path(of).lines] for of in (wanted, found)]
    for one, other in zip(*lines, strict=True):
        np.testing.assert_allclose(other, one, atol=1e-6)
    drawn = [fm.plot.frequencies(of, count=2).lines[0].get_ydata() for of in (wanted, found)]
    np.testing.assert_allclose(drawn[1], drawn[0], rtol=1e-6)


def hardening(e, *, ref, k, k3):
    return k * e[0] ** 2 / 2 + k3 * e[0] ** 4 / 4


def elongation(p: fm.Point2, q: fm.Point2, *, ref):
    return planar.truss.deformation(p, q, ref=ref)


def stayed(sparse):
    """An arch that a spring of a law of its own holds back."""
    b = fm.Builder()
    for i in range(5):
        b.node(f"n{i}", (i / 4, 0.1 * np.sin(np.pi * i / 4)))
    for i in range(4):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e4, EIy=1.0, mass=1.0))
    b.node("ground", (0.5, -0.4))
    b.add(fm.Element(elongation, energy=hardening), "ground", "n2", k=20.0, k3=5e4)
    for node in ("n0", "n4", "ground"):
        b.fix(node, "position")
    b.force("n2", (0.0, -160.0))
    return b.build(check=not sparse)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:At load factor 1, these loads")
def test_laws_with_a_potential():
    dense, sparse = (fm.path(stayed(of), sparse=of, stop={"load_factor": 0.3}) for of in (False, True))
    (critical,) = dense.critical_points
    assert sparse.critical_points[0].load_factor == approx(critical.load_factor, rel=1e-9)
    np.testing.assert_allclose(sparse.x, dense.x, atol=1e-10)
    np.testing.assert_allclose(sparse.sigma[1:], dense.sigma[1:], rtol=1e-7, atol=1e-6)
    wanted, found = (fm.buckling_loads(stayed(of), count=4, sparse=of) for of in (False, True))
    np.testing.assert_allclose(found, wanted, rtol=1e-9)


def test_loads_without_a_potential_are_refused_by_name():
    b = fm.Builder()
    b.node("a", (0, 0, 0))
    b.node("b", (1, 0, 0))
    b.add(spatial.beam, "a", "b", section=fm.Rectangle(0.01, 0.01, STEEL), y=(0, 1, 0))
    b.fix("a")
    b.moment("b", (1.0, 0.0, 0.0))
    model = b.build(check=False)
    with pytest.raises(fm.ModelError, match="fixed axes in space and laws of several deformations have none"):
        fm.buckling_loads(model, count=1, sparse=True)


@pytest.mark.slow
@pytest.mark.parametrize("count", [3, 40])
def test_a_square_column_buckles_to_both_sides_at_once(count):
    # Euler; two equal critical values, in motions normal to each other. 18 motions are found one and all, of 240
    # the nearest to zero by Lanczos iterations, from one start.
    b, side, length = fm.Builder(), 2e-3, 0.3
    for i in range(count + 1):
        b.node(f"n{i}", (length * i / count, 0, 0))
    for i in range(count):
        b.add(spatial.beam, f"n{i}", f"n{i + 1}", section=fm.Rectangle(side, side, STEEL), y=(0, 1, 0))
    b.fix("n0")
    euler = np.pi**2 / 4 * STEEL.E * side**4 / 12 / length**2
    b.force(f"n{count}", (-1.5 * euler, 0, 0))
    path = fm.path(b.build(check=False), sparse=True, step=0.2)
    first, second = path.critical_points
    assert first.kind == second.kind == "bifurcation"
    # Cubic beams: 0.01 / count^4 measured; shear and axial strain as the square of thickness over length.
    assert first.load_factor == approx(2 / 3, rel=2e-4)
    assert second.load_factor == approx(first.load_factor, abs=first.uncertainty)
    assert abs(first.phi @ second.phi) < 1e-9 * np.linalg.norm(first.phi) * np.linalg.norm(second.phi)
    assert sorted(set(path.negative.tolist())) == [0, 2]


@pytest.mark.slow
def test_sparse_factors_are_chosen_by_size_and_left_where_they_do_not_serve():
    small, large = arch(4), arch(100, (0.0, -3.0))
    assert large.topology.n_x > 300
    stop = {"load_factor": 0.1}
    assert type(fm.path(small, stop=stop)).__name__ == "Path"
    found = fm.path(large, stop=stop)
    assert type(found).__name__ == "SparsePath"
    wanted = fm.path(large, stop=stop, sparse=False)
    assert type(wanted).__name__ == "Path"
    np.testing.assert_allclose(found.x[-1], wanted.x[-1], atol=1e-10)
    multipliers = fm.buckling_loads(large, count=2)
    np.testing.assert_allclose(multipliers, fm.buckling_loads(large, count=2, sparse=False), rtol=1e-7)


@pytest.mark.slow
def test_a_hanging_body_is_left_to_dense_matrices(monkeypatch):
    b = fm.Builder()
    b.node("ceiling", (0.0, 0.0))
    b.node("bob", (0.0, -1.0))
    b.add(planar.truss, "ceiling", "bob", section=fm.Rigidity(EA=1e3))
    b.fix("ceiling")
    b.force("bob", (0.0, -1.0))
    monkeypatch.setattr("flexmb.paths.path.by_sparse", lambda model, sparse: True)
    path = fm.path(b.build())
    assert type(path).__name__ == "Path"
    # N L / EA.
    assert float(path.at("bob")[-1, 1]) == approx(-1.001, abs=1e-12)


@pytest.mark.slow
def test_multipliers_about_a_state_of_a_held_elongation():
    case = {"beams": 4, "released": (2, 3), "rise": 0.05}
    paths = [fm.path(arch(**case, sparse=of), sparse=of, stop={"load_factor": 0.02}) for of in (False, True)]
    wanted, found = (fm.buckling_loads(path.model, count=2, at=path, step=-1) for path in paths)
    np.testing.assert_allclose(found, wanted, rtol=1e-9)


@pytest.mark.slow
def test_a_path_ends_at_a_stress():
    models = strip(True, preload=False), strip(False, preload=False)
    stop = {"stress": 50e6}
    wanted, found = (fm.path(model, sparse=of, stop=stop) for model, of in zip(models, (False, True), strict=True))
    assert wanted.stopped_by == found.stopped_by == "stress"
    assert float(found.load_factor[-1]) == approx(float(wanted.load_factor[-1]), rel=1e-8)
    with pytest.raises(ValueError, match="but the path begins with"):
        fm.path(strip(False), sparse=True, stop={"stress": 1e3})


@pytest.mark.slow
def test_a_multiplier_has_its_derivative_where_held_and_free_deformations_are_coupled():
    def first(model, load):
        force = model.parameters.loads.force * load
        loads = dataclasses.replace(model.parameters.loads, force=force)
        return fm.Model(model.topology, dataclasses.replace(model.parameters, loads=loads), model.labels)

    import jax

    model = arch(**{**HALF, "load": (0.0, -1.0)}, sparse=True)
    slope = jax.grad(lambda load: fm.buckling_loads(first(model, load), count=1, sparse=True)[0])(1.0)
    h = 1e-3
    ends = [float(fm.buckling_loads(first(model, 1 + s * h), count=1, sparse=True)[0]) for s in (1, -1)]
    # Truncation h^2.
    assert float(slope) == approx((ends[0] - ends[1]) / (2 * h), rel=1e-5)


@pytest.mark.slow
def test_multipliers_of_incremental_loads_about_a_state_that_has_snapped_through():
    # Under the same loads there is an equilibrium that has not.
    case = {"beams": 4, "preload": (0.0, -1.0)}
    paths = [fm.path(arch(**case, sparse=of), sparse=of) for of in (False, True)]
    steps = [int(np.flatnonzero(path.stable & (path.at("n2")[:, 1] < 0))[0]) for path in paths]
    assert steps[0] == steps[1]
    wanted, found = (
        fm.buckling_loads(path.model, count=4, at=path, step=i) for path, i in zip(paths, steps, strict=True)
    )
    np.testing.assert_allclose(found, wanted, rtol=1e-8)


def test_the_error_of_a_state_space_is_not_one_of_a_resonance(paths):
    """Without damping no response is to compare with at a resonance; elsewhere the error is that of dense matrices."""
    for path in paths:
        with pytest.warns(fm.FlexmbWarning, match=r"off by [89]\d % for 'position n2.y' of 'force n1.y' at 2[67]\d"):
            fm.to_statespace(**about(path), modes=3)
