"""Lean models: no larger than an expert's, and no worse than they say."""

import dataclasses

import jax
import numpy as np
import pytest
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.mechanisms import mechanism_path

STEEL = fm.Material(E=210e9, G=80e9, rho=7850.0)
LEAF = fm.Rectangle(0.018, 0.0005, STEEL)


def shipped(name):
    return fm.read_spacar(mechanism_path(name)).builder.build()


@pytest.fixture(scope="module")
def nineteen():
    return shipped("pf3d19dof")


@pytest.fixture(scope="module")
def lean_guide(nineteen):
    return fm.lean(nineteen, bandwidth=100.0)


def frequencies(model):
    """Of the linearisation, which is compiled for other questions too."""
    return np.asarray(fm.frequencies(fm.linearize(model)))


# -- the tutorial's guide -----------------------------------------------------------------------------------------


@pytest.mark.slow
def test_guide_in_the_plane():
    found = fm.lean(shipped("pf2d3dof"), bandwidth=100.0)
    assert found.model.q_labels == ["3.x"]
    assert found.fixed == ("1.e1", "3.e1")
    # Tutorial 3.1: 10.6448 Hz with one degree of freedom.
    assert frequencies(found.model)[0] == approx(10.6448474, rel=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize(("bandwidth", "n_q"), [(100.0, 1), (200.0, 2), (260.0, 3)])
def test_guide_in_space(nineteen, bandwidth, n_q):
    """The cut leaf spring vibrates at 148.6 Hz, the whole one at 252 Hz (tutorial 4.2)."""
    found = fm.lean(nineteen, bandwidth=bandwidth)
    assert found.model.topology.n_q == n_q
    full, own = (frequencies(m)[:n_q] for m in (nineteen, found.model))
    # Round-off of a ratio of frequencies.
    assert np.max(np.abs(own / full - 1)) <= found.error.frequencies + 1e-13
    assert found.error.frequencies <= 0.01
    # Constraints are kept by the whole chain of ties.
    assert fm.mobility(found.model).status == "ok"


@pytest.mark.slow
def test_report_says_what_is_left_out(lean_guide):
    text = lean_guide.report()
    assert "19 degrees of freedom; lean model: 1 (3.y)" in text
    assert "FIXED, since they hardly deform" in text
    assert "5 further combinations" in text


@pytest.mark.slow
def test_lean_model_moves_as_the_full_one(nineteen, lean_guide):
    """A stroke of 2 mm: the bar sinks by 0.6 d^2/L, THEORY.md 4, in both."""

    def at_stroke(model):
        force = np.zeros(model.topology.n_x)
        force[model.labels.known("3")[1]] = 1.9
        loads = dataclasses.replace(model.parameters.loads, force=jax.numpy.asarray(force))
        parameters = dataclasses.replace(model.parameters, loads=loads)
        return fm.linearize(dataclasses.replace(model, parameters=parameters)).x[model.labels.known("3")]

    full, own = at_stroke(nineteen), at_stroke(lean_guide.model)
    stroke = float(own[1])
    assert stroke == approx(float(full[1]), rel=5e-3)
    # The middle node of the whole leaf spring makes the parabola two chords: 5 % of the shortening or so.
    assert 0.1 - float(own[2]) == approx(0.6 * stroke**2 / 0.1, rel=0.05)


@pytest.mark.slow
def test_lean_models_have_derivatives(nineteen, lean_guide):
    def frequency(model):
        def of(scale):
            properties = tuple(
                block | {"section": jax.tree.map(lambda v: v * scale, block["section"])}
                if "section" in block
                else block
                for block in model.parameters.properties
            )
            scaled = dataclasses.replace(model.parameters, properties=properties)
            return fm.frequencies(lean_guide.of(dataclasses.replace(model, parameters=scaled)))[0]

        return of

    of = frequency(nineteen)
    h = 1e-4
    difference = (float(of(1 + h)) - float(of(1 - h))) / (2 * h)
    # Mass and stiffness of the leaf springs both grow. Difference: round-off 1e-12 over h, truncation h^2.
    assert float(jax.grad(of)(1.0)) == approx(difference, rel=1e-6)
    assert float(jax.jacfwd(of)(1.0)) == approx(difference, rel=1e-6)


# -- further mechanisms, against sixteen beams --------------------------------------------------------------------


def chain(b, name, p, q, beams, section=LEAF):
    """A leaf spring of so many beams from node to node."""
    begin, end = (np.array(b.nodes[n].start, float) for n in (p, q))
    nodes = [p, *(f"{name}{i}" for i in range(1, beams)), q]
    for i, node in enumerate(nodes[1:-1], start=1):
        b.node(node, begin + (end - begin) * i / beams)
    for i in range(beams):
        b.add(planar.beam, nodes[i], nodes[i + 1], name=f"{name} {i + 1}", section=section)


def cross_pivot(beams):
    b = fm.Builder()
    for node, place in {"A": (0, 0), "B": (0.06, 0), "C": (0.06, 0.06), "D": (0, 0.06)}.items():
        b.node(node, place)
    chain(b, "first", "A", "C", beams)
    chain(b, "second", "B", "D", beams)
    b.add(planar.beam, "C", "D", name="body")
    b.fix("A")
    b.fix("B")
    b.mass("C", 0.2)
    b.mass("D", 0.2)
    b.input("C", "x")
    b.output("D", "x")
    return b.build()


def folded_guide(outer, inner):
    b = fm.Builder()
    for i, x in enumerate((0.0, 0.1)):
        b.node(f"foot{i}", (x, 0))
        b.node(f"fold{i}", (x, 0.1))
        b.node(f"stage{i}", (0.02 + 0.6 * x, 0))
        chain(b, f"outer{i}", f"foot{i}", f"fold{i}", outer)
        chain(b, f"inner{i}", f"fold{i}", f"stage{i}", inner)
        b.fix(f"foot{i}")
        b.mass(f"fold{i}", 0.02)
        b.mass(f"stage{i}", 0.2)
    b.add(planar.beam, "fold0", "fold1", name="frame")
    b.add(planar.beam, "stage0", "stage1", name="stage")
    b.input("stage0", "x")
    b.output("stage0", "x")
    b.output("fold0", "x")
    return b.build()


def four_bar(hinges):
    """Four flexures of 10 mm between rigid links."""
    b = fm.Builder()
    thin = fm.Rectangle(0.018, 0.0003, STEEL)
    for side, x in (("left", 0.0), ("right", 0.1)):
        for node, y in {"foot": 0.0, "low": 0.01, "high": 0.09, "top": 0.1}.items():
            b.node(f"{side} {node}", (x, y))
        chain(b, f"{side} lower", f"{side} foot", f"{side} low", hinges, thin)
        b.add(
            planar.beam, f"{side} low", f"{side} high", name=f"{side} link", section=fm.Rigidity(mass=0.5), released=()
        )
        chain(b, f"{side} upper", f"{side} high", f"{side} top", hinges, thin)
        b.fix(f"{side} foot")
        b.mass(f"{side} top", 0.3)
    b.add(planar.beam, "left top", "right top", name="coupler")
    b.input("left top", "x")
    b.output("left top", "x")
    return b.build()


def slider_crank(rod):
    """A crank that points upwards, a flexible rod, a slider against a spring."""
    b = fm.Builder()
    for node, place in {"axle": (0, 0), "pin": (0, 0.1), "slider": (0.3, 0), "wall": (0.5, 0)}.items():
        b.node(node, place)
    b.rotation("crank")
    b.add(planar.rigid_beam, "axle", "crank", "pin", name="arm")
    chain(b, "rod", "pin", "slider", rod, fm.Rectangle(0.01, 0.003, STEEL))
    b.add(planar.truss, "slider", "wall", name="spring", section=fm.Rigidity(EA=2000.0))
    b.fix("axle")
    b.fix("slider", "y")
    b.fix("wall")
    b.mass("slider", 0.5)
    return b.build()


def two_stage(lower, upper):
    """As many parts of each kind as the folded guide has, which is compiled already."""
    b = fm.Builder()
    for i, x in enumerate((0.0, 0.1)):
        for level, y in enumerate((0.0, 0.1, 0.18)):
            b.node(f"n{i}{level}", (x, y))
        chain(b, f"lower{i}", f"n{i}0", f"n{i}1", lower)
        chain(b, f"upper{i}", f"n{i}1", f"n{i}2", upper)
        b.fix(f"n{i}0")
        b.mass(f"n{i}1", 0.3)
        b.mass(f"n{i}2", 0.2)
    for level in (1, 2):
        b.add(planar.beam, f"n0{level}", f"n1{level}", name=f"stage {level}")
    b.input("n02", "x")
    b.output("n02", "x")
    b.output("n01", "x")
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("build", "bandwidth", "n_q"),
    [
        (cross_pivot, 100.0, 1),
        (folded_guide, 50.0, 2),
        (four_bar, 50.0, 1),
        (slider_crank, 100.0, 2),
        (two_stage, 60.0, 2),
    ],
)
def test_the_error_is_bounded(build, bandwidth, n_q):
    found = fm.lean(build, bandwidth=bandwidth)
    fine = build(**dict.fromkeys(found.beams, 16))
    ends = [fm.linearize(model) for model in (fine, found.model)]
    exact, own = (np.asarray(fm.frequencies(lin)) for lin in ends)
    count = max(int(np.sum(exact <= bandwidth)), 1)
    true = np.max(np.abs(own[:count] / exact[:count] - 1))
    assert true <= found.error.frequencies <= 0.01
    assert found.model.topology.n_q == n_q
    for signal in fine.labels.inputs:
        node, axis = fine.labels.x[signal.index].of, fine.labels.x[signal.index].symbol
        exact, own = (float(fm.stiffness(lin, node, axis)) for lin in ends)
        assert abs(exact / own - 1) <= found.error.stiffness + 1e-9 <= 0.01


@pytest.mark.slow
def test_stiffness_at_a_node_asks_for_more():
    """Elongations of the leaf springs carry the stage, so that they stay where its support stiffness is asked for."""
    b_full = two_stage(2, 2)
    coarse = fm.lean(b_full, bandwidth=60.0)
    asked = fm.lean(b_full, bandwidth=60.0, nodes=["n02"])
    assert asked.model.topology.n_q > coarse.model.topology.n_q
    full, own = (fm.compliance(m, "n02") for m in (b_full, asked.model))
    np.testing.assert_allclose(np.diag(own), np.diag(full), rtol=0.01)


# -- too lean, and what is refused --------------------------------------------------------------------------------


@pytest.mark.slow
def test_too_lean_is_said():
    one = shipped("pf3d")
    assert fm.design.too_lean(one, bandwidth=100.0) == ()
    reasons = fm.design.too_lean(one, bandwidth=200.0)
    assert len(reasons) == 2
    # Closed form of a beam with both ends held: 22.37 sqrt(EI/m)/L^2 / 2 pi.
    assert "vibrates between its ends at 265.8 Hz" in reasons[0]
    assert fm.design.too_lean(shipped("pf3d19dof"), bandwidth=200.0) == ()


@pytest.mark.slow
def test_fixed_deformations_that_matter_are_named():
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("end", (0.1, 0))
    b.add(planar.beam, "foot", "end", name="leaf", section=LEAF, released=(2,))
    b.fix("foot")
    b.mass("end", 0.1)
    (reason,) = fm.design.too_lean(b.build(), bandwidth=20.0)
    assert "leaf.e3" in reason
    assert "a release changes it" in reason


@pytest.mark.slow
def test_what_is_refused(nineteen, lean_guide):
    with pytest.raises(fm.ModelError, match="`bandwidth` must be positive, but is 0"):
        fm.lean(nineteen, bandwidth=0)
    with pytest.raises(fm.ModelError, match="needs the nodes and elements"):
        lean_guide.of(shipped("pf3d"))
    with pytest.raises(fm.AnalysisError, match="No smaller model answers"):
        fm.lean(shipped("pf3d"), bandwidth=100.0)
    with pytest.raises(fm.ModelError, match="`finest` must be at least 2"):
        fm.lean(cross_pivot, bandwidth=100.0, finest=1)
    with pytest.raises(fm.ModelError, match="numbers of beams"):
        fm.lean(lambda: nineteen, bandwidth=100.0)


@pytest.mark.slow
def test_free_and_unstable_motions_are_refused():
    """A stage that nothing holds back, and a strut beyond its buckling load (pi^2 EI / 4 L^2 = 0.97 kN)."""
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("stage", (1, 0))
    b.add(planar.truss, "wall", "stage", name="rail", released=())
    b.fix("wall")
    b.mass("stage", 1.0)
    strut = fm.Builder()
    for i in range(3):
        strut.node(f"n{i}", (0.05 * i, 0))
    for i in range(2):
        strut.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"beam {i}", section=LEAF, released=(2, 3))
    strut.fix("n0")
    strut.mass("n2", 0.1)
    strut.force("n2", (-100.0, 0))
    for case in (b.build(), strut.build(), lambda beams: strut.build()):
        with pytest.raises(fm.AnalysisError, match="The state is unstable"):
            fm.lean(case, bandwidth=100.0)


@pytest.mark.slow
def test_spatial_chain_is_reduced_too():
    b = fm.Builder()
    for i in range(4):
        b.node(f"n{i}", (0.05 * i, 0, 0))
    for i in range(3):
        b.add(spatial.beam, f"n{i}", f"n{i + 1}", name=f"beam {i + 1}", section=LEAF, y=(0, 1, 0))
    b.fix("n0")
    b.mass("n3", 0.05)
    full = b.build()
    found = fm.lean(full, bandwidth=30.0, nodes=["n3"])
    own, exact = (np.diag(fm.compliance(m, "n3")) for m in (found.model, full))
    np.testing.assert_allclose(own, exact, rtol=0.01)
    assert found.model.topology.n_q <= 6


@pytest.mark.slow
def test_a_stroke_is_asked_for():
    """Sideways support falls to a fraction over the stroke; the lean model follows."""
    b = fm.Builder()
    for i, x in enumerate((0.0, 0.1)):
        b.node(f"foot{i}", (x, 0))
        b.node(f"top{i}", (x, 0.1))
        chain(b, f"leaf{i}", f"foot{i}", f"top{i}", 2)
        b.fix(f"foot{i}")
        b.mass(f"top{i}", 0.3)
    b.add(planar.beam, "top0", "top1", name="stage")
    b.force("top0", (8.0, 0), increment=True)
    full = b.build()
    found = fm.lean(full, bandwidth=100.0, nodes=["top0"], increments=(0.0, 0.5, 1.0))
    assert found.model.topology.n_q < full.topology.n_q
    for increment in (0.0, 0.5, 1.0):
        ends = [fm.linearize(m, increment=increment) for m in (full, found.model)]
        exact, own = (np.diag(fm.compliance(lin, "top0")) for lin in ends)
        np.testing.assert_allclose(own, exact, rtol=0.01)
        assert float(ends[1].x[full.labels.known("top0")[0]]) == approx(
            float(ends[0].x[full.labels.known("top0")[0]]), rel=1e-3
        )


@pytest.mark.slow("0.0")
@pytest.mark.parametrize("strain", [0.0, 2e-3])
def test_what_a_constant_load_or_strain_moves_is_kept(strain):
    """A mass on a soft spring along x, and on a stiff one along y, which its weight or a piezo in its place moves."""
    b = fm.Builder()
    for name, place in {"w": (0, 0), "c": (0.1, 0), "f": (0.1, -0.1)}.items():
        b.node(name, place)
    b.add(planar.truss, "w", "c", section=fm.Rigidity(EA=0.1 * 62.83**2))
    b.add(planar.truss, "f", "c", name="stiff", section=fm.Rigidity(EA=0.1 * 502.65**2))
    b.fix("w")
    b.fix("f")
    b.mass("c", 1.0)
    if strain:
        b.strain("stiff", strain)
    else:
        b.gravity((0, -9.81))
    with pytest.raises(fm.AnalysisError, match="No smaller model answers"):
        fm.lean(b.build(), bandwidth=30.0)


@pytest.mark.slow
@pytest.mark.parametrize("space", [False, True])
def test_leaf_springs_side_by_side_have_one_freedom(space):
    """Their rotations depend on each other, which FIXED deformations must not state twice."""
    b = fm.Builder()
    zero, extra = ((0.0,), {"y": (0, 0, 1)}) if space else ((), {})
    b.node("base", (0, 0, *zero))
    b.node("stage", (0, 0.1, *zero))
    b.fix("base")
    section = fm.Rectangle(0.02, 0.5e-3, fm.Material(E=210e9, G=80.77e9, rho=7850))
    fm.blocks.parallel_guide(b, "base", "stage", length=0.1, spacing=0.05, section=section, **extra)
    b.mass("stage", 0.5)
    full = b.build()
    found = fm.lean(full, bandwidth=100.0)
    assert found.model.topology.n_q == 1
    assert found.error.worst < 0.01
    if not space:
        # Loads at the stage have three static responses: along x, along y and about z.
        at_stage = fm.lean(full, bandwidth=100.0, nodes=["stage"])
        assert at_stage.model.topology.n_q == 3
        assert at_stage.error.worst < 0.01
    # Two strips in sway, whose stiffness lies between that of a beam and that of a plate, with 26/35 of their mass.
    stiffness, mass = 2 * 12 * 210e9 * 0.02 * 0.5e-3**3 / 12 / 0.1**3, 0.5 + 2 * 26 / 35 * 7850 * 0.02 * 0.5e-3 * 0.1
    beam = np.sqrt(stiffness / mass) / (2 * np.pi)
    assert beam < found.frequencies[0] < beam / np.sqrt(1 - 0.3**2)
