"""Degrees of freedom of models of many coordinates, which are found part by part, and their mistakes."""

import warnings

import jax
import numpy as np
import pytest
from cases import mechanisms
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial
from flexmb.design.stroke import driven, unit_of_driven
from flexmb.math import subspace

STOREYS = 60


def rack(storeys=STOREYS, **held) -> fm.Builder:
    """Rigid plates on two columns of leaf springs each, six coordinates and two rotations a storey."""
    section = fm.Rectangle(10e-3, 1e-3, mechanisms.steel())
    b = fm.Builder()
    for i in range(storeys + 1):
        b.node(f"l{i}", (0, 0.1 * i))
        b.node(f"r{i}", (0.1, 0.1 * i))
    for i in range(storeys):
        for side in "lr":
            b.node(f"{side}{i}m", (0.1 * (side == "r"), 0.1 * i + 0.05))
            b.add(planar.beam, f"{side}{i}", f"{side}{i}m", section=section, **held)
            b.add(planar.beam, f"{side}{i}m", f"{side}{i + 1}", section=section, **held)
        b.add(planar.beam, f"l{i + 1}", f"r{i + 1}", name=f"plate{i + 1}")
    b.fix("l0")
    b.fix("r0")
    return b


@pytest.fixture(scope="module")
def model():
    return rack().build()


@pytest.mark.slow
def test_what_is_rigid_leaves_its_own_motions(model):
    assert model.topology.n_x == 12 * STOREYS + 6
    # Of each storey, two nodes that are free, and a plate: coordinates, where there are so many.
    assert model.topology.n_q == 9 * STOREYS
    assert {name.split(".")[-1] for name in model.q_labels} == {"x", "y", "phi"}
    # Columns that do not stretch: each takes a coordinate away.
    assert rack(released=(2, 3)).build().topology.n_q == (9 - 4) * STOREYS


@pytest.mark.slow
def test_they_determine_the_same_motions(model):
    """Beside deformations, which are found where there are fewer coordinates."""
    few = rack(4).build()
    assert {name.split(".")[-1] for name in few.q_labels} == {"e1", "e2", "e3"}
    own = [name for name in model.q_labels if name.split(".")[0].strip("lrm") in list("1234")]
    floor = [name for name in model.q_labels if name.split(".")[0] in ("l0m", "r0m")]
    named = rack(4).build(dofs=[name for name in (*own, *floor) if "4m" not in name])
    np.testing.assert_allclose(fm.frequencies(named), fm.frequencies(few), rtol=1e-8)


def test_over_constraints_of_many_coordinates():
    b = rack()
    b.add(planar.beam, "l30", "r30", name="second plate")
    with pytest.raises(fm.MechanismError, match=r"over-constraints: 3(.|\n)*'?second plate") as caught:
        b.build()
    assert "plate31" not in str(caught.value)


def test_mistakes_of_many_coordinates():
    b = rack()
    b.dof("l30", "x")
    with pytest.raises(
        fm.MechanismError, match=r"NDOF = 540, but 1 degrees of freedom are named\. Name none, and build\(\) finds all"
    ):
        b.build()
    twice = rack()
    twice.dof("l1", "phi")
    twice.dof("r1", "phi")
    with pytest.raises(fm.MechanismError, match="NDOF = 540, but 2"):
        twice.build()


def test_repeated_among_many(model):
    """The turn of a plate named at both its ends, in place of one of the coordinates of another storey."""
    names = [name for name in model.q_labels if name != "l2m.x"]
    other = next(f"{node}.rotation.phi" for node in ("l1", "r1") if f"{node}.rotation.phi" not in names)
    with pytest.raises(fm.MechanismError, match=r"do not determine the rest") as caught:
        rack().build(dofs=[*names, other])
    assert "l2m.x" in str(caught.value)


def test_too_many_that_hang_together(monkeypatch):
    monkeypatch.setattr(subspace, "MOST_CONNECTED", 100)
    with pytest.raises(fm.MechanismError, match=r"360 deformations and 360 coordinates are connected.*check=False"):
        rack(released=(2, 3)).build()


def test_deformations_of_a_chain_determine_it():
    """As those of a short one, the angle of its hinge among them, with which it may turn as far as it likes."""
    section = fm.Rectangle(0.02, 2e-3, mechanisms.steel())

    def chain(count):
        b = fm.Builder()
        b.node("n0", (0, 0))
        b.rotation("ground")
        b.fix("ground")
        b.fix("n0", "position")
        b.add(planar.hinge, "ground", "n0.rotation", name="hinge", stiffness=1.0)
        for i in range(count):
            b.node(f"n{i + 1}", (0.3 * (i + 1) / count, 0))
            b.add(planar.beam, f"n{i}", f"n{i + 1}", section=section)
        return b.build()

    for count in (2, 210):
        labels = chain(count).q_labels
        assert sorted(labels) == sorted(["hinge.e1", *(f"beam {i + 2}.e{e}" for i in range(count) for e in (1, 2, 3))])
    many = chain(210)
    assert many.topology.n_x > 600
    assert unit_of_driven(many, driven(many, "hinge.e1")) == "rad"
    assert unit_of_driven(many, driven(many, "beam 2.e1")) == "m"


@pytest.mark.slow("element1")
@pytest.mark.parametrize("element", [spatial.spectral_beam(order=4), spatial.leaf_spring(order=4)])
def test_degrees_of_freedom_beside_the_stage_leave_leaf_springs_free_to_bend(element):
    """A guide in space: to shift its stage two coefficients of the soft curvature of each leaf spring follow."""
    leaf = fm.Rectangle(0.02, 0.5e-3, fm.Material(E=210e9, G=80e9, rho=7850.0))
    b = fm.Builder()
    for name, place in {"A": (0, 0, 0), "B": (0, 0.1, 0), "C": (0.1, 0.1, 0), "D": (0.1, 0, 0)}.items():
        b.node(name, place)
    for name, ends in (("left", "AB"), ("right", "DC")):
        b.add(element, *ends, name=name, section=leaf, y=(0, 0, 1))
    b.add(spatial.beam, "B", "C")
    b.fix("A")
    b.fix("D")
    b.mass("B", 0.1)
    b.dof("B", "x")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fm.BeamTheoryWarning)
        model = b.build()
    found, (stretch, _, soft, _, *_) = set(model.q_labels), element.fields
    for name in ("left", "right"):
        assert found.isdisjoint(f"{name}.e{n}" for n in soft[:2])
        assert found.issuperset(f"{name}.e{n}" for n in (*stretch, *soft[2:]))


def test_degrees_of_freedom_beside_the_stage_of_arcs_are_what_varies_along_them():
    """Of curved leaf springs all coefficients have a part in where their ends come."""
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, 0.1), "C": (0.1, 0.1), "D": (0.1, 0)}.items():
        b.node(name, place)
    section = fm.Rigidity(EA=1e6, EIy=1.0)
    for name, ends in (("left", "AB"), ("right", "DC")):
        b.add(planar.spectral_beam(order=5), *ends, name=name, section=section, curvature=15.0)
    b.add(planar.rigid_body, "B", "C")
    b.fix("A")
    b.fix("D")
    b.dof("B", "x")
    stretch, bending = planar.spectral_beam(order=5).fields
    wanted = {f"{name}.e{n}" for name in ("left", "right") for n in (*stretch, *bending[2:])}
    assert wanted <= set(b.build().q_labels)


@pytest.mark.slow("True")
@pytest.mark.parametrize("named", [False, True])
def test_degrees_of_freedom_found_for_one_design_serve_others(named):
    """A cross pivot of stiffness 8 EI/L (1 - 3 r + 3 r^2): where leaf springs cross in their middles some bend not."""
    ratios, length, section = np.array([0.0, 0.3, 0.5, 1.0]), 0.05, fm.Rigidity(EA=1e6, EIy=0.1)

    def pivot(ratio):
        b = fm.Builder()
        ends, angle = {}, np.pi / 4
        for side, sign in (("l", 1.0), ("r", -1.0)):
            along = np.array([sign * np.sin(angle), np.cos(angle)])
            ends[side] = f"{side}0", f"{side}1"
            b.node(ends[side][0], -ratio * length * along)
            b.node(ends[side][1], (1 - ratio) * length * along)
            b.add(planar.spectral_beam(order=4), *ends[side], name=side, section=section)
            b.fix(ends[side][0])
        b.add(planar.rigid_body, "l1", "r1")
        b.mass("l1", 1.0)
        if named:
            b.dof("l1.rotation", "phi")
        return b.build()

    def stiffness(model):
        return 1 / fm.compliance(model, "l1")[2, 2]

    found = fm.sweep(pivot, {"k": stiffness}, {"ratio": ratios})["k"]
    np.testing.assert_allclose(found, 8 * 0.1 / length * (1 - 3 * ratios + 3 * ratios**2), rtol=1e-3)


def guide_to_release(thickness, height=0.1, **kwargs):
    """Three leaf springs of 12 EI/h^3 each, of which the elongation of one has to give way."""
    b = fm.Builder()
    leaf = fm.Rigidity(EA=1e6, EIy=2e8 * thickness**3)
    for i in range(3):
        b.node(f"A{i}", (0.05 * i, 0))
        b.node(f"B{i}", (0.05 * i, height))
        b.fix(f"A{i}")
        b.add(planar.beam, f"A{i}", f"B{i}", section=leaf, released=(2, 3))
        if i:
            b.add(planar.rigid_body, "B0", f"B{i}")
    b.mass("B0", 0.1)
    return b.build(release="auto", **kwargs)


@pytest.mark.slow
def test_what_is_over_constrained_is_released_beside_traced_sections():
    """Its frequency goes with the root of the cube of the thickness."""

    def frequency(thickness):
        return fm.frequencies(guide_to_release(thickness))[0]

    expected = np.sqrt(3 * 12 * 2e8 * 0.5e-3**3 / 0.1**3 / 0.1) / (2 * np.pi)
    assert float(frequency(0.5e-3)) == approx(expected, rel=1e-9)
    assert float(jax.grad(frequency)(0.5e-3)) == approx(1.5 * expected / 0.5e-3, rel=1e-9)
    assert float(jax.jit(frequency)(0.5e-3)) == approx(expected, rel=1e-9)


def test_a_release_that_is_not_looked_for_is_refused():
    with pytest.raises(fm.ModelError, match="cannot be found while numbers of the model's geometry are traced"):
        jax.grad(lambda height: fm.frequencies(guide_to_release(0.5e-3, height))[0])(0.1)
    with pytest.raises(fm.ModelError, match="release='auto' needs the checks: leave out check=False"):
        guide_to_release(0.5e-3, check=False)


def test_coefficients_found_beside_named_degrees_of_freedom_are_known_as_found():
    """A driven motion that starts elsewhere depends on them, and warns by their names."""
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, 0.1), "C": (0.1, 0.1), "D": (0.1, 0)}.items():
        b.node(name, place)
    for name, ends in (("left", "AB"), ("right", "DC")):
        b.add(planar.spectral_beam(order=3), *ends, name=name, section=fm.Rigidity(EA=1e6, EIy=1.0))
    b.add(planar.rigid_body, "B", "C")
    b.fix("A")
    b.fix("D")
    b.dof("B", "x")
    model = b.build()
    assert len(model.q_labels) > 1
    assert set(model.labels.found) == set(model.q_labels) - {"B.x"}
    assert b.build(dofs=model.q_labels).labels.found == ()


@pytest.mark.parametrize("how", ["auto", "named"])
def test_an_unchecked_model_keeps_its_start(how):
    """An oscillator let go at 0.1 m: 0.1 cos(t)."""
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("b", (1, 0))
    b.fix("a")
    b.fix("b", "y")
    b.add(planar.truss, "a", "b", section=fm.Rigidity(EA=1.0), released=(1,))
    b.mass("b", 1.0)
    b.start("b", "x", 0.1, -0.2)
    model = b.build(dofs=how, check=False)
    assert model.q_labels == ["b.x"]
    np.testing.assert_array_equal(np.ravel(model.parameters.start), [0.1, -0.2])


@pytest.mark.parametrize("drag", [False, True], ids=["free", "drag"])
@pytest.mark.parametrize("first", [False, True], ids=["drag behind", "drag before"])
def test_a_pendulum_swings_by_its_angle(drag, first):
    """Positions turn back after a quarter of a turn. Drag measures displacements, which are no better."""
    b = fm.Builder()
    b.node("p", (0, 0))
    b.node("q", (1, 0))
    if drag and first:
        b.add(planar.beam_drag, "p", "q", damping=0.1)
    b.add(planar.rigid_body, "p", "q")
    if drag and not first:
        b.add(planar.beam_drag, "p", "q", damping=0.1)
    b.fix("p", "position")
    assert b.build().q_labels == ["p.rotation.phi"]


def test_drag_changes_no_degree_of_freedom():
    section = fm.Rigidity(EA=1e3, EIy=1.0, EIz=1.0, GIt=1.0)
    found = []
    for kind, axes in ((planar, 2), (spatial, 3)):
        for drag in (False, True):
            b = fm.Builder()
            b.node("p", (0, 0, 0)[:axes])
            b.node("q", (0.3, 0.4, 0)[:axes])
            if drag:
                b.add(kind.beam_drag, "p", "q", name="along", damping=0.1)
                b.add(kind.drag, "q", name="ball", damping=0.1)
            b.add(kind.beam, "p", "q", name="leaf", section=section)
            b.fix("p")
            found.append(b.build().q_labels)
    planar_labels, spatial_labels = ([f"leaf.e{i}" for i in range(1, count + 1)] for count in (3, 6))
    assert found == [planar_labels, planar_labels, spatial_labels, spatial_labels]
