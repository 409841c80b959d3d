"""What to release in closed loops of rigid parts: every proposal builds, and its warning names where it fails."""

import itertools

import numpy as np
import pytest
from cases.mechanisms import braced_rectangle

import flexmb as fm
from flexmb import planar, spatial
from flexmb.checks.releases import Release
from flexmb.mechanics import deformation

# Along edges of the unit cube, and at each corner the hinge is across both links.
CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 0, 1), (1, 1, 1), (0, 1, 1), (0, 1, 0)], float)
AXES = np.cross(CORNERS - np.roll(CORNERS, 1, 0), np.roll(CORNERS, -1, 0) - CORNERS)


def bricard() -> fm.Builder:
    """Bricard's orthogonal loop: six links of 1 m, the sixth of which is the ground."""
    b = fm.Builder()
    for i, corner in enumerate(CORNERS):
        b.node(f"p{i}", corner)
        b.rotation(f"r{i}")
    for i in range(5):
        b.add(spatial.rigid_beam, f"p{i}", f"r{i + 1}", f"p{i + 1}", name=f"link {i + 1}")
    for i in range(6):
        b.add(spatial.hinge, f"r{i}", f"r{(i + 1) % 6}", name=f"hinge {i}", axis=AXES[i])
    b.fix("r0")
    b.fix("p0")
    b.fix("p5")
    return b


def scott_russell(angle: float = 0.9) -> fm.Builder:
    """A bar of 2 m whose middle is on a crank; either slider at its ends is one too many."""
    b = fm.Builder()
    c, s = np.cos(angle), np.sin(angle)
    for name, place in {"O": (0, 0), "M": (c, s), "A": (2 * c, 0), "B": (0, 2 * s)}.items():
        b.node(name, place)
    b.rotation("bar")
    b.add(planar.rigid_beam, "M", "bar", "A")
    b.add(planar.rigid_beam, "M", "bar", "B")
    b.add(planar.truss, "O", "M", name="crank", released=())
    b.fix("O")
    b.fix("A", "y")
    b.fix("B", "x")
    return b


def parallelogram() -> fm.Builder:
    """A coupler on three parallel bars, the third of which is redundant."""
    b = fm.Builder()
    for i, name in enumerate("abc"):
        b.node(f"{name}0", (i, 0))
        b.node(name, (i + 0.6, 0.8))
        b.add(planar.truss, f"{name}0", name, name=f"bar {name}", released=())
        b.fix(f"{name}0")
    b.rotation("coupler")
    b.add(planar.rigid_beam, "a", "coupler", "b")
    b.add(planar.rigid_beam, "b", "coupler", "c")
    return b


def candidates(b: fm.Builder) -> tuple[Release, ...]:
    found = fm.mobility(b.build(check=False))
    assert found.overconstraints == 1
    assert found.release == (found.candidates[0][0][:2],)
    return found.candidates[0]


def built(b: fm.Builder, release: Release, **how) -> fm.Model:
    """The mechanism after the call that the report names, typed as it stands there."""
    call = str(release).split(" (loses")[0]
    exec(f"b.{call}", {"b": b})
    return b.build(**how)


@pytest.mark.slow
def test_every_proposal_for_bricards_loop_builds_and_the_first_turns():
    found = candidates(bricard())
    hinges = {(f"hinge {i}", number) for i in range(6) for number in (2, 3)}
    assert hinges < {one[:2] for one in found}
    # By eight digits, since round-off decides between equals.
    assert np.all(np.diff([one.part for one in found]) < 1e-8)
    # What fails comes last.
    assert [bool(one.fails) for one in found] == sorted(one.part == 0 for one in found)
    for one in found:
        assert built(bricard(), one).topology.n_q == 1
    model = built(bricard(), found[0], dofs=["hinge 1.e1"])
    ways = np.linspace(-np.pi, 0.45, 23)
    tilts = np.array([_tilts(model, way) for way in ways])
    # The self-stress has no sign: it is followed from state to state.
    for before, now in itertools.pairwise(tilts):
        now *= np.sign(now @ before)
    fails = {one[:2]: one.fails for one in found}
    for k, (i, number) in enumerate((i, number) for i in range(6) for number in (2, 3)):
        crossed = np.flatnonzero(tilts[1:, k] * tilts[:-1, k] < 0)
        said = fails[f"hinge {i}", number]
        if crossed.size:
            # By screw theory at a right angle. It is found between two states, 0.2 apart.
            assert abs(float(said.removeprefix("hinge 1.e1 = ")) + np.pi / 2) < 0.05
        elif said:
            # The angle turns back at 30 degrees, where the others vanish.
            assert abs(float(said.removeprefix("hinge 1.e1 = ")) - np.pi / 6) < 0.05
            assert abs(tilts[-1, k]) < 0.5 * np.min(np.abs(tilts[:5, k]))
        else:
            assert np.min(np.abs(tilts[:, k])) > 0.3


def _tilts(model: fm.Model, angle: float) -> np.ndarray:
    """Virtual work of the loop's self-stress in the tilts of its hinges: the wrench reciprocal to their six screws."""
    state = fm.configuration(model, [angle])
    screws, tilts = [], []
    for i, axis in enumerate(AXES):
        turn = np.asarray(fm.rotations.to_matrix(state.at(f"r{i}")))
        y = np.eye(3)[np.argmin(np.abs(axis))]
        for own, into in ((axis, screws), (y, tilts), (np.cross(axis, y), tilts)):
            into.append([*np.cross(state.position(f"p{i}"), turn @ own), *(turn @ own)])
    _, sizes, wrenches = np.linalg.svd(screws)
    # Round-off of six screws of order one.
    assert sizes[-1] < 1e-12
    return np.array(tilts) @ wrenches[-1]


def test_auto_releases_a_hinge_of_bricards_loop():
    model = bricard().build(release="auto")
    assert model.topology.n_q == 1


@pytest.mark.slow
def test_supports_of_a_scott_russell_linkage():
    """The crank pushes the bar along itself, and a slider bears it across its way: cosine and sine of its angle."""
    found = {one[:2]: one for one in candidates(scott_russell())}
    assert list(found) == [("O", "y"), ("A", "y"), ("O", "x"), ("B", "x")]
    for (_, component), one in found.items():
        # Upright the crank has no cosine, flat no sine; the bar turns against the crank.
        expected = {"x": 0.9 - np.pi / 2, "y": 0.9}[component]
        assert abs(float(one.fails.removeprefix("bar.phi = ")) - expected) < 0.01
        assert built(scott_russell(), one).topology.n_q == 1
    model = built(scott_russell(), found["B", "x"], dofs=["A.x"])
    state = fm.configuration(model, [0.3])
    x = 2 * np.cos(0.9) + 0.3
    # Newton's method ends at 1e-10.
    np.testing.assert_allclose(state.position("B"), [0, np.sqrt(4 - x**2)], atol=1e-9)
    with pytest.warns(fm.FlexmbWarning, match=r"coordinate y of node 'O'\. This release loses rank near bar\.phi"):
        scott_russell().build(release="auto")


@pytest.mark.parametrize("many", [600, 0], ids=["dense", "sparse"])
def test_supports_of_a_redundant_bar(many, monkeypatch):
    """The middle bar bears as much as both others, by 0.8 along y; none has y where it is flat, nor x upright."""
    monkeypatch.setattr(deformation, "MANY", many)
    found = candidates(parallelogram())
    assert [one[:2] for one in found] == [("b0", "y"), ("b0", "x"), *((f"{n}0", c) for c in "yx" for n in "ac")]
    for one in found:
        # All three bars have the same y: round-off decides whose y is named.
        name, value = one.fails.split(" = ")
        assert name in ("a.y", "b.y", "c.y")
        assert abs(float(value) - {"y": 0.0, "x": 1.0}[str(one.component)]) < 0.02
        assert built(parallelogram(), one).topology.n_q == 1


def test_a_support_that_a_signal_needs_is_not_proposed():
    b = scott_russell()
    b.output("B", "x", quantity="reaction")
    assert ("B", "x") not in {one[:2] for one in candidates(b)}


def test_a_flexible_loop_beside_a_rigid_one():
    """Each over-constraint has its own advice, and the beams do not keep the linkage from moving."""
    b = scott_russell()
    for i in range(3):
        b.node(f"n{i}", (i, 3))
    for i in range(2):
        section = fm.Rigidity(EA=1.0, EIy=1.0)
        b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"beam {i}", section=section, released=(2, 3))
    b.fix("n0")
    b.fix("n2")
    first, second = fm.mobility(b.build(check=False)).candidates
    assert [one[:2] for one in first] == [("beam 0", 1), ("beam 1", 1)]
    assert {one[:2] for one in second} == {("O", "y"), ("A", "y"), ("O", "x"), ("B", "x")}
    assert all(one.fails for one in second)


@pytest.mark.parametrize("component", ["rx", "ry", "rz"])
def test_a_support_is_released_about_one_axis(component):
    b = fm.Builder()
    b.node("A", (0, 0, 0))
    b.node("B", (1, 0, 0))
    b.add(spatial.rigid_beam, "A", "B", name="B")
    b.fix("A")
    b.release("A", component)
    model = b.build()
    motion = fm.mobility(b.build(dofs="named", check=False)).motion
    assert (model.topology.n_q, motion.shape[1]) == (1, 1)
    axis = "xyz".index(component[1])
    own = model.labels.coordinates("A.rotation")
    np.testing.assert_allclose(np.abs(motion[own]).ravel() > 1e-9, [i == axis + 1 for i in range(4)])


def test_rigid_elements_alone_are_refused_by_name():
    with pytest.raises(fm.MechanismError, match="Rigid elements alone are over-constrained"):
        braced_rectangle().build(release="auto")


def test_calls_of_releases():
    assert str(Release("hinge 1", 2, 0.5)) == "release('hinge 1', 2)"
    assert str(Release("B", "x", 0.5, shared=True)) == "release('B', 'x', kind='node')"
    assert str(Release("3", 2, 0.5)) == "RLSE 3 2"
    assert str(Release("3", "y", 0.5, "4.x = 1")) == "FIX 3 without coordinate 2 (loses rank near 4.x = 1)"
