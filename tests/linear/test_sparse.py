"""Large mechanisms by sparse matrices: modes, compliance and stress are those of dense ones, and so are derivatives."""

import dataclasses
import threading

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.linear.sparse_solve import call_on_host
from flexmb.math.linear_solver import SPARSE
from flexmb.math.sparse import on_host_thread
from flexmb.results import RESULTS

STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0)


def bent(thickness=1e-3, check=False):
    """Clamped strip of six beams that its load bends, with a rigid part at its end and an elongation held."""
    b = fm.Builder()
    for i in range(8):
        b.node(f"n{i}", (0.03 * i, 0.01 * (i % 2)))
    for i in range(6):
        section = fm.Rectangle(0.01, thickness, STEEL)
        released = {"released": (2, 3)} if i == 2 else {}
        b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"b{i}", section=section, **released)
    b.add(planar.beam, "n6", "n7", name="rigid")
    b.fix("n0")
    b.mass("n7", 0.01)
    b.force("n7", (0.5, 0.4))
    b.gravity((0.0, -9.81))
    return b.build(check=check)


@pytest.mark.slow
def test_answers_are_those_of_dense_matrices():
    dense, large = bent(check=True), fm.linearize(bent(), sparse=True)
    own = fm.modes(large, count=4)
    exact = fm.modes(dense, count=4)
    assert own.eigenvalues.shape == exact.eigenvalues.shape == (4,)
    np.testing.assert_allclose(own.eigenvalues, exact.eigenvalues, rtol=1e-9)
    for node in ("n3", "n7"):
        for component in ("x", "phi"):
            shapes = np.abs(np.stack([of.shape(node, component) for of in (own, exact)]))
            np.testing.assert_allclose(shapes[0], shapes[1], rtol=1e-8, atol=1e-9 * np.max(shapes))
    for local in (False, True):
        found, wanted = (fm.compliance(of, "n6", local=local) for of in (large, dense))
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-10 * np.max(np.abs(wanted)))
    # Both find the equilibrium to 1e-9 of the extent.
    exact_stress = fm.stress(dense).von_mises
    for stress in (fm.stress(bent(), sparse=True), fm.stress(bent(), at=large)):
        np.testing.assert_allclose(stress.von_mises, exact_stress, atol=1e-8 * np.max(exact_stress))
    np.testing.assert_allclose(large.position("n7"), fm.linearize(dense).position("n7"), rtol=1e-9)


@pytest.mark.slow
def test_matrices_are_those_of_scipy():
    """Frequencies of the matrices given away, solved by SciPy in the motions that the constraints allow."""
    import scipy.linalg

    k, _, m, d = (of.toarray() for of in fm.linearize(bent(), sparse=True).sparse())
    allowed = scipy.linalg.null_space(d / np.linalg.norm(d, axis=1)[:, None])
    wanted = scipy.linalg.eigh(allowed.T @ k @ allowed, allowed.T @ m @ allowed, eigvals_only=True)[:3]
    found = fm.modes(bent(), count=3, sparse=True).eigenvalues
    # SciPy knows the lowest to round-off of the highest.
    np.testing.assert_allclose(found, wanted, rtol=1e-6)


@pytest.mark.slow
def test_a_spectral_beam_and_a_law_are_those_of_dense_matrices():
    """Elements whose stiffness depends on their deformations."""

    def model(check):
        b = fm.Builder()
        for name, x in (("a", 0.0), ("b", 0.1), ("c", 0.2)):
            b.node(name, (x, 0.0))
        section = fm.Rectangle(0.01, 1e-3, STEEL)
        b.add(planar.spectral_beam, "a", "b", name="ab", section=section)
        b.add(planar.beam, "b", "c", section=section)
        b.fix("a")
        b.mass("c", 0.05)
        b.force("c", (0.0, 0.5))
        return b.build(check=check)

    wanted, found = (fm.modes(model(check), count=3, **how) for check, how in ((True, {}), (False, {"sparse": True})))
    np.testing.assert_allclose(found.eigenvalues, wanted.eigenvalues, rtol=1e-7)


@pytest.mark.slow
def test_derivatives_are_those_of_central_differences():
    def answers(thickness):
        large = fm.linearize(bent(thickness), sparse=True)
        modes = fm.modes(large, count=3)
        stress = fm.stress(large.model, at=large).smooth_maximum()
        # Of one size each, in a sum that takes one program.
        return (
            modes.eigenvalues[1] / 1e5
            + jnp.sum(modes.shape("n4", "y") ** 2) / 100
            + jnp.abs(modes.shape("n4", "y")[2])
            + fm.compliance(large, "n5")[1, 1] * 1e3
            + stress / 1e8
            + fm.frequencies(large, count=2)[1] / 100
        )

    start, h = 1e-3, 2e-6
    both = fm.jit(jax.value_and_grad(answers))
    near = {i: both(start + i * h)[0] for i in (-2, -1, 1, 2)}
    difference = (8 * (near[1] - near[-1]) - (near[2] - near[-2])) / (12 * h)
    # Truncation (h/t)^4, and the equilibrium's 1e-10 over h.
    assert float(both(start)[1]) == approx(float(difference), rel=1e-6)


@pytest.mark.slow
def test_repeated_frequencies_have_derivatives_of_what_does_not_depend_on_shapes():
    """A square rod: two modes of one frequency; by a cantilever's formula it is as the thickness."""

    def rod(thickness):
        b = fm.Builder()
        for i in range(5):
            b.node(f"n{i}", (0.1 * i, 0, 0))
        for i in range(4):
            section = fm.Rectangle(thickness, thickness, STEEL)
            b.add(spatial.beam, f"n{i}", f"n{i + 1}", section=section, y=(0, 1, 0))
        b.fix("n0")
        return fm.modes(b.build(check=False), count=2, sparse=True)

    def total(thickness):
        modes = rod(thickness)
        return jnp.sum(modes.frequencies), jnp.sum(modes.shape("n4", "y") ** 2)

    value, slope = jax.jvp(total, (2e-3,), (1.0,))
    # Rotary inertia, as the square of thickness over length, is what the formula leaves out.
    assert float(slope[0]) == approx(float(value[0]) / 2e-3, rel=1e-4)
    # Mass goes as the square of the thickness, and so do squares of shapes with the inverse of it.
    assert float(slope[1]) == approx(-2 * float(value[1]) / 2e-3, rel=1e-3)


@dataclasses.dataclass(frozen=True)
class Counted:
    """A linear solver that keeps with which shifts it was asked."""

    asked: list = dataclasses.field(default_factory=list, compare=False)

    def factored(self, elements, mass=0.0, damping=0.0):
        self.asked.append((mass, damping))
        return SPARSE.factored(elements, mass, damping)


@pytest.mark.slow
def test_questions_are_answered_by_the_solver_that_they_are_given():
    own, dense = Counted(), bent(check=True)
    lin = fm.linearize(bent(), solver=own)
    np.testing.assert_allclose(fm.compliance(lin, "n6"), fm.compliance(dense, "n6", solver="dense"), rtol=1e-7)
    assert own.asked == [(0.0, 0.0)]
    found = fm.frequencies(lin, count=2)
    np.testing.assert_allclose(found, fm.frequencies(dense, count=2, sparse=False), rtol=1e-7)
    np.testing.assert_allclose(found, fm.frequencies(lin, count=2, solver="sparse"), rtol=1e-9)
    assert len(own.asked) == 2


@pytest.mark.slow
def test_what_is_chosen_and_refused():
    large = fm.linearize(bent(), sparse=True)
    with pytest.raises(ValueError, match="give `count`"):
        fm.modes(large)
    with pytest.raises(ValueError, match="contradicts sparse=False"):
        fm.modes(large, count=2, sparse=False)
    with pytest.raises(ValueError, match=r"give fm\.modes a Model"):
        fm.modes(fm.linearize(bent(check=True)), count=2, sparse=True)
    # All that there are.
    with pytest.warns(fm.FlexmbWarning, match="fewer modes with mass"):
        assert fm.modes(large, count=100).eigenvalues.shape == fm.modes(bent(check=True)).eigenvalues.shape
    with pytest.raises(AttributeError, match="no K0, a matrix in the degrees of freedom"):
        large.K0  # noqa: B018
    with pytest.raises(ValueError, match="contradicts at="):
        fm.stress(bent(), at=large, sparse=True)
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("b", (1, 0))
    b.add(planar.beam, "a", "b", section=fm.Rectangle(0.01, 0.001, STEEL))
    b.fix("a", "x", "y")
    with pytest.raises(fm.AnalysisError, match="a motion has no stiffness"):
        fm.compliance(b.build(check=False), "b", sparse=True)


@pytest.mark.slow
@pytest.mark.parametrize("released", [None, (2, 3)])
def test_what_is_far_below_zero_is_not_lost(released):
    """A column beyond its second buckling load: both frequencies below zero, though others are nearer to it."""
    import scipy.linalg

    section, load = fm.Rectangle(0.01, 1e-3, STEEL), 12 * np.pi**2 / 4 * 210e9 * 0.01 * 1e-9 / 12
    own = {} if released is None else {"released": released}
    b = fm.Builder()
    for i in range(21):
        b.node(f"n{i}", (i / 20, 0.0))
    for i in range(20):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=section, **own)
    b.fix("n0")
    b.force("n20", (-load, 0.0))
    lin = fm.linearize(b.build(check=False), sparse=True)
    k, _, m, d = (of.toarray() for of in lin.sparse())
    allowed = scipy.linalg.null_space(d) if len(d) else np.eye(len(k))
    wanted = scipy.linalg.eigh(allowed.T @ k @ allowed, allowed.T @ m @ allowed, eigvals_only=True)[:3]
    assert np.sum(wanted < 0) == 2
    # The lowest but one is nearest to zero.
    for count in (1, 3):
        found = fm.modes(lin, count=count)
        np.testing.assert_allclose(found.eigenvalues, wanted[:count], rtol=1e-5)
        assert not bool(found.stable)


def comb(leaves, check=False):
    """Upright leaf springs whose tops rigid bodies join: constraints leave six motions, however many they are."""
    b = fm.Builder()
    for i in range(leaves):
        b.node(f"f{i}", (0.05 * i, 0.0, 0.0))
        b.node(f"t{i}", (0.05 * i, 0.0, 0.1))
        b.add(spatial.beam, f"f{i}", f"t{i}", section=fm.Rectangle(0.02, 5e-4, STEEL), y=(0, 1, 0))
        b.fix(f"f{i}")
        b.force(f"t{i}", (0.0, 0.0, -1.0))
    for i in range(leaves - 1):
        b.add(spatial.rigid_body, f"t{i}", f"t{i + 1}")
    b.input("t0", "x")
    b.output("t0", "x")
    return b.build(check=check)


@pytest.mark.filterwarnings("ignore:Argument `count`")
@pytest.mark.slow
def test_few_motions_of_many_coordinates_are_found_one_and_all():
    """One cubic beam whose top may only shift buckles at 10 EI/L^2; its six frequencies are those of dense matrices."""
    large = comb(3)
    loads = fm.buckling_loads(large, count=3, sparse=True)
    # Of leaf springs that are shortened by 1e-6 and stand on a rigid ground.
    assert loads[0] == approx(10 * 210e9 * 0.02 * 5e-4**3 / 12 / 0.1**2, rel=2e-3)
    assert np.all(loads[1:] > 1e4)
    found = fm.frequencies(large, count=10, sparse=True)
    np.testing.assert_allclose(found, fm.frequencies(comb(3, check=True)), rtol=1e-9)
    with pytest.raises(ValueError, match="from 1 to 6, the number of modes"):
        fm.to_statespace(large, modes=8, sparse=True)


@pytest.mark.slow
def test_every_copy_of_a_repeated_value_is_found():
    """Sixty leaf springs alike have sixty lowest frequencies and load multipliers; iterations see one of each."""
    section = fm.Rectangle(0.01, 1e-3, STEEL)
    b = fm.Builder()
    for j in range(60):
        for i in range(3):
            b.node(f"n{j} {i}", (0.05 * i, 0.05 * j))
        for i in range(2):
            b.add(planar.beam, f"n{j} {i}", f"n{j} {i + 1}", section=section)
        b.fix(f"n{j} 0")
        b.force(f"n{j} 2", (-1.0, 0.0))
    model = b.build(check=False)
    for answer in (fm.frequencies, fm.buckling_loads):
        for count in (30, 70):
            found = np.asarray(answer(model, count=count, sparse=True))
            assert np.sum(np.abs(found / found[0] - 1) < 1e-6) == min(count, 60)


@pytest.mark.slow
def test_another_model_and_failures_that_are_not_raised_are_refused():
    with pytest.raises(ValueError, match="belongs to another model"):
        fm.compliance(comb(2), "t0", at=fm.linearize(bent(), sparse=True))
    with pytest.raises(ValueError, match="always raises"):
        fm.modes(bent(), count=2, sparse=True, throw=False)


def light_line(masses, clamped=True, inertia=None):
    """Forty beams without mass in a line, with masses on their nodes."""
    b = fm.Builder()
    for i in range(41):
        b.node(f"n{i}", (i / 40, 0.0))
    for i in range(40):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=1e4, EIy=1.0, mass=0.0))
    if clamped:
        b.fix("n0")
    for i, mass in masses.items():
        b.mass(f"n{i}", mass)
    if inertia is not None:
        b.inertia("n40", inertia)
    return b.build(check=False)


@pytest.mark.filterwarnings("ignore:Argument `count`")
@pytest.mark.slow
def test_a_mass_on_many_beams_without_mass():
    """Closed form: a point mass at the end of a cantilever bends and stretches it; nothing else has mass."""
    model = light_line({40: 1.0})
    found = fm.frequencies(model, count=2, sparse=True)
    np.testing.assert_allclose(found, np.sqrt([3.0, 1e4]) / (2 * np.pi), rtol=1e-8)
    # Of two masses that are asked for one mode, the slower.
    both = light_line({20: 1e-6, 40: 1.0})
    np.testing.assert_allclose(fm.frequencies(both, count=1, sparse=True), np.sqrt(3.0) / (2 * np.pi), rtol=1e-6)
    # Asked for more, it answers as dense matrices do.
    found = np.asarray(fm.frequencies(model, count=5, sparse=True))
    np.testing.assert_array_equal(np.isinf(found), [False, False, True, True, True])
    modes = fm.modes(model, count=5, sparse=True)
    assert (len(modes.frequencies), modes.massless, modes.shapes.shape[1]) == (2, 118, 2)
    assert modes.stable

    def answers(mass):
        modes = fm.modes(light_line({40: mass}), count=3, sparse=True)
        return modes.frequencies, modes.shape("n40", "y")

    at, slope = jax.jvp(answers, (1.0,), (1.0,))
    for own, change in zip(at, slope, strict=True):
        np.testing.assert_allclose(change, np.where(np.isfinite(own), -own / 2, 0.0), rtol=1e-7, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("clamped", [True, False])
def test_soft_and_free_motions_leave_others_their_digits(clamped):
    """Closed form of equal masses on equal springs, along the line; without a clamp three motions are free."""
    first = int(clamped)
    model = light_line(dict.fromkeys(range(first, 41), 1.0), clamped)
    found = np.asarray(fm.frequencies(model, count=60, sparse=True))
    number = np.arange(1, 41)
    angle = (2 * number - 1) * np.pi / 162 if clamped else number * np.pi / 82
    wanted = 2 * np.sqrt(1e4 * 40) * np.sin(angle) / (2 * np.pi)
    wanted = wanted[wanted < found[-1]]
    assert len(wanted) > 20
    for own in wanted:
        assert np.min(np.abs(found / own - 1)) < 1e-9
    assert np.sum(np.abs(found) < 1e-3 * found[10]) == 3 * (not clamped)


@pytest.mark.slow("True")
@pytest.mark.parametrize("space", [False, True])
def test_a_cantilever_of_any_size_vibrates_alike(space):
    """Of a nanometre too, stiffnesses are 1e16 times below the constraints beside them."""

    def lowest(size):
        kind, d = (spatial, 3) if space else (planar, 2)
        b = fm.Builder()
        b.node("a", np.zeros(d))
        b.node("c", size * np.eye(d)[0])
        section = fm.Rectangle(0.18 * size, 5e-3 * size, fm.Material(E=210e9, G=80e9, rho=7850))
        b.add(kind.spectral_beam(3), "a", "c", section=section, **({"y": (0, 1, 0)} if space else {}))
        b.fix("a")
        b.mass("c", 100 * size**3)
        return size * fm.frequencies(b.build(check=False), count=1, sparse=True)[0]

    # Lengths and times by one factor: the frequency by its inverse. From round-off, times what it grows by.
    np.testing.assert_allclose([lowest(size) for size in (1e-6, 1e-8, 1e-9, 1e-12)], lowest(1.0), rtol=1e-9)


@pytest.mark.slow
def test_a_negative_mass_is_refused():
    """As by dense matrices; where masses of beams make up for it, it is one of theirs."""
    with pytest.raises(fm.AnalysisError, match="or a negative mass"):
        fm.frequencies(light_line({40: 1.0}, inertia=-1e-6), count=2, sparse=True)


def springs(stiffness=1e14, first=100.0):
    """Three masses in a row, the first spring and the last of 100 N/m, the second near to rigid."""
    b = fm.Builder()
    for i in range(4):
        b.node(f"n{i}", (0.1 * i, 0.0))
    b.fix("n0")
    for i, k in enumerate((first, stiffness, 100.0)):
        b.add(planar.truss, f"n{i}", f"n{i + 1}", section=fm.Rigidity(EA=0.1 * k))
        b.fix(f"n{i + 1}", "y")
        b.mass(f"n{i + 1}", 1.0)
    b.force("n3", (0.01, 0.0))
    return b.build(check=False)


def test_round_off_of_the_highest_frequency_does_not_come_into_the_lowest():
    """Two masses as one: (2 m, m) between springs of 100 N/m; the stiff spring gives 1e-12 of the soft ones' way."""
    found = fm.frequencies(springs(), count=3, sparse=True)
    squares = 100.0 + np.array([-1.0, 1.0]) * np.sqrt(5000.0)
    np.testing.assert_allclose(found[:2], np.sqrt(squares) / (2 * np.pi), rtol=2e-12)


@pytest.mark.slow("compliance-6")
@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("compliance", RESULTS.singular_stiffness),
        ("frequency", RESULTS.singular_stiffness),
        ("buckling", RESULTS.singular_stiffness),
        ("pole", RESULTS.singular_stiffness),
        ("heavy", RESULTS.not_finite),
    ],
)
def test_a_design_that_fails_stops_no_other(name, code):
    """The first spring has no stiffness; or a rotary inertia is negative."""
    ask = {
        "compliance": lambda m: fm.compliance(m, "n3", sparse=True)[0, 0],
        "frequency": lambda m: fm.frequencies(m, count=2, sparse=True)[0],
        "buckling": lambda m: 1 / fm.buckling_loads(m, count=1, sparse=True)[0],
        "pole": lambda m: jnp.abs(fm.poles(m, count=2, sparse=True)[0]),
        "heavy": lambda m: fm.frequencies(m, count=2, sparse=True)[0],
    }
    heavy = name == "heavy"

    def design(value):
        return light_line({40: 1.0}, inertia=value) if heavy else springs(200.0, first=value)

    found = fm.sweep(design, {name: ask[name]}, {"value": [1e-3, -1.0, 1e-2] if heavy else [100.0, 0.0, 50.0]})
    np.testing.assert_array_equal(found.codes, [0, code, 0])
    np.testing.assert_array_equal(np.isfinite(found[name]), [True, False, True])


@pytest.mark.filterwarnings("ignore:Argument `count`")
def test_nothing_moves():
    b = fm.Builder()
    b.node("A", (0.0, 0.0))
    b.node("B", (0.0, 0.1))
    b.node("C", (0.1, 0.1))
    b.add(planar.rigid_body, "A", "B")
    b.add(planar.rigid_body, "B", "C")
    b.fix("A")
    b.mass("C", 1.0)
    b.force("C", (1.0, 2.0))
    model = b.build(check=False)
    assert fm.modes(model, count=3, sparse=True).frequencies.shape == (0,)
    assert fm.poles(model, count=3, sparse=True).shape == (0,)
    assert np.all(np.isinf(fm.buckling_loads(model, count=3, sparse=True)))


def where(_):
    return np.array(threading.get_ident())


def test_the_host_works_for_compiled_code_in_one_thread():
    # SuperLU gives memory back in the thread alone that took it.
    like = jax.ShapeDtypeStruct((), int)
    assert int(jax.jit(lambda a: call_on_host(where, like, a))(1.0)) == on_host_thread(threading.get_ident)


def never(_):
    raise AssertionError("asked about what is no number")


def test_the_host_is_not_asked_about_what_has_failed_before():
    assert np.isnan(jax.jit(lambda a: call_on_host(never, jax.ShapeDtypeStruct((), float), a))(np.nan))


@pytest.mark.slow
def test_frequencies_at_any_size_of_a_net():
    """All lengths times U: frequencies are those of U = 1, by dense matrices, over U. Thin beams and a thick one."""

    def net(size):
        b = fm.Builder()

        def square(thickness):
            return fm.Rectangle(thickness * size, thickness * size, fm.Material(E=2e11, G=8e10, rho=8000.0))

        for i in range(3):
            for j in range(3):
                place = i + 0.1 * j, j * (1 + 0.1 * i), 0.1 * i * j
                b.node(f"{i}{j}", tuple(size * of for of in place))
        for pair in ("01 11", "11 21", "11 12"):
            b.add(spatial.rigid_body, *pair.split())
        for pair in ("00 10", "10 20", "20 21"):
            b.add(spatial.beam, *pair.split(), section=square(0.002), released=(2, 3, 4, 5, 6))
        for pair in ("00 01", "01 02", "02 12", "10 11", "12 22"):
            b.add(spatial.beam, *pair.split(), section=square(0.002))
        b.add(spatial.beam, "21", "22", section=square(0.06))
        b.fix("00")
        return b.build()

    wanted = fm.frequencies(net(1.0), sparse=False)[:2]
    for size in (1.0, 1e-4):
        # Six digits of the fourth power of lengths.
        np.testing.assert_allclose(size * fm.frequencies(net(size), count=2, sparse=True), wanted, rtol=1e-6)
