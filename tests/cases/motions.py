"""Mechanisms that move, each once, with what is known about their motion."""

import jax.numpy as jnp
import numpy as np

import flexmb as fm
from flexmb import planar, spatial


def pendulum(place=(-1.0, 0), mass=1.0) -> fm.Builder:
    """D5: point mass on a rigid rod of 1 m, from rest at the horizontal; or another, elsewhere."""
    b = fm.Builder()
    b.node("pivot", (0, 0))
    b.node("mass", place)
    b.rotation("rod")
    b.add(planar.rigid_beam, "pivot", "rod", "mass", name="arm")
    b.fix("pivot", "x", "y")
    b.mass("mass", mass)
    b.gravity((0, -9.81))
    b.dof("rod", "phi")
    return b


def double_pendulum(masses=(1.0, 1.0)) -> fm.Builder:
    """Two point masses on rigid rods of 1 m, at rest, both rods horizontal."""
    b = fm.Builder()
    for i, name in enumerate(("pivot", "upper", "lower")):
        b.node(name, (0.0, -1.0 * i))
    for rod, p, q, mass in (("first", "pivot", "upper", masses[0]), ("second", "upper", "lower", masses[1])):
        b.rotation(rod)
        b.add(planar.rigid_beam, p, rod, q, name=f"arm of {q}")
        b.mass(q, mass)
        b.start(rod, "phi", np.pi / 2)
    b.fix("pivot", "x", "y")
    b.gravity((0, -9.81))
    return b


def slider_crank(rod_mass=0.0666) -> fm.Builder:
    """Rigid crank of 0.15 m whose angle is prescribed, uniform rod of 0.3 m, slider on the x axis, stretched."""
    b = _crank_and_slider()
    b.rotation("rod")
    b.add(planar.rigid_beam, "pin", "rod", "slider", name="bar", section=fm.Rigidity(mass=rod_mass / 0.3))
    return b


def flexible_slider_crank(order=9, diameter=0.006, E=2e11, rho=7870.0) -> fm.Builder:
    """The same with a round rod that bends and stretches."""
    b = _crank_and_slider()
    area, second = np.pi * diameter**2 / 4, np.pi * diameter**4 / 64
    section = fm.Rigidity(EA=E * area, EIy=E * second, mass=rho * area)
    b.add(planar.spectral_beam(order), "pin", "slider", name="rod", section=section)
    return b


def _crank_and_slider() -> fm.Builder:
    b = fm.Builder()
    for name, x in (("ground", 0.0), ("pin", 0.15), ("slider", 0.45)):
        b.node(name, (x, 0.0))
    b.rotation("crank")
    b.add(planar.rigid_beam, "ground", "crank", "pin", name="arm")
    b.fix("ground", "x", "y")
    b.fix("slider", "y")
    b.mass("slider", 0.033)
    b.prescribe("crank", "phi", 0.0)
    return b


def four_bars(loops: int) -> fm.Builder:
    """D5: parallel cranks and couplers of unit length and mass, all upright, turning at -1 rad/s."""
    b = fm.Builder()
    bar = fm.Rigidity(mass=1.0)
    for i in range(loops + 1):
        b.node(f"ground{i}", (i, 0))
        b.node(f"top{i}", (i, 1.0))
        b.rotation(f"crank{i}")
        b.fix(f"ground{i}", "x", "y")
        b.add(planar.rigid_beam, f"ground{i}", f"crank{i}", f"top{i}", name=f"bar{i}", section=bar)
    for i in range(loops):
        b.add(planar.truss, f"top{i}", f"top{i + 1}", name=f"coupler{i}", section=bar, released=())
    b.start("crank0", "phi", 0.0, -1.0)
    b.gravity((0, -9.81))
    return b


def body(inertia, rates, mass=0.0, centre=(0.0, 0.0, 0.0), gravity=None) -> fm.Builder:
    """A rigid body about a fixed point, with principal inertia about its centre of mass and rates of its own axes."""
    b = fm.Builder()
    b.node("point", (0, 0, 0))
    b.rotation("body")
    b.fix("point", "x", "y", "z")
    if mass:
        b.node("centre", centre)
        b.add(spatial.rigid_beam, "point", "body", "centre", name="arm")
        b.mass("centre", mass)
    b.inertia("body", (inertia[0], 0, 0, inertia[1], 0, inertia[2]))
    for i, rate in enumerate(rates):
        # The rate of a vector Euler parameter is half the angular velocity at the unit orientation.
        b.start("body", f"l{i + 1}", 0.0, rate / 2)
    if gravity is not None:
        b.gravity(gravity)
    return b


def body_rates(motion: fm.motion.Motion) -> np.ndarray:
    """Angular velocity about the body's own axes, (n_t, 3) [rad/s]."""
    parameters, rates = (np.asarray(a) for a in (motion.at("body"), motion.velocity("body")))
    l0, v = parameters[:, :1], parameters[:, 1:]
    r0, r = rates[:, :1], rates[:, 1:]
    # Vector part of 2 conj(l) l_dot.
    return 2 * (l0 * r - r0 * v - np.cross(v, r))


def rotor(order=8, EA=1e9) -> fm.Builder:
    """C3: cantilever of unit length, mass and bending stiffness on a hub of radius zero that is turned."""
    b = fm.Builder()
    b.node("hub", (0, 0))
    b.node("tip", (1.0, 0))
    section = fm.Rigidity(EA=EA, EIy=1.0, mass=1.0)
    b.add(planar.spectral_beam(order), "hub", "tip", name="blade", section=section)
    b.fix("hub", "x", "y")
    b.prescribe("hub", "phi", 0.0)
    return b


def turned(t, speed):
    """Angle of a rotation at constant speed."""
    return speed * t


def spun(t, speed, duration):
    """Angle of a rotation that is brought to a speed, W/T (t^2/2 + (T/2pi)^2 (cos(2pi t/T) - 1)) until then."""
    k = 2 * np.pi / duration
    turn = speed / duration * (t**2 / 2 + (jnp.cos(k * t) - 1) / k**2)
    return jnp.where(t < duration, turn, speed * (t - duration / 2))


def spinning_up(order=8) -> fm.Builder:
    """Cantilever of 10 m on a hub of radius zero that is turned; without shear and rotary inertia."""
    b = fm.Builder()
    b.node("hub", (0, 0))
    b.node("tip", (10.0, 0))
    section = fm.Rigidity(EA=2.8e7, EIy=1.4e4, mass=1.2)
    b.add(planar.spectral_beam(order), "hub", "tip", name="blade", section=section)
    b.fix("hub", "x", "y")
    b.prescribe("hub", "phi", 0.0)
    return b


def spaghetti(order) -> fm.Builder:
    """D1: a free flexible rod."""
    b = fm.Builder()
    b.node("lower", (6.0, 0, 0))
    b.node("upper", (0, 8.0, 0))
    _shearing_rod(b, order, "lower", "upper", bending=500.0, stretching=1e4)
    return b


def _shearing_rod(b: fm.Builder, order: int, p: str, q: str, bending: float, stretching: float):
    compliance = bending / stretching
    stiffness = dict(EA=stretching, EIy=bending, EIz=bending, GIt=bending, shear_y=compliance, shear_z=compliance)
    section = fm.Rigidity(**stiffness, mass=1.0, Jx=20.0, Jy=10.0, Jz=10.0)
    b.add(spatial.spectral_beam(order, shear=True), p, q, name=f"{p} to {q}", section=section, y=(0, 0, 1))


def shaft(order=6, diameter=0.05, E=210e9, rho=7850.0) -> fm.Builder:
    """C4: simply supported spinning shaft of 1 m with rotary inertia and without shear."""
    b = fm.Builder()
    b.node("left", (0, 0, 0))
    b.node("right", (1.0, 0, 0))
    area, second = np.pi * diameter**2 / 4, np.pi * diameter**4 / 64
    section = fm.Rigidity(
        EA=E * area,
        EIy=E * second,
        EIz=E * second,
        GIt=E / 2.6 * 2 * second,
        mass=rho * area,
        Jx=2 * rho * second,
        Jy=rho * second,
        Jz=rho * second,
    )
    b.add(spatial.spectral_beam(order), "left", "right", name="shaft", section=section, y=(0, 1, 0))
    b.fix("left", "position")
    b.fix("right", "y", "z")
    b.prescribe("left", "rotation", 0.0, axis=(1, 0, 0), tilt="free")
    return b


def released_guide(thickness=0.0005) -> fm.Builder:
    """Two planar leaf springs of two beams each with all deformations, a bar on top."""
    from cases.mechanisms import planar_guide

    return planar_guide(thickness, beams=2, elongation=True, dofs=False)


def pushed(model: fm.Model, node: str, component: int, force: float) -> fm.Model:
    """The same mechanism under one more force."""
    import dataclasses

    index = int(model.labels.known(node)[component])
    present = model.parameters.loads.force
    whole = jnp.zeros(model.topology.n_x) if present is None else present
    loads = dataclasses.replace(model.parameters.loads, force=whole.at[index].add(force))
    return dataclasses.replace(model, parameters=dataclasses.replace(model.parameters, loads=loads))


def thrown_at_a_stop(gap) -> fm.Builder:
    """A mass of 1 kg thrown up with 3 m/s, by which it comes 0.45 m high, against a stop of 1e5 N/m above a gap."""
    b = fm.Builder()
    b.node("below", (0.0, -200.0))
    b.node("mass", (0.0, 0.0))
    b.add(planar.spring_damper(lambda e, ed, *, gap: 1e5 * jnp.maximum(e - gap, 0.0)), "below", "mass", gap=gap)
    b.fix("below")
    b.fix("mass", "x")
    b.mass("mass", 1.0)
    b.gravity((0.0, -10.0))
    b.start("mass", "y", 0.0, velocity=3.0)
    return b


def height_behind_the_stop(gap):
    """After 2 s: flight, contact with the speed v of arrival, (pi - 2 atan(g/(w v)))/w long, and flight from -v."""
    w, speed = jnp.sqrt(1e5), jnp.sqrt(9.0 - 20.0 * gap)
    left = 2.0 - (3.0 - speed) / 10.0 - (jnp.pi - 2 * jnp.arctan(10.0 / (w * speed))) / w
    return gap - speed * left - 5.0 * left**2


def sprung_mass(
    *, length=0.4, stiffness=90.0, damping=0.0, mass=0.4, guided=True, foot: str = "fixed", dofs=True
) -> fm.Builder:
    """A mass on a spring s along x, between the nodes foot and mass; its motion along x is that of one oscillator."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("mass", (length, 0))
    own = fm.Damping(EA=damping * length) if damping else None
    b.add(planar.truss, "foot", "mass", name="s", section=fm.Rigidity(EA=stiffness * length), damping=own)
    if foot == "fixed":
        b.fix("foot")
    else:
        b.fix("foot", "y")
        b.prescribe("foot", "x", 0.0)
    if guided:
        b.fix("mass", "y")
    b.mass("mass", mass)
    if dofs and guided:
        b.dof("mass", "x")
    return b


def oscillation(t, stiffness, damping, mass, force, displacement=0.0, rate=0.0) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and velocity of an oscillator under a constant force: closed form, of less than critical damping."""
    t, rest = np.asarray(t), force / stiffness
    decay = damping / (2 * mass)
    omega = np.sqrt(stiffness / mass - decay**2)
    a = displacement - rest
    b = (rate + decay * a) / omega
    swing, turned = a * np.cos(omega * t) + b * np.sin(omega * t), b * np.cos(omega * t) - a * np.sin(omega * t)
    fall = np.exp(-decay * t)
    return rest + fall * swing, fall * (omega * turned - decay * swing)


def meshing_wheels(turned=0.0) -> fm.Builder:
    """Two wheels at rest that mesh with no stress, the second as driven by the first; inputs and outputs are torques
    and turns of both."""
    b = fm.Builder()
    for name, x in (("p", 0.0), ("q", 0.15)):
        b.node(name, (x, 0))
        b.fix(name, "x", "y")
    b.add(planar.gear, "p", "q", name="mesh", ratio=2.0, stiffness=1000.0)
    for name, inertia, turn in (("p", 1e-2, turned), ("q", 4e-2, -turned / 2)):
        b.inertia(name, inertia)
        b.dof(name, "phi")
        b.start(name, "phi", turn)
        b.input(name, "phi", name=f"torque {name}")
        b.output(name, "phi", name=f"turn {name}")
    return b
