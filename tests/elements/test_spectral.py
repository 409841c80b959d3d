"""Spectral beams against closed forms and independent solutions: one element a leaf spring (keys of the references)."""

import itertools

import jax
import numpy as np
import pytest
from cases import mechanisms
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, spatial

STIFF = 1e9


def chain(element, points, section, *, clamp=True, **properties):
    b = fm.Builder()
    for i, point in enumerate(points):
        b.node(str(i), point)
    for i in range(len(points) - 1):
        own = {k: v[i] if isinstance(v, list) else v for k, v in properties.items()}
        b.add(element, str(i), str(i + 1), name=f"leaf {i}", section=section, **own)
    if clamp:
        b.fix("0")
    return b


def straight(n, space=False):
    return [(i / n, 0, 0) if space else (i / n, 0) for i in range(n + 1)]


PLANE = fm.Rigidity(EA=STIFF, EIy=1.0, mass=1.0)


@pytest.mark.slow
@pytest.mark.parametrize(("order", "error"), [(3, 2e-4), (5, 2e-6), (8, 3e-9)])
def test_elastica_by_one_element(order, error):
    # A1, P L^2/EI = 2, closed form. Errors fall exponentially.
    b = chain(planar.spectral_beam(order), straight(1), PLANE)
    b.force("1", (0.0, 2.0))
    found = fm.equilibrium(b.build())
    tip = [1 - found.at("1")[0], found.at("1")[1], found.at("1.rotation")[0]]
    # Elongation P/EA = 2e-9.
    np.testing.assert_allclose(tip, [0.1606417208, 0.4934574804, 0.7817498316], rtol=0, atol=error + 5e-9)
    assert int(found.iterations) <= 15


@pytest.mark.slow
@pytest.mark.parametrize("elements", [1, 2, 8])
@pytest.mark.parametrize("turns", [1, 2])
def test_roll_up(elements, turns):
    # A4, closed form: a constant curvature is in the series, so the circle closes to rounding.
    b = chain(planar.spectral_beam(5), straight(elements), PLANE)
    b.moment(str(elements), 2 * np.pi * turns)
    found = fm.equilibrium(b.build())
    np.testing.assert_allclose(found.at(str(elements)), 0, atol=1e-8)
    assert found.at(f"{elements}.rotation")[0] == approx(2 * np.pi * turns, rel=1e-10)
    assert int(found.iterations) <= 40 * turns


@pytest.mark.slow
@pytest.mark.parametrize("tilted", [False, True])
def test_roll_up_in_space(tilted):
    # A4 along and across no axis: the moment's axis is normal to the beam.
    along, about = (1.0, 0, 0), (0, 0, 1.0)
    if tilted:
        along, about = np.array([1.0, 2, 2]) / 3, np.array([2.0, 1, -2]) / 3
    section = fm.Rigidity(EA=STIFF, EIy=1.0, EIz=1.0, GIt=1.0)
    b = chain(spatial.spectral_beam(3), [np.zeros(3), along], section)
    b.moment("1", 2 * np.pi * np.asarray(about))
    found = fm.equilibrium(b.build())
    np.testing.assert_allclose(found.at("1"), 0, atol=1e-8)
    assert int(found.iterations) <= 40


ARC = fm.Rigidity(EA=1e7, EIy=1e7 / 12, EIz=1e7 / 12, GIt=5e6 / 6, shear_z=1e7 / 12 / (5e6 * 5 / 6), shear_y=0.2)


def arc(n, order, force):
    angles = np.pi / 4 * np.arange(n + 1) / n
    points = [(100 * (1 - np.cos(a)), 100 * np.sin(a), 0) for a in angles]
    element = spatial.spectral_beam(order, shear=True)
    b = chain(element, points, ARC, y=(0, 0, 1), curvature=(0.0, -0.01, 0.0))
    b.force(str(n), (0, 0, force))
    return fm.equilibrium(b.build())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("force", "tip"), [(300, (22.244679, 58.778897, 40.192392)), (450, (18.508065, 52.238262, 48.503492))]
)
def test_bend_carried_out_of_its_plane(force, tip):
    # A5, independent solution with J = 2 I, digits to 1e-6; 1e-4 of R = 100 is asked for.
    found = arc(2, 5, force)
    np.testing.assert_allclose(found.at("2"), tip, atol=3e-6)
    assert int(found.iterations) <= 60


PRINCETON = {  # A9, P = 8.896 N: load angle [deg], uy, uz, ux [m], twist [deg]
    0: (0.01071360, 0, -0.00013553, 0),
    45: (0.00888740, 0.10903588, -0.01438777, -1.664822),
    90: (0, 0.14625304, -0.02602168, 0),
}


@pytest.mark.slow
@pytest.mark.parametrize("angle", PRINCETON)
def test_princeton_beam(angle):
    e, g, w, t = 71.7e9, 71.7e9 / 2.62, 12.3777e-3, 3.2024e-3
    area, iy, iz = w * t, w * t**3 / 12, t * w**3 / 12
    shear = g * area * 5 / 6
    section = fm.Rigidity(
        EA=e * area, EIy=e * iy, EIz=e * iz, GIt=g * 1.1340719e-10, shear_z=e * iy / shear, shear_y=e * iz / shear
    )
    b = chain(spatial.spectral_beam(6, shear=True), [(0, 0, 0), (0.508, 0, 0)], section, y=(0, 1, 0))
    a = np.deg2rad(angle)
    b.force("1", (0, 8.896 * np.cos(a), 8.896 * np.sin(a)))
    found = fm.equilibrium(b.build())
    uy, uz, ux, twist = PRINCETON[angle]
    np.testing.assert_allclose(found.at("1") - np.array([0.508, 0, 0]), [ux, uy, uz], atol=1e-6)
    l0, l1, l2, l3 = np.asarray(found.at("1.rotation"))
    turned = np.arctan2(2 * (l2 * l3 + l0 * l1), l0**2 - l1**2 + l2**2 - l3**2)
    assert np.rad2deg(turned) == approx(twist, abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("order", "load"), [(2, 4.485), (6, 4.0127)])
def test_lateral_buckling_by_one_element(order, load):
    # A11-lateral: 4.0125993436 for a thin section. The values of THEORY.md 2, rounded there to what is shown; the
    # SPACAR beam gives 6.00, 4.29 and 4.07 with 1, 2 and 4 elements.
    section = fm.Rigidity(EA=STIFF, EIy=1e6, EIz=1.0, GIt=1.0)
    b = chain(spatial.spectral_beam(order), straight(1, space=True), section, y=(0, 1, 0))
    b.force("1", (0, 0, 1.0))
    loads = np.sort(np.abs(np.asarray(fm.buckling_loads(b.build())[:2])))
    # Both directions alike; EIz/EIy = 1e-6 and the elongation leave 1e-5.
    np.testing.assert_allclose(loads, load, rtol=2e-4)


@pytest.mark.slow
def test_euler_columns_by_one_element():
    # A11-euler, closed form; P/EA = 1e-8.
    b = chain(planar.spectral_beam(8), straight(1), PLANE)
    b.force("1", (-1.0, 0))
    assert fm.buckling_loads(b.build())[0] == approx(2.4674011003, rel=1e-7)


POST_BUCKLING = {  # A2, closed form: tip angle [deg]: P over the buckling load, x, y
    20: (1.0153968655, 0.9697309074, 0.2194130424),
    40: (1.0636632664, 0.8812035117, 0.4222403401),
    60: (1.1517196205, 0.7410196061, 0.5932076462),
    80: (1.2938893239, 0.5593959190, 0.7194971047),
    100: (1.5183887933, 0.3489893004, 0.7915394965),
}


def pressed(ratio):
    """A2: cantilever of order eight that cannot stretch, pressed along its axis by a multiple of its buckling load."""
    element = planar.spectral_beam(8)
    b = chain(element, straight(1), PLANE, released=element.fields[1])
    b.force("1", (-ratio * np.pi**2 / 4, 0))
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize("angle", POST_BUCKLING)
@pytest.mark.parametrize("side", [1, -1])
def test_post_buckling(angle, side):
    ratio, x, y = POST_BUCKLING[angle]
    path = fm.path(pressed(ratio), switch=side)
    (critical,) = path.critical_points
    assert critical.kind == "bifurcation"
    assert ratio * critical.load_factor == approx(1, abs=1e-10)
    assert path.load_factor[-1] == 1.0
    assert path.stable[-1]
    # The table's tolerance; at 20 degrees the last digit of the load is 3e-10 of y.
    np.testing.assert_allclose(path.at("1")[-1], [x, side * y], rtol=0, atol=1e-8)
    assert np.rad2deg(path.at("1.rotation")[-1, 0]) == approx(side * angle, abs=1e-6)


@pytest.mark.slow
def test_the_straight_state_beyond_buckling_is_called_unstable():
    ratio = POST_BUCKLING[60][0]
    model = pressed(ratio)
    path = fm.path(model)
    np.testing.assert_allclose(path.at("1")[:, 1], 0, atol=1e-9)
    np.testing.assert_array_equal(path.stable, ratio * path.load_factor < 1)
    assert not path.stable[-1]
    with pytest.warns(fm.FlexmbWarning, match="The equilibrium is not stable"):
        found = fm.equilibrium(model)
    np.testing.assert_allclose(found.at("1"), [1, 0], rtol=0, atol=1e-12)
    assert not fm.modes(model).stable
    # The load multiplier of linear buckling about it counts from none: less than one.
    assert fm.buckling_loads(model)[0] == approx(1 / ratio, rel=1e-9)


def modes_of(b, n):
    return 2 * np.pi * np.asarray(fm.frequencies(b.build())[:n])


@pytest.mark.slow
def test_modes_of_a_cantilever():
    # C1, clamped-free, closed form: (beta L)^2 with EI = mass = L = 1.
    found = modes_of(chain(planar.spectral_beam(8), straight(1), PLANE), 4)
    expected = np.array([1.8751040687, 4.6940911330, 7.8547574382]) ** 2
    np.testing.assert_allclose(found[:2], expected[:2], rtol=1e-8)
    np.testing.assert_allclose(found[2], expected[2], rtol=2e-5)
    # Two elements resolve the higher modes too.
    found = modes_of(chain(planar.spectral_beam(8), straight(2), PLANE), 4)
    np.testing.assert_allclose(found[:3], expected, rtol=1e-8)


@pytest.mark.slow
def test_modes_of_a_timoshenko_cantilever():
    # C2, independent spectral solution at 1e-10, clamped-free.
    e, nu, rho, h = 210e9, 0.3, 7850.0, 0.1
    area, i = h**2, h**4 / 12
    shear = e * i / (e / (2 * (1 + nu)) * area * 5 / 6)
    section = fm.Rigidity(
        EA=e * area, EIy=e * i, EIz=2 * e * i, GIt=e * i, shear_z=shear, shear_y=2 * shear, mass=rho * area,
        Jx=2 * rho * i, Jy=rho * i, Jz=rho * i,
    )  # fmt: skip
    in_space = chain(spatial.spectral_beam(8, shear=True), straight(2, space=True), section, y=(0, 1, 0))
    for b in (in_space, chain(planar.spectral_beam(8, shear=True), straight(2), section)):
        found = modes_of(b, 12)
        for expected in (520.84064174, 3121.57776540, 8210.22613309):
            assert np.min(np.abs(found / expected - 1)) < 1e-8


def guide(order, ea=480000.0):
    """B1: two leaf springs of length 1 upright at a distance of 1, EI = 1, joined by a rigid bar."""
    b = fm.Builder()
    section = fm.Rigidity(EA=ea, EIy=1.0)
    for name, x in (("left", -0.5), ("right", 0.5)):
        b.node(f"{name} foot", (x, 0))
        b.node(f"{name} top", (x, 1))
        b.add(planar.spectral_beam(order), f"{name} foot", f"{name} top", name=name, section=section)
        b.fix(f"{name} foot")
    b.node("platform", (0, 1))
    for name in ("left", "right"):
        b.add(planar.beam, "platform", f"{name} top", name=f"bar {name}")
    return b


B1 = {  # stroke: Fx, y, phi, Kz
    0.01: (0.240017862, -0.0000599991, -5.344e-7, 898286.668),
    0.05: (1.202960515, -0.0015012125, -6.815e-6, 352530.027),
}


@pytest.mark.slow
@pytest.mark.parametrize("stroke", B1)
def test_support_stiffness_of_a_guide_at_a_stroke(stroke):
    # B1, shooting at 1e-12: Fx to 1e-6, Kz to 1e-4.
    b = guide(5)
    b.prescribe("platform", "x", stroke)
    model = b.build()
    found = fm.equilibrium(model)
    force, y, phi, support = B1[stroke]
    x_index, y_index = model.labels.coordinates("platform")
    assert found.reactions[x_index] == approx(force, rel=1e-6)
    assert found.x[y_index] - 1 == approx(y, rel=1e-4)
    assert found.at("platform.rotation")[0] == approx(phi, rel=2e-3)
    compliance = fm.linear.directional_compliance(model)["platform"]
    assert 1 / compliance[1] == approx(support, rel=1e-4)


def cross_pivot(fraction, angle):
    model = mechanisms.cross_pivot(fraction, angle).build()
    found = fm.equilibrium(model)
    moment = found.reactions[model.labels.coordinates("body.rotation")[0]]
    return float(moment / angle), float(np.hypot(*found.at("body")))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fraction", "degrees", "stiffness", "shift"),
    [(0.5, 5, 2.00253510, 8.96862e-4), (0.5, 10, 2.01010020, 3.579963e-3), (0.1273, 10, 5.33756828, 5.37295e-5)],
)
def test_cross_pivot(fraction, degrees, stiffness, shift):
    found = cross_pivot(fraction, np.deg2rad(degrees))
    # B3, inextensible leaf springs: 1e-6 in M/phi, 1e-5 in the shift; EA L^2/EI = 1e9.
    assert found[0] == approx(stiffness, rel=1e-6)
    assert found[1] == approx(shift, rel=1e-5, abs=1e-8)


@pytest.mark.slow
def test_derivatives_of_a_loaded_spectral_beam():
    def tip(numbers):
        load, curvature, rigidity = numbers
        b = fm.Builder()
        b.node("0", (0, 0))
        b.node("1", (1, 0))
        section = fm.Rigidity(EA=1e3, EIy=rigidity, mass=1.0)
        b.add(planar.spectral_beam(4), "0", "1", name="leaf", section=section, curvature=curvature)
        b.fix("0")
        b.force("1", (0, load))
        b.dof("leaf", *range(4, 12))
        lin = fm.linearize(b.build())
        return lin.x[lin.labels.known("1")[0]] + fm.frequencies(lin)[0]

    at, step = np.array([1.5, 0.3, 1.2]), 1e-5
    value = fm.jit(tip)
    difference = [(value(at + step * d) - value(at - step * d)) / (2 * step) for d in np.eye(3)]
    for differentiate in (jax.jacfwd, jax.jacrev):
        # Truncation 1e-10, round-off 1e-13/step.
        np.testing.assert_allclose(fm.jit(differentiate(tip))(at), difference, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize(
    ("element", "points", "message"),
    [
        (planar.spectral_beam(3), ((0, 0), (1, 0)), "initial curvature that no arc"),
        (spatial.spectral_beam(3), ((0, 0, 0), (1, 0, 0)), "initial curvature that no arc"),
    ],
)
def test_curvature_that_no_arc_has(element, points, message):
    curvature = 3.0 if len(points[0]) == 2 else (0.0, 3.0, 0.0)
    with pytest.raises(fm.ModelError, match=message):
        chain(element, points, PLANE, curvature=curvature)


def test_shear_is_counted_by_both_or_neither():
    material = fm.Material(E=1.0, G=0.4)
    for section, shear, message in (
        (fm.Rectangle(0.1, 0.1, material, shear=True), False, "shear=True"),
        (fm.Rectangle(0.1, 0.1, material), True, "its section has none"),
    ):
        with pytest.raises(fm.ModelError, match=message):
            chain(spatial.spectral_beam(3, shear=shear), straight(1, space=True), section)
        with pytest.raises(fm.ModelError, match=message):
            chain(planar.spectral_beam(3, shear=shear), straight(1, space=False), section)
    # A leaf spring counts it of any rectangle, where it is made so.
    chain(planar.leaf_spring(3, shear=True), straight(1, space=False), fm.Rectangle(0.1, 0.1, material))
    with pytest.raises(fm.ModelError, match="does not count shear"):
        chain(planar.leaf_spring(3), straight(1, space=False), fm.Rectangle(0.1, 0.1, material, shear=True))


@pytest.mark.slow
@pytest.mark.parametrize("space", [False, True])
def test_deformations_are_the_closure_and_then_one_field_after_the_other(space):
    # Small loads on a straight cantilever of length 1: tension, twist and a moment each fill the first coefficient of
    # one field, a force across the first two of a bending.
    rigidities = {"EA": 2.0, "GIt": 3.0, "EIy": 5.0, "EIz": 7.0} if space else {"EA": 2.0, "EIy": 5.0}
    order, closure = 4, 6 if space else 3
    element = spatial.spectral_beam(order) if space else planar.spectral_beam(order)
    assert element.fields == tuple(
        tuple(range(closure + 1 + order * i, closure + 1 + order * (i + 1))) for i in range(len(rigidities))
    )
    assert element.freed({}) == tuple(range(closure + 1, closure + order * len(rigidities) + 1))
    b = chain(element, straight(1, space), fm.Rigidity(**rigidities), **({"y": (0, 1, 0)} if space else {}))
    f = 1e-7
    b.force("1", (f, 0, 2 * f) if space else (f, 2 * f))
    b.moment("1", (3 * f, 0, 5 * f) if space else 5 * f)
    e = np.asarray(fm.equilibrium(b.build()).e) / f
    found = e[closure : closure + order * len(rigidities)].reshape(-1, order)
    # Moment 2 (1 - s) of a force across: coefficients 1 and -1 of the series; about y it is negative.
    across = np.array([1.0, -1, 0, 0]) / 5
    turned = np.array([5.0 / (7 if space else 5), 0, 0, 0])
    first = np.array([1 / 2, 0, 0, 0])
    expected = [first, [1, 0, 0, 0], -across, turned] if space else [first, across + turned]
    np.testing.assert_allclose(found, expected, atol=1e-6)
    np.testing.assert_allclose(e[:closure], 0, atol=1e-6)


def test_one_element_for_all_ways_to_ask_for_it():
    assert planar.spectral_beam() is planar.spectral_beam(order=5)
    assert spatial.spectral_beam() is spatial.spectral_beam(5, shear=False)
    with pytest.raises(ValueError, match="order must be at least 1"):
        planar.spectral_beam(0)


@pytest.mark.slow
def test_rigid_motion_does_not_deform():
    """Deformations of a spectral beam whose nodes all move as one body stay zero."""
    b = chain(spatial.spectral_beam(3), [(0, 0, 0), (1, 0.5, 0)], fm.Rigidity(), clamp=False, curvature=(0.0, 0.4, 0.3))
    model = b.build(check=False)
    rng = np.random.default_rng(0)
    turn = rng.standard_normal(4)
    turn /= np.linalg.norm(turn)
    from flexmb.math.rotation import rotation_matrix
    from flexmb.mechanics.deformation import deformations, zero_strain

    x = np.array(model.parameters.reference)
    for name, kind in itertools.product(("0", "1"), ("position", "rotation")):
        indices = model.labels.coordinates(name if kind == "position" else f"{name}.rotation")
        moved = np.asarray(rotation_matrix(turn)) @ x[indices] + [1, 2, 3] if kind == "position" else turn
        x[indices] = moved
    e = deformations(model.topology, model.parameters, x, zero_strain(model.topology))
    np.testing.assert_allclose(e, 0, atol=1e-14)
