"""Structures that others measured, as mechanisms of flexmb: a wing, a composite cantilever, a rotating strip."""

import json
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

import flexmb as fm
from flexmb import spatial

WING = json.loads((Path(__file__).parent / "pazy.json").read_text())
SPAN, CHORD, AXIS = WING["span"], 0.1, 0.044
GRAVITY, INCH = 9.81, 0.0254
# Levers of the weights behind the axis of the wing [m]: at mid-chord, and behind the trailing edge with and without
# skin. The source prints 0.08 and 0.04 behind the edge. These fit the twist for a rigid clamp and no own weight.
MID_CHORD = 0.006
LEVERS = {"with skin": 0.114, "without skin": 0.098}
# Place of the masses with the own weight of the wing and a rigid clamp, fitted by measured_fits.py: lever, and how far
# beyond the tip they hang [m].
FITTED = {"with skin": {"lever": 0.124, "outboard": 0.055}, "without skin": {"lever": 0.098, "outboard": 0.055}}
# All readings without skin, from the files of the source. Both edges were read in steps of 1 mm, 95 mm apart: masses
# [kg], displacement at mid-chord [mm] under masses at mid-chord and behind the edge, and twist [deg]. ZEROS: error of
# the reading without mass in both tests [mm], fitted.
READ_MASSES = 0.2 * np.arange(1, 11)
READ_BENDING = np.array([23.5, 50.0, 74.5, 98.5, 121.5, 142.5, 162.5, 181.0, 198.0, 213.5])
READ_TORSION = np.array([25.0, 51.5, 77.0, 100.5, 123.5, 144.5, 164.0, 181.5, 199.0, 214.0])
READ_TWIST = np.degrees(1 / 95) * np.array([2, 3, 4, 5, 7, 7, 8, 9, 10, 10])
ZEROS = np.array([4.5, 2.5])
# Minguet and Dugundji's beam 3: weights at the tip [N], displacement down at 0.5 m [m].
WEIGHTS = GRAVITY * 1e-3 * np.array([20.0, 50, 100, 200, 300, 400, 500])
DISPLACEMENTS = np.array([0.0063917, 0.013699, 0.026949, 0.053838, 0.080046, 0.10625, 0.12876])
# Epps and Chandra's strip: frequencies [Hz] by sweep [deg]: flapping, a row for each speed, and three above them at 750
# rpm.
RPM = np.array([0.0, 500.0, 750.0])
FLAPPING = {
    0: [[1.4, 10.3, 27.7], [10.2, 25.2, 47.0], [14.8, 36.1, 62.9]],
    15: [[1.8, 10.2, 27.2], [10.1, 25.2, 44.4], [14.4, 34.8, 55.9]],
    30: [[1.7, 10.4, 26.6], [10.2, 23.7, 39.3], [14.9, 30.7, 48.6]],
    45: [[1.6, 10.4, 24.8], [10.2, 21.6, 35.1], [14.7, 26.1, 44.8]],
}
COUPLED = {0: [95.4, 106.6, 132.7], 15: [87.5, 120.1, 147.3], 30: [83.7, 122.6, 166.2], 45: [78.8, 117.7, 162.0]}


def wing(kind: str, clamp: Any = 0.0) -> fm.Builder:
    """The Pazy wing on 15 beams: x to the trailing edge, y along the span, z up.

    Args:
        kind: "with skin" or "without skin".
        clamp: Compliance of the root in bending out of plane [rad/(N m)].
    """
    own, places, b = WING[kind], WING["nodes"], fm.Builder()
    for number, place in enumerate(places):
        b.node(f"n{number}", (0.0, place, 0.0))
    for number, (extension, twist, bending, in_plane, *couplings) in enumerate(own["stiffness"], 1):
        k12, k13, k14, k23, k24, k34 = couplings
        if number == 1:
            bending = 1 / (1 / bending + clamp / places[1])
        stiffness = [extension, k12, k13, k14, twist, k23, k24, bending, k34, in_plane]
        section = fm.sections.General(stiffness)
        ends = f"n{number - 1}", f"n{number}"
        # Local y points to the leading edge: the spar lies at mid-chord, where K14/K11 puts the tension centre.
        b.add(spatial.spectral_beam(2), *ends, name=f"b{number}", section=section, y=(-1.0, 0.0, 0.0))
        b.dof(f"b{number}", *range(7, 15))
    for number, (mass, x, y, z, ixx, iyy, izz) in enumerate(own["inertia"]):
        if number:
            b.body(f"n{number}", mass, center=(x, y, z), inertia=(ixx, 0, 0, iyy, 0, izz))
    b.fix("n0")
    return b


def wing_loaded(
    kind: str, lever: Any, masses: Any, clamp: Any = 0.0, weight: bool = False, outboard: Any = 0.0
) -> dict[str, Any]:
    """Displacement and twist of the wing under tip masses. Lever, clamp and outboard may be traced.

    Args:
        kind: "with skin" or "without skin".
        lever: How far behind the axis the masses hang [m].
        masses: Of several loads [kg].
        clamp: Compliance of the root [rad/(N m)].
        weight: Whether the wing's own weight acts. Results are what is added to its sag.
        outboard: How far beyond the tip the masses hang [m].

    Returns:
        "displacement" down of the axis at the tip, "at mid-chord" there, and "at the mass" [% of the span], "twist":
        angle of the chord with the horizontal [deg].
    """
    b, tip = wing(kind, clamp), f"n{len(WING['nodes']) - 1}"
    b.node("mass", (lever, SPAN + outboard, 0.0))
    b.node("mid-chord", (MID_CHORD, SPAN, 0.0))
    b.add(spatial.rigid_body, tip, "mid-chord", name="rib")
    b.add(spatial.rigid_body, tip, "mass", name="arm")
    b.force("mass", (0.0, 0.0, -GRAVITY), increment=True)
    if weight:
        b.gravity((0.0, 0.0, -GRAVITY))
    found = fm.equilibria(b.build(), increment=jnp.asarray([0.0, *masses]))
    places = {"displacement": tip, "at mid-chord": "mid-chord", "at the mass": "mass"}
    values = {name: -100 * found.position(node, "z") / SPAN for name, node in places.items()}
    chord = jax.vmap(fm.rotations.to_matrix)(found.at(f"{tip}.rotation"))[:, :, 0]
    values["twist"] = jnp.degrees(jnp.arcsin(-chord[:, 2]))
    return {name: value[1:] - value[0] for name, value in values.items()}


def composite(bending: Any = 0.983, coupling: float = -522.0) -> fm.Model:
    """Minguet and Dugundji's beam 3, its root turned by 45 degrees about its axis; local z is its soft direction."""
    stiffness = jnp.diag(jnp.stack([jnp.asarray(k, float) for k in (3.9e6, 1.1e6, 1.2e5, 1.18, bending, 290.0)]))
    section = fm.sections.General(stiffness.at[[0, 3], [3, 0]].set(coupling))
    b = fm.Builder()
    for name, place in {"root": 0.0, "reading": 0.5, "tip": 0.55}.items():
        b.node(name, (place, 0.0, 0.0))
    for name, ends, order in (("inner", ("root", "reading"), 5), ("outer", ("reading", "tip"), 3)):
        beam = spatial.spectral_beam(order=order, shear=True)
        b.add(beam, *ends, name=name, section=section, y=(0.0, 1.0, 1.0))
        b.dof(name, *range(7, 7 + 6 * order))
    b.fix("root")
    b.force("tip", (0.0, 0.0, -1.0), increment=True)
    return b.build()


def sunk(model: fm.Model) -> Any:
    """Displacement down of beam 3 at its reading, under all weights."""
    place = [str(entry) for entry in model.labels.x].index("reading.z")
    return -fm.equilibria(model, increment=jnp.asarray(WEIGHTS)).x[:, place]


# Coefficients of each strain of both parts of the strip.
ORDERS = (6, 4)


def strip(sweep: float, modulus: float = 73.08e9, offset: float = 2.5 * INCH) -> fm.Model:
    """Epps and Chandra's strip in space, whose hub turns about z and whose tip is swept in the plane of rotation."""
    aluminium = fm.Material(E=modulus, nu=0.325, rho=2682)
    section = fm.Rectangle(width=INCH, thickness=0.063 * INCH, material=aluminium)
    sine, cosine = np.sin(np.radians(sweep)), np.cos(np.radians(sweep))
    b = fm.Builder()
    bend = offset + 31.5 * INCH
    places = {"hub": 0.0, "root": offset, "bend": bend, "tip": bend + 6 * INCH * cosine}
    for name, place in places.items():
        b.node(name, (place, -6 * INCH * sine if name == "tip" else 0.0, 0.0))
    b.fix("hub", "x", "y", "z")
    b.prescribe("hub", "rotation", 0.0, axis=(0, 0, 1), tilt="fixed")
    b.add(spatial.rigid_body, "hub", "root", name="arm")
    across = {"inner": (0.0, 1.0, 0.0), "outer": (sine, cosine, 0.0)}
    for (name, y), ends, order in zip(across.items(), (("root", "bend"), ("bend", "tip")), ORDERS, strict=True):
        b.add(spatial.spectral_beam(order), *ends, name=name, section=section, y=y)
        b.dof(name, *range(7, 7 + 4 * order))
    return b.build()


def turned(time: Any, speed: Any) -> Any:
    """Angle of the hub."""
    return speed * time


def out_of_plane(model: fm.Model, rpm: float) -> np.ndarray:
    """Frequencies of flapping and twisting of the strip at a steady speed, from the lowest on [Hz].

    The strip lies in the plane of rotation, so that its stretching and bending in this plane are motions of their own.
    """
    drive = {"turn of hub.e1": jax.tree_util.Partial(turned, speed=rpm * 2 * np.pi / 60)}
    lin = fm.linearize(model) if rpm == 0 else fm.motion.steady_motion(model, drive)
    first = np.cumsum([0, 4 * ORDERS[0]])
    out = np.concatenate([at + np.arange(order, 3 * order) for at, order in zip(first, ORDERS, strict=True)])
    rest = np.setdiff1d(np.arange(4 * sum(ORDERS)), out)
    m, c, k = (np.asarray(one) for one in (lin.M0, lin.C0, lin.K0 + lin.N0 + lin.G0))
    for whole in (m, c, k):
        assert np.max(np.abs(whole[np.ix_(out, rest)])) <= 1e-6 * np.max(np.abs(whole[np.ix_(out, out)])) + 1e-9
    m, c, k = (whole[np.ix_(out, out)] for whole in (m, c, k))
    n = len(out)
    first_order = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(m, k), -np.linalg.solve(m, c)]])
    found = np.sort(np.abs(np.linalg.eigvals(first_order).imag))
    return found[::2] / (2 * np.pi)
