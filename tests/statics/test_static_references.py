"""Large deflection, support stiffness and stability against an independent shooting solution (rod_references.py).

One spectral beam stands for a whole leaf spring. Where the reference has no extension, EA is 1e9 here.
"""

import numpy as np
import pytest
from cases import mechanisms
from cases.tolerances import approx
from references.rod_references import REFERENCE

import flexmb as fm
from flexmb import planar, spatial

STIFF = 1e9


def finite(rigidity):
    return STIFF if np.isinf(rigidity) else rigidity


def rows(key, keep=lambda row: True):
    return [row for row in REFERENCE[key]["rows"] if keep(row)]


def leaf(points, section, order=6, element=planar.spectral_beam, **properties):
    b = fm.Builder()
    for i, point in enumerate(points):
        b.node(str(i), point)
    for i in range(len(points) - 1):
        b.add(element(order), str(i), str(i + 1), name=f"leaf {i}", section=section, **properties)
    b.fix("0")
    return b


@pytest.mark.slow
@pytest.mark.parametrize("row", rows("follower-force", lambda r: np.isinf(r[2])), ids=str)
def test_follower_force(row):
    load, ea, _, *expected = row
    b = leaf([(0, 0), (1, 0)], fm.Rigidity(EA=finite(ea), EIy=1.0), order=8)
    b.force("1", (0, load), follower=True)
    found = fm.equilibrium(b.build())
    # Order eight at a tip angle of 2 rad: 1e-8.
    np.testing.assert_allclose([*found.at("1"), *found.at("1.rotation")], expected, atol=3e-8)


def sections(key, shear):
    data = REFERENCE[key]
    if not shear:
        return fm.Rigidity(EA=STIFF, EIy=data["EIy"], EIz=data["EIz"], GIt=data["GJ"])
    e, g, a = data["E"], data["G"], data["side"] ** 2
    bend, compliance = e * a**2 / 12, e * a**2 / 12 / (g * a * data["k"])
    return fm.Rigidity(EA=e * a, EIy=bend, EIz=bend, GIt=g * data["J"], shear_y=compliance, shear_z=compliance)


@pytest.mark.slow
@pytest.mark.parametrize("row", rows("follower-arc"), ids=lambda r: str(r[0]))
def test_follower_force_on_an_arc_in_space(row):
    load, *expected = row
    radius, angle = REFERENCE["follower-arc"]["R"], REFERENCE["follower-arc"]["angle"]
    points = [(radius * (1 - np.cos(a)), radius * np.sin(a), 0) for a in (0, angle / 2, angle)]
    b = leaf(
        points, sections("follower-arc", True), 6, lambda p: spatial.spectral_beam(p, shear=True), y=(0, 0, 1),
        curvature=(0.0, -1 / radius, 0.0),
    )  # fmt: skip
    b.force("2", (0, 0, load), follower=True)
    found = fm.equilibrium(b.build())
    # 1e-6 of the radius.
    np.testing.assert_allclose(found.at("2"), expected[:3], atol=1e-4)


def turned(vector):
    angle = np.linalg.norm(vector)
    k = -np.cross(np.eye(3), np.asarray(vector) / angle).T
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


@pytest.mark.slow
@pytest.mark.parametrize("row", rows("moment-space"), ids=lambda r: f"{r[3]} {r[0]}")
def test_moments_about_fixed_and_following_axes(row):
    *moment, kind, x, y, z = row[:7]
    root = turned(REFERENCE["moment-space"]["turn"])
    b = leaf([(0, 0, 0), root[:, 0]], sections("moment-space", False), 8, spatial.spectral_beam, y=root[:, 1])
    follower = kind == "follower_moment"
    b.moment("1", root @ moment if follower else np.array(moment), follower=follower)
    found = fm.equilibrium(b.build())
    np.testing.assert_allclose(found.at("1"), [x, y, z], atol=2e-6)


@pytest.mark.slow
@pytest.mark.parametrize("row", rows("distributed"), ids=lambda r: f"{r[0]} {r[1]}")
def test_distributed_load_as_weight(row):
    degrees, load, x, y, angle, _ = row
    a = np.deg2rad(degrees)
    b = leaf([(0, 0), (np.cos(a), np.sin(a))], fm.Rigidity(EA=STIFF, EIy=1.0, mass=1.0), order=8)
    b.gravity((0.0, load))
    found = fm.equilibrium(b.build())
    np.testing.assert_allclose(found.at("1"), [x, y], atol=1e-7)
    assert a + found.at("1.rotation")[0] == approx(angle, abs=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("row", rows("right-angle-frame", lambda r: np.isinf(r[0])), ids=lambda r: f"{r[1]} {r[2]}")
def test_right_angle_frame(row):
    _, at_corner, at_tip, corner, tip = row
    b = leaf([(0, 0), (0, 1), (1, 1)], fm.Rigidity(EA=STIFF, EIy=1.0), order=8)
    b.force("1", at_corner)
    b.force("2", at_tip)
    found = fm.equilibrium(b.build())
    np.testing.assert_allclose(found.at("1"), corner[:2], atol=1e-6)
    np.testing.assert_allclose(found.at("2"), tip[:2], atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("row", rows("cross-pivot", lambda r: np.isinf(r[0]) and r[3] in (5.0, 30.0)), ids=str)
def test_cross_pivot_under_load(row):
    _, fraction, force, degrees, moment, x, y = row
    b = mechanisms.cross_pivot(fraction, np.deg2rad(degrees))
    b.force("body", (0, force))
    model = b.build()
    found = fm.equilibrium(model)
    assert found.reactions[model.labels.coordinates("body.rotation")[0]] == approx(moment, rel=2e-6)
    np.testing.assert_allclose(found.at("body"), [x, y], atol=1e-7)


def guide(space):
    data = REFERENCE["guide-spatial" if space else "guide-planar"]
    b = fm.Builder()
    height, half = data["l"], data["b"] / 2
    if space:
        section = fm.Rectangle(data["w"], data["t"], fm.Material(E=data["E"], G=data["G"]), torsion="series")
        element, bar, rest, across = spatial.spectral_beam(6), spatial.beam, (0,), {"y": (0, 0, 1)}
    else:
        section = fm.Rigidity(EA=data["EA"], EIy=data["EI"])
        element, bar, rest, across = planar.spectral_beam(7), planar.beam, (), {}
    b.node("platform", (0, height, *rest))
    for name, x in (("left", -half), ("right", half)):
        b.node(f"{name} foot", (x, 0, *rest))
        b.node(f"{name} top", (x, height, *rest))
        b.add(element, f"{name} foot", f"{name} top", name=name, section=section, **across)
        b.fix(f"{name} foot")
        b.add(bar, "platform", f"{name} top", name=f"bar {name}")
    return b


@pytest.mark.slow
@pytest.mark.parametrize("row", rows("guide-planar"), ids=lambda r: f"{r[0]:.2f} {r[1]}")
def test_guide_in_the_plane(row):
    fx, fy, x, y, phi, drive, support = row
    b = guide(False)
    b.force("platform", (fx, fy))
    model = b.build()
    found = fm.equilibrium(model)
    moved = [*np.asarray(found.at("platform")) - [0, 0.1], found.at("platform.rotation")[0]]
    np.testing.assert_allclose(moved, [x, y, phi], rtol=1e-6, atol=1e-10)
    c = np.asarray(fm.compliance(model, "platform"))
    assert 1 / c[0, 0] == approx(drive, rel=1e-6)
    # x held, phi free: one over the compliance left once x is taken out.
    assert 1 / (c[1, 1] - c[0, 1] ** 2 / c[0, 0]) == approx(support, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("row", rows("guide-spatial", lambda r: np.isinf(r[0])), ids=lambda r: str(r[1]))
def test_guide_in_space(row):
    _, force, moved, drive, support_y, support_z = row
    b = guide(True)
    b.force("platform", force)
    model = b.build()
    found = fm.equilibrium(model)
    # One spectral beam a leaf spring; 1e-4 is asked for.
    np.testing.assert_allclose(np.asarray(found.at("platform")) - [0, 0.1, 0], moved[:3], rtol=2e-6, atol=1e-9)
    c = np.asarray(fm.compliance(model, "platform"))
    assert 1 / c[0, 0] == approx(drive, rel=5e-6)
    for k, support in ((1, support_y), (2, support_z)):
        assert 1 / (c[k, k] - c[0, k] ** 2 / c[0, 0]) == approx(support, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    "row", rows("lateral", lambda r: r[0] == "distributed" and r[1] == 20.0 and r[2] == 0.0), ids=str
)
def test_lateral_buckling_with_the_bending_before_it(row):
    _, stiff, _, sign, critical = row
    section = fm.Rigidity(EA=STIFF, EIy=stiff, EIz=1.0, GIt=1.0, mass=1.0)
    b = leaf([(0, 0, 0), (1, 0, 0)], section, 8, spatial.spectral_beam, y=(0, 1, 0))
    b.gravity((0, 0, sign))
    model = b.build()

    def lowest(load):
        return float(np.linalg.eigvalsh(np.asarray(fm.linearize(model, load_factor=load).K))[0])

    # The stiffness under the load, bending included, stops being positive definite at the critical load.
    assert lowest(abs(critical) * (1 - 1e-4)) > 0 > lowest(abs(critical) * (1 + 1e-4))


@pytest.mark.slow
@pytest.mark.parametrize("row", rows("frame-lateral", lambda r: r[0] == 2.16), ids=str)
def test_frame_leaves_its_plane(row):
    torsion, sign, critical = row
    data = REFERENCE["frame-lateral"]
    w, t, e, leg = data["width"], data["thickness"], data["E"], data["leg"]
    section = fm.Rigidity(
        EA=e * w * t, EIy=e * t * w**3 / 12, EIz=e * w * t**3 / 12, GIt=e / (2 + 2 * data["nu"]) * torsion, mass=1.0
    )
    b = leaf([(0, 0, 0), (leg, 0, 0), (leg, -leg, 0)], section, 6, spatial.spectral_beam, y=(0, 0, 1))
    b.force("2", (sign, 0, 0))
    model = b.build()

    def lowest(load):
        return float(np.linalg.eigvalsh(np.asarray(fm.linearize(model, load_factor=load).K))[0])

    assert lowest(abs(critical) * (1 - 1e-4)) > 0 > lowest(abs(critical) * (1 + 1e-4))


@pytest.mark.slow
def test_a_frame_that_snaps_through_and_back():
    """Lee's frame: the load rises, falls below zero and rises again, with its point of attack moving to and fro."""
    data = REFERENCE["lee-frame"]
    length, load = data["L"], data["P_end"]
    ea, _, limits, _ = data["rows"][0]
    b = fm.Builder()
    section = fm.Rigidity(EA=ea, EIy=data["EI"], mass=1.0)
    places = {"foot": (0, 0), "corner": (0, length), "load": (0.2 * length, length), "end": (length, length)}
    for name, place in places.items():
        b.node(name, place)
    for p, q, order in (("foot", "corner", 7), ("corner", "load", 4), ("load", "end", 7)):
        b.add(planar.spectral_beam(order), p, q, name=f"{p} {q}", section=section)
    b.fix("foot", "position")
    b.fix("end", "position")
    b.force("load", (0, -load))
    model = b.build()
    path = fm.path(model)
    assert path.load_factor[-1] == 1.0
    assert [c.kind for c in path.critical_points] == ["limit", "limit"]
    x, y = model.labels.coordinates("load")
    for found, (u, v, critical, *_) in zip(path.critical_points, limits, strict=True):
        # Series of order seven at rotations of 3 rad: 2e-5.
        assert found.load_factor * load == approx(critical, rel=2e-5)
        # Where the load is stationary the place is known to the root of that, and the extent is 120.
        np.testing.assert_allclose([found.x[x] - 24, 120 - found.x[y]], [u, v], atol=0.2)
    # Falling through the first limit and rising through the second, the frame is unstable between them.
    between = np.diff(np.asarray(path.load_factor)) < 0
    assert not np.any(path.stable[1:][between][1:-1])
