"""Temperature of elements: free expansion, self-stress, buckling by heat, motion, against closed forms."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import flexmb as fm
from flexmb import planar, sections, spatial

ALPHA, E, L, WIDTH, THICKNESS = 11.5e-6, 210e9, 0.1, 0.018, 5e-4
STEEL = fm.Material(E, 80e9, 7850.0, alpha=ALPHA)
LEAF = fm.Rectangle(WIDTH, THICKNESS, STEEL)
THICK = fm.Rectangle(WIDTH, 10 * THICKNESS, STEEL)

CANTILEVERS: dict[str, tuple[str, dict[str, Any]]] = {
    "cubic": ("beam", {"section": LEAF}),
    # Of other kinds of section, in one block with the first.
    "wire": ("beam", {"section": fm.Circle(2e-3, STEEL)}),
    "numbers": ("beam", {"section": fm.Rigidity(EA=1e6, EIy=1.0, EIz=2.0, GIt=1.0, alpha=ALPHA)}),
    "cold": ("beam", {"section": fm.Rigidity(EA=1e6, EIy=1.0, EIz=2.0, GIt=1.0)}),
    "spectral": ("spectral_beam", {"section": LEAF}),
    "reinforced": ("spectral_beam", {"section": sections.stepped([LEAF, THICK, LEAF], (0.2, 0.8)), "order": 4}),
    "rigid": ("rigid_beam", {"alpha": ALPHA}),
    "rigid at both ends": ("rigid_body", {"alpha": ALPHA}),
}
# K, at both ends, and K/m along y and z: small, since the cubic beam's arc is right to first order.
CHANGE, ACROSS = (5.0, 15.0), (300.0, 1200.0)


def cantilevers(dimension: int) -> fm.Model:
    """One of each kind along x, clamped at its first end, all of them warmed but one."""
    b, module = fm.Builder(), planar if dimension == 2 else spatial
    kinds = {name: of for name, of in CANTILEVERS.items() if dimension == 2 or name != "reinforced"}
    for i, (name, (element, properties)) in enumerate(kinds.items()):
        place = np.array([0.0, i, 0.0])[:dimension]
        b.node(f"foot {name}", place)
        b.node(f"tip {name}", place + L * np.eye(dimension)[0])
        across = {} if dimension == 2 else {"y": (0.0, 1.0, 0.0)}
        b.add(getattr(module, element), f"foot {name}", f"tip {name}", name=name, **properties, **across)
        b.fix(f"foot {name}")
        if name != "cold":
            b.temperature(name, CHANGE, gradient=ACROSS[1] if dimension == 2 else ACROSS)
    return b.build()


@pytest.mark.slow
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_free_element_becomes_an_arc_without_stress(dimension):
    """Strain alpha T, curvature alpha g away from the warmer side."""
    model = cantilevers(dimension)
    found = fm.equilibrium(model)
    bend = ALPHA * np.array(ACROSS[::-1][: dimension - 1]) * L
    for name, *_ in model.labels.elements:
        moved = (
            np.asarray(found.at(f"tip {name}"))
            - np.asarray(model.parameters.reference)[model.labels.known(f"tip {name}")]
        )
        expected = np.zeros(dimension)
        if name != "cold":
            expected[0] = ALPHA * np.mean(CHANGE) * L - L * bend @ bend / 6
            expected[1:] = (-bend / 2 * L) if dimension == 2 else (-bend[::-1] / 2 * L)
        if name != "rigid":
            turn = np.asarray(found.at(f"tip {name}.rotation"))
            slope = [-bend[0]] if dimension == 2 else [0.0, bend[0], -bend[1]]
            turn = turn if dimension == 2 else 2 * turn[1:]
            # As what is moved, below.
            np.testing.assert_allclose(turn, (name != "cold") * np.array(slope), atol=2e-4 * np.max(bend), err_msg=name)
        if name.startswith("rigid"):
            # Its arc is straight.
            expected[0] = ALPHA * np.mean(CHANGE) * L
        # Second order in the curvature, and its product with the mean strain of 1e-4.
        np.testing.assert_allclose(moved, expected, atol=2e-4 * L * np.max(bend), err_msg=name)
        # How the curvature of the reinforced one is spread, and so its shortening, is approached to a tenth.
        spread = 0.1 * L * bend @ bend / 6 if name == "reinforced" else 0.0
        np.testing.assert_allclose(moved[0], expected[0], atol=1e-10 + spread, err_msg=name)
    # Round-off of stiffnesses of 2e7 N/m times lengths of metres.
    np.testing.assert_allclose(found.sigma, 0.0, atol=2e7 * 1e-14)


def stage(feet: tuple[float, ...], leaf: Any = LEAF, length: Any = L) -> fm.Builder:
    """Leaf springs that stand on feet and carry a stage."""
    b = fm.Builder()
    for i, x in enumerate(feet):
        b.node(f"foot{i}", (x, 0.0))
        b.node(f"top{i}", (x, length))
        b.add(planar.beam, f"foot{i}", f"top{i}", name=f"leaf{i}", section=leaf)
        b.fix(f"foot{i}")
        if i:
            b.add(planar.beam, f"top{i - 1}", f"top{i}", name=f"stage{i}")
    return b


def guide(change, alpha=ALPHA, length=L):
    """Guide of two leaf springs, one of them warmer."""
    b = stage((0.0, 0.1), fm.Rectangle(WIDTH, THICKNESS, dataclasses.replace(STEEL, alpha=alpha)), length)
    b.temperature("leaf1", change)
    b.dof("leaf0", 1, 3)
    b.dof("leaf1", 1)
    return b.build()


def tilt(model) -> Any:
    return fm.equilibrium(model).at("top0.rotation")[0]


@pytest.mark.slow
def test_a_warm_leaf_spring_tilts_its_guide():
    """By alpha L/(distance of the feet) for each kelvin: bending resists with some 1e-4 of what stretches."""
    np.testing.assert_allclose(tilt(guide(1.0)), 11.5e-6, rtol=2e-4)
    at = np.array([30.0, ALPHA, L])

    def of(numbers):
        return tilt(guide(*numbers))

    forward, reverse = jax.jit(jax.jacfwd(of))(at), jax.jit(jax.grad(of))(at)
    steps = np.cbrt(np.finfo(float).eps) * at
    central = [(of(at + h) - of(at - h)) / (2 * np.max(h)) for h in np.diag(steps)]
    # Round-off of the equilibrium, 1e-13 of it, over the step.
    np.testing.assert_allclose(forward, central, rtol=3e-7)
    np.testing.assert_allclose(reverse, forward, rtol=1e-12)
    answers = {"tilt": lambda model: tilt(model)}
    many = fm.sweep(lambda change: guide(change), answers, fm.design.grid(change=[10.0, 30.0, -20.0]))
    np.testing.assert_allclose(many["tilt"][1], of(at), rtol=1e-10)
    np.testing.assert_allclose(many["tilt"], 11.5e-6 * np.array([10.0, 30.0, -20.0]), rtol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("sparse", [False, True])
def test_a_third_leaf_spring_makes_self_stress_and_a_free_one_none(sparse):
    """Three equal springs k = EA/L on a stage that only rises: the middle one pushes with 2/3 k alpha L."""
    b = stage((0.0, 0.05, 0.1))
    b.temperature("leaf1", 10.0)
    alone = stage((0.0, 0.1))
    alone.node("foot", (0.05, 0.0))
    alone.node("top", (0.05, L))
    alone.add(planar.beam, "foot", "top", name="leaf", section=LEAF)
    alone.fix("foot")
    alone.temperature("leaf", 10.0)
    push = E * WIDTH * THICKNESS * ALPHA * 10.0 / 3
    for builder, expected in ((b, [push, -2 * push, push]), (alone, [0.0, 0.0, 0.0])):
        found = fm.equilibrium(builder.build(), sparse=sparse)
        normal = [
            float(s)
            for s, e in zip(found.sigma, found.labels.e, strict=True)
            if e.of[:4] == "leaf" and e.component == 1
        ]
        # Changes of length beside one, alpha T = 1e-4, and bending of the stage's rise.
        np.testing.assert_allclose(normal, expected, rtol=3e-4, atol=1e-9)


@pytest.mark.slow
def test_an_over_constrained_guide_twists_its_stage_and_a_released_one_does_not():
    """One leaf spring warmer along one edge: it would be an arc in its own plane, which the other leaf spring resists.

    Both bend by half of the curvature alpha g, with the moment EIz alpha g/2, which the stage carries as torsion; the
    guide's one self-stress.
    """
    gradient = 500.0
    for release, share in (((), 1.0), ((2,), 0.0)):
        b = fm.Builder()
        for i, y in enumerate((0.0, 0.1)):
            b.node(f"foot{i}", (0.0, y, 0.0))
            b.node(f"top{i}", (0.0, y, 0.1))
            b.add(spatial.beam, f"foot{i}", f"top{i}", name=f"leaf{i}", section=LEAF, y=(1.0, 0, 0))
            b.fix(f"foot{i}")
        b.add(spatial.beam, "top0", "top1", name="stage", released=release)
        b.temperature("leaf0", 0.0, gradient=(gradient, 0.0))
        model = b.build()
        lin = fm.linearize(model)
        moment = np.asarray(fm.linear.section_resultants(model, at=lin).values)[:, :, 5]
        expected = share * E * THICKNESS * WIDTH**3 / 12 * ALPHA * gradient / 2
        # What is left without the release is the torsion of the leaf springs, GIt/L beside EIz/L.
        np.testing.assert_allclose(np.abs(moment), expected, rtol=5e-3, atol=4e-3 * (1 - share))


def clamped_and_warmed(share, count=4):
    """Cubic beams between walls, their increment a share of T = 4 pi^2 (t^2/12)/(alpha L^2), at which they buckle."""
    critical = 4 * np.pi**2 * THICKNESS**2 / 12 / (ALPHA * L**2)
    b = fm.Builder()
    for i in range(count + 1):
        b.node(f"n{i}", (i * L / count, 0.0))
    for i in range(count):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", name=f"piece{i}", section=LEAF)
        b.temperature(f"piece{i}", share * critical, increment=True)
    b.fix("n0")
    b.fix(f"n{count}")
    return b.build()


def test_a_clamped_leaf_spring_buckles_by_heat():
    # Discretisation, of order four: 7.5e-3, with eight and sixteen beams 5.1e-4 and 3.3e-5.
    np.testing.assert_allclose(fm.buckling_loads(clamped_and_warmed(1.2))[0], 1 / 1.2, rtol=7.6e-3)


@pytest.mark.slow
def test_a_path_of_heat_leaves_where_linear_buckling_says():
    model = clamped_and_warmed(1.2)
    (point,) = fm.path(model).critical_points
    assert point.kind == "bifurcation"
    # Until then it is straight, and its length stays.
    np.testing.assert_allclose(point.load_factor, fm.buckling(model).multipliers[0], rtol=1e-5)


@pytest.mark.slow
def test_a_warm_spring_and_a_warm_rigid_arm_move_their_masses():
    """(m1 + m2) x'' + m2 a alpha T2'' = -k (x - alpha T1 L), and the energy gained is the work of the expansion."""
    k, m1, m2, arm = 90.0, 0.4, 0.3, 0.2
    big = 1e-3
    b = fm.Builder()
    for name, x in {"foot": 0.0, "slide": L, "end": L + arm}.items():
        b.node(name, (x, 0.0))
    b.add(planar.truss, "foot", "slide", name="spring", section=fm.Rigidity(EA=k * L, alpha=big))
    b.add(planar.rigid_beam, "slide", "end", name="arm", alpha=big)
    b.fix("foot")
    b.fix("slide", "y")
    b.fix("slide", "rotation")
    b.mass("slide", m1)
    b.mass("end", m2)
    b.temperature("spring", 2.0)
    b.temperature("arm", 0.0)
    times = np.linspace(0.0, 0.6, 301)
    loads = {
        "spring.temperature": lambda t: 10 * t,
        "arm.temperature": lambda t: jnp.stack([0 * t, 8 * (1 - jnp.cos(9 * t))]),
    }
    model = b.build()
    motion = fm.simulate(model, times, loads=loads, rtol=1e-9)

    def rate(t, z):
        push = k * (z[0] - big * (2 + 10 * t) * L) + m2 * arm * big * 4 * 81 * np.cos(9 * t)
        return [z[1], -push / (m1 + m2)]

    exact = solve_ivp(rate, (0, 0.6), [0.0, 0.0], t_eval=times, rtol=1e-12, atol=1e-14)
    # Ten times the tolerance of a step, over some tens of steps.
    np.testing.assert_allclose(motion.at("slide")[:, 0] - L, exact.y[0], atol=1e-8)
    stretched = arm * (1 + big * 4 * (1 - np.cos(9 * times)))
    np.testing.assert_allclose(motion.at("end")[:, 0] - motion.at("slide")[:, 0], stretched, atol=1e-12)
    observed = motion.observe()
    work = np.concatenate([[0.0], np.cumsum((observed.power[1:] + observed.power[:-1]) / 2 * np.diff(times))])
    # The trapezoidal rule: (step/period)^2.
    np.testing.assert_allclose(observed.energy - observed.energy[0], work, atol=1e-4 * np.ptp(observed.energy))


def test_what_temperature_cannot_drive_or_change_is_named():
    b = stage((0.0, 0.1))
    b.node("end", (0.2, L))
    b.add(planar.rigid_beam, "top1", "end", name="arm", alpha=ALPHA)
    b.temperature("arm", 0.0)
    b.mass("top0", 1.0)
    model, ramp = b.build(), fm.motion.Table(jnp.array([0.0, 1.0]), jnp.array([0.0, 1.0]))
    cases = {
        "leaf0.temperature": (
            jnp.sin,
            r"'leaf0.temperature': the element has no temperature.* temperature\('leaf0', 0.0\)",
        ),
        "arm.temperature": (ramp, "'arm.temperature' is a table, but deformations of the element are FIXED"),
        "arm.gradient": (
            lambda t: jnp.stack([t, t]),
            r"'arm.gradient' must return one number, but returns shape \(2,\)",
        ),
        "leaf.temperature": (jnp.sin, "'leaf.temperature' names no coordinate"),
    }
    for name, (function, message) in cases.items():
        with pytest.raises(fm.ModelError, match=message):
            fm.simulate(model, [0.0, 1.0], loads={name: function})
    with pytest.raises(fm.ModelError, match="one number, or 2, one for each end, but returns shape \\(3,\\)"):
        fm.simulate(model, [0.0, 1.0], loads={"arm.temperature": lambda t: t * jnp.ones(3)})
    for coordinate in (1, 2):
        b.prescribe("arm", coordinate, 0.0)
    with pytest.warns(fm.FlexmbWarning, match="Temperature of element 'arm': all of its deformations are PRESCRIBED"):
        b.build()


def bar(p: fm.Point2, q: fm.Point2, *, ref):
    """Elongation of a bar."""
    return (jnp.sqrt((q - p) @ (q - p)) - jnp.sqrt((ref.q - ref.p) @ (ref.q - ref.p)))[None]


def hardening(e, *, ref, k: float):
    return 0.5 * k * e[0] ** 2 + 1e3 * k * e[0] ** 4


def swelling(change, *, ref, expansion: float):
    return expansion * jnp.mean(change)[None]


@pytest.mark.slow
def test_an_element_of_ones_own_expands_by_its_companion():
    element = fm.Element(bar, energy=hardening, thermal=swelling)
    b = fm.Builder()
    for name, x in {"foot": 0.0, "end": 1.0}.items():
        b.node(name, (x, 0.0))
    b.add(element, "foot", "end", name="bar", k=100.0, expansion=1e-3)
    b.fix("foot")
    b.fix("end", "y")
    b.temperature("bar", (4.0, 8.0), increment=True)
    b.force("end", (3.0, 0.0))
    found = fm.equilibrium(b.build(), increment=1.0)
    moved = float(found.at("end")[0]) - 1.0
    strain = moved - 6e-3
    # Round-off of a force of 3 N that Newton's method leaves.
    np.testing.assert_allclose(100.0 * strain + 4e5 * strain**3, 3.0, rtol=1e-10)
    with pytest.raises(fm.ModelError, match="Temperature of element 'bar': an element of type bar does not bend"):
        b.temperature("bar", 1.0, gradient=2.0)
