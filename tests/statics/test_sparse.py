"""The sparse path: answers and derivatives of the dense one, and closed forms where that one does not reach."""

import threading

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.sparse
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.math import element_matrices
from flexmb.math.sparse import SparseFactors, on_host_thread
from flexmb.statics.sparse import _traced_answer

STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0)


def arm(thickness=1e-3):
    """A right-angled arm in space under its own weight.

    With a rigid middle, an elongation FIXED, a side branch, its tip prescribed in one direction.
    """
    section = fm.Rectangle(0.01, thickness, STEEL)
    b = fm.Builder()
    for name, place in {
        "a": (0, 0, 0),
        "b": (0.1, 0, 0),
        "c": (0.1, 0.03, 0),
        "d": (0.1, 0.1, 0.02),
        "e": (0.15, 0, 0),
    }.items():
        b.node(name, place)
    b.add(spatial.beam, "a", "b", section=section, y=(0, 1, 0), released=(2, 3, 4, 5, 6))
    b.add(spatial.beam, "b", "c", y=(0, 0, 1))
    b.add(spatial.beam, "c", "d", section=section, y=(0, 0, 1))
    b.add(spatial.beam, "b", "e", section=section, y=(0, 0, 1))
    b.fix("a")
    b.fix("e")
    b.mass("d", 0.02)
    b.gravity((0, 0.5, -9.81))
    b.prescribe("d", "z", 0.002)
    b.force("d", (0.3, 0.0, 0.0))
    return b


@pytest.mark.slow
def test_answers_are_those_of_the_dense_path():
    dense, sparse = arm().build(), arm().build(check=False)
    one, other = fm.equilibrium(dense), fm.equilibrium(sparse, sparse=True)
    # Both iterate to 1e-9 of the extent, beyond which the error is its square.
    for name in ("x", "e", "reactions"):
        exact = np.asarray(getattr(one, name))
        np.testing.assert_allclose(getattr(other, name), exact, atol=1e-9 * max(np.max(np.abs(exact)), 1e-3))
    np.testing.assert_allclose(other.sigma[: one.sigma.shape[0]], one.sigma, atol=1e-8 * np.max(np.abs(one.sigma)))
    found = fm.frequencies(sparse, count=3, sparse=True)
    np.testing.assert_allclose(found, fm.frequencies(dense)[:3], rtol=1e-8)


@pytest.mark.slow
def test_derivatives_are_those_of_central_differences():
    start = 1e-3

    def tip(thickness):
        found = fm.equilibrium(arm(thickness).build(check=False), sparse=True)
        return found.at("d")[0]

    def first(thickness):
        return fm.frequencies(arm(thickness).build(check=False), count=2, sparse=True)[0]

    h = 1e-4 * start
    for function, derivative in ((tip, jax.grad), (first, jax.jacfwd)):
        difference = (float(function(start + h)) - float(function(start - h))) / (2 * h)
        # Truncation h^2, round-off 1e-10 over h.
        assert float(derivative(function)(start)) == approx(difference, rel=1e-6)


@pytest.mark.slow
def test_a_thousand_beams_against_the_closed_form():
    section = fm.Rigidity(EA=1e6, EIy=20.0, mass=0.4)
    b = fm.Builder()
    count, length = 1000, 1.0
    for i in range(count + 1):
        b.node(f"n{i}", (length * i / count, 0))
    for i in range(count):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=section)
    b.fix("n0")
    model = b.build(check=False)
    wave = np.sqrt(20.0 / 0.4) / (2 * np.pi)
    # Roots of cos(z) cosh(z) = -1; round-off of the stiffness of a short beam, EA/EI beside 1/L^4.
    exact = np.array([1.8751040687119611, 4.694091132974174, 7.854757438237613]) ** 2 * wave
    np.testing.assert_allclose(fm.frequencies(model, count=3, sparse=True), exact, rtol=1e-5)


@pytest.mark.slow
def test_a_load_beyond_one_step():
    """The dense path's answer where load steps are needed: a strip bent to some forty degrees."""
    section = fm.Rectangle(0.018, 5e-4, STEEL)
    b = fm.Builder()
    for i in range(9):
        b.node(f"n{i}", (0.0125 * i, 0))
    for i in range(8):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=section)
    b.fix("n0")
    b.force("n8", (0, 8.0))
    dense, sparse = fm.equilibrium(b.build()), fm.equilibrium(b.build(check=False), sparse=True)
    np.testing.assert_allclose(sparse.x, dense.x, atol=1e-10)


@pytest.mark.slow
def test_what_is_refused():
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("b", (1, 0))
    b.add(planar.beam, "a", "b", section=fm.Rectangle(0.01, 0.001, STEEL))
    b.fix("a", "x", "y")
    b.force("b", (0, 1.0))
    with pytest.raises(fm.AnalysisError, match="a motion has no stiffness"):
        fm.equilibrium(b.build(check=False), sparse=True)
    with pytest.raises(ValueError, match="`count`"):
        fm.frequencies(arm().build(check=False), sparse=True)


@pytest.mark.slow
def test_a_rigid_motion_has_no_frequency():
    b = fm.Builder()
    for i in range(4):
        b.node(f"n{i}", (0.1 * i, 0))
    for i in range(3):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rectangle(0.01, 0.001, STEEL))
    b.fix("n0", "x", "y")
    found = fm.frequencies(b.build(check=False), count=2, sparse=True)
    dense = fm.frequencies(b.build())
    assert abs(float(found[0])) < 1e-3 * float(dense[1])
    assert float(found[1]) == approx(float(dense[1]), rel=1e-6)


def hardening(e, ed, *, stiffness):
    """A spring that stiffens."""
    return stiffness * (e + 100.0 * e**3)


def pulled(numbers):
    """A bent arm whose tangent is not symmetric.

    A beam and a spectral beam with a rigid piece between them, a spring that stiffens, a force that follows its end.
    """
    stiffness, load, thickness = numbers
    section = fm.Rectangle(0.01, thickness, STEEL)
    b = fm.Builder()
    for name, place in {"a": (0, 0), "b": (0.1, 0), "c": (0.12, 0.01), "d": (0.12, 0.1), "g": (0.2, 0.1)}.items():
        b.node(name, place)
    b.add(planar.beam, "a", "b", section=section)
    b.add(planar.rigid_body, "b", "c")
    b.add(planar.spectral_beam, "c", "d", section=section, order=3)
    b.add(planar.spring_damper, "d", "g", law=hardening, stiffness=stiffness)
    b.fix("a")
    b.fix("g", "x", "y")
    b.mass("d", 0.02)
    b.gravity((0.5, -9.81))
    b.force("d", (load, 0.0), follower=True)
    return b


NUMBERS = np.array([40.0, 2.0, 1e-3])


def end(numbers):
    return fm.equilibrium(pulled(numbers).build(check=False), sparse=True).at("d")[0]


@pytest.mark.slow
def test_laws_and_loads_that_follow():
    b = pulled(NUMBERS)
    dense, sparse = fm.equilibrium(b.build(), sparse=False), fm.equilibrium(b.build(check=False), sparse=True)
    # Loads bend it by a tenth of its size; both iterate to round-off.
    np.testing.assert_allclose(sparse.x, dense.x, atol=1e-13)
    np.testing.assert_allclose(sparse.sigma[: len(dense.sigma)], dense.sigma, atol=1e-9)
    np.testing.assert_allclose(sparse.reactions, dense.reactions, atol=1e-9)


@pytest.mark.slow
def test_derivatives_under_jit_are_those_of_central_differences():
    h = 1e-4
    found = jax.jit(jax.grad(end))(NUMBERS)
    for i, number in enumerate(NUMBERS):
        step = h * number * np.eye(3)[i]
        difference = (float(end(NUMBERS + step)) - float(end(NUMBERS - step))) / (2 * h * number)
        # Truncation h^2.
        assert float(found[i]) == approx(difference, rel=1e-6)


def where(*_, **__):
    return np.array([float(threading.get_ident())]), np.array(0, np.int32)


def test_equations_of_compiled_code_are_solved_in_one_thread(monkeypatch):
    # SuperLU gives memory back in the thread alone that took it.
    monkeypatch.setattr("flexmb.statics.sparse._answer", where)
    found, _ = jax.jit(lambda right: _traced_answer(None, right))(jnp.zeros(1))
    assert int(found[0]) == on_host_thread(threading.get_ident)


@pytest.mark.slow
def test_sweep_and_tune_against_the_closed_form():
    def cantilever(EI):
        b = fm.Builder()
        b.node("a", (0, 0))
        b.node("b", (0.3, 0))
        b.add(planar.beam, "a", "b", section=fm.Rigidity(EA=1e5, EIy=EI))
        b.fix("a")
        b.force("b", (0, 1e-6))
        return b.build(check=False)

    answers = {"tip": lambda model: fm.equilibrium(model, sparse=True).at("b")[1]}
    designs = np.array([0.5, 1.0, 2.0])
    found = fm.sweep(cantilever, answers, {"EI": designs})
    # F L^3 / (3 EI); large deflections add the square of the tip's angle, 1e-14.
    np.testing.assert_allclose(found["tip"], 1e-6 * 0.3**3 / (3 * designs), rtol=1e-9)
    tuned = fm.tune(cantilever, answers, {"EI": 1.0}, {"EI": (0.2, 5.0)}, targets={"tip": 6e-9})
    assert float(tuned.dimensions["EI"]) == approx(1.5, rel=1e-4)


@pytest.mark.slow
def test_moments_about_fixed_axes():
    b = fm.Builder()
    b.node("a", (0, 0, 0))
    b.node("b", (0.1, 0, 0))
    b.add(spatial.beam, "a", "b", section=fm.Rectangle(0.01, 1e-3, STEEL), y=(0, 1, 0))
    b.fix("a")
    b.moment("b", (0.1, 0.2, 0.1))
    b.force("b", (0, 0, 1.0), follower=True)
    dense, sparse = fm.equilibrium(b.build(), sparse=False), fm.equilibrium(b.build(check=False), sparse=True)
    np.testing.assert_allclose(sparse.x, dense.x, atol=1e-12)


@pytest.mark.slow
def test_a_failure_is_a_code_where_it_is_not_raised():
    b = fm.Builder()
    for i in range(3):
        b.node(f"n{i}", (0.1 * i, 0.0))
    b.add(planar.beam, "n0", "n1", section=fm.Rectangle(0.01, 1e-3, STEEL))
    b.add(planar.rigid_body, "n1", "n2")
    b.force("n2", (0.0, 1.0))
    found = fm.equilibrium(b.build(check=False), sparse=True, throw=False)
    assert int(found.result) == fm.RESULTS.singular_stiffness
    # Constraints that state the same twice.
    b.add(planar.rigid_body, "n1", "n2")
    b.fix("n0")
    with pytest.raises(fm.AnalysisError, match="do not determine the configuration"):
        fm.equilibrium(b.build(check=False), sparse=True)


@pytest.mark.slow("ac bc ac-singular_configuration")
@pytest.mark.parametrize(("bars", "why"), [("ac bc ac", "singular_configuration"), ("ac", "singular_stiffness")])
def test_bars_that_hold_the_same_twice_and_too_few_are_told_apart(bars, why):
    b = fm.Builder()
    for name, position in {"a": (0.0, 0.0), "b": (1.0, 0.0), "c": (0.5, 1.0)}.items():
        b.node(name, position)
    for p, q in bars.split():
        b.add(planar.truss, p, q)
    b.fix("a")
    b.fix("b")
    # Across the bar, which so has no stiffness from its load.
    b.force("c", (0.2, -0.1))
    with pytest.raises(fm.AnalysisError) as info:
        fm.equilibrium(b.build(check=False), sparse=True)
    assert info.value.code == why


@pytest.mark.slow
@pytest.mark.parametrize("ask", ["answers about a state", "equilibrium"])
def test_memory_that_does_not_suffice_is_named(monkeypatch, ask):
    def full(*_, **__):
        raise MemoryError

    model = arm().build(check=False)
    asked = [lambda: fm.equilibrium(model, sparse=True)]
    if ask != "equilibrium":
        lin = fm.linearize(model, sparse=True)
        asked = [lambda: fm.compliance(lin, "d"), lambda: fm.frequencies(lin, count=1)]
    monkeypatch.setattr("scipy.sparse.linalg.splu", full)
    monkeypatch.setattr("flexmb.math.element_matrices._known", type(element_matrices._known)())
    for of in asked:
        with pytest.raises(fm.AnalysisError, match="memory does not suffice") as info:
            of()
        assert info.value.code == "out_of_memory"


def test_dense_matrices_that_memory_does_not_hold_are_refused(monkeypatch):
    model = arm().build()
    monkeypatch.setattr("flexmb.model.model.memory", lambda: 1e3)
    with pytest.raises(fm.AnalysisError, match=r"fm\.equilibrium: dense matrices of \d+ coordinates take .* GB"):
        fm.equilibrium(model, sparse=False)


def test_small_pivots_on_the_diagonal():
    """Rows change places where pivots on the diagonal would spoil the solution: NumPy's answer for a dense matrix."""
    rng = np.random.default_rng(7)
    matrix = rng.standard_normal((30, 30))
    matrix[np.arange(30), np.arange(30)] = 1e-7 * rng.standard_normal(30)
    factors = SparseFactors(scipy.sparse.csc_array(matrix))
    right = rng.standard_normal(30)
    assert factors.regular
    for transposed, whole in ((False, matrix), (True, matrix.T)):
        np.testing.assert_allclose(factors.solve(right, transposed), np.linalg.solve(whole, right), rtol=1e-9)
    assert not SparseFactors(scipy.sparse.csc_array(np.ones((3, 3)))).regular


@pytest.mark.slow("True")
@pytest.mark.parametrize("sparse", [False, True])
def test_a_load_that_happens_to_be_zero_asks_for_no_stiffness(sparse):
    """A mechanism that floats has its three motions without a frequency, whether such a load is named or not."""

    def floating(load):
        b = fm.Builder()
        for i in range(4):
            b.node(f"n{i}", (0.1 * i, 0))
        for i in range(3):
            b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rectangle(0.01, 0.001, STEEL))
        if load is not None:
            b.force("n0", (0.0, load))
        return b.build()

    plain, named = (fm.frequencies(floating(load), count=4, sparse=sparse) for load in (None, 0.0))
    assert plain[3] > 50
    np.testing.assert_allclose(named[:3], 0.0, atol=1e-3)
    np.testing.assert_allclose(named[3], plain[3], rtol=1e-9)


@pytest.mark.slow
def test_a_rigid_arm_with_a_load_that_happens_to_be_zero():
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("b", (1.0, 0))
    b.rotation("r")
    b.add(planar.rigid_beam, "a", "r", "b")
    b.fix("a")
    b.force("b", (0.0, 0.0))
    np.testing.assert_array_equal(fm.equilibrium(b.build(check=False), sparse=True).x, [0, 0, 1, 0, 0])


def named(place):
    return "n" + "".join(map(str, place))


def lattice(per_metre):
    """Two cells each way of a lattice in space with a rigid body, in units of which so many are a metre."""
    material = fm.Material(E=200e9 / per_metre, G=77e9 / per_metre, rho=7850 / per_metre**3)
    section = fm.Rectangle(0.002 * per_metre, 0.001 * per_metre, material)
    b = fm.Builder()
    places = list(np.ndindex(3, 3, 3))
    for place in places:
        b.node(named(place), 0.03 * per_metre * np.array(place))
    for place in places:
        for axis, y in enumerate(((0, 1, 0.2), (0, 0.1, 1), (1, 0.2, 0))):
            other = tuple((np.array(place) + np.eye(3, dtype=int)[axis]).tolist())
            if max(other) > 2 or other[2] == 0:
                continue
            ends = named(place), named(other)
            if (place, axis) == ((0, 0, 1), 0):
                b.add(spatial.rigid_body, *ends)
            else:
                b.add(spatial.beam, *ends, section=section, y=y)
    for i, j in np.ndindex(3, 3):
        b.fix(f"n{i}{j}0")
    b.force("n222", per_metre * np.array([3.0, -2.0, -5.0]))
    return b.build(check=False)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*flexmb reads (metres|SI units):flexmb.FlexmbWarning")
def test_units_make_nothing_singular():
    """In micrometres constraints of rigid bodies stand beside stiffnesses 1e12 times as large."""
    metres, micrometres = (
        (fm.equilibrium(lattice(per_metre), sparse=True).at("n222") / per_metre - 0.06) for per_metre in (1.0, 1e6)
    )
    assert np.linalg.norm(metres) > 1e-4
    np.testing.assert_allclose(micrometres, metres, rtol=1e-8)


@pytest.mark.slow
def test_what_is_large_is_solved_by_sparse_factors(monkeypatch):
    b = arm()
    monkeypatch.setattr("flexmb.statics.solver_choice.LARGE", 10)
    # It has no degrees of freedom, which dense matrices need.
    assert fm.equilibrium(b.build(check=False)).result == fm.RESULTS.successful
    monkeypatch.undo()
    with pytest.raises(fm.ModelError, match="do not determine it"):
        fm.equilibrium(b.build(check=False))


@pytest.mark.slow
def test_factors_of_a_chain_of_held_elongations_stay_sparse(monkeypatch):
    made, original = [], SparseFactors.__init__

    def noted(self, matrix, *ordering, **how):
        original(self, matrix, *ordering, **how)
        made.append((self._factors.L.nnz + self._factors.U.nnz) / matrix.nnz)

    monkeypatch.setattr(SparseFactors, "__init__", noted)
    b = fm.Builder()
    for i in range(501):
        b.node(f"n{i}", (i / 500, 0.0))
    for i in range(500):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e4, EIy=1.0), released=(2, 3))
    b.fix("n0")
    b.force("n500", (0.0, 2.0))
    tip = fm.equilibrium(b.build(check=False), sparse=True).at("n500")
    # theta'' = -2 cos(theta) by a boundary value solver; cubic beams converge with order two.
    np.testing.assert_allclose(tip, (0.8393583, 0.4934575), atol=1e-5)
    # A multiplier eliminated before its coordinates has no pivot: 40 times as many entries.
    assert max(made[1:]) < 4


@pytest.mark.slow
@pytest.mark.parametrize("angle", [7.0, -13.0])
def test_turns_are_counted(angle):
    """A spring in a hinge in space that is turned by its body beyond full turns, a leaf spring carried along."""

    def turned(stiffness):
        b = fm.Builder()
        for name, place in {"a": (0, 0, 0), "b": (0, 0, 0), "c": (0.1, 0, 0)}.items():
            b.node(name, place)
        across = jnp.stack([stiffness, 1.0, 1.0])
        b.add(spatial.hinge, "a", "b", name="spring", axis=(0, 0, 1), stiffness=across, released="all")
        b.add(spatial.beam, "b", "c", section=fm.Rectangle(0.01, 1e-3, STEEL), y=(0, 0, 1))
        b.fix("a")
        b.prescribe("b", "rotation", angle, axis=(0, 0, 1))
        b.fix("b", "position")
        return fm.equilibrium(b.build(check=False), sparse=True)

    found = turned(0.05)
    place = [str(name) for name in found.labels.e].index("spring.e1")
    # Round-off of the load steps.
    assert found.e[place] == approx(angle, abs=1e-12)
    assert found.sigma[place] == approx(0.05 * angle, abs=1e-12)
    np.testing.assert_allclose(found.at("c"), 0.1 * np.array([np.cos(angle), np.sin(angle), 0]), atol=1e-12)
    assert jax.grad(lambda k: turned(k).sigma[place])(0.05) == approx(angle, abs=1e-12)


@pytest.mark.slow
def test_a_rope_of_rigid_links_hangs():
    """Nothing but weight resists it; Bernoulli: frequencies by the zeros of J0, j/(4 pi) sqrt(g/l), of a heavy rope."""
    b = fm.Builder()
    for i in range(41):
        b.node(f"n{i}", (0.0, -i / 40))
    for i in range(40):
        b.add(planar.truss, f"n{i}", f"n{i + 1}", section=fm.Rigidity(mass=1.0), released=())
    b.fix("n0", "x", "y")
    b.gravity((0, -9.81))
    model = b.build(check=False)
    found = fm.equilibrium(model, sparse=True)
    assert float(found.reaction("n0", "y")) == approx(9.81, rel=1e-12)
    exact = np.array([2.404825557695773, 5.520078110286311]) / (4 * np.pi) * np.sqrt(9.81)
    # Links are stiffer by some 1/n^2.
    np.testing.assert_allclose(fm.frequencies(model, count=2, sparse=True), exact, rtol=1e-3)


def test_what_hangs_is_found_inside_compiled_code_too():
    def ends(gravity):
        b = fm.Builder()
        for i in range(4):
            b.node(f"n{i}", (0.03 * i, -0.4 * i))
        for i in range(3):
            b.add(planar.truss, f"n{i}", f"n{i + 1}", section=fm.Rigidity(mass=2.0), released=())
        b.fix("n0", "x", "y")
        b.gravity((0, -gravity))
        found = fm.equilibrium(b.build(check=False), sparse=True)
        return found.at("n3"), found.reaction("n0", "y")

    # From a little aslant to straight down, under its weight of 2 kg/m.
    length = 3 * np.hypot(0.03, 0.4)
    for asked in (ends, jax.jit(ends)):
        place, weight = asked(9.81)
        np.testing.assert_allclose(place, (0.0, -length), atol=1e-9)
        assert float(weight) == approx(2 * length * 9.81, rel=1e-9)


@pytest.mark.slow
def test_light_loads_on_stiff_parts_have_all_digits():
    """A row of bars a hundred million times stiffer than their load, which all of them carry: statics.

    Coordinates of a metre tell their elongations to a few digits.
    """

    def bars(force):
        b = fm.Builder()
        for i in range(6):
            b.node(f"n{i}", (i / 5, 0.0))
        for i in range(5):
            b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"b{i}", section=fm.Rigidity(EA=1e8, EIy=1.0))
        b.fix("n0")
        b.force("n5", (force, 0.0))
        return b.build(check=False)

    def carried(force):
        found = fm.equilibrium(bars(force), sparse=True)
        return jnp.stack([*(found.stress_resultant(f"b{i}", 1) for i in range(5)), -found.reaction("n0")[0]])

    # Round-off of a solution.
    np.testing.assert_allclose(carried(1e-4), 1e-4, rtol=1e-13)
    for derivative in (jax.jacfwd, jax.jacrev):
        np.testing.assert_allclose(derivative(carried)(1e-4), 1.0, rtol=1e-13)
    np.testing.assert_allclose(jax.jit(carried)(1e-4), 1e-4, rtol=1e-13)
