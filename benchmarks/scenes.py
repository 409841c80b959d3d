"""Mechanisms that the benchmarks share."""

import flexmb as fm
from flexmb import spatial

STEEL = {"E": 210e9, "G": 80e9, "rho": 7850.0}


def guide(thickness=0.0005, width=0.018, beams=2, dofs=None, signals=()):
    """Spatial guide: two leaf springs 0.1 m long and 0.1 m apart, all deformations free, a rigid bar on top.

    Args:
        thickness: Of the leaf springs [m].
        width: Of the leaf springs [m].
        beams: Beams a leaf spring.
        dofs: Names of degrees of freedom, such as ``model.q_labels`` of another build; found if None.
        signals: Components of the right end of the bar that are inputs and outputs.
    """
    leaf = fm.Rectangle(width, thickness, fm.Material(**STEEL))
    b = fm.Builder()
    for side, y in (("left", 0.0), ("right", 0.1)):
        for i in range(beams + 1):
            b.node(f"{side}{i}", (0, y, 0.1 * i / beams))
        for i in range(beams):
            b.add(spatial.beam, f"{side}{i}", f"{side}{i + 1}", name=f"{side} {i + 1}", section=leaf, y=(1, 0, 0))
        b.fix(f"{side}0")
    bar = fm.Rigidity(mass=2.0)
    b.add(spatial.beam, f"left{beams}", f"right{beams}", name="bar", section=bar, released=(), y=(1, 0, 0))
    b.mass(f"right{beams}", 0.006)
    for name in dofs or ():
        of, _, component = name.rpartition(".")
        b.dof(of, component.removeprefix("e") if of not in b.nodes else component)
    for component in signals:
        b.input(f"right{beams}", component)
        b.output(f"right{beams}", component)
    return b.build()
