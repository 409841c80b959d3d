"""Design problems with known optima, each once: builder, exact value and source."""

import jax.numpy as jnp
import numpy as np

import flexmb as fm
from flexmb import planar


def column(area, ends="pinned"):
    """Column of length 1 along y under a load of 1, one beam for each area, I = A^2 and E = 1."""
    n = len(area)
    b = fm.Builder()
    for i in range(n + 1):
        b.node(f"{i}", (0.0, i / n))
    for i in range(n):
        # Slender: what the elongation allows is far from what is asked.
        section = fm.Rigidity(EA=1e6, EIy=area[i] ** 2)
        b.add(planar.beam, f"{i}", f"{i + 1}", name=f"piece {i + 1}", section=section, released=(2, 3))
    b.fix("0", *(("x", "y") if ends == "pinned" else ()))
    b.fix(f"{n}", *(("x",) if ends == "pinned" else ("x", "phi")))
    b.force(f"{n}", (0.0, -1.0))
    return b.build()


def cantilever(heights, law):
    """Cantilever of length 1 in pieces of equal length, I = size^law, E = 1."""
    n = len(heights)
    b = fm.Builder()
    for i in range(n + 1):
        b.node(f"{i}", (i / n, 0.0))
    for i in range(n):
        section = fm.Rigidity(EIy=heights[i] ** law)
        b.add(planar.beam, f"{i}", f"{i + 1}", name=f"piece {i + 1}", section=section, released=(2, 3))
    b.fix("0")
    return b.build()


def two_carts(first, second):
    """Two carts of 1 kg, each on a rod of its own stiffness."""
    b = fm.Builder()
    for i, stiffness in enumerate((first, second)):
        b.node(f"wall {i}", (0, i))
        b.node(f"cart {i}", (0.1, i))
        b.add(planar.truss, f"wall {i}", f"cart {i}", section=fm.Rigidity(EA=0.1 * stiffness))
        b.fix(f"wall {i}")
        b.fix(f"cart {i}", "y")
        b.mass(f"cart {i}", 1.0)
    return b.build()


def mean(values):
    return jnp.mean(jnp.asarray(values))


STRONGEST_PINNED = 4 * np.pi**2 / 3  # Clausen 1851, Keller 1960: 4/3 of Euler's load of the uniform column
# Olhoff, Rasmussen 1977: 52.3563; Seyranian: 52.3565, both for the bimodal optimum.
STRONGEST_CLAMPED = 52.356


def unloaded_guide(thickness, width=0.018, length=0.1):
    """E1: the tutorial's guide, by its dimensions; degrees of freedom are found."""
    return _guide(thickness, width, length).build()


def loaded_guide(thickness, width=0.018, length=0.1):
    """The same under 1 N downwards."""
    b = _guide(thickness, width, length)
    b.force("B", (0.0, -1.0))
    return b.build()


def _guide(thickness, width, length):
    leaf = fm.Rectangle(width, thickness, fm.Material(E=210e9, G=80e9, rho=7850.0), rotary=False)
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, length), "C": (0.1, length), "D": (0.1, 0)}.items():
        b.node(name, place)
    b.add(planar.beam, "A", "B", name="left", section=leaf, released=(2, 3))
    b.add(planar.beam, "D", "C", name="right", section=leaf, released=(2, 3))
    b.add(planar.beam, "B", "C", name="stage")
    b.fix("A")
    b.fix("D")
    b.mass("B", 0.103)
    b.mass("C", 0.103)
    return b
