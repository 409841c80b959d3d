"""Section resultants and stress: closed forms, hand calculation, rods solved by shooting, balance, derivatives."""

import dataclasses
import warnings

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases import mechanisms
from cases.tolerances import approx
from references import shooting
from references.rods import Assembly, Cantilever, PlanarRod, SpatialRod, column, matrix
from scipy.spatial.transform import Rotation

import flexmb as fm
from flexmb import planar, spatial
from flexmb.answers.answers import answer
from flexmb.mechanics.inertia import InertialLoad
from flexmb.motion.coordinates_form import coordinates_form
from flexmb.motion.element_forces import Moving
from flexmb.motion.moving_matrices import dynamic_balance
from flexmb.statics.equilibrium import Equilibrium

EPS = np.finfo(float).eps
L, W, T = mechanisms.LENGTH, mechanisms.WIDTH, mechanisms.THICKNESS
LEAF = mechanisms.leaf()
EI = float(LEAF.rigidity().EIy)
SLENDER = fm.Rigidity(EA=1e4, EIy=1.0, mass=1.0)  # of length one
FIELDS = [0, 2, 4]  # normal force, shear along z, bending about y: what a planar element has


def chain(element, points, section, **properties):
    b = fm.Builder()
    for i, point in enumerate(points):
        b.node(str(i), point)
    for i in range(len(points) - 1):
        b.add(element, str(i), str(i + 1), name=f"leaf {i}", section=section, **properties)
    b.fix("0")
    return b


def straight(n, space, length=L):
    return [(length * i / n, 0, 0) if space else (length * i / n, 0) for i in range(n + 1)]


def cantilever(element, n, section, length=L, *, force=(0, 0, 0), moment=(0, 0, 0), gravity=(0, 0, 0)):
    """A chain along x with loads in axes of the section; those that are zero too, so that all is compiled once."""
    space = len(element.nodes["p"].start) == 3
    b = chain(element, straight(n, space, length), section, **({"y": (0, 1, 0)} if space else {}))
    # In the plane the section's z is the global y, and its y points into the plane.
    b.force(str(n), force if space else (force[0], force[2]))
    b.moment(str(n), moment if space else -moment[1])
    b.gravity(gravity if space else (gravity[0], gravity[2]))
    return b.build()


# -- closed forms -------------------------------------------------------------------------------------------------

CANTILEVERS = {
    "planar, beams": (planar.beam, 2),
    "planar, spectral": (planar.spectral_beam(3), 1),
    "space, beams": (spatial.beam, 2),
    "space, spectral": (spatial.spectral_beam(3), 1),
}
FORCE = 1e-4  # N: F L^2/EI = 2.5e-5, of which the square is what large deflection changes


@pytest.mark.slow
@pytest.mark.parametrize(("element", "n"), CANTILEVERS.values(), ids=CANTILEVERS)
def test_cantilever_with_a_force_at_its_tip(element, n):
    found = fm.stress(cantilever(element, n, LEAF, force=(0, 0, FORCE)))
    assert found.names == tuple(f"leaf {i}" for i in range(n))
    # A force to +z compresses the fibres at +z: M = -F (L - x) about y.
    x = (np.arange(n)[:, None] + np.asarray(found.places)) * L / n
    values = np.asarray(found.resultants.values)
    np.testing.assert_allclose(values[:, :, 4], -FORCE * (L - x), rtol=0, atol=1e-8 * FORCE * L)
    np.testing.assert_allclose(values[:, :, 2], FORCE, rtol=1e-8)
    # The force tilts into the normal force by the slope, below F L^2/2EI.
    assert np.max(np.abs(values[:, :, [0, 1, 3, 5]])) < 2e-5 * FORCE
    largest = 6 * FORCE * L / (W * T**2)
    assert found.maximum == approx(largest, rel=1e-8)
    assert found.where[:2] == ("leaf 0", 0.0)
    np.testing.assert_allclose(
        found.sigma_x[0, 0], largest * -np.array([1, 1, 1, 0, -1, -1, -1, 0]), atol=1e-6 * largest
    )
    # 3/2 V/A in the middle of the short sides, across which z runs: the parabola of the shear force.
    np.testing.assert_allclose(
        np.asarray(found.tau[0, 0])[[7, 3]], [1.5 * FORCE / W / T, -1.5 * FORCE / W / T], rtol=1e-6
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("element", "n"), [(spatial.beam, 2), (spatial.spectral_beam(3), 1)], ids=["beams", "spectral"]
)
def test_force_bending_and_torsion_combined_by_hand(element, n):
    w, t, force, torque = 0.02, 0.004, np.array([3.0, 0.05, 0.02]), 0.03
    section = fm.Rectangle(w, t, mechanisms.steel(), rotary=False)
    found = fm.stress(cantilever(element, n, section, force=force, moment=(torque, 0, 0)))
    # Saint-Venant's constants of a strip of 5 to 1: 64/pi^5 and 8/pi^2 times sums that are those of the thin strip.
    constant = w * t**3 * (1 / 3 - 0.2100 * t / w)
    my, mz = -force[2] * L, force[1] * L
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * [w / 2, t / 2]
    sigma = force[0] / w / t + my * corners[:, 1] / (w * t**3 / 12) - mz * corners[:, 0] / (t * w**3 / 12)
    # Deflection and twist are 1e-5 and 1e-4, which turn the forces by as much; N w is 5e-4 of the bending moment F L.
    np.testing.assert_allclose(np.asarray(found.sigma_x[0, 0])[::2], sigma, rtol=0, atol=1e-3 * np.max(sigma))
    tau_long = torque * t / constant
    expected = [-tau_long + 1.5 * force[1] / w / t, -tau_long - 1.5 * force[1] / w / t]
    np.testing.assert_allclose(-np.asarray(found.tau[0, 0])[[1, 5]], expected, rtol=2e-3)
    np.testing.assert_allclose(np.asarray(found.tau[0, 0])[::2], 0, atol=1e-9)
    top = np.hypot(found.sigma_x[0, 0, 1], np.sqrt(3) * found.tau[0, 0, 1])
    assert found.von_mises[0, 0, 1] == approx(float(top), rel=1e-12)


@pytest.mark.slow
def test_truss_has_a_normal_force_alone():
    b = fm.Builder()
    for name, place in {"a": (0, 0), "b": (1, 0), "c": (0.5, 0.5)}.items():
        b.node(name, place)
    b.add(planar.truss, "a", "c", name="left", section=fm.Circle(0.01, mechanisms.steel()))
    b.add(planar.truss, "c", "b", name="right", section=fm.Tube(0.02, 0.001, mechanisms.steel()))
    b.fix("a")
    b.fix("b")
    b.force("c", (0, -100.0))
    found = fm.stress(b.build())
    # Half the load on each, over the sine of 45 degrees; the strain is 5e-6.
    push = -100 / np.sqrt(2)
    np.testing.assert_allclose(found.resultants.values[:, :, 0], push, rtol=1e-5)
    assert not np.any(found.resultants.values[:, :, 1:])
    areas = np.pi / 4 * np.array([0.01**2, 0.02**2 - 0.018**2])
    np.testing.assert_allclose(found.sigma_x, np.broadcast_to((push / areas)[:, None, None], (2, 5, 8)), rtol=1e-5)
    np.testing.assert_allclose(found.by_element, -push / areas, rtol=1e-5)
    assert found.where.element == "right"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("element", "n"), [(planar.beam, 16), (planar.spectral_beam(3), 1), (spatial.spectral_beam(3), 1)]
)
def test_roll_up_has_one_moment_everywhere(element, n):
    # A4: no force anywhere, so the end moment goes through, exactly for any mesh.
    if n > 1:
        found = fm.linear.section_resultants(cantilever(element, n, SLENDER, 1.0, moment=(0, -2 * np.pi, 0)), points=2)
        scale = 1.0
    else:
        scale = EI / L
        found = fm.stress(cantilever(element, n, LEAF, moment=(0, -2 * np.pi * scale, 0))).resultants
    values = np.asarray(found.values) / scale
    np.testing.assert_allclose(values[:, :, 4], -2 * np.pi, rtol=1e-9)
    # Round-off of the elongation times EA is a force.
    np.testing.assert_allclose(np.delete(values, 4, axis=2), 0, atol=1e-7)


# -- large deflection ---------------------------------------------------------------------------------------------


def sections_of_rod(problem, places, z):
    """Resultants in axes of the section of a cantilever solved by shooting, (places, 6), in space."""
    found = []
    for s in places:
        rod = dataclasses.replace(problem.rod, length=max(float(s), 1e-12) * problem.rod.length)
        pose, n, m = rod.march(column(problem.root), column(z[:3]), column(z[3:6]), z[-1])
        axes = matrix(pose[3:, 0])
        found.append(np.r_[axes.T @ n[:, 0], axes.T @ m[:, 0]])
    return np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize("shear", [np.inf, 30.0])
def test_elastica_against_shooting(shear):
    rod = PlanarRod(1.0, 1.0, 1e4, shear, load=(0.3, -0.8))
    problem = Cantilever(rod, (0.0, 0.0, 0.0), force=(-1.0, 2.0), moment=(0.5,))
    z = shooting.solve(problem)
    element, section = planar.spectral_beam(10, shear=np.isfinite(shear)), fm.Rigidity(EA=1e4, EIy=1.0, mass=1.0)
    b = chain(element, straight(1, False, 1.0), dataclasses.replace(section, shear_z=1.0 / shear))
    b.force("1", (-1.0, 2.0))
    b.moment("1", 0.5)
    b.gravity(rod.load)
    found = fm.linear.section_resultants(b.build(), points=7)
    errors = []
    for s, values in zip(found.places, np.asarray(found.values[0]), strict=True):
        part = dataclasses.replace(rod, length=max(float(s), 1e-12))
        pose, n, m = part.march(column(problem.root), column(z[:2]), column(z[2:3]))
        c, sn = np.cos(pose[2, 0]), np.sin(pose[2, 0])
        expected = [c * n[0, 0] + sn * n[1, 0], c * n[1, 0] - sn * n[0, 0], -m[0, 0]]
        errors.append(values[FIELDS] - expected)
    # Order ten leaves 1e-9 in the pose and in forces and moments of order one; EA times round-off.
    assert np.max(np.abs(errors)) < 2e-8, errors


RODS = {  # element, initial curvature of the rod in its section's axes, shear rigidities, dead load per length
    "twisted": (spatial.spectral_beam(8), (0.0, 0.0, 0.0), np.inf, (0.0, 0.0, 0.0)),
    "heavy arc with shear": (spatial.spectral_beam(8, shear=True), (0.0, 0.4, -0.6), 300.0, (0.2, -0.4, 0.3)),
}


@pytest.mark.slow
@pytest.mark.parametrize(("element", "curvature", "shear", "load"), RODS.values(), ids=RODS)
def test_rod_in_space_against_shooting(element, curvature, shear, load):
    rod = SpatialRod(1.0, 0.8, 1.0, 2.5, 1e4, shear, shear, curvature=curvature, load=load)
    force, moment = (-0.4, 0.9, 1.1), (0.5, -0.3, 0.2)
    start = Rotation.from_rotvec([0.3, -0.5, 0.4])
    root = (0.0, 0.0, 0.0, *start.as_quat(scalar_first=True))
    problem = Cantilever(rod, root, force=force, moment=moment)
    z = shooting.solve(problem)
    unloaded = dataclasses.replace(rod, EA=np.inf, GAy=np.inf, GAz=np.inf, load=(0.0, 0.0, 0.0))
    end = unloaded.march(column(root), np.zeros((3, 1)), np.zeros((3, 1)))[0][:3, 0]
    compliance = {"shear_z": 1.0 / shear, "shear_y": 2.5 / shear} if np.isfinite(shear) else {}
    section = fm.Rigidity(EA=1e4, GIt=0.8, EIy=1.0, EIz=2.5, mass=1.0, **compliance)
    # The element's frame is that of the arc's middle: the y that makes it the rod's own.
    bend = np.array(curvature)
    y = (start * Rotation.from_rotvec(bend / 2)).as_matrix()[:, 1]
    properties = {"curvature": curvature} if np.any(bend) else {}
    b = chain(element, [np.zeros(3), end], section, y=y, **properties)
    b.force("1", force)
    b.moment("1", moment)
    if any(load):
        b.gravity(load)
    found = fm.linear.section_resultants(b.build(), points=6)
    expected = sections_of_rod(problem, np.asarray(found.places), z)
    # Order eight leaves 1e-7 of forces and moments of order one.
    errors = np.max(np.abs(np.asarray(found.values[0]) - expected), axis=0)
    assert np.all(errors < 3e-7), errors


@pytest.mark.slow
def test_cubic_beams_converge_with_order_two():
    problem = Cantilever(PlanarRod(1.0, 1.0, 1e4), (0.0, 0.0, 0.0), force=(0.0, 2.0))
    clamp = shooting.solve(problem)[2]
    errors = []
    for n in (4, 8, 16):
        found = fm.linear.section_resultants(cantilever(planar.beam, n, SLENDER, 1.0, force=(0.0, 0.0, 2.0)), points=2)
        errors.append(float(found.values[0, 0, 4]) + clamp)
    ratios = np.array(errors[:-1]) / errors[1:]
    np.testing.assert_allclose(ratios, 4, rtol=0.15)
    assert abs(errors[-1]) < 1e-3 * clamp


def bending_of(element):
    """Numbers of the deformations that bending stiffens."""
    starts = [np.array(kind.start) for kind in element.nodes.values()]
    starts[2] = np.eye(len(starts[0]))[0]
    own = element.arguments(element.stiffness, {"section": fm.Rigidity(EIy=1.0)})
    stiffness = element.stiffness(ref=element.reference(starts), **own)
    return tuple(np.flatnonzero(np.diag(stiffness)) + 1)


@pytest.mark.slow
def test_guide_at_a_stroke_with_fixed_elongation():
    """B1: the normal force of a leaf spring that does not stretch is a multiplier."""
    element = planar.spectral_beam(6)
    stroke, leaf, released = 0.1, PlanarRod(1.0), bending_of(element)
    leaves = tuple((leaf, (x, 0.0, np.pi / 2), (x, 0.0, np.pi / 2)) for x in (-0.5, 0.5))
    problem = Assembly(leaves, (0.0, 1.0, 0.0), (0.0, 0.0, 0.0), {0: stroke}, dead=(0.0, -3.0, 0.0))
    z = shooting.solve(problem)
    b = fm.Builder()
    b.node("platform", (0, 1))
    for name, x in (("left", -0.5), ("right", 0.5)):
        for i in range(2):
            b.node(f"{name} {i}", (x, i))
        section = fm.Rigidity(EA=1.0, EIy=1.0)
        b.add(element, f"{name} 0", f"{name} 1", name=name, section=section, released=released)
        b.fix(f"{name} 0")
        b.add(planar.beam, "platform", f"{name} 1", name=f"arm {name}")
    b.prescribe("platform", "x", stroke)
    b.force("platform", (0, -3.0))
    found = fm.linear.section_resultants(b.build(), points=3)
    for k, name in enumerate(("left", "right")):
        n_x, n_y, m = z[3 * k : 3 * k + 3]
        at_foot = np.asarray(found.values[found.names.index(name), 0])
        # Section x is up, z to the left.
        np.testing.assert_allclose(at_foot[FIELDS], [n_y, -n_x, -m], rtol=1e-6)


# -- balance ------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kinds", "n"),
    [((planar.beam, spatial.beam), 2), ((planar.spectral_beam(3), spatial.spectral_beam(3)), 1)],
    ids=["beams", "spectral"],
)
def test_plane_and_space_agree(kinds, n):
    loads = dict(force=(0.3, 0, 2.0), moment=(0, -0.05, 0), gravity=(500.0, 0, -300.0))
    found = [fm.stress(cantilever(element, n, LEAF, **loads)) for element in kinds]
    plane, space = found
    scale = np.array([2.0, 2.0, 2.0, 0.2, 0.2, 0.2])
    # Elongations, 1e-12 of the length by the Newton tolerance, times EA; the two integrate poses in different ways.
    np.testing.assert_allclose(plane.resultants.values / scale, space.resultants.values / scale, atol=1e-6)
    np.testing.assert_allclose(plane.von_mises, space.von_mises, rtol=1e-5, atol=1e-6 * float(space.maximum))


def global_wrench(model, found, state, values, end):
    """Force and moment about global axes of the resultants at an end of an element in space."""
    p, rot_p, q, rot_q, *_ = next(nodes for name, _, nodes in model.labels.elements if name == found)
    lam = {0: rot_p, 1: rot_q}[end]
    start, there = (
        np.asarray(x)[np.array(model.labels.coordinates(lam))] for x in (model.parameters.reference, state.x)
    )
    span = [np.asarray(model.parameters.reference)[np.array(model.labels.coordinates(n))] for n in (p, q)]
    ex = (span[1] - span[0]) / np.linalg.norm(span[1] - span[0])
    ez = np.cross(ex, [0, 0, 1.0])
    ez /= np.linalg.norm(ez)
    frame = np.stack([ex, np.cross(ez, ex), ez], axis=1)
    turn = Rotation.from_quat(there, scalar_first=True) * Rotation.from_quat(start, scalar_first=True).inv()
    axes = turn.as_matrix() @ frame
    return np.r_[axes @ values[:3], axes @ values[3:]]


@pytest.mark.slow
def test_ends_balance_at_a_node_with_a_load():
    """A bent frame in space: what one leg hands on, less the load on the corner, the other takes up.

    Of spectral beams; beams have this by the power of their end sections, tests/elements/test_laws.py.
    """
    section = fm.Rectangle(0.01, 0.001, mechanisms.steel())
    points = [(0, 0, 0), (0.1, 0, 0), (0.1, 0.08, 0)]
    b = chain(spatial.spectral_beam(3), points, section, y=(0, 0, 1))
    load, moment = np.array([1.0, -2.0, 3.0]), np.array([0.01, 0.02, -0.03])
    b.force("1", load)
    b.moment("1", moment)
    b.force("2", (2.0, 1.0, 1.5))
    model = b.build()
    state = fm.equilibrium(model)
    values = np.asarray(fm.linear.section_resultants(model, at=state, points=2).values)
    one, other = (global_wrench(model, f"leaf {i}", state, values[i, end], end) for i, end in ((0, 1), (1, 0)))
    # The residual of Newton's last step, 1e-9 of the stiffness EA times the length.
    np.testing.assert_allclose(one, other + np.r_[load, moment], atol=1e-8)
    root = global_wrench(model, "leaf 0", state, values[0, 0], 0)
    np.testing.assert_allclose(-root[:3], state.reactions[np.array(model.labels.coordinates("0"))], atol=1e-8)
    tip = global_wrench(model, "leaf 1", state, values[1, 1], 1)
    np.testing.assert_allclose(tip, [2.0, 1.0, 1.5, 0, 0, 0], atol=1e-8)


# -- distributed loads --------------------------------------------------------------------------------------------

LIGHT = 9.81e-2  # m/s^2: a leaf spring five times as thick sinks by 1e-6 of its length
THICK = fm.Rectangle(W, 5 * T, mechanisms.steel(), rotary=False)
WEIGHT = 7850 * LIGHT * W * 5 * T


@pytest.mark.slow
@pytest.mark.parametrize(("element", "n"), CANTILEVERS.values(), ids=CANTILEVERS)
def test_cantilever_under_its_own_weight(element, n):
    """Lying, hanging and at a slant at once, and one of each: statics of what lies beyond a place."""
    space = len(element.nodes["p"].start) == 3
    pull = np.array([0.6, 0.48, -0.64]) if space else np.array([np.sqrt(0.5), 0.0, -np.sqrt(0.5)])
    found = fm.stress(cantilever(element, n, THICK, gravity=LIGHT * pull))
    beyond = L - (np.arange(n)[:, None] + np.asarray(found.places)) * L / n
    n_x, v_y, v_z = WEIGHT * pull[:, None, None] * beyond
    expected = np.stack([n_x, v_y, v_z, 0 * beyond, -v_z * beyond / 2, v_y * beyond / 2], axis=-1)
    # It tilts and sinks by 1e-6, and the forces with it; the round-off of elongations is 1e-6 in the normal force.
    scale = WEIGHT * L * np.array([1, 1, 1, L, L, L])
    np.testing.assert_allclose(np.asarray(found.resultants.values) / scale, expected / scale, rtol=0, atol=1e-5)
    # The largest stress is at the clamp, in space in a corner, where both moments and the normal force add up.
    corner = WEIGHT / (W * 5 * T) * np.abs(pull) @ [L, 3 * L**2 / W, 3 * L**2 / (5 * T)]
    assert found.maximum == approx(corner, rel=1e-5)
    assert found.where[:2] == ("leaf 0", 0.0)


@pytest.mark.slow
def test_weight_between_two_supports():
    # M = w L^2 s (1 - s)/2 of a bar on two pins, V = w L (1/2 - s), closed form.
    n, b = 3, fm.Builder()
    for i, point in enumerate(straight(n, False)):
        b.node(str(i), point)
    for i in range(n):
        b.add(planar.beam, str(i), str(i + 1), section=THICK)
    b.fix("0", "x", "y")
    b.fix(str(n), "y")
    b.gravity((0, -LIGHT))
    found = fm.linear.section_resultants(b.build())
    s = (np.arange(n)[:, None] + np.asarray(found.places)) / n
    scale = WEIGHT * L
    np.testing.assert_allclose(found.values[:, :, 2] / scale, s - 0.5, rtol=0, atol=1e-5)
    np.testing.assert_allclose(found.values[:, :, 4] / scale / L, -s * (1 - s) / 2, rtol=0, atol=1e-5)


@pytest.mark.slow
def test_truss_under_its_own_weight_hangs():
    b = chain(planar.truss, [(0, 0), (0, -L)], THICK)
    b.fix("1", "x")
    b.gravity((0, -LIGHT))
    found = fm.linear.section_resultants(b.build())
    expected = WEIGHT * L * (1 - np.asarray(found.places))
    np.testing.assert_allclose(found.values[0, :, 0], expected, rtol=0, atol=1e-5 * WEIGHT * L)
    assert not np.any(found.values[0, :, 1:])


def twice_as_heavy():
    """A cantilever of one beam whose weight is among the constant and the incremental loads."""
    b = chain(planar.beam, straight(1, False), THICK)
    b.gravity((0, -LIGHT))
    b.gravity((0, -LIGHT), increment=True)
    return b


@pytest.mark.slow
def test_weight_among_the_incremental_loads_counts_by_its_factor():
    """In equilibria, linearisations and steps of a path, all of which may be the state to be asked about."""
    model = twice_as_heavy().build()
    path = fm.path(model, step=0.5)
    for at, factor in [
        (fm.equilibrium(model, increment=0.5), 1.5),
        (fm.linearize(model, load_factor=0.5, increment=0.0), 0.5),
    ] + [(path.linearization(i), 1 + share) for i, share in enumerate(np.asarray(path.load_factor))]:
        found = fm.stress(model, at=at, points=2)
        np.testing.assert_allclose(found.resultants.values[0, 0, 4], factor * WEIGHT * L**2 / 2, rtol=1e-5)
        assert found.maximum == approx(6 * factor * WEIGHT * L**2 / 2 / (W * (5 * T) ** 2), rel=1e-5)
    factors = 1 + np.asarray(path.load_factor)
    every = fm.stress(model, at=path, points=2).resultants.values
    np.testing.assert_allclose(every[:, 0, 0, 4], factors * WEIGHT * L**2 / 2, rtol=1e-5)


@pytest.mark.slow
def test_heavy_cubic_beams_converge_with_order_two():
    """A tip that sinks by half the length, at a slant, against shooting: at the clamp and in the middle."""
    rod = PlanarRod(1.0, 1.0, 1e4, load=(3.0, -6.0))
    problem = Cantilever(rod, (0.0, 0.0, 0.0))
    z = shooting.solve(problem)
    middle = dataclasses.replace(rod, length=0.5).march(column(problem.root), column(z[:2]), column(z[2:3]))[2][0, 0]
    errors = []
    for n in (4, 8, 16):
        model = cantilever(planar.beam, n, SLENDER, 1.0, gravity=(rod.load[0], 0.0, rod.load[1]))
        values = fm.linear.section_resultants(model, points=2).values[:, 0, 4]
        errors.append([float(values[0]) + z[2], float(values[n // 2]) + middle])
    errors = np.abs(errors)
    np.testing.assert_allclose(errors[:-1] / errors[1:], 4, rtol=0.2)
    assert np.all(errors[-1] < 1e-3 * abs(z[2]))


def hinged(element, released, section=THICK):
    """A bar from a hinge at the origin, under gravity across."""
    space = len(element.nodes["p"].start) == 3
    b = fm.Builder()
    for name, place in (("pivot", 0.0), ("tip", L)):
        b.node(name, (place, 0, 0) if space else (place, 0))
    if space:
        b.node("axle", (0, 0, 0))
        b.add(spatial.hinge, "axle", "pivot", axis=(0, 0, 1))
        b.fix("axle")
    b.fix("pivot", "position")
    b.add(
        element, "pivot", "tip", name="bar", section=section, released=released, **({"y": (0, 0, -1)} if space else {})
    )
    b.gravity((0, -LIGHT, 0) if space else (0, -LIGHT))
    return b.build()


def falling(s, rotary=0.0):
    """Shear force over w L and bending moment over w L^2 of a bar that starts to fall from the horizontal.

    Args:
        s: Places, over the length.
        rotary: Rotary inertia over mass, and over the length squared.
    """
    # Acceleration of the tip, over g.
    a = -1 / (2 / 3 + 2 * rotary)
    moment = (1 - s) ** 2 / 2 + a * (1 / 3 - s / 2 + s**3 / 6 + rotary * (1 - s))
    return -(1 - s) - a * (1 - s**2) / 2, moment


@pytest.mark.slow
@pytest.mark.parametrize("rotary", [0.0, 0.1])
@pytest.mark.parametrize(
    ("element", "released"),
    [(planar.beam, (1,)), (planar.spectral_beam(2), (4, 5))],
    ids=["beam", "spectral"],
)
def test_bar_that_falls_about_a_hinge(element, released, rotary):
    """M = w L^2 s (1 - s)^2/4 as it starts from rest: weight less inertia, that of a falling chimney. Closed form.

    Rotary inertia of its sections adds to its moment of inertia, and to the bending moment what turns each section.
    """
    # It stretches alone, so that it turns as a rigid bar and the bending moments are multipliers.
    mass = WEIGHT / LIGHT
    section = fm.Rigidity(EA=1e6, EIy=1.0, mass=mass, Jy=rotary * mass * L**2)
    model = hinged(element, released, section)
    along = fm.motion.linearize_motion(fm.simulate(model, np.array([0.0, 1e-3])))
    found = fm.linear.section_resultants(model, at=along.at_time(0))
    s, scale = np.asarray(found.places), WEIGHT * L
    # Local z is the global y, and local y points into the plane.
    shear, moment = falling(s, rotary)
    np.testing.assert_allclose(found.values[0, :, 2] / scale, shear, rtol=0, atol=1e-5)
    np.testing.assert_allclose(found.values[0, :, 4] / scale / L, moment, rtol=0, atol=1e-5)


def test_the_printed_range_of_a_stress_is_over_all_points():
    """At the foot of a cantilever N/(w t) +- 6 F L/(w t^2), also at the point of smaller size."""
    found = fm.stress(cantilever(planar.beam, 2, LEAF, force=(0.05, 0, FORCE)))
    low, high = float(jnp.min(found.sigma_x)), float(jnp.max(found.sigma_x))
    assert (low + high) / 2 == approx(0.05 / W / T, rel=1e-6)
    assert (high - low) / 2 == approx(6 * FORCE * L / W / T**2, rel=0.01)
    assert found.summary().rows["sigma_x"].startswith(f"{low:.5g} to {high:.5g} Pa, largest in")


@pytest.mark.slow("spectral", "beam")
@pytest.mark.parametrize(
    ("element", "released", "speed"),
    [(spatial.beam, (1,), 0.0), (spatial.spectral_beam(2), (7, 8), np.sqrt(LIGHT / L))],
    ids=["beam", "spectral"],
)
def test_bar_that_falls_about_a_hinge_in_space(element, released, speed):
    """At speed it pulls at the hinge besides: N = w L (1 - s^2)/2 where the centripetal acceleration of the tip is g.

    The state of motion is given, without its motion, so that no equations of motion are integrated. (The normal force
    of a beam is that of its stretch, and this one has none.)
    """
    model = hinged(element, released)
    # Of a uniform bar 3 g/(2 L); the Euler parameters are the cosine and sine of half the angle.
    square, turning = speed**2, -1.5 * LIGHT / L
    v, a = (np.zeros(model.topology.n_x) for _ in range(2))
    tip = np.array(model.labels.coordinates("tip"))
    v[tip[1]] = speed * L
    a[tip[:2]] = -square * L, turning * L
    for name in ("pivot", "tip"):
        own = np.array(model.labels.coordinates(f"{name}.rotation"))
        v[own[-1]], a[own[-1]], a[own[0]] = speed / 2, turning / 2, -square / 4
    x, none = model.parameters.reference, jnp.zeros(model.topology.n_e)

    @fm.jit
    def balance(topology, parameters, x, v, a, near):
        form = coordinates_form(topology, parameters)
        return dynamic_balance(form, jnp.zeros(()), Moving(x, v, a, near)).sigma, InertialLoad(form.gravity, v, a)

    sigma, felt = balance(model.topology, model.parameters, x, v, a, none)
    zero = jnp.zeros((), jnp.int32)
    nothing = jnp.zeros_like(x)
    state = Equilibrium(x, none, sigma, felt, nothing, nothing, zero, zero, model.labels)
    found = fm.linear.section_resultants(model, at=state)
    s, scale = np.asarray(found.places), WEIGHT * L
    # Local z is the global y, and local y points into the plane.
    expected = np.zeros((len(s), 6))
    expected[:, 0], (expected[:, 2], expected[:, 4]) = speed**2 * L / LIGHT * (1 - s**2) / 2, falling(s)
    found = np.asarray(found.values[0]) / scale / np.array([1, 1, 1, L, L, L])
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5)


# -- the maximum --------------------------------------------------------------------------------------------------


def guide(thickness, stroke=0.01, load=-5.0, length=L, rho=7850.0, dofs=()):
    b = fm.Builder()
    section = fm.Rectangle(W, thickness, fm.Material(E=210e9, G=80e9, rho=rho))
    b.node("body", (0, length))
    for name, x in (("left", -0.04), ("right", 0.05)):
        b.node(f"{name} foot", (x, 0))
        b.node(f"{name} top", (x, length))
        b.add(planar.beam, f"{name} foot", f"{name} top", name=name, section=section)
        b.fix(f"{name} foot")
        b.add(planar.beam, "body", f"{name} top", name=f"arm {name}")
    b.prescribe("body", "x", stroke)
    b.force("body", (0, load))
    b.gravity((50.0, 0))
    for of, symbol in (name.split(".e") for name in dofs):
        b.dof(of, int(symbol))
    return b.build()


@pytest.fixture(scope="module")
def dofs():
    """Degrees of freedom as found on concrete numbers; all are deformations."""
    return guide(T).q_labels


@pytest.mark.slow
def test_derivatives_by_thickness_stroke_load_length_and_weight(dofs):
    @fm.jit
    def answers(numbers):
        found = fm.stress(guide(*numbers, dofs=dofs))
        return jnp.stack([found.maximum, found.smooth_maximum(), found.resultants.values[1, 0, 4]])

    at = np.array([T, 0.01, -5.0, L, 7850.0])
    size = np.asarray(answers(at))
    # Forward derivatives of an equilibrium: test_derivatives.py.
    found = np.asarray(fm.jit(jax.jacrev(answers))(at))
    step = 1e-5
    for i in range(len(at)):
        plus, minus = (np.asarray(answers(at + sign * step * at * np.eye(len(at))[i])) for sign in (1, -1))
        # Truncation step^2; round-off of the stress, 1e-14 of it, over the step.
        difference = (plus - minus) / (2 * step)
        np.testing.assert_allclose(found[:, i] * at[i] / size, difference / size, rtol=0, atol=1e-8)


@pytest.mark.slow
def test_maximum_is_a_number_of_the_batch_too(dofs):
    thicknesses = np.array([0.4e-3, 0.5e-3, 0.6e-3])

    def largest(t):
        found = fm.stress(guide(t, dofs=dofs))
        return found.maximum, found.smooth_maximum(200.0)

    together = fm.jit(jax.vmap(largest))(thicknesses)
    alone = [fm.stress(guide(float(t))) for t in thicknesses]
    # Newton's tolerance of 1e-9, from other degrees of freedom.
    np.testing.assert_allclose(together[0], [a.maximum for a in alone], rtol=1e-8)
    np.testing.assert_allclose(together[1], [a.smooth_maximum(200.0) for a in alone], rtol=1e-8)


def test_smooth_maximum_keeps_its_bound_and_scales():
    rng = np.random.default_rng(3)
    names = ("a", "b", "c")
    blank = fm.linear.SectionResultants(jnp.zeros((3, 4, 6)), np.linspace(0, 1, 4), np.zeros((), np.int32), names)
    sigma, tau = rng.standard_normal((2, 3, 4, 8))

    def of(factor):
        return fm.linear.Stress(factor * sigma, factor * tau, factor * np.sqrt(sigma**2 + 3 * tau**2), blank)

    smooth = fm.jit(lambda found, sharpness: found.smooth_maximum(sharpness))
    found = of(1.0)
    for sharpness in (2.0, 20.0, 100.0, 1e4):
        value = float(smooth(found, sharpness))
        assert found.maximum <= value <= found.maximum * 96 ** (1 / sharpness)
        for factor in (1e-9, 1e9):
            assert smooth(of(factor), sharpness) == approx(factor * value, rel=1e-12)
    # Two that change places: the derivative of the maximum jumps, that of the estimate is shared between them.
    pair = np.zeros((3, 4, 8))
    pair[0, 0, 0] = pair[2, 1, 3] = 1.0

    @fm.jit
    @jax.value_and_grad
    def estimate(sigma):
        return fm.linear.Stress(sigma, 0 * sigma, jnp.abs(sigma), blank).smooth_maximum(50.0)

    value, slope = map(np.asarray, estimate(pair))
    assert slope[0, 0, 0] == approx(slope[2, 1, 3], rel=1e-12)
    assert np.sum(slope * pair) == approx(value, rel=1e-12)
    # Nothing stressed: zero, with a derivative.
    value, slope = estimate(0 * pair)
    assert value == 0
    assert np.all(np.isfinite(slope))
    assert found.where.element == names[np.argmax(np.max(np.asarray(found.von_mises), axis=(1, 2)))]


# -- which elements, and what is refused ---------------------------------------------------------------------------


@pytest.mark.slow
def test_rows_are_in_the_order_of_the_model_and_leave_rigid_elements_out():
    """Sections of three kinds in one block of beams, a rigid beam among them, and a truss in between."""
    steel = mechanisms.steel()
    sections = {
        "strip": fm.Rectangle(0.01, 0.001, steel),
        "wire": fm.Circle(0.002, steel),
        "box": fm.HollowRectangle(0.01, 0.008, 0.001, 0.001, steel),
        "strip too": fm.Rectangle(0.01, 0.002, steel),
    }
    b = fm.Builder()
    b.node("0", (0, 0))
    for i, (name, section) in enumerate(sections.items()):
        b.node(str(i + 1), (0.1 * (i + 1), 0))
        b.add(planar.beam, str(i), str(i + 1), name=name, section=section)
        if name == "wire":
            b.node("far", (0.2, 1.0))
            b.add(planar.truss, "2", "far", name="stay", section=fm.Circle(0.001, steel))
            b.fix("far")
    b.node("end", (0.5, 0))
    b.add(planar.beam, "4", "end", name="rigid", section=fm.Rigidity(mass=1.0), released=())
    b.fix("0")
    b.force("end", (10.0, 0))
    found = fm.stress(b.build(), points=2)
    assert found.names == ("strip", "wire", "stay", "box", "strip too")
    areas = np.array([1e-5, np.pi * 1e-6, np.pi * 0.25e-6, 8e-5 - 8e-3 * 6e-3, 2e-5])
    pulls = np.array([10, 10, 0, 10, 10])
    # The stay takes 2e-3 N from a side deflection, which bends.
    np.testing.assert_allclose(np.mean(found.sigma_x[:, 0], axis=1), pulls / areas, rtol=1e-4, atol=1e4)


@pytest.mark.slow
def test_refusals():
    b = chain(planar.beam, straight(2, False), LEAF)
    b.node("far", (0.1, 0.1))
    b.add(planar.beam, "2", "far", name="numbers", section=fm.Rigidity(EA=1e5, EIy=1.0))
    b.force("far", (0, 0.1))
    model = b.build()
    assert fm.linear.section_resultants(model).names == ("leaf 0", "leaf 1", "numbers")
    with pytest.raises(ValueError, match="`points` must be at least 2"):
        fm.linear.section_resultants(model, points=1)
    with pytest.raises(fm.ModelError, match="has no shape"):
        fm.Rigidity().stress(jnp.zeros(6))
    rigid = fm.Builder()
    rigid.node("a", (0, 0))
    rigid.node("b", (1, 0))
    rigid.add(planar.beam, "a", "b", section=LEAF, released=())
    rigid.fix("a", "position")
    with pytest.raises(fm.ModelError, match="No flexible element has a section"):
        fm.stress(rigid.build())


@pytest.mark.slow
def test_an_element_without_stress_is_left_out():
    """A wire of Rigidity beside two leaf springs, which carries its share of the load all the same."""

    def built(section):
        b = chain(planar.beam, straight(2, False), LEAF)
        b.node("far", (0.1, 0.1))
        b.add(planar.beam, "2", "far", name="numbers", section=section)
        b.force("far", (0, 0.1))
        return b.build()

    with pytest.warns(fm.FlexmbWarning, match="section of element 'numbers' .* without a shape.* left out"):
        found = fm.stress(built(LEAF.rigidity()))
    every = fm.stress(built(LEAF))
    assert (found.names, found.left_out) == (("leaf 0", "leaf 1"), ("numbers",))
    assert every.left_out == ()
    # The same rigidities, and so the same equilibrium to round-off times the condition of a leaf spring.
    np.testing.assert_allclose(found.von_mises, every.von_mises[:2], rtol=1e-9)
    assert found.summary().rows["without stress"] == "numbers"
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("b", (1, 0))
    b.add(planar.truss, "a", "b", section=fm.Rigidity(EA=1.0))
    b.fix("a")
    with pytest.raises(fm.ModelError, match="without a shape"):
        fm.stress(b.build(check=False))


@pytest.mark.slow
def test_where_needs_concrete_numbers(dofs):
    with pytest.raises(TypeError, match=r"outside jax\.jit"):
        fm.jit(lambda t: fm.stress(guide(t, dofs=dofs)).where.place)(T)
    found = fm.stress(guide(T))
    with pytest.raises(ValueError, match="`sharpness` must be at least 2"):
        found.smooth_maximum(1.0)


@pytest.mark.slow
def test_answers_have_the_stress_of_sections_with_a_shape():
    largest = 6 * WEIGHT * L**2 / 2 / (W * (5 * T) ** 2)
    for mode, factor in ((7, 1), (10, 2)):
        data = answer(twice_as_heavy(), "bar", mode, dofs="auto").data
        found = data["path"][-1]["stress"] if mode == 10 else data["stress"]
        assert found["maximum"] == approx(factor * largest, rel=1e-5)
        assert (found["element"], found["place"]) == ("leaf 0", 0)
    numbers = chain(planar.truss, straight(1, False), fm.Rigidity(EA=1.0, mass=1.0))
    numbers.fix("1", "y")
    assert "stress" not in answer(numbers, "numbers", 7, dofs="auto").data


def stepped(place, points=5, beams=1):
    """Stress of cantilevers of two thicknesses that small forces bend."""
    thick, thin = (fm.Rectangle(0.01, t, fm.Material(E=2e11, G=8e10, strength=3e8)) for t in (0.004, 0.001))
    b = fm.Builder()
    b.node("A", (0, 0))
    b.fix("A")
    section = fm.sections.stepped([thick, thin], [place])
    for end in "BC"[:beams]:
        b.node(end, (0.1, 0))
        b.force(end, (0, 0.1))
        b.add(planar.spectral_beam(order=3), "A", end, name="leaf" + end, section=section)
    return fm.stress(b.build(dofs="named"), points=points)


@pytest.mark.slow
def test_both_sides_of_a_break_are_looked_at():
    """Under a small force F: beside the step F L (1 - s)/W in its thin part."""
    found = stepped(0.37)
    # The force bends it so little that its lever is 1e-5 shorter.
    np.testing.assert_allclose(found.maximum, 0.1 * 0.063 / (0.01 * 0.001**2 / 6), rtol=1e-4)
    assert (found.where.place, len(found.places)) == (approx(0.37), 5 + 2 + 2)
    np.testing.assert_allclose(found.utilisation, float(found.maximum) / 3e8)

    # Traced breaks of two elements at one place are not known to be one: it stands twice, and counts once.
    found = fm.jit(lambda place: stepped(place, beams=2))(0.37)
    once = np.diff(found.places, prepend=-1.0) > 0
    assert np.sum(once) < len(once)
    norm = np.sum(np.asarray(found.von_mises)[:, once] ** 4) ** 0.25
    np.testing.assert_allclose(found.smooth_maximum(4.0), norm, rtol=1e-9)


@pytest.mark.slow
def test_a_step_moves_and_what_is_looked_at_beside_it():
    # With two points the middle of either part is looked at as well.
    np.testing.assert_allclose(stepped(0.37, points=2).places, [0, 0.185, 0.37, 0.37, 0.685, 1], atol=1e-8)
    slope = fm.jit(jax.grad(lambda place: stepped(place).maximum))(0.37)
    np.testing.assert_allclose(slope, -0.1 * 0.1 / (0.01 * 0.001**2 / 6), rtol=1e-4)


def test_stress_between_the_ends_of_a_spectral_beam():
    """A strut kL = 2.5 between two hinges with a small moment M at its end: M/sin(kL) at kx = pi/2 [4]."""
    section, moment = fm.Rectangle(0.01, 0.001, fm.Material(E=2e11, G=8e10)), 1e-4
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0.1, 0))
    for node, axis in ("Ax", "Ay", "By"):
        b.fix(node, axis)
    b.add(planar.spectral_beam, "A", "B", name="strut", section=section)
    thrust = 2.5**2 * float(section.rigidity().EIy) / 0.1**2
    b.force("B", (-thrust, 0))
    b.moment("B", moment)
    found = fm.stress(b.build(dofs="named"))
    # Half of one of 32 parts aside cos(kL/64) is 8e-4 less, of four parts 5 %.
    bending = 6 * moment / np.sin(2.5) / (0.01 * 0.001**2)
    assert float(found.maximum) == approx(thrust / (0.01 * 0.001) + bending, rel=1e-3)
    assert found.where.place == approx(np.pi / 5, abs=1 / 64)


@pytest.mark.slow
@pytest.mark.parametrize("breaks", [(), (0.1, 0.2)])
def test_stress_in_a_groove_between_the_places(breaks):
    """Under a moment M alone 6 M/(w t^2) where a section is thinnest."""
    thickness = lambda s: 0.001 * (1 - 0.3 * jnp.exp(-(((s - 0.134) / width) ** 2)))  # noqa: E731
    width = 0.01 if breaks else 0.1
    groove = fm.sections.Profile(lambda s: fm.Rectangle(0.01, thickness(s), fm.Material(E=2e11, G=8e10)), breaks)
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0.1, 0))
    b.fix("A")
    b.moment("B", 1e-3)
    b.add(planar.spectral_beam, "A", "B", section=groove, order=10)
    found = fm.stress(b.build(dofs="named"))
    # At half a part from the middle of the groove it is thicker by 0.3 (1/(128 width))^2.
    assert float(found.maximum) == approx(6e-3 / (0.01 * 0.0007**2), rel=6e-3)


@pytest.mark.slow
@pytest.mark.parametrize("element", [spatial.warping_beam, spatial.beam])
def test_the_stress_of_restrained_warping_is_left_out_with_a_warning(element):
    """A strip under a torque: a leaf spring has 1.5 times the stress, by its normal stress at the clamp."""
    length = {} if element is spatial.warping_beam else {"warping_length": 0.1}
    strip = fm.Rectangle(0.018, 0.5e-3, mechanisms.steel(), shear=True)

    def twisted(element, section, moment):
        b = fm.Builder()
        b.node("foot", (0, 0, 0))
        b.node("tip", (0.1, 0, 0))
        b.node("end", (0.12, 0, 0))
        b.add(element, "foot", "tip", name="strip", section=section, y=(0, 1, 0))
        b.add(spatial.rigid_body, "tip", "end")
        b.fix("foot")
        b.moment("end", moment)
        return fm.stress(b.build())

    with pytest.warns(fm.BeamTheoryWarning, match="torque acts on element 'strip'. Its stress leaves out the normal"):
        less = twisted(element, dataclasses.replace(strip, **length), (2e-3, 0, 0))
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "A torque acts")
        more = twisted(spatial.leaf_spring, strip, (2e-3, 0, 0))
        twisted(element, dataclasses.replace(strip, **length), (1e-6, 2e-3, 0))
    assert float(more.maximum) > 1.4 * float(less.maximum)
