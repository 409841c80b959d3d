"""Scripts of SPACAR Light: its examples against closed forms and models built by hand, releases, and faults."""

import functools
import re
import warnings

import jax
import numpy as np
import pytest
from cases.tolerances import approx
from scipy.spatial.transform import Rotation

import flexmb as fm
from flexmb import spatial
from flexmb.spacar.light import load_steps
from flexmb.spacar.light_checks import check_script
from flexmb.spacar.light_fields import read_script

STEEL = {"emod": 210e9, "smod": 80e9, "dens": 7800.0}
UP = [0, 0, 1]  # width of the leaf springs along z


def leaf(thickness=0.5e-3, width=50e-3, **fields):
    return {**STEEL, "cshape": "rect", "dim": [width, thickness], "orien": UP, "flex": range(1, 7), **fields}


def body(**fields):
    return {"dens": 2700.0, "cshape": "rect", "dim": [50e-3, 25e-3], "orien": UP, **fields}


# -- parallel guide ---------------------------------------------------------------------------------------------------

GUIDE = [[0, 0, 0], [0, 0.1, 0], [0.05, 0.1, 0], [0.1, 0.1, 0], [0.1, 0, 0]], [[1, 2], [2, 3], [3, 4], [4, 5]]


def guide(thickness=0.5e-3, **opt):
    """Two leaf springs of which one is pliable in its plane too, so that nothing is over-constrained."""
    nprops = {1: {"fix": True}, 5: {"fix": True}}
    eprops = [
        {"elems": 1, **leaf(thickness, flex=[2, 3, 4])},
        {"elems": 4, **leaf(thickness, flex=[2, 3, 4, 6])},
        {"elems": [2, 3], **body()},
    ]
    return *GUIDE, nprops, eprops, opt


def guide_frequency(t):
    """Closed form: both leaf springs in sway with shear, their mass with that of the cubic interpolation."""
    length, width, nu = 0.1, 50e-3, 210 / 160 - 1
    i, k = width * t**3 / 12, 10 * (1 + nu) / (12 + 11 * nu)
    phi = 12 * 210e9 * i / (80e9 * width * t * k * length**2)
    mass = 2700 * 50e-3 * 25e-3 * 0.1 + 2 * 7800 * width * t * length
    # Cubic mass of the sway, 13/35 of a leaf, instead of the half of it that the line above gives to each end.
    mass += 2 * (13 / 35 - 1) * 7800 * width * t * length
    return np.sqrt(24 * 210e9 * i / (length**3 * (1 + phi)) / mass) / (2 * np.pi)


@functools.cache
def run_guide():
    return fm.spacar.spacar_light(*guide())


@pytest.mark.slow
def test_frequency_of_a_guide_is_its_closed_form():
    out = run_guide()
    assert out.ndof == 1
    assert out.freq.shape == (1, 1)
    assert out.freq[0, 0] == approx(guide_frequency(0.5e-3), rel=1e-9)
    assert sum(len(numbers) for numbers in out.overconstraints.values()) == 6
    # What is FIXED does not give way: no elongation, so that the support stiffness is infinite at zero stroke.
    sway = 24 * 210e9 * 50e-3 * 0.5e-3**3 / 12 / 0.1**3
    np.testing.assert_allclose(1 / out.node(3).CMglob[0, 0], sway, rtol=1e-3)
    assert abs(out.node(3).CMglob[1, 1]) < 1e-12 * out.node(3).CMglob[0, 0]
    assert out.node(3).CMglob.shape == (6, 6, 1)
    assert fm.spacar.spacar_light(*guide(calccompl=False)).node(3).CMloc is None


@pytest.mark.slow
def test_derivative_through_the_script():
    # Releases are found inside the trace, from the geometry alone.
    def frequency(t):
        return fm.frequencies(fm.spacar.spacar_light_model(*guide(t)))[0]

    value, slope = fm.jit(jax.value_and_grad(frequency))(0.5e-3)
    assert value == approx(guide_frequency(0.5e-3), rel=1e-9)
    step = 1e-8
    difference = (guide_frequency(0.5e-3 + step) - guide_frequency(0.5e-3 - step)) / (2 * step)
    assert slope == approx(difference, rel=1e-7)


@pytest.mark.slow
def test_traced_nodes_need_named_releases():
    nodes, elements, nprops, eprops, _ = guide()
    releases = run_guide().overconstraints

    def height(y, opt):
        moved = [[x, y if place else 0.0, z] for x, place, z in nodes]
        model = fm.spacar.spacar_light_model(moved, elements, nprops, eprops, opt)
        return model.parameters.reference[model.labels.coordinates("n3")[1]]

    with pytest.raises(fm.ModelError, match=r"\(nodes or orien\) is traced.*Give opt.rls"):
        jax.grad(height)(0.1, {})
    assert jax.grad(height)(0.1, {"rls": releases}) == 1.0


def stroke(x, beams):
    """B1: guide whose middle is driven, no shear; W = L and EA L^2/EI = 480000."""
    sets = [{"elems": [1, 4], **leaf(smod=1e15, nbeams=beams)}, {"elems": [2, 3], "orien": UP}]
    nprops = fm.spacar.StructArray()
    nprops(1).fix = nprops(5).fix = True
    nprops(3).displ_x = x
    return fm.spacar.spacar_light(*GUIDE, nprops, sets, {"loadsteps": 2, "gravity": [0, 0, 0]})


@pytest.mark.slow
def test_support_stiffness_falls_with_the_stroke():
    # B1, independent: shooting. EI/L^3 times 959994 at 1e-4 of L, 752990 at 0.02, 352530 at 0.05.
    bending = 210e9 * 50e-3 * 0.5e-3**3 / 12
    out = stroke(0.05 * 0.1, 4)
    assert [out.freq.shape[1], len(out.linearizations)] == [2, 2]
    stiffness = 1 / out.node(3).CMglob[1, 1, :] * 0.1**3 / bending
    assert stiffness[0] == approx(960000, rel=1e-4)
    # Order two in the number of beams: 2.8 % with four.
    assert stiffness[1] == approx(352530.027, rel=0.03)
    np.testing.assert_allclose(out.node(3).p[:, -1] - [0.05, 0.1, 0], [5e-3, -0.0015012 * 0.1, 0], atol=2e-7)
    assert out.node(3).Freac[0, -1] == approx(1.202960515 * bending / 0.1**2, rel=1e-3)
    assert out.element(1).e.shape == (4, 6, 2)
    assert out.step(2).element(4).e.shape == (4, 6)
    np.testing.assert_array_equal(out.step(2).node(3).p, out.node(3).p[:, 1])


# -- cross flexure ----------------------------------------------------------------------------------------------------

CROSS = [[0, 0, 0], [0, 0.1, 0], [0.1, 0.1, 0], [0.1, 0, 0]], [[1, 3], [2, 3], [2, 4]]


def cross_flexure(**opt):
    """The predecessor's first example with one beam a leaf spring, its lines as they stand there."""
    nprops, eprops = fm.spacar.StructArray(), fm.spacar.StructArray()
    nprops(1).fix = True
    nprops(4).fix = True
    nprops(3).force = [0, 1, 0]
    nprops(3).moment_initial = [0, 0, -0.025]
    nprops(3).moment = [0, 0, 0.05]
    nprops(3).mass = 0.1
    eprops(1).elems = [1, 3]
    eprops(1).emod = 210e9
    eprops(1).smod = 70e9
    eprops(1).dens = 7800
    eprops(1).cshape = "rect"
    eprops(1).dim = [50e-3, 0.2e-3]
    eprops(1).orien = [0, 0, 1]
    eprops(1).nbeams = 3
    eprops(1).flex = [1, 2, 3, 4, 5, 6]
    eprops(1).warping = True
    eprops(2).elems = 2
    eprops(2).dens = 3000
    eprops(2).cshape = "rect"
    eprops(2).dim = [50e-3, 10e-3]
    eprops(2).orien = [0, 0, 1]
    return *CROSS, nprops, eprops, {"gravity": [0, 0, -9.81], "loadsteps": 2, **opt}


def cross_by_hand():
    """The same with flexmb's Builder; all deformations of the springs released, degrees of freedom found by it."""
    b = fm.Builder()
    for i, place in enumerate(CROSS[0], 1):
        b.node(str(i), place)
    section = fm.Rectangle(50e-3, 0.2e-3, fm.Material(E=210e9, G=70e9, rho=7800.0), shear=True, warping_modulus="beam")
    for k, (p, q) in ((1, (0, 2)), (3, (1, 3))):
        ends = [str(p + 1), f"{k} a", f"{k} b", str(q + 1)]
        for i in (1, 2):
            b.node(ends[i], np.array(CROSS[0][p]) * (3 - i) / 3 + np.array(CROSS[0][q]) * i / 3)
        for i in range(3):
            b.add(spatial.warping_beam, ends[i], ends[i + 1], name=f"{k}.{i}", section=section, y=(0, 0, 1))
    mass = fm.Rectangle(50e-3, 10e-3, fm.Material(1.0, 1.0, 3000.0))
    b.add(spatial.beam, "2", "3", name="body", section=mass, y=(0, 0, 1), released=())
    b.fix("1")
    b.fix("4")
    b.mass("3", 0.1)
    b.moment("3", (0, 0, -0.025))
    b.gravity((0, 0, -9.81))
    b.force("3", (0, 1, 0), increment=True)
    b.moment("3", (0, 0, 0.05), increment=True)
    return b.build()


@functools.cache
def run_cross():
    return fm.spacar.spacar_light(*cross_flexure(calcbuck=True))


@pytest.mark.slow
def test_cross_flexure_is_that_built_by_hand():
    out, by_hand = run_cross(), cross_by_hand()
    # Unloaded, initial loads, all loads.
    np.testing.assert_array_equal(out.load_factors, [[0, 1, 1], [0, 0, 1]])
    for i, factors in ((1, (1.0, 0.0)), (2, (1.0, 1.0))):
        lin = fm.linearize(by_hand, load_factor=factors[0], increment=factors[1])
        expected = lin.matrices.x[lin.labels.known("3")]
        np.testing.assert_allclose(out.node(3).p[:, i], expected, atol=1e-10)
        # A moment about a fixed axis: the stiffness is not symmetric, so that poles are compared.
        poles = np.unique(np.round(np.abs(np.imag(fm.poles(lin))) / (2 * np.pi), 6))
        np.testing.assert_allclose(out.freq[:5, i], poles[:5], rtol=1e-5)


@pytest.mark.slow
def test_stiff_deformations_may_be_released():
    # In-plane bending, 6e4 times stiffer than the other: where its stress came from D(x), no equilibrium was found.
    releases = ((4, 6), (2, 3, 4, 6)), ((1, 2, 3, 4, 5, 6), ()), ((2, 3, 4), (2, 4, 6))
    for first, third in releases:
        model = fm.spacar.spacar_light_model(*cross_flexure(rls={1: first, 3: third}))
        lin = fm.linearize(model, load_factor=1.0, increment=1.0)
        assert lin.matrices.iterations <= 30
        np.testing.assert_allclose(lin.matrices.x[lin.labels.known("n3")], run_cross().node(3).p[:, 2], atol=1e-9)


@pytest.mark.slow
def test_named_releases_are_those_found():
    out = run_cross()
    assert sum(len(numbers) for numbers in out.overconstraints.values()) == 6
    assert all(k in (1, 3) for k in out.overconstraints)
    again = fm.spacar.spacar_light(*cross_flexure(rls=out.overconstraints, showinputonly=True))
    assert again.model.q_labels == out.model.q_labels
    # Six deformations a beam less six releases, and two nodes between beams that warp in each leaf spring.
    assert again.freq.shape == (34, 0)


@pytest.mark.slow
def test_supports_carry_the_loads():
    out = run_cross()
    gravity = 9.81 * (0.1 + 3000 * 50e-3 * 10e-3 * 0.1 + 2 * 7800 * 50e-3 * 0.2e-3 * np.sqrt(0.02))
    for i, force in ((1, 0.0), (2, 1.0)):
        total = out.node(1).Freac[:, i] + out.node(4).Freac[:, i]
        np.testing.assert_allclose(total, [0, -force, gravity], atol=1e-9)
        moment = out.node(1).Mreac[2, i] + out.node(4).Mreac[2, i] + 0.1 * out.node(4).Freac[1, i]
        applied = (-0.025 if i == 1 else 0.025) + force * out.node(3).p[0, i]
        assert moment == approx(-applied, abs=1e-9)
    np.testing.assert_array_equal(out.node(3).Freac, 0)


@pytest.mark.slow
def test_rotations_in_every_form():
    out = run_cross()
    node = out.step(3).node(3)
    turned = Rotation.from_quat(node.r_quat, scalar_first=True)
    matrix = turned.as_matrix()
    by_axis, by_angles = (
        Rotation.from_rotvec(node.r_axang[0] * node.r_axang[1:]),
        Rotation.from_euler("ZYX", node.r_eulzyx),
    )
    for other in (by_axis, by_angles):
        np.testing.assert_allclose(other.as_matrix(), matrix, atol=1e-12)
    np.testing.assert_array_equal(out.node(1).r_axang[:, 0], [0, 1, 0, 0])
    # Local compliance is the global one in turned axes.
    turn = np.kron(np.eye(2), matrix)
    np.testing.assert_allclose(node.CMloc, turn.T @ node.CMglob @ turn, rtol=1e-9, atol=1e-12)
    # Unloaded, no load multiplies.
    assert np.all(np.isinf(out.buck[:, 0]))


# -- wire flexure, state space, hinges --------------------------------------------------------------------------------


@pytest.mark.slow
def test_buckling_and_frequencies_of_a_wire():
    wire = {"elems": 1, "emod": 210e9, "smod": 79e9, "dens": 7800.0, "cshape": "circ", "dim": 1e-3}
    wire |= {"orien": [0, 1, 0], "nbeams": 4, "flex": range(1, 7)}
    tip = {"force_initial": [-1.0, 0, 0]}
    out = fm.spacar.spacar_light(
        [[0, 0, 0], [0.1, 0, 0]], [[1, 2]], [{"fix": 1}, tip], [wire], {"calcbuck": 1, "loadsteps": 2}
    )
    assert out.overconstraints == {}
    bending, per_length = 210e9 * np.pi * 1e-3**4 / 64, 7800 * np.pi * 1e-3**2 / 4
    # A11 fixed-free: pi^2/4; four cubic beams are within a thousandth of both, in both planes.
    np.testing.assert_allclose(out.step(2).buck[:2], np.pi**2 / 4 * bending / 0.1**2, rtol=1e-3)
    first = 1.8751040687**2 * np.sqrt(bending / per_length / 0.1**4) / (2 * np.pi)
    np.testing.assert_allclose(out.step(1).freq[:2], first, rtol=1e-3)
    assert out.freq[0, 1] < out.freq[0, 0]
    modes, mass = out.step(1).freqmodes, np.asarray(out.step(1).lin.M0)
    np.testing.assert_allclose(modes.T @ mass @ modes, np.eye(out.ndof), atol=1e-9)
    # Straight, it carries the force alone: sigma = F / A.
    np.testing.assert_allclose(out.stressmax, [0, 4 / (np.pi * 1e-3**2)], rtol=1e-9)
    np.testing.assert_allclose(out.element(1).stressmax, out.stressmax, rtol=1e-12)
    assert out.step(2).element(1).stressmax == out.step(2).stressmax


@pytest.mark.slow
def test_state_space_with_a_damping_ratio():
    nodes = [*CROSS[0], [0.1, 0.2, 0]]
    elements = [[1, 2], [2, 3], [3, 4], [3, 5]]
    nprops = {1: {"fix": 1}, 4: {"fix": 1}, 3: {"transfer_in": "force_x", "transfer_out": ["displ_x", "veloc_x"]}}
    eprops = [{"elems": [1, 3], **leaf(0.2e-3, nbeams=2)}, {"elems": [2, 4], **body(dens=7800)}]
    out = fm.spacar.spacar_light(nodes, elements, nprops, eprops, {"transfer": [True, 0.01]})
    system = out.statespace
    assert system.input_labels == ["force-x n3"]
    assert system.output_labels == ["displ-x n3", "veloc-x n3"]
    poles = np.linalg.eigvals(system.A)
    lowest = poles[np.argsort(np.abs(poles))[:8]]
    np.testing.assert_allclose(-lowest.real / np.abs(lowest), 0.01, rtol=1e-4)
    np.testing.assert_allclose(np.abs(lowest[::2]) / (2 * np.pi), out.freq[:4, 0], rtol=1e-6)
    # At rest, force to displacement is the compliance.
    assert system.dcgain()[0, 0] == approx(out.node(3).CMglob[0, 0, 0], rel=1e-6)


@pytest.mark.slow
def test_slider_crank_turns_past_half_a_turn():
    nodes = [[0, 0, 0], [1, 1, 0], [1, 1, 0], [3, 0, 0]]
    elements = [[1, 2], [2, 3], [3, 4]]
    nprops, eprops = fm.spacar.StructArray(), fm.spacar.StructArray()
    nprops(1).fix_pos = True
    nprops(1).rot_initial = [-0.5, 0, 0, 2]
    nprops(1).rot = [4.5, 0, 0, 1]
    nprops(4).fix_y = True
    nprops(4).fix_z = True
    eprops(1).elems = 1
    for name, value in leaf(1.5e-3, 30e-3).items():
        setattr(eprops(1), name, value)
    eprops(2).elems = 2
    eprops(2).type = "hinge"
    eprops(2).orien = UP
    out = fm.spacar.spacar_light(nodes, elements, nprops, eprops, {"loadsteps": 3})
    # Nothing resists, so that the crank stays straight: radius sqrt 2, rod sqrt 5.
    turned = np.array([0, -0.25, -0.5, 1.75, 4.0])
    angle = np.pi / 4 + turned
    slider = np.sqrt(2) * np.cos(angle) + np.sqrt(5 - 2 * np.sin(angle) ** 2)
    np.testing.assert_allclose(out.node(4).p[0], slider, atol=1e-9)
    np.testing.assert_allclose(out.node(1).r_axang[0], np.abs(turned), atol=1e-9)
    np.testing.assert_allclose(out.element(1).e, 0, atol=1e-9)
    np.testing.assert_allclose(out.node(2).p, out.node(3).p, atol=1e-12)
    assert out.element(2).e.shape == (1, 3, 5)


@pytest.mark.slow
def test_reactions_at_a_turned_support():
    # A wire whose tip is carried aside and turned about y, the other two rotations free: forces and moments balance.
    tip = {"displ_y": 0.002, "displ_z": 0.02, "rot_y": 0.4}
    wire = {"elems": 1, "emod": 210e9, "smod": 79e9, "dens": 7800.0, "cshape": "circ", "dim": 1e-3}
    wire |= {"nbeams": 4, "flex": range(1, 7)}
    out = fm.spacar.spacar_light([[0, 0, 0], [0.1, 0, 0]], [[1, 2]], [{"fix": 1}, tip], [wire], {"loadsteps": 2})
    foot, end = out.step(2).node(1), out.step(2).node(2)
    np.testing.assert_allclose(foot.Freac + end.Freac, 0, atol=1e-9 * np.abs(end.Freac).max())
    moments = foot.Mreac + end.Mreac + np.cross(end.p, end.Freac)
    np.testing.assert_allclose(moments, 0, atol=1e-8 * np.abs(foot.Mreac).max())
    q = end.r_quat
    assert 2 * np.arctan2(q[2], q[0]) == approx(0.4, abs=1e-12)
    # Forces and displacements, moments and rotations in axes that have turned with the node.
    axes = np.kron(np.eye(2), Rotation.from_quat(q, scalar_first=True).as_matrix())
    size = np.abs(end.CMglob).max()
    np.testing.assert_allclose(end.CMloc, axes.T @ end.CMglob @ axes, rtol=0, atol=1e-9 * size)
    assert np.abs(np.subtract(end.CMloc, end.CMglob)).max() > 0.1 * size


def test_local_axes_are_those_of_the_script():
    """x along the beam or the hinge, y in the plane of x and orien, z across both."""
    nodes = [[0, 0, 0], [0.3, 0.4, 0], [0.3, 0.4, 0]]
    eprops = [{"elems": 1, **leaf(orien=[1, 0, 2.0])}, {"elems": 2, "type": "hinge", "orien": [0, 0, 3.0]}]
    nprops = {1: {"fix": 1}, 3: {"fix_orien": 1}}
    out = fm.spacar.spacar_light(nodes, [[1, 2], [2, 3]], nprops, eprops, {"showinputonly": True, "silent": True})
    x = np.array([0.6, 0.8, 0])
    y = np.array([1, 0, 2.0]) - 0.6 * x
    y /= np.linalg.norm(y)
    np.testing.assert_allclose(out.element(1).Ri, np.stack([x, y, np.cross(x, y)], axis=1), atol=1e-14)
    assert out.element(1).L0 == approx(0.5, rel=1e-14)
    np.testing.assert_allclose(out.element(2).Ri[:, 0], [0, 0, 1], atol=1e-14)
    np.testing.assert_allclose(out.element(2).Ri.T @ out.element(2).Ri, np.eye(3), atol=1e-14)


HINGED = [[0, 0, 0], [-0.1, 0.1, 0], [0, 0.2, 0], [0, 0.2, 0], [0, 0.2, 0], [0.1, 0.2, 0], [0.1, 0.2, 0]]


@pytest.mark.slow
def test_universal_joint():
    elements = [[1, 2], [2, 3], [3, 4], [4, 5], [5, 6], [6, 7]]
    sets = [{"elems": 1, **leaf(0.2e-3, nbeams=2)}, {"elems": [3, 6], "type": "hinge", "orien": UP}]
    sets += [{"elems": 4, "type": "hinge", "orien": [0, 1, 0]}]
    nprops = {1: {"fix": 1}, 7: {"fix": 1}, 2: {"force": [1, 1, 0]}}
    out = fm.spacar.spacar_light(HINGED, elements, nprops, sets, {"showinputonly": True})
    # Two beams and three hinges have 15 deformations; the loop through the ground closes with six of them.
    assert out.ndof == 9
    assert sum(len(numbers) for numbers in out.overconstraints.values()) == 6
    found = fm.mobility(out.model)
    assert (found.overconstraints, found.underconstraints) == (0, 0)


# -- load steps, structures, faults -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fields", "steps"),
    [
        ({}, [(1, 0)]),
        ({"force": [1, 0, 0]}, [(1, 0), (1, 0.5), (1, 1)]),
        ({"moment_initial": [1, 0, 0]}, [(0, 0), (0.5, 0), (1, 0)]),
        ({"force": [1, 0, 0], "rot_initial_x": 1}, [(0, 0), (0.5, 0), (1, 0), (1, 0.5), (1, 1)]),
    ],
)
def test_initial_loads_come_first(fields, steps):
    nodes, elements, nprops, eprops, _ = guide()
    script = read_script(nodes, elements, {**nprops, 3: fields}, eprops, {"loadsteps": 3, "gravity": [0, 0, -9.81]})
    check_script(script)
    assert load_steps(script) == steps


def test_structures_grow_and_are_read_in_every_form():
    grown = fm.spacar.StructArray()
    grown(3).force = [0, 1, 0]
    grown[1].fix = 1
    grown(1).fix_warp = []
    assert len(grown) == 3
    with pytest.raises(IndexError, match="Structure 0 does not exist"):
        grown(0)
    listed = [{"fix": True}, {}, {"force": np.array([[0, 1, 0]])}]
    for nprops in (grown, listed, {3: {"force": (0, 1, 0)}, 1: {"fix": True}}):
        found = read_script([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[1, 2], [2, 3]], nprops, {}, None).nprops
        assert found[1] == {"fix": True}
        np.testing.assert_array_equal(found[3]["force"], [0, 1, 0])
    opt = fm.spacar.Struct()
    opt.rls = fm.spacar.StructArray()
    opt.rls(4).def_ = [2, 3]
    script = read_script(*GUIDE, {1: {"fix": 1}}, [{"elems": 4, **leaf()}], opt)
    check_script(script)
    assert script.opt["rls"] == {4: (2, 3)}


def changed(nodes=None, elements=None, nprops=None, node=None, sets=None, opt=None, at=3):
    """The guide with something changed."""
    n, e, supports, eprops, _ = guide()
    eprops = [{**own, **(sets or {}).get(i, {})} for i, own in enumerate(eprops, 1)]
    return nodes or n, elements or e, nprops or {**supports, at: node or supports.get(at, {})}, eprops, opt


FAULTS = {
    "node without element": (
        {"nodes": [*GUIDE[0], [1, 1, 1]]},
        "Node 6: is in no element; attach it or leave it out.",
    ),
    "unknown node": (
        {"elements": [*GUIDE[1], [1, 9]]},
        "Element 5: there is no node 9; nodes are numbered",
    ),
    "to itself": ({"elements": [*GUIDE[1], [2, 2]]}, "Element 5: joins node 2 to itself; give it two nodes."),
    "no length": ({"nodes": [*GUIDE[0][:1], [0, 1e-6, 0], *GUIDE[0][2:]]}, "Element 1: its length is 1e-06 m, but"),
    "units": ({"nodes": [*GUIDE[0][:4], [0.1, -1000, 0]]}, "Element 4: is more than 1000 times as long as element 2"),
    "unknown field": ({"node": {"force_y": 1}}, "nprops(3).force_y: there is no such field. Did you mean force?"),
    "wrong length": ({"node": {"force": [0, 1]}}, "nprops(3).force: must be 3 finite numbers, but is [0, 1]."),
    "not a number": ({"node": {"mass": float("nan")}}, "nprops(3).mass: must be a finite number, but is nan."),
    "fixed twice": ({"node": {"fix": 1, "fix_x": 1}, "at": 1}, "Node 1: fix fixes the whole node; leave out fix_x."),
    "two ways": ({"node": {"fix_x": 1, "displ_x": 1}}, "Node 3: fix_x and displ_x act on x; choose one."),
    "two ways to turn": ({"node": {"moment": [1, 0, 0], "rot_x": 1}}, "Node 3: moment and rot_x act on its rotation"),
    "two axes": ({"node": {"rot_x": 1, "rot_initial_y": 1}}, "Node 3: rot_x and rot_initial_y turn about several axes"),
    "no axis": ({"node": {"rot": [1, 0, 0, 0]}}, "Node 3: rot must be [angle, ax, ay, az] with an axis that is not"),
    "supports": (
        {"nprops": {1: {"fix_pos": 1}, 5: {"fix_x": 1}}},
        "nprops: 4 coordinates are fixed, but at least 6",
    ),
    "output": ({"node": {"transfer_out": "rot_x"}}, "Node 3: transfer_out must be some of displ_x, displ_y"),
    "no output": ({"node": {"transfer_in": "force_x"}, "opt": {"transfer": 1}}, "opt.transfer: needs an input"),
    "in two sets": (
        {"sets": {2: {"elems": [1, 4]}}},
        "Element 1: is in eprops(1) and in eprops(2); each element belongs to one set.",
    ),
    "unknown element": ({"sets": {2: {"elems": 7}}}, "eprops(2).elems: there is no element 7; they are numbered to 4."),
    "flex": ({"sets": {1: {"flex": [2, 7]}}}, "eprops(1).flex: must be some of 1 to 6, each once, but is [2, 7]."),
    "no modulus": ({"sets": {3: {"flex": [1]}}}, "eprops(3): flexible elements need emod, smod too."),
    "shape": ({"sets": {1: {"cshape": "tube"}}}, "eprops(1).cshape: must be 'rect' or 'circ', but is 'tube'."),
    "dimensions": ({"sets": {1: {"dim": 1e-3}}}, "eprops(1).dim: of a 'rect' must be [width, thickness], but has 1"),
    "orientation": ({"sets": {1: {"orien": [0, 2, 0]}}}, "Element 1: orien = [0.0, 2.0, 0.0] in eprops(1) is zero or"),
    "not a hinge": ({"sets": {3: {"type": "slider"}}}, "eprops(3).type: must be 'hinge' or left out, but is 'slider'."),
    "raw lines": ({"opt": {"customdyn": "XM 1 2"}}, "opt.customdyn: lines of an input file are not read here."),
    "mode": ({"opt": {"mode": 3}}, "opt.mode: must be 10 (equilibrium at load steps) or left out, but is 3."),
    "release": (
        {"opt": {"rls": {1: [5]}}},
        "opt.rls(1): must be some of the flex of element 1 ([2, 3, 4]), but",
    ),
    "nodes": ({"nodes": "abc"}, "nodes: must be one row of x, y and z per node, but is 'abc'."),
    "ragged nodes": (
        {"nodes": [[0, 0, 0], [1]]},
        "nodes: must be one row of x, y and z per node, but is [[0, 0, 0], [1]].",
    ),
    "elements": ({"elements": [["a", "b"]]}, "elements: must be one row of two node numbers per element, but is [['a'"),
    "endless elements": (
        {"elements": [[1, 10**400]]},
        "elements: must be one row of two node numbers per element, but",
    ),
    "node far away": ({"nodes": [*GUIDE[0][:4], [1e300, 0, 0]]}, "Node 5: its position must be finite numbers, 0 or"),
    "no structures": (
        {"nprops": "fix"},
        "nprops: must be a StructArray, a dictionary by number or a list, but is 'fix'",
    ),
    "no name of a field": ({"node": {5: 1}}, "nprops(3).5: there is no such field."),
    "letters that act": ({"node": {"\x1b[31m": 1}}, r"nprops(3).\x1b[31m: there is no such field."),
    "a long text": (
        {"node": {"mass": "x" * 10**6}},
        f"nprops(3).mass: must be a finite number, but is '{'x' * 39}...{'x' * 39}' (1000002 characters).",
    ),
    "large": ({"node": {"mass": 1e60}}, "nprops(3).mass: must be 0 or from 1e-100 to 1e+50 in size, but is 1e+60."),
    "small": ({"node": {"mass": 1e-320}}, "nprops(3).mass: must be 0 or from 1e-100 to 1e+50 in size, but is 1e-320."),
    "text as number": ({"sets": {1: {"nbeams": "3"}}}, "eprops(1).nbeams: must be a whole number from 1 to 999999999"),
    "beams": ({"sets": {1: {"nbeams": 10**8}}}, "eprops(1).nbeams: must be at most 1000, but is 100000000."),
    "endless beams": (
        {"sets": {1: {"nbeams": 1e300}}},
        "eprops(1).nbeams: must be a whole number from 1 to 999999999,",
    ),
    "steps": ({"opt": {"loadsteps": 10**8}}, "opt.loadsteps: must be at most 10000, but is 100000000."),
    "release by a word": ({"opt": {"rls": {1: "x"}}}, "opt.rls(1): must be numbers of deformations, but is 'x'."),
    "no releases": ({"opt": {"rls": 5}}, "opt.rls: must be a StructArray, a dictionary by number or a list, but is 5."),
    "damping": ({"opt": {"transfer": [True, np.nan]}}, "opt.transfer: must be true, or [true, damping ratio], but is"),
    "warping twice": ({"sets": {1: {"cw": 1, "warping": 1}}}, "eprops(1): has warping and cw, which model the same"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_told_by_name(fault):
    change, text = FAULTS[fault]
    with pytest.raises(fm.ModelError, match=re.escape(text)):
        fm.spacar.spacar_light(*changed(**change))


def test_all_faults_are_told_at_once():
    with pytest.raises(fm.ModelError) as caught:
        fm.spacar.spacar_light(*changed(node={"fix_x": 1, "displ_x": 1, "mass": -1}, sets={1: {"emod": 0}}))
    lines = str(caught.value).splitlines()
    assert [line.split(":")[0] for line in lines] == ["eprops(1).emod", "Node 3", "Node 3"]


@pytest.mark.slow
def test_constraints_are_told_by_element_and_node():
    nodes, elements, nprops, eprops, opt = changed(sets={2: {"flex": [2, 3, 4]}})
    stuck = r"(?s)\(1 times\).*elements 1, 2, 3, 4 hold each other: add one of \[5, 6\] to flex of element 1; or add"
    with pytest.raises(fm.MechanismError, match=stuck):
        fm.spacar.spacar_light(nodes, elements, nprops, eprops, opt)
    with pytest.raises(fm.MechanismError, match=r"(?s)opt.rls as given \(3 times\).*opt.rls\(1\).def = "):
        fm.spacar.spacar_light(*guide(rls={4: [2, 3, 6]}))
    loose = {1: {"fix_pos": 1}, 5: {"fix_pos": 1}}
    with pytest.raises(fm.MechanismError, match=r"(?s)under-constrained: 1 free motion\..* n3"):
        fm.spacar.spacar_light(nodes, elements, loose, [{"elems": [2, 3], **body()}], opt)
    loop = [*GUIDE[1], [5, 1]]
    with pytest.raises(fm.MechanismError, match="form a loop of rigid elements; make one of them flexible"):
        fm.spacar.spacar_light(nodes, loop, {1: {"fix": 1}}, [{"elems": [2, 3], **body()}], opt)


def test_what_has_no_effect_is_warned_of():
    nodes, elements, nprops, eprops, _ = guide()
    eprops[0] |= {"color": "grey", "opacity": 0.5}
    nprops[1] |= {"mass": 1.0, "fix_warp": 1}
    del nprops[1]["fix"]
    nprops[1] |= {"fix_pos": 1, "fix_orien": 1}
    opt = {"spavisual": False, "showinputonly": True}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        out = fm.spacar.spacar_light(nodes, elements, nprops, eprops, opt)
    texts = [str(w.message) for w in caught]
    assert texts == out.warnings
    assert texts[0].endswith("for pictures and stresses: eprops(1).color, eprops(1).opacity, opt.spavisual")
    assert texts[1] == "Node 1: its mass does not move, since the node is fixed."
    assert texts[2].startswith("Node 1: fix_warp has no effect")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fm.spacar.spacar_light(nodes, elements, nprops, eprops, {**opt, "silent": True})


# -- warping ----------------------------------------------------------------------------------------------------------


def twisted(parts, supports=None, last=None, **fields):
    """Leaf springs in a row from a fixed node 1, each of so many beams, as long as the cross flexure's in all."""
    nodes = [[0.1 * np.sqrt(2) * i / len(parts), 0, 0] for i in range(len(parts) + 1)]
    elements = [[i, i + 1] for i in range(1, len(nodes))]
    own = {**leaf(0.2e-3, smod=70e9), "warping": True, **fields}
    sets = {i: {**own, "elems": i, "nbeams": beams} for i, beams in enumerate(parts, 1)}
    if last is not None:
        nodes.append([0.2, 0, 0])
        elements.append([len(nodes) - 1, len(nodes)])
        sets[len(elements)] = {"elems": len(elements), **last}
    return nodes, elements, {1: {"fix": True}, **(supports or {})}, sets, {"calccompl": True, "silent": True}


def restrained(ends: int) -> float:
    """Twist stiffness where warping is restrained at so many ends: (2.10) with the modulus of a beam [N m/rad]."""
    git = 70e9 * float(fm.sections.torsion_series(50e-3, 0.2e-3))
    al = 0.1 * np.sqrt(2) * np.sqrt(git / (210e9 * (50e-3 * 0.2e-3) ** 3 / 144))
    return git / (0.1 * np.sqrt(2)) / (1 - ends * np.tanh(al / ends) / al)


@pytest.mark.slow("free", "body")
@pytest.mark.parametrize(
    ("script", "ends"),
    [
        (twisted([3, 2]), 1),
        (twisted([2, 1], {3: {"fix_warp": True}}), 2),
        (twisted([1, 1], last=body()), 2),
    ],
    ids=["free", "held", "body"],
)
def test_leaf_springs_in_a_row_share_their_warping(script, ends):
    """REFERENCES.md S1-leaf-section: one and two clamped ends, at the end of the second."""
    model = fm.spacar.spacar_light_model(*script)
    assert 1 / float(fm.compliance(model, "n3")[3, 3]) == approx(restrained(ends), rel=1e-10)


@pytest.mark.slow
def test_warping_as_by_the_builder_and_by_the_closed_form():
    out = fm.spacar.spacar_light(*twisted([1], {2: {"fix_warp": True}}))
    # Of the six deformations and two warpings of a beam, one beam, whose warping is held.
    assert (out.ndof, out.element(1).e.shape) == (6, (1, 6, 1))
    b = fm.Builder()
    b.node("1", (0, 0, 0))
    b.node("2", (0.1 * np.sqrt(2), 0, 0))
    material = fm.Material(E=210e9, G=70e9, rho=7800.0)
    section = fm.Rectangle(50e-3, 0.2e-3, material, shear=True, warping_modulus="beam")
    b.add(spatial.warping_beam, "1", "2", section=section, y=UP, clamped=True)
    b.fix("1")
    np.testing.assert_allclose(out.node(2).CMglob[..., 0], fm.compliance(b.build(), "2"), rtol=1e-9, atol=1e-15)
    closed = fm.spacar.spacar_light_model(*twisted([1], warping=False, cw=True))
    # That of a narrow strip, It = w t^3/3: 0.25 % of alpha, which the factor feels by a seventh.
    assert 1 / float(fm.compliance(closed, "n2")[3, 3]) == approx(restrained(2), rel=4e-4)


def test_warping_that_nothing_asks_for_is_warned_of():
    nodes, elements, nprops, eprops, _ = twisted([1], flex=[1, 3, 4, 5, 6])
    with pytest.warns(UserWarning, match=r"eprops\(1\).warping has no effect: .* whose torsion, 2, is in flex"):
        out = fm.spacar.spacar_light(nodes, elements, nprops, eprops, {"showinputonly": True})
    assert out.ndof == 5


def as_struct(**fields):
    """The same script as one struct, as the predecessor takes it too."""
    nodes, elements, nprops, eprops, opt = guide(showinputonly=True)
    parts = {"coordinates": nodes, "connect": elements, "nprops": nprops, "eprops": eprops, "opt": opt}
    return {name: value for name, value in {**parts, **fields}.items() if value is not None}


def test_a_script_in_one_struct():
    alone = fm.spacar.spacar_light_model(as_struct())
    apart = fm.spacar.spacar_light_model(*guide())
    for one, other in zip(jax.tree.leaves(alone), jax.tree.leaves(apart), strict=True):
        np.testing.assert_array_equal(one, other)
    # As a Struct, and without opt.
    assert fm.spacar.spacar_light_model(fm.spacar.Struct(**as_struct(opt=None))).labels == apart.labels
    assert fm.spacar.spacar_light(as_struct()).ndof == 1


@pytest.mark.slow("arguments4-nprops, eprops: are not given", "arguments5-elements, nprops, eprops: are not given")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((as_struct(nprops=None),), r"nprops: is not given"),
        ((as_struct(connect=None, eprops=None),), r"connect, eprops: are not given"),
        ((as_struct(nodes=[]),), r"nodes: there is no such field.*coordinates, connect, nprops, eprops, opt"),
        ((as_struct(), [[1, 2]]), r"one struct .* alone"),
        (GUIDE, r"nprops, eprops: are not given"),
        ((GUIDE[0],), r"elements, nprops, eprops: are not given"),
    ],
)
def test_a_script_that_lacks_a_part(arguments, message):
    for call in (fm.spacar.spacar_light, fm.spacar.spacar_light_model):
        with pytest.raises(fm.ModelError, match=message):
            call(*arguments)
