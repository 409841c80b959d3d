"""Mechanisms that move, each once, with what is known about their motion."""

import jax.numpy as jnp
import numpy as np

import flexmb as fm
from flexmb import planar, spatial


def pendulum() -> fm.Builder:
    """D5: point mass on a rigid rod of 1 m, from rest at the horizontal."""
    b = fm.Builder()
    b.node("pivot", (0, 0))
    b.node("mass", (-1.0, 0))
    b.rotation("rod")
    b.add(planar.rigid_beam, "pivot", "rod", "mass", name="arm")
    b.fix("pivot", "x", "y")
    b.mass("mass", 1.0)
    b.gravity((0, -9.81))
    b.dof("rod", "phi")
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


def body_rates(motion: fm.Motion) -> np.ndarray:
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


def released_guide(thickness=0.0005) -> fm.Builder:
    """Two planar leaf springs of two beams each with all deformations, a bar on top."""
    from mechanisms import planar_guide

    return planar_guide(thickness, beams=2, elongation=True, dofs=False)


def pushed(model: fm.Model, node: str, component: int, force: float) -> fm.Model:
    """The same mechanism under one more force."""
    import dataclasses

    index = int(model.labels.known(node)[component])
    present = model.parameters.loads.force
    whole = jnp.zeros(model.topology.n_x) if present is None else present
    loads = dataclasses.replace(model.parameters.loads, force=whole.at[index].add(force))
    return dataclasses.replace(model, parameters=dataclasses.replace(model.parameters, loads=loads))
