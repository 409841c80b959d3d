"""Laws that every element type must obey; the types are found by walking the modules, their arguments by signature.

What a law needs of an element (its deformations, the companions, and the derivatives of all of them by coordinates,
reference coordinates and properties) is compiled once for each type, since that is most of the time these tests take.
Derivatives are asked for in directions, a few at once: a whole Jacobian of some hundred answers by some sixty numbers
takes as long as all else, and a direction that is drawn meets every entry of it.
"""

import dataclasses
import functools
import types
import typing

import hypothesis
import hypothesis.extra.numpy as npst
import hypothesis.strategies as st
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from cases.tolerances import approx
from hypothesis import given
from jax.flatten_util import ravel_pytree
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import flexmb as fm
from flexmb import planar, spatial
from flexmb.build.assemble import UNIT_NORM
from flexmb.elements.element import COMPANIONS, Element

EPS = np.finfo(float).eps


def characteristic(e, ed, *, k, c):
    """Law of the springs that ask for one."""
    return k * e + k * e**3 + c * jnp.tanh(ed) + e**2 * ed


def found_in(module: types.ModuleType) -> dict[str, Element]:
    """Element types of a module, each once under its first name."""
    room, found = module.__name__.rpartition(".")[2], {}
    for name, element in vars(module).items():
        if isinstance(element, Element) and all(element is not other for other in found.values()):
            found[f"{room}.{name}"] = element
    return found


ELEMENTS = {**found_in(planar), **found_in(spatial), "unit_norm": UNIT_NORM}
BEAMLIKE = {name: element for name, element in ELEMENTS.items() if element.resultants is not None}
MASSIVE = {name: element for name, element in ELEMENTS.items() if element.inertia is not None}
# An energy of third order stands beside a quadratic one, and is not positive alone.
POTENTIAL = {
    name: element
    for name, element in ELEMENTS.items()
    if (element.energy or element.dissipation) and not element.third_order
}
# Drag is relative to the ground.
FLOATING = {name: element for name, element in ELEMENTS.items() if not element.grounded}
every_element = pytest.mark.parametrize("element", ELEMENTS.values(), ids=ELEMENTS)
every_massive_element = pytest.mark.parametrize("element", MASSIVE.values(), ids=MASSIVE)

every_beam = pytest.mark.parametrize("element", BEAMLIKE.values(), ids=BEAMLIKE)


# -- what is drawn ------------------------------------------------------------------------------------------------

NUMBER = st.floats(-1, 1).map(lambda x: round(x, 3))
POSITIVE = st.floats(0.1, 10).map(lambda x: round(x, 3))


def vectors(size: int, bound: float = 1.0):
    return npst.arrays(float, size, elements=NUMBER).map(lambda v: bound * v)


@st.composite
def rigidities(draw):
    # Of a real section: Jx = Jy + Jz, and Jyz^2 < Jy Jz.
    jy, jz, share = draw(POSITIVE), draw(POSITIVE), draw(NUMBER)
    names = ("EA", "EIy", "EIz", "GIt", "shear_z", "shear_y", "mass", "EIw", "Jw")
    numbers = {name: draw(POSITIVE) for name in names}
    return fm.Rigidity(**numbers, Jx=jy + jz, Jy=jy, Jz=jz, Jyz=0.9 * share * np.sqrt(jy * jz))


def rectangles():
    """Of leaf springs."""
    steel = fm.Material(E=3.0, G=1.2, rho=2.0, alpha=0.1)
    return st.builds(lambda w, t: fm.Rectangle(0.1 + w / 25, 0.05 + t / 200, steel), POSITIVE, POSITIVE)


def dampings():
    return st.builds(fm.Damping, EA=POSITIVE, EIy=POSITIVE, EIz=POSITIVE, GIt=POSITIVE)


# Of arcs between ends up to 4 apart. That of no curvature is a straight beam, whose function is another.
CURVATURE = st.floats(0.05, 0.4).map(lambda x: round(x, 3))


def curvatures():
    return st.builds(lambda size, angle: size * np.array([0, np.cos(angle), np.sin(angle)]), CURVATURE, st.floats(0, 6))


@st.composite
def inertia_tensors(draw):
    # J = tr(P) I - P of a body with second moments P.
    second = np.eye(3) + (half := draw(vectors(9)).reshape(3, 3)) @ half.T
    return (np.trace(second) * np.eye(3) - second)[np.triu_indices(3)]


def dimension_of(hint) -> int:
    return int(hint.dim_str)


# By name of the property; two share a name where the annotation tells them apart.
PROPERTIES = {
    "section": lambda hint: rectangles() if fm.Rectangle in typing.get_args(hint) else rigidities(),
    "clamped": lambda hint: st.sampled_from([np.array([1.0, 0.0]), np.ones(2)]),
    "damping": lambda hint: POSITIVE if hint is float else dampings(),
    "stiffness": lambda hint: POSITIVE,
    "mass": lambda hint: POSITIVE,
    "inertia": lambda hint: POSITIVE if hint is float else inertia_tensors(),
    "center": lambda hint: vectors(dimension_of(hint)),
    "moment": lambda hint: vectors(3),
    "force": lambda hint: vectors(dimension_of(hint)),
    "axis": lambda hint: vectors(dimension_of(hint)),
    "axis_p": lambda hint: vectors(3),
    "axis_q": lambda hint: vectors(3),
    "ratio": lambda hint: st.builds(lambda size, sign: sign * size, POSITIVE, st.sampled_from([1, -1])),
    "pitch": lambda hint: NUMBER,
    "radius_p": lambda hint: NUMBER.map(lambda x: x / 2),
    "radius_q": lambda hint: NUMBER.map(lambda x: x / 2),
    "alpha": lambda hint: NUMBER,
    "k": lambda hint: POSITIVE,
    "c": lambda hint: POSITIVE,
    "y": lambda hint: vectors(3),
    # Skew and elastic ends in space have tests of their own, since they multiply the time that compiling takes.
    "skew": lambda hint: st.none(),
    "clamp": lambda hint: (
        st.tuples(*[npst.arrays(float, 3, elements=POSITIVE)] * 2) if "'3'" in str(hint) else st.none()
    ),
    "curvature": lambda hint: CURVATURE if float in typing.get_args(hint) else curvatures(),
}
# Properties that an element may be without, which then has other code. A leaf spring in space is always drawn with all
# of them: it takes fifteen seconds to compile, and what it is without them it has from the beams.
OPTIONAL = ("y", "curvature", "skew", "clamp")
# Few options, since each is compiled; ``whole`` tells whether an element has all that it may have.
OPTIONS = {
    "second_order": lambda whole: st.just(whole),
    "order": lambda whole: st.just(2),
    "shear": lambda whole: st.just(whole),
    "law": lambda whole: st.just(characteristic),
}


def hints_of(element: Element) -> dict[str, typing.Any]:
    hints = {}
    for function in (element.deformation, *(getattr(element, name) for name in COMPANIONS)):
        if function is not None:
            hints |= {k: v for k, v in typing.get_type_hints(function).items() if k in element.properties}
    return hints


class Drawn(typing.NamedTuple):
    """An element with its options, where it is (x) and was undeformed (ref), node by node, and its properties."""

    element: Element
    x: list[np.ndarray]
    ref: list[np.ndarray]
    properties: dict


def quaternion(turn: np.ndarray) -> np.ndarray:
    """Euler parameters of a rotation whose vector part goes with ``turn``; zero for the unturned one."""
    return np.r_[1.0, turn] / np.sqrt(1 + turn @ turn)


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.r_[a[0] * b[0] - a[1:] @ b[1:], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:])]


def apart(element: Element, parts: list[np.ndarray]) -> np.ndarray:
    """From an element's first point to its last."""
    points = [part for kind, part in zip(element.nodes.values(), parts, strict=True) if kind.part == "position"]
    return points[-1] - points[0]


@st.composite
def drawn(draw, element: Element) -> Drawn:
    optional = {"second_order", "shear", *OPTIONAL} & {*element.option_names, *element.properties}
    whole = bool(optional) and (element is spatial.leaf_spring or draw(st.booleans()))
    for name in element.option_names:
        if name not in OPTIONS:
            pytest.fail(f"Option '{name}' of element '{element.name}' is new: add to OPTIONS how to draw it.")
        element = element(**{name: draw(OPTIONS[name](whole))})
    dimension = max(kind.dimension for kind in element.nodes.values())
    axis = draw(st.integers(0, dimension - 1))
    turned = draw(st.booleans())  # False: every rotation and every change zero, where a branch could have a kink
    x, ref = [], []
    for i, kind in enumerate(element.nodes.values()):
        by = draw(vectors(3, 0.5)) if turned else np.zeros(3)
        if kind.part == "position":
            # Ends between 1 and 3 apart, in every direction: differences then have derivatives of order one.
            start = draw(vectors(dimension, 0.5)) + 2 * i * (np.arange(dimension) == axis)
            now = start + 0.6 * by[:dimension]
        elif kind.part in ("internal", "warping"):
            start = np.zeros(kind.size)
            now = draw(vectors(kind.size, 0.3)) if turned else start
        elif dimension == 2:
            start = draw(vectors(1, 3.0)) if turned else np.zeros(1)
            now = start + 2 * by[:1]
        else:
            start = quaternion(draw(vectors(3, 2.0)) if turned else np.zeros(3))
            now = product(quaternion(by), start)
        ref.append(start)
        x.append(now)
    hints, numbers = hints_of(element), {}
    for name in element.properties:
        if name not in PROPERTIES:
            pytest.fail(f"Property '{name}' of element '{element.name}' is new: add to PROPERTIES how to draw it.")
        there = name not in OPTIONAL or whole
        value = draw(PROPERTIES[name](hints.get(name))) if there else None
        if name == "section" and element.inertia is None:
            value = dataclasses.replace(value, mass=0.0)
        if isinstance(value, fm.Rigidity) and not element.options.get("shear", True):
            value = dataclasses.replace(value, shear_y=0.0, shear_z=0.0)
        numbers[name] = jax.tree.map(lambda leaf: np.asarray(leaf, float), value)
    sample = Drawn(element, x, ref, numbers)
    if element.check is not None:
        faults = element.check(
            ref=element.reference(ref), **(element.arguments(element.check, sample.properties) or {})
        )
        hypothesis.assume(not faults)
    if numbers.get("y") is not None:
        along = apart(element, ref)
        sine = np.linalg.norm(np.cross(along, numbers["y"])) / np.linalg.norm(along)
        hypothesis.assume(sine > 0.1)  # or its derivatives by y and ref are large
    for axis in (numbers[name] for name in ("axis", "axis_p", "axis_q") if name in numbers):
        size = np.sort(np.abs(axis))
        # No derivative where two components are smallest: the second axis is chosen by that.
        hypothesis.assume(size[-1] > 0.1 and (size.size == 2 or size[1] - size[0] > 0.01))
    if "y" in numbers and numbers["y"] is None:
        size = np.sort(np.abs(apart(element, ref)))
        hypothesis.assume(size[1] - size[0] > 0.01)
    return sample


# -- what is measured ---------------------------------------------------------------------------------------------


def some_stress(n_e: int) -> np.ndarray:
    """Stress resultants of order one, no two alike."""
    return np.cos(1.0 + np.arange(n_e))


def answers(element: Element, x, ref, properties) -> dict:
    """Deformations and all companions of an element."""
    where = element.reference(ref)

    def chosen(companion) -> dict[str, typing.Any]:
        return element.arguments(companion, properties) or {}

    near = {"near": jnp.zeros(6)} if element.tracks_angle else {}
    e = element.deformation(*x, ref=where, **chosen(element.deformation), **near)
    ed = jnp.cos(1 + jnp.arange(e.shape[0]))  # any rates
    found = {"e": e}
    for name, arguments in (("energy", (e,)), ("dissipation", (e, ed)), ("law", (e, ed))):
        companion = getattr(element, name)
        if companion is not None:
            found[name] = companion(*arguments, ref=where, **chosen(companion))
    for name in ("stiffness", "damping"):
        companion = getattr(element, name)
        if companion is not None:
            found[name] = companion(ref=where, **chosen(companion))
    if element.inertia is not None:
        found["vectors"], found["H"] = element.inertia(*x, ref=where, **chosen(element.inertia))
    if element.force is not None:
        found["force"] = element.force(*x, ref=where, **chosen(element.force))
    if element.resultants is not None:
        sigma, own = some_stress(found["e"].shape[0]), chosen(element.resultants)

        def section(place):
            return element.resultants(*x, ref=where, place=place, sigma=sigma, **own)

        found["sections"] = jax.vmap(section)(jnp.array([0.0, 0.3, 1.0]))
    return found


DIRECTIONS = 4  # at once


@functools.cache
def _compiled(element, structure, shapes):
    """Functions of one flat vector of coordinates, reference coordinates and properties."""
    example = jax.tree.unflatten(structure, [np.zeros(shape) for shape in shapes])
    _, unravel = ravel_pytree(example)

    def whole(point):
        x, ref, own = unravel(point)
        return answers(element, x, ref, own)

    def flat(point):
        return ravel_pytree(whole(point))[0]

    def both(point):
        """All answers, and the derivatives of their product with a vector."""
        value, pull = jax.vjp(flat, point)
        return value, pull(weights(value.size))[0]

    def slopes(points, directions):
        """Both at each point, and their derivatives in its direction."""
        return jax.vmap(lambda point, along: jax.jvp(both, (point,), (along,)))(points, directions)

    return fm.jit(slopes), jax.eval_shape(whole, ravel_pytree(example)[0])


def weights(n: int) -> np.ndarray:
    """Numbers of order one that no answer's symmetry matches."""
    return np.cos(2.0 + 1.7 * np.arange(n))


class Measured:
    """Answers of an element by name, and their derivatives in directions."""

    def __init__(self, sample: Drawn):
        tree = (sample.x, sample.ref, sample.properties)
        leaves, structure = jax.tree.flatten(tree)
        self.slopes, shapes = _compiled(sample.element, structure, tuple(np.shape(leaf) for leaf in leaves))
        self.point = np.asarray(ravel_pytree(tree)[0])
        self.n_x = sum(part.size for part in sample.x)
        self.slices, start = {}, 0
        for name in sorted(shapes):  # as ravel_pytree orders a dict
            size = int(np.prod(shapes[name].shape))
            self.slices[name] = slice(start, start + size), shapes[name].shape
            start += size

    def along(self, directions: np.ndarray, away: float = 0.0):
        """Values and gradients at the point, or away from it, and their derivatives in directions, row by row."""
        found = self.slopes(self.point + away * directions, directions)
        return jax.tree.map(np.asarray, found)

    @functools.cached_property
    def value(self) -> np.ndarray:
        return self.along(np.zeros((DIRECTIONS, self.point.size)))[0][0][0]

    def __getitem__(self, name: str) -> np.ndarray:
        rows, shape = self.slices[name]
        return self.value[rows].reshape(shape)

    def rates(self, name: str, rates: np.ndarray) -> np.ndarray:
        """Rates of an answer at rates of the coordinates, each row of them, (rows, ..)."""
        rows, shape = self.slices[name]
        directions = np.zeros((-(-len(rates) // DIRECTIONS) * DIRECTIONS, self.point.size))
        directions[: len(rates), : self.n_x] = rates
        found = [self.along(some)[1][0] for some in directions.reshape(-1, DIRECTIONS, self.point.size)]
        return np.concatenate(found)[: len(rates), rows].reshape(-1, *shape)

    def mass(self) -> np.ndarray:
        j = self.rates("vectors", np.eye(self.n_x))
        return np.einsum("cak,ab,dbk->cd", j, self["H"], j)


def moved(sample: Drawn, turn: np.ndarray, shift: np.ndarray) -> Drawn:
    """The same after a rigid motion of the whole: positions turned and shifted, rotations turned."""
    planar_angle, lam = turn[0], quaternion(turn)
    matrix = Rotation.from_quat(lam, scalar_first=True).as_matrix()
    c, s = np.cos(planar_angle), np.sin(planar_angle)
    x = []
    for kind, part in zip(sample.element.nodes.values(), sample.x, strict=True):
        if kind.part == "position":
            rotation = np.array([[c, -s], [s, c]]) if kind.dimension == 2 else matrix
            x.append(rotation @ part + shift[: kind.dimension])
        elif kind.part in ("internal", "warping"):
            x.append(part)
        else:
            x.append(part + planar_angle if kind.dimension == 2 else product(lam, part))
    return sample._replace(x=x)


def rigid_velocity(sample: Drawn, velocity: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Rates of the coordinates in a rigid motion: velocity of the first node, and angular velocity."""
    rates = []
    for kind, part in zip(sample.element.nodes.values(), sample.x, strict=True):
        if kind.part == "position":
            arm = np.zeros(3)
            arm[: kind.dimension] = part - sample.x[0]
            rates.append((velocity + np.cross(omega, arm))[: kind.dimension])
        elif kind.part in ("internal", "warping"):
            rates.append(np.zeros(part.size))
        elif kind.dimension == 2:
            rates.append(omega[2:])
        else:
            rates.append(product(np.r_[0.0, omega], part) / 2)
    return np.concatenate(rates)


def turned_rates(sample: Drawn, rates: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Rates of the coordinates as a rotation of the whole carries them along; that of an angle stays."""
    ends = np.cumsum([part.size for part in sample.x])[:-1]
    at_origin = [np.zeros_like(part) for part in sample.x]
    change = [
        a - b
        for a, b in zip(
            moved(sample._replace(x=np.split(rates, ends)), turn, np.zeros(3)).x,
            moved(sample._replace(x=at_origin), turn, np.zeros(3)).x,
            strict=True,
        )
    ]
    return np.concatenate(change)


def energy(sample: Drawn, rates: np.ndarray) -> float:
    measured = Measured(sample)
    found = measured.rates("vectors", rates[None])[0]
    return float(0.5 * np.einsum("ak,ab,bk->", found, measured["H"], found))


def length(sample: Drawn) -> float:
    ends = [r for kind, r in zip(sample.element.nodes.values(), sample.ref, strict=True) if kind.part == "position"]
    return float(np.linalg.norm(ends[-1] - ends[0]))


# -- laws of every element ----------------------------------------------------------------------------------------


def test_elements_are_found():
    # The walk itself: an empty one would let every law pass.
    wanted = {"planar.beam", "planar.hinge", "spatial.beam", "spatial.hinge", "spatial.moment"}
    springs = {f"{room}.{name}" for room in ("planar", "spatial") for name in ("spring_damper", "rotary_spring_damper")}
    assert wanted | springs | {"planar.spectral_beam", "spatial.spectral_beam"} <= set(ELEMENTS)


@pytest.mark.slow
@every_element
@given(st.data())
def test_deformations_are_zero_at_the_reference(element, data):
    sample = data.draw(drawn(element))
    # Coordinates up to 4, some ten rounded products.
    np.testing.assert_allclose(Measured(sample._replace(x=sample.ref))["e"], 0, atol=50 * EPS)


@pytest.mark.slow(
    "planar.beam",
    "planar.spectral_beam",
    "planar.leaf_spring",
    "planar.belt",
    "spatial.beam",
    "spatial.warping_beam",
    "spatial.spectral_beam",
    "spatial.leaf_spring",
    "spatial.rigid_beam",
    "spatial.rigid_body",
    "spatial.hinge",
    "spatial.prismatic",
    "spatial.screw",
    "spatial.gear",
    "spatial.rotary_spring_damper",
)
@pytest.mark.parametrize("element", FLOATING.values(), ids=FLOATING)
@given(st.data())
def test_rigid_motion_changes_no_deformation(element, data):
    sample = data.draw(drawn(element))
    there = moved(sample, data.draw(vectors(3, 2.0)), data.draw(vectors(3, 5.0)))
    # Positions up to 10, rounded, times the triads; the second-order terms multiply by e/l0 < 4.
    np.testing.assert_allclose(Measured(there)["e"], Measured(sample)["e"], rtol=0, atol=1000 * EPS)


CHECKED = {name: element for name, element in ELEMENTS.items() if element.check is not None}


@pytest.mark.slow
@pytest.mark.parametrize("element", CHECKED.values(), ids=CHECKED)
@given(st.data())
def test_many_have_a_fault_where_one_of_them_has(element, data):
    sample = data.draw(drawn(element))
    element = sample.element
    wanted = element.wanted(element.check)
    whole = (sample.ref, {name: value for name, value in sample.properties.items() if name in wanted})
    leaves, structure = jax.tree.flatten(whole)
    # One part of it vanishes or changes its sign, or all vanish.
    which, factor = data.draw(st.integers(0, len(leaves))), data.draw(st.sampled_from([0.0, -1.0]))
    spoiled = [leaf * factor if i == which else leaf for i, leaf in enumerate(leaves)]
    if which == len(leaves):
        spoiled = [leaf * 0 for leaf in leaves]

    def faults(parts):
        ref, own = jax.tree.unflatten(structure, parts)
        return element.check(ref=element.reference(ref), **element.arguments(element.check, own))

    alone = faults(spoiled)
    for pair in ((leaves, spoiled), (spoiled, leaves)):
        # Two designs of one element each.
        many = [np.stack([one, other])[:, None] for one, other in zip(*pair, strict=True)]
        assert bool(faults(many)) == bool(alone)


@pytest.mark.slow
@every_beam
@given(st.data())
def test_rigid_motion_changes_no_section_resultants(element, data):
    sample = data.draw(drawn(element))
    there = moved(sample, data.draw(vectors(3, 2.0)), data.draw(vectors(3, 5.0)))
    # As for the deformations, whose derivatives multiply the stress resultants here.
    np.testing.assert_allclose(Measured(there)["sections"], Measured(sample)["sections"], rtol=0, atol=2000 * EPS)


# Of a series this holds where its closure is zero: tests/linear/test_stress.py.
CLOSED = {name: element for name, element in BEAMLIKE.items() if not element.fields}


@pytest.mark.slow
@pytest.mark.parametrize("element", CLOSED.values(), ids=CLOSED)
@given(st.data())
def test_power_of_the_end_sections_is_that_of_the_stress(element, data):
    """sigma . e_dot is what the rest of the mechanism does on both end sections, for any velocities of the ends."""
    sample = data.draw(drawn(element))
    measured = Measured(sample)
    velocities, spins = data.draw(vectors(6)).reshape(2, 3), data.draw(vectors(6)).reshape(2, 3)
    in_plane = next(iter(element.nodes.values())).dimension == 2
    if in_plane:
        velocities[:, 2], spins[:, :2] = 0, 0
    rates, wrenches, seen = [], [], 0
    for kind, part in zip(element.nodes.values(), sample.x, strict=True):
        if kind.part == "position":
            rates.append(velocities[seen][: kind.dimension])
            seen += 1
        elif kind.part == "warping":
            # Bimoments, which are no resultants, do work on it.
            rates.append(np.zeros(part.size))
        else:
            omega = spins[seen - 1]
            rates.append(omega[2:] if in_plane else product(np.r_[0.0, omega], part) / 2)
    ends = [
        (np.r_[part, 0.0] if in_plane else part)
        for kind, part in zip(element.nodes.values(), sample.x, strict=True)
        if kind.part == "position"
    ]
    for i, section in enumerate((measured["sections"][0], measured["sections"][2])):
        axes = section_axes(sample, i, ends)
        wrenches.append((axes @ section[:3], axes @ section[3:]))
    (n0, m0), (n1, m1) = wrenches
    power = n1 @ velocities[1] - n0 @ velocities[0] + m1 @ spins[1] - m0 @ spins[0]
    expected = some_stress(measured["e"].size) @ measured.rates("e", np.concatenate(rates)[None])[0]
    assert power == approx(float(expected), rel=1e-12, abs=1e-12)


def section_axes(sample: Drawn, end: int, ends: list[np.ndarray]) -> np.ndarray:
    """Axes of the end section as columns, in space: a bar's along the bar, a beam's as its node has turned them."""
    names = list(sample.element.nodes)
    in_plane = len(sample.x[0]) == 2
    if "rot_p" not in names:
        return local_frame(ends[1] - ends[0], None)
    start, along = sample.ref[names.index(("rot_p", "rot_q")[end])], apart(sample.element, sample.ref)
    now = sample.x[names.index(("rot_p", "rot_q")[end])]
    if in_plane:
        # Local y into the plane: z is the normal to the left.
        frame = local_frame(np.r_[along, 0.0], np.array([0, 0, -1.0]))
        return Rotation.from_rotvec([0, 0, (now - start)[0]]).as_matrix() @ frame
    return homogeneous_matrix(now) @ homogeneous_matrix(start).T @ local_frame(along, sample.properties["y"])


@pytest.mark.slow
@every_massive_element
@given(st.data())
def test_rigid_motion_changes_no_kinetic_energy(element, data):
    sample = data.draw(drawn(element))
    turn, rates = data.draw(vectors(3, 2.0)), data.draw(vectors(Measured(sample).n_x))
    there = moved(sample, turn, data.draw(vectors(3, 5.0)))
    # Round-off of the energy, which cancels from terms of size mass times rates squared, below 100.
    assert energy(there, turned_rates(sample, rates, turn)) == approx(energy(sample, rates), rel=1e-12, abs=1e-12)


@st.composite
def directions(draw, n: int) -> np.ndarray:
    """Directions of unit length, every number in them."""
    found = np.random.default_rng(draw(st.integers(0, 99))).standard_normal((DIRECTIONS, n))
    return found / np.linalg.norm(found, axis=1, keepdims=True)


@pytest.mark.slow
@every_element
@given(st.data())
def test_forward_reverse_and_central_differences_agree(element, data):
    measured = Measured(data.draw(drawn(element)))
    along = data.draw(directions(measured.point.size))
    (value, reverse), (forward, second) = measured.along(along)
    for found in (reverse, forward, second):
        assert np.all(np.isfinite(found))
    scale = 1 + np.abs(value) + np.abs(forward)
    # The same numbers summed in another order.
    size = np.max(np.sum(scale, axis=1)) + np.max(np.sum(np.abs(reverse), axis=1))
    assert np.max(np.abs(forward @ weights(value.shape[1]) - along @ reverse[0])) < 1000 * EPS * size
    step = EPS ** (1 / 3)

    def difference(step):
        plus, minus = (measured.along(along, sign * step)[0][0] for sign in (1, -1))
        return (plus - minus) / (2 * step)

    # Two steps leave a truncation of step^4/30 times the fifth derivative; round-off 3 eps/step = 1e-10.
    extrapolated = (4 * difference(step) - difference(2 * step)) / 3
    assert np.max(np.abs(extrapolated - forward) / scale, initial=0) < 1e-8
    # Second derivatives are symmetric.
    product = second @ along.T
    np.testing.assert_allclose(product, product.T, rtol=0, atol=1000 * EPS * (1 + np.max(np.abs(second), initial=0)))


@pytest.mark.slow
@every_element
@given(st.data())
def test_an_element_is_the_same_beside_others(element, data):
    measured = Measured(data.draw(drawn(element)))
    along = 0.01 * data.draw(directions(measured.point.size))
    together = measured.along(along, 1.0)[0][0]
    for i in range(DIRECTIONS):
        alone = measured.along(np.tile(along[i], (DIRECTIONS, 1)), 1.0)[0][0]
        # The compiler may contract and order differently.
        np.testing.assert_allclose(together[i], alone[0], rtol=1000 * EPS, atol=1000 * EPS)


@pytest.mark.slow
@every_element
@given(st.data())
def test_stiffness_damping_and_mass_are_symmetric_and_semidefinite(element, data):
    measured = Measured(data.draw(drawn(element)))
    found = {name: measured[name] for name in ("stiffness", "damping") if name in measured.slices}
    if "H" in measured.slices:
        found["mass"] = measured.mass()
    for name, matrix in found.items():
        size = np.max(np.abs(matrix))
        assert size > 0, name
        np.testing.assert_allclose(matrix, matrix.T, rtol=0, atol=10 * EPS * size, err_msg=name)
        # Round-off of the eigenvalues: a few eps times the size of the matrix.
        assert np.linalg.eigvalsh((matrix + matrix.T) / 2)[0] > -100 * EPS * size, name


@functools.cache
def _potentials(element: Element):
    """Energy and dissipation with their first and second derivatives, at given deformations and at given rates."""

    def both(e, ed, ref, properties):
        where = {"ref": element.reference(ref)}
        companions = (element.energy, element.dissipation)
        energy, dissipation = (where | (element.arguments(companion, properties) or {}) for companion in companions)
        return (
            found
            for function, at in (
                (lambda e: element.energy(e, **energy), e),
                (lambda ed: element.dissipation(e, ed, **dissipation), ed),
            )
            for found in (function(at), jax.grad(function)(at), jax.hessian(function)(at))
        )

    return fm.jit(lambda *arguments: tuple(both(*arguments)))


@pytest.mark.slow
@pytest.mark.parametrize("element", POTENTIAL.values(), ids=POTENTIAL)
@given(st.data())
def test_energy_and_dissipation_are_least_at_rest(element, data):
    """Neither is negative; without deformation, or at rest, both vanish with their stress, and are convex."""
    sample = data.draw(drawn(element))
    e = Measured(sample)["e"]
    ed, none = data.draw(vectors(e.size)), np.zeros(e.size)
    moving = _potentials(element)(e, ed, sample.ref, sample.properties)
    at_rest = _potentials(element)(none, none, sample.ref, sample.properties)
    for k in (0, 3):
        assert moving[k] >= 0
        value, stress, stiffness = map(np.asarray, at_rest[k : k + 3])
        assert value == 0
        assert not np.any(stress)
        assert np.max(np.abs(stiffness)) > 0
        assert np.linalg.eigvalsh(stiffness)[0] >= -100 * EPS * np.max(np.abs(stiffness))


def straight(sample):
    """The same element without initial curvature, whose mass lies on the line between its nodes."""
    curved = "curvature" in sample.properties
    return sample._replace(properties=sample.properties | {"curvature": None}) if curved else sample


@pytest.mark.slow
@every_massive_element
@given(st.data())
def test_energy_of_a_translation_is_that_of_the_whole_mass(element, data):
    sample = straight(data.draw(drawn(element)))
    velocity = data.draw(vectors(3))
    has_position = any(kind.part == "position" for kind in element.nodes.values())
    axes = 2 if any(kind.dimension == 2 for kind in element.nodes.values()) else 3
    own, mass = sample.properties, 0.0
    if has_position:
        mass = own["section"].rigidity().mass * length(sample) if "section" in own else own["mass"]
    expected = 0.5 * mass * velocity[:axes] @ velocity[:axes]
    found = energy(sample, rigid_velocity(sample, velocity, np.zeros(3)))
    assert found == approx(float(expected), rel=1e-13, abs=1e-14)


@pytest.mark.slow
@every_massive_element
@given(st.data())
def test_energy_of_a_rotation_is_that_of_a_rigid_body(element, data):
    """Undeformed and turning about its first node: a line with the rotary inertia of its section, or a body."""
    sample = straight(data.draw(drawn(element)))
    sample = sample._replace(x=sample.ref)
    omega = data.draw(vectors(3))
    if len(sample.x[0]) == 2 or element.nodes[next(iter(element.nodes))].dimension == 2:
        omega[:2] = 0
    tensor = np.zeros((3, 3))
    if "section" in sample.properties:
        s, arm = sample.properties["section"].rigidity(), np.zeros(3)
        start, end = [r for k, r in zip(element.nodes.values(), sample.ref, strict=True) if k.part == "position"]
        arm[: start.size] = end - start
        tensor += s.mass * length(sample) / 3 * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        if element in (planar.beam, planar.spectral_beam, planar.leaf_spring, planar.rigid_beam, planar.rigid_body):
            tensor[2, 2] += s.Jy * length(sample)
        elif element not in (planar.truss, spatial.truss):
            frame = local_frame(arm, sample.properties["y"])
            own = np.diag([float(s.Jx), float(s.Jy), float(s.Jz)])
            own[1, 2] = own[2, 1] = s.Jyz
            tensor += length(sample) * frame @ own @ frame.T
    elif element in (planar.inertia, planar.body):
        tensor[2, 2] = sample.properties["inertia"]
    elif element in (spatial.inertia, spatial.body):
        tensor[np.triu_indices(3)] = sample.properties["inertia"]
        tensor = tensor + np.triu(tensor, 1).T
    if "center" in sample.properties:
        arm = np.zeros(3)
        arm[: sample.ref[0].size] = sample.properties["center"]
        tensor += sample.properties["mass"] * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    found = energy(sample, rigid_velocity(sample, np.zeros(3), omega))
    assert found == approx(0.5 * omega @ tensor @ omega, rel=1e-12, abs=1e-12)


def local_frame(axis: np.ndarray, y: np.ndarray | None) -> np.ndarray:
    """Local x along the axis, y as near as can be to the vector given."""
    ex = axis / np.linalg.norm(axis)
    across = np.eye(3)[np.argmin(np.abs(ex))] if y is None else np.asarray(y)
    ez = np.cross(ex, across)
    ez /= np.linalg.norm(ez)
    return np.stack([ex, np.cross(ez, ex), ez], axis=1)


# -- beams --------------------------------------------------------------------------------------------------------

BEAMS = {"planar": (planar.beam, slice(1, 3)), "y": (spatial.beam, slice(2, 4)), "z": (spatial.beam, slice(4, 6))}


def stiffness_of(element: typing.Any, section: fm.Rigidity, l0: float) -> np.ndarray:
    dimension = next(iter(element.nodes.values())).dimension
    starts = [np.array(kind.start) for kind in element.nodes.values()]
    starts[2] = l0 * np.eye(dimension)[0]
    return np.asarray(element.stiffness(ref=element.reference(starts), section=section))


@pytest.mark.parametrize("plane", BEAMS)
@given(POSITIVE, POSITIVE, POSITIVE, NUMBER, NUMBER)
def test_bending_energy_of_a_linear_curvature(plane, l0, ei, other, a, b):
    """Curvature a + b s/l: end deformations are its moments about the far ends, the energy EI/2 times its square."""
    element, at = BEAMS[plane]
    section = fm.Rigidity(EIy=other, EIz=ei) if plane == "z" else fm.Rigidity(EIy=ei, EIz=other)
    bending = l0**2 * np.array([a / 2 + b / 6, a / 2 + b / 3])
    e = np.zeros(6 if element is spatial.beam else 3)
    e[at] = bending
    expected = 0.5 * ei * l0 * (a**2 + a * b + b**2 / 3)
    assert 0.5 * e @ stiffness_of(element, section, l0) @ e == approx(expected, rel=1e-13, abs=1e-14)


@pytest.mark.parametrize("plane", BEAMS)
@given(POSITIVE, POSITIVE, POSITIVE)
def test_sway_of_a_beam_with_shear(plane, l0, ei, compliance):
    """Ends kept parallel: the compliances of bending and of shear add, l^3/(12 EI) + l/(GAk)."""
    element, at = BEAMS[plane]
    # EI/(GAk) is given, so that 1/(GAk) = compliance/EI.
    names = ("EIz", "shear_y") if plane == "z" else ("EIy", "shear_z")
    stiffness = stiffness_of(element, fm.Rigidity(**dict(zip(names, (ei, compliance), strict=True))), l0)[at, at]
    sway = np.array([-1.0, 1.0])
    assert 1 / (sway @ stiffness @ sway) == approx(l0**3 / (12 * ei) + l0 * compliance / ei, rel=1e-13)


@given(POSITIVE, POSITIVE, POSITIVE)
def test_extension_and_torsion_energy(l0, ea, git):
    section = fm.Rigidity(EA=ea, GIt=git)
    beams: typing.Any = (planar.beam, spatial.beam, planar.truss, spatial.truss)
    for element in beams:
        if element in (planar.truss, spatial.truss):
            starts = [np.zeros(kind.dimension) for kind in element.nodes.values()]
            starts[1] = starts[1] + l0 * np.eye(len(starts[1]))[0]
            stiffness = np.asarray(element.stiffness(ref=element.reference(starts), section=section))
        else:
            stiffness = stiffness_of(element, section, l0)
        assert stiffness[0, 0] == approx(ea / l0, rel=1e-13)
        assert not np.any(stiffness[0, 1:])
    # e2 = l0 times twist, and twist over length squared times GIt l0/2 is the energy.
    assert stiffness_of(spatial.beam, section, l0)[1, 1] == approx(git / l0**3, rel=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("element", [planar.beam, spatial.beam], ids=["planar", "spatial"])
@given(st.data())
def test_beam_mass_is_that_of_the_cubic_interpolation(element, data):
    """Kinetic energy of a cubic with the end positions and end directions, by a quadrature exact for its square."""
    sample = data.draw(drawn(element))
    section = fm.Rigidity(mass=data.draw(POSITIVE))
    sample = sample._replace(properties={**sample.properties, "section": jax.tree.map(np.asarray, section)})
    rates = data.draw(vectors(Measured(sample).n_x))
    l0, d = length(sample), len(sample.x[0])
    axis = (apart(sample.element, sample.ref)) / l0

    def direction(x, ref):
        """End direction of a node's triad."""
        if d == 2:
            return Rotation.from_rotvec([0, 0, (x - ref)[0]]).apply(np.r_[axis, 0])[:2]
        return homogeneous_matrix(x) @ homogeneous_matrix(ref).T @ axis

    parts = np.split(rates, np.cumsum([p.size for p in sample.x])[:-1])
    # Quadratic in the coordinates (the angle apart), so that a central difference is exact but for round-off.
    step = 1e-5 if d == 2 else 0.1
    spin = [
        (
            direction(sample.x[i] + step * parts[i], sample.ref[i])
            - direction(sample.x[i] - step * parts[i], sample.ref[i])
        )
        / (2 * step)
        for i in (1, 3)
    ]
    points, weights = np.polynomial.legendre.leggauss(4)
    s = (1 + points) / 2
    shape = [1 - 3 * s**2 + 2 * s**3, s - 2 * s**2 + s**3, 3 * s**2 - 2 * s**3, s**3 - s**2]
    ends = [parts[0], l0 * spin[0], parts[2], l0 * spin[1]]
    velocity = sum(np.outer(n, v) for n, v in zip(shape, ends, strict=True))
    expected = 0.5 * section.mass * l0 / 2 * weights @ np.sum(velocity**2, axis=1)
    # In the plane the step leaves 1e-10 of truncation.
    assert energy(sample, rates) == approx(float(expected), rel=1e-9 if d == 2 else 1e-12, abs=1e-12)


def homogeneous_matrix(lam: np.ndarray) -> np.ndarray:
    """Rotation matrix, quadratic in Euler parameters of any norm."""
    a, v = lam[0], lam[1:]
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return (a**2 - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * a * cross


@functools.cache
def deformed(element, second_order: bool):
    """Deformations of a beam, with or without terms of second order, compiled."""

    def of(state, starts, **own):
        return element.deformation(*state, ref=element.reference(starts), second_order=second_order, **own)

    return jax.jit(of)


@pytest.mark.slow("spatial-True-0.6", "spatial-False-0.5")
@pytest.mark.parametrize(("second_order", "share"), [(True, 0.6), (False, 0.5)])
@pytest.mark.parametrize("element", [planar.beam, spatial.beam], ids=["planar", "spatial"])
@given(POSITIVE, st.floats(1e-4, 1e-3))
def test_shortening_by_sway(element, second_order, share, l0, slope):
    """Ends kept parallel, the far end displaced across by d: the chord's projection shortens by 6/5 d^2/(2 l).

    3/5 d^2/l is half the integral of the squared slope of the cubic; the chord alone gives 1/2. By that the guide of
    T3 buckles at 78.75 N and not at 94.5 N, which tests/spacar/test_tutorial.py holds for the whole mechanism.
    """
    starts = [np.array(kind.start) for kind in element.nodes.values()]
    starts[2] = l0 * np.eye(len(starts[0]))[0]
    there, sway = list(starts), slope * l0
    there[2] = starts[2] + sway * np.eye(len(starts[0]))[-1]
    e = deformed(element, second_order)(there, starts)
    # Relative truncation slope^2, up to 1e-6; round-off of l - l0 is eps l0 beside slope^2 l0, 2e-8.
    assert e[0] == approx(share * sway**2 / l0, rel=2e-6)


# Curvature about local y and z, value and slope, and twist, of a rod of length 1.3.
RODS = {
    "all": (0.5, 0.9, -0.7, 0.4, 0.6),
    "no twist": (0.3, -1.1, 0.8, 0.5, 0.0),
    "twist and one plane": (0.8, -0.3, 0.0, 0.0, -0.9),
}
ROD_LENGTH = 1.3


def integrated_rod(fields, start: Rotation) -> tuple[np.ndarray, np.ndarray]:
    """End of an inextensible rod that starts at the origin: position, and Euler parameters."""
    a, b, c, d, twist = fields

    def rates(s, z):
        matrix, t = z[3:].reshape(3, 3), s / ROD_LENGTH
        x, y, w = twist, a + b * t, c + d * t
        spin = np.array([[0, -w, y], [w, 0, -x], [-y, x, 0]])
        return np.r_[matrix[:, 0], (matrix @ spin).ravel()]

    first = np.r_[np.zeros(3), start.as_matrix().ravel()]
    end = solve_ivp(rates, (0, ROD_LENGTH), first, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    return end[:3], Rotation.from_matrix(end[3:].reshape(3, 3)).as_quat(scalar_first=True)


def rod_error(fields, second_order: bool) -> np.ndarray:
    """Deformations of one beam between the ends of a rod, minus those of its fields to first order.

    To first order the deformations are e2 = l0 times the whole twist, e3 and e5 the moment of the curvature about the
    far end, e4 and e6 about the near end: what the stiffness is the exact energy of.
    """
    # A start that is turned: nothing lies along a global axis.
    start = Rotation.from_rotvec([0.4, -0.7, 0.5])
    lam = start.as_quat(scalar_first=True)
    end, lam_end = integrated_rod(fields, start)
    matrix = start.as_matrix()
    starts = [np.zeros(3), lam, ROD_LENGTH * matrix[:, 0], lam]
    found = deformed(spatial.beam, second_order)([np.zeros(3), lam, end, lam_end], starts, y=matrix[:, 1])
    a, b, c, d, twist = fields
    moments = [0, twist, a / 2 + b / 6, a / 2 + b / 3, c / 2 + d / 6, c / 2 + d / 3]
    return np.asarray(found) - ROD_LENGTH**2 * np.array(moments)


@pytest.mark.parametrize("fields", RODS.values(), ids=RODS)
def test_second_order_terms_against_integrated_rods(fields):
    amplitudes = np.array([0.1, 0.05])
    with_terms = np.array([rod_error(f * np.array(fields), True) for f in amplitudes])
    without = np.array([rod_error(f * np.array(fields), False) for f in amplitudes])
    # What is left is of third order, a factor 8; where it happens to vanish there is the integrator's 1e-12.
    left = np.abs(with_terms)
    assert np.all((left[1] < left[0] / 2**2.7) | (left[1] < 1e-11))
    # Without the terms the error is of second order somewhere in each of these rods, and the terms are what is missing.
    assert np.max(np.abs(without[1])) > 4 * np.max(left[1])
    assert np.log2(np.linalg.norm(without[0]) / np.linalg.norm(without[1])) < 2.3


def test_each_second_order_term_is_needed():
    # The rod with all fields: every deformation but for its terms is of second order.
    fields = np.array(RODS["all"])
    large, small = (np.abs(rod_error(f * fields, False)) for f in (0.02, 0.01))
    order = np.log2(large / small)
    assert np.all(order < 2.3), order


# -- hinges -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", [1, -1])
def test_planar_hinge_counts_past_full_turns(way):
    ref = planar.hinge.reference([np.array([0.3]), np.array([-0.2])])
    for angle in way * np.arange(0, 15, 0.4):
        e = planar.hinge.deformation(np.array([0.3 + 1.0]), np.array([-0.2 + 1.0 + angle]), ref=ref)
        np.testing.assert_allclose(e, [angle], atol=20 * EPS * 15)


@pytest.mark.parametrize("way", [1, -1])
@given(vectors(3), vectors(3, 2.0), vectors(3, 2.0), vectors(3, 2.0))
@hypothesis.settings(max_examples=3)
def test_spatial_hinge_counts_past_full_turns(way, axis, start_p, start_q, carried):
    hypothesis.assume(np.linalg.norm(axis) > 0.1)
    unit = axis / np.linalg.norm(axis)
    ref_p, ref_q, carry = quaternion(start_p), quaternion(start_q), quaternion(carried)
    ref = spatial.hinge.reference([ref_p, ref_q])
    call = fm.jit(lambda p, q, near: spatial.hinge.deformation(p, q, ref=ref, axis=jnp.asarray(axis), near=near))
    near = np.zeros(3)
    for angle in way * np.arange(0, 15, 0.4):
        # The body q turns about the axis, and both are carried along by a rotation of the whole.
        turn = np.r_[np.cos(angle / 2), np.sin(angle / 2) * unit]
        near = np.asarray(call(product(carry, ref_p), product(carry, product(turn, ref_q)), near))
        np.testing.assert_allclose(near, [angle, 0, 0], atol=20 * EPS * 15)


@jax.jit
def hinged(turn, axis):
    """Deformations of a hinge whose second node has turned, compiled."""
    one = np.array([1.0, 0, 0, 0])
    return spatial.hinge.deformation(one, turn, ref=spatial.hinge.reference([one, one]), axis=axis, near=np.zeros(3))


@given(vectors(3), st.floats(-0.01, 0.01), st.floats(-3.0, 3.0))
def test_spatial_hinge_tilt_is_small_rotation_across_the_axis(axis, tilt, angle):
    """A tilt about the hinge's own second axis before the rotation: e2, e3 have its size, e1 is the rotation."""
    hypothesis.assume(np.linalg.norm(axis) > 0.1)
    frame = local_frame(axis, None)
    turn = np.r_[np.cos(angle / 2), np.sin(angle / 2) * frame[:, 0]]
    tilted = np.r_[np.cos(tilt / 2), np.sin(tilt / 2) * frame[:, 1]]
    e = hinged(product(tilted, turn), axis)
    np.testing.assert_allclose(e[0], angle, atol=1e-14)
    assert np.hypot(e[1], e[2]) == approx(2 * abs(np.sin(tilt / 2)), abs=1e-14)
