"""Mechanisms that are driven along trajectories."""

import flexmb as fm
from flexmb import planar


def arm(ratio=0.02):
    """A steel arm of 0.5 m with a load at its tip, driven at its hub: two beams that bend."""
    section = fm.Rectangle(0.03, 0.003, fm.Material(E=210e9, G=80e9, rho=7850.0))
    b = fm.Builder()
    damping = fm.sections.damping_from_ratio(section, 0.25, ratio) if ratio else None
    for i in range(3):
        b.node(f"{i}", (0.25 * i, 0))
    for i in range(2):
        b.add(planar.beam, f"{i}", f"{i + 1}", name=f"arm{i}", section=section, damping=damping, released=(2, 3))
        b.dof(f"arm{i}", 2, 3, kind="element")
    b.fix("0", "position")
    b.mass("0", 0.1, inertia=1e-3)
    b.mass("2", 0.1)
    b.dof("0", "phi")
    b.input("0", "phi", name="torque")
    b.output("2", "y", name="tip")
    b.output("0", "phi", name="hub")
    return b.build()
