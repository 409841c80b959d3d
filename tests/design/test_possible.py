"""Designs that a concrete build refuses have their code in a batch too."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import mechanisms
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.blocks import cross_pivot, notch_hinge
from flexmb.design.evaluate import build_once, refusal_of_designs
from flexmb.elements.element import Element

T = mechanisms.THICKNESS
GOOD, BAD = "successful", "impossible_design"
STEEL = {"E": 210e9, "G": 80e9, "rho": 7850.0}


def cantilever(make, length=0.1):
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (0, length))
    b.add(planar.beam, "foot", "tip", section=make, released=(2, 3))
    b.fix("foot")
    return b


def guide(value, height=0.1):
    return cantilever(fm.Rectangle(0.02, value, fm.Material(**STEEL)), height).build()


def tube(value):
    return cantilever(fm.Tube(0.01, value, fm.Material(**STEEL))).build()


def hollow(value):
    return cantilever(fm.HollowRectangle(0.02, 0.01, 1e-3, value, fm.Material(**STEEL))).build()


def rigidity(value):
    return cantilever(fm.Rigidity(EIy=value, mass=1.0)).build()


def several_sections(value):
    b = cantilever(fm.Rectangle(0.02, T, fm.Material(**STEEL)))
    b.node("end", (0, 0.2))
    b.add(planar.beam, "tip", "end", section=fm.Tube(0.01, value, fm.Material(**STEEL)), released=(2, 3))
    return b.build()


def laden(value):
    b = cantilever(fm.Rectangle(0.02, T, fm.Material(**STEEL)))
    b.mass("tip", value)
    return b.build()


def length(value):
    return cantilever(fm.Rectangle(0.02, T, fm.Material(**STEEL)), value).build()


def pushed(value):
    b = cantilever(fm.Rectangle(0.02, T, fm.Material(**STEEL)))
    b.force("tip", (0, -1 / value))
    return b.build()


def hinged(value):
    b = fm.Builder()
    b.node("a", (0, 0, 0))
    b.rotation("r")
    b.rotation("s")
    b.add(spatial.hinge, "r", "s", axis=[0, 0, value], stiffness=1.0)
    b.fix("a")
    b.fix("r")
    b.inertia("s", (1, 0, 0, 1, 0, 1))
    return b.build()


def _deformation(p: fm.Point2, q: fm.Point2, *, ref):
    return jnp.stack([jnp.linalg.norm(q - p) - jnp.linalg.norm(ref.q - ref.p)])


def _pressed(*, ref, stiffness):
    # On plain numbers, as a user writes it.
    return ["has a stiffness beyond its range"] if not 1.0 <= float(stiffness) <= 1e4 else []


own_spring = Element(_deformation, stiffness=lambda *, ref, stiffness: jnp.reshape(stiffness, (1, 1)), check=_pressed)


def own(value):
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("cart", (1, 0))
    b.add(own_spring, "wall", "cart", stiffness=value)
    b.fix("wall")
    b.fix("cart", "y")
    b.mass("cart", 1.0)
    return b.build()


FILE = """PLBEAM 1 1 2 3 4
X 1 0 0
X 3 0 0.1
FIX 1
FIX 2
RLSE 1 2 3
END
HALT
EM 1 1.0
ESTIFF 1 0 {1e3*t}
END
END
"""


def from_file(value):
    return fm.read_spacar(FILE, numbers={"t": value}).builder.build()


# A function, and values of its dimension with whether the concrete build takes them; the first one it does not.
CASES = [
    (guide, {-0.6e-3: False, T: True, 0.0: False, 2 * T: True, np.nan: False, np.inf: False}),
    (tube, {0.005: False, 0.001: True, 0.006: False, -0.001: False}),
    (hollow, {0.005: False, 0.001: True}),
    (rigidity, {-1.0: False, 1.0: True}),
    (several_sections, {0.005: False, 0.001: True, 0.0: False}),
    (laden, {-1.0: False, 0.0: True, 1.0: True}),
    (length, {0.0: False, 0.1: True, -0.1: True}),
    (pushed, {np.nan: False, 1.0: True}),
    (hinged, {0.0: False, 1.0: True, -2.0: True}),
    (own, {0.5: False, 2.0: True, 1e5: False}),
    (from_file, {-1.0: False, 1.0: True}),
]


@pytest.mark.slow
@pytest.mark.parametrize(("build", "values"), CASES, ids=lambda one: getattr(one, "__name__", ""))
def test_a_batch_refuses_what_a_concrete_build_refuses(build, values):
    for value, good in values.items():
        if good:
            build(value)
        else:
            with pytest.raises((fm.ModelError, fm.SpacarError)):
                build(value)
    designs = {"value": list(values)}
    expected = [GOOD if good else BAD for good in values.values()]
    for compiled in (True, False):
        found = fm.sweep(build, {"mass": fm.mass}, designs, compiled=compiled)
        assert [fm.RESULTS(c).name for c in found.codes] == expected
        np.testing.assert_array_equal(np.isnan(found["mass"]), [name == BAD for name in expected])
        assert found.failures() == {BAD: expected.count(BAD)}


def frequency(model):
    return fm.frequencies(model)[0]


@pytest.mark.slow
def test_designs_before_the_first_good_one_fill_whole_chunks():
    designs = fm.design.grid(value=np.linspace(-1e-3, 1e-3, 9))
    found = fm.sweep(guide, frequency, designs, chunk=2)
    assert [fm.RESULTS(c).name for c in found.codes] == [BAD] * 5 + [GOOD] * 4
    # The frequency of a leaf spring goes as its thickness but for its rotary inertia, some 1e-5 of it.
    np.testing.assert_allclose(found["frequency"][5:] / found["frequency"][5], [1, 2, 3, 4], rtol=1e-3)


def test_nothing_can_be_built():
    with pytest.raises(fm.ModelError, match="must be positive"):
        fm.sweep(guide, frequency, {"value": [-1e-3, 0.0]}, chunk=1)


@pytest.mark.slow
def test_a_search_does_not_leave_what_can_be_built():
    # The mass is least where the thickness is most negative, but for what can be built.
    found = fm.tune(guide, fm.mass, {"value": T}, {"value": (-1e-3, 1e-3)}, minimize="mass", throw=False)
    assert found.dimensions["value"] > 0
    assert np.min(found.history["value"]) > 0
    assert found.answers["mass"] > 0


@pytest.mark.slow
@pytest.mark.parametrize("together", [1, 2])
def test_a_start_that_cannot_be_built_is_no_design(together):
    found = fm.tune(
        guide,
        frequency,
        {"value": T},
        {"value": (-1e-3, 1e-3)},
        targets={"frequency": 80.0},
        starts=4,
        together=together,
    )
    drawn = np.isnan(found.runs[:, 0])
    assert 0 < np.sum(drawn) < 4
    assert found.answers["frequency"] == approx(80.0, rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("optimizer", ["optax", "optimistix"])
def test_optimisers_of_others_stop_at_what_cannot_be_built(optimizer):
    import optax
    import optimistix

    taken = {"optax": optax.sgd(10.0), "optimistix": optimistix.LevenbergMarquardt(rtol=1e-8, atol=1e-8)}[optimizer]
    found = fm.tune(
        guide,
        {"mass": fm.mass},
        {"value": T},
        {"value": (-1e-3, 1e-3)},
        targets={"mass": -1.0},
        optimizer=taken,
        throw=False,
    )
    assert found.result is fm.RESULTS.impossible_design
    assert found.answers["mass"] > 0
    assert found.dimensions["value"] > 0


@pytest.mark.slow
def test_samples_that_cannot_be_built_are_left_out():
    # One deviation below, nothing is left of the thickness.
    left_out = pytest.warns(fm.FlexmbWarning, match=r"Of 60 samples \d+ have no answers .*leave them out")
    with left_out, pytest.warns(fm.FlexmbWarning, match="'frequency' .* not linear"):
        found = fm.design.tolerances(guide, frequency, {"value": T}, {"value": T}, samples=60, seed=1)
    drawn = found.samples.designs["value"]
    np.testing.assert_array_equal(found.samples.codes == fm.RESULTS.impossible_design, drawn <= 0)
    assert np.any(drawn <= 0)
    assert found.sampled_interval[0, 0] > 0


@pytest.mark.slow
def test_the_code_says_what_to_try():
    assert "bounds" in fm.RESULTS.impossible_design.message


@pytest.mark.slow("False")
@pytest.mark.filterwarnings("ignore::flexmb.BeamTheoryWarning")
@pytest.mark.parametrize("space", [False, True])
def test_checks_of_all_beams_take_many_designs(space):
    """Each kind of section in each beam, asked about all designs at once."""
    room = spatial if space else planar
    steel = fm.Material(**STEEL)

    def build(value):
        flat = fm.Rectangle(0.02, value, steel)
        stated = {"warping_length": 0.1, "warping_modulus": "beam"}
        plain = [flat, fm.Rectangle(0.02, value, steel, torsion="approximate", **stated), fm.Circle(value, steel)]
        plain += [fm.Tube(0.01, value, steel), fm.HollowRectangle(0.02, 0.01, 1e-3, value, steel)]
        plain += [fm.sections.taper(flat, flat), fm.Rigidity(EA=value, EIy=1.0, EIz=1.0, GIt=1.0, mass=1.0)]
        sheared = fm.Rectangle(0.02, value, steel, shear=True)
        used = [(room.spectral_beam(2), section) for section in plain]
        used += [(room.beam, section) for section in [*plain[:5], sheared]] + [(room.leaf_spring(2), flat)]
        used += [(spatial.spectral_beam(2, shear=True), sheared), (spatial.warping_beam, flat)] if space else []
        b = fm.Builder()
        b.node("0", (0,) * (3 if space else 2))
        for i, (element, section) in enumerate(used):
            b.node(str(i + 1), (0.1 * (i + 1), *(0,) * (2 if space else 1)))
            b.add(element, str(i), str(i + 1), section=section, **({"y": (0, 1, 0)} if space else {}))
        b.fix("0")
        return b.build(check=False)

    refused = refusal_of_designs(build, build_once(build, {"value": T}), {"value": T})
    np.testing.assert_array_equal(refused({"value": np.array([T, 2 * T, -T])}), [False, False, True])


@pytest.mark.slow
def test_what_a_block_refuses():
    """Its arguments are asked about in every design, also where the first cannot be, or each is built by itself."""

    def build(length, half_angle, radius):
        b = fm.Builder()
        for name, place in {"base": (0, 0), "middle": (0.1, 0), "stage": (0.2, 0.1)}.items():
            b.node(name, place)
        b.fix("base")
        cross_pivot(b, "base", "middle", length=length, half_angle=half_angle, section=fm.Rigidity(EA=1e4, EIy=1.0))
        sizes = {"width": 0.01, "height": 5e-3, "neck": 5e-4, "material": fm.Material(**STEEL)}
        notch_hinge(b, "middle", "stage", name="hinge", radius=radius, **sizes)
        return b.build(check=False)

    good = {"length": 0.05, "half_angle": 0.7, "radius": 3e-3}
    refused = refusal_of_designs(build, build_once(build, good), good)
    bad = [{"length": -0.05}, {"half_angle": 2.0}, {"half_angle": -0.7}, {"radius": -3e-3}, {"radius": 1e-3}]
    rows = [good, *[{**good, **one} for one in bad]]
    designs = {name: np.array([row[name] for row in rows]) for name in good}
    np.testing.assert_array_equal(refused(designs), [False, True, True, True, True, True])
    first = {name: designs[name][[1, 0]] for name in good}
    for compiled in (True, False):
        found = fm.sweep(build, {"mass": fm.mass}, fm.design.Designs(first), compiled=compiled)
        assert [fm.RESULTS(code).name for code in found.codes] == [BAD, GOOD]
    with pytest.raises(fm.ModelError, match="Argument `radius` must be positive"):
        build(0.05, 0.7, -3e-3)


def test_conditions_do_not_leave_a_program_of_the_build_itself():
    @jax.jit
    def constant(width):
        return fm.sections.torsion_series(width, 1e-3)

    def build(width):
        return cantilever(fm.Rigidity(EIy=constant(width), mass=1.0)).build(check=False)

    refused = refusal_of_designs(build, build_once(build, {"width": 1.0}), {"width": 1.0})
    np.testing.assert_array_equal(refused({"width": np.array([2.0, 3.0])}), [False, False])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::flexmb.BeamTheoryWarning")
def test_known_numbers_stay_so_beside_traced_ones():
    """Sections whose functions compute with constants, and constants that are arrays of JAX."""
    steel, thick, wire = fm.Material(**STEEL), jnp.asarray(5e-4), jnp.asarray(1e-3)

    def build(mass):
        flat = fm.Rectangle(0.02, thick, steel)
        used = [(spatial.spectral_beam(2), fm.sections.stepped([flat, fm.Rectangle(0.02, 1e-3, steel)], [0.4]))]
        used += [(spatial.leaf_spring(2), fm.sections.taper(fm.Rectangle(0.02, 1e-3, steel), flat))]
        used += [
            (spatial.beam, fm.Tube(0.01, thick, steel)),
            (spatial.beam, fm.HollowRectangle(0.02, 0.01, wire, wire, steel)),
        ]
        b = fm.Builder()
        b.node("0", (0, 0, 0))
        for i, (element, section) in enumerate(used):
            b.node(str(i + 1), (0.1 * (i + 1), 0, 0))
            b.add(element, str(i), str(i + 1), name=f"e{i}", section=section, y=(0, 1, 0))
        b.prestress("e2", wire)
        b.mass("4", mass)
        b.fix("0")
        return b.build(check=False)

    alone = float(fm.mass(build(0.0)))
    refused = refusal_of_designs(build, build_once(build, {"mass": 1.0}), {"mass": 1.0})
    np.testing.assert_array_equal(refused({"mass": np.array([2.0, -3.0])}), [False, True])
    assert float(jax.jit(lambda mass: fm.mass(build(mass)))(0.3)) == approx(alone + 0.3)
