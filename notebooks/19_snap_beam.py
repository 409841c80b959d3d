# %% [markdown]
# # A beam that snaps
#
# **Question.** A beam with an initial curvature is pushed through. Which force does this take, and does the beam stay
# on the other side?
#
# Such a beam holds a switch or a valve in one of two positions without power. It is etched from silicon in the shape of
# a cosine, $w = \frac h2\left(1 - \cos\frac{2\pi x}{L}\right)$, with both ends clamped, and has no stress in this shape
# (Qiu, Lang and Slocum, *A curved-beam bistable mechanism*, J. Microelectromech. Syst. 13, 2004).

# %%
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import flexmb as fm
from flexmb import planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# ## The model
#
# 3 mm long, 60 µm high, 6 µm thick: ten times as high as thick. A chain of **spectral beams**, each with its own
# `curvature`, is bent and without stress. The force acts at "middle". Forces are in units of $EIh/L^3$, as in the
# paper.
#
# One beam can turn at its middle. Two beams side by side, joined at their middles, cannot: this suppresses the
# antisymmetric shape. By symmetry half of one beam models them, with its middle guided and under half the load.

# %%
length, height, thickness, width, arcs, most = 3e-3, 60e-6, 6e-6, 50e-6, 4, 900.0
silicon = fm.Material(E=170e9, G=66e9, rho=2330.0)
section = fm.Rectangle(width, thickness, silicon)
unit = float(section.rigidity().EIy) * height / length**3


def snapping(halves):
    x = np.linspace(0.0, length / 2 * halves, arcs * halves + 1)
    y = height / 2 * (1 - np.cos(2 * np.pi * x / length))
    slope = np.arctan(np.pi * height / length * np.sin(2 * np.pi * x / length))
    names = ["middle" if i == arcs else f"node {i}" for i in range(len(x))]
    b = fm.Builder()
    for name, *place in zip(names, x, y, strict=True):
        b.node(name, place)
    chords, turns = np.hypot(np.diff(x), np.diff(y)), np.diff(slope)
    for ends, chord, turn in zip(pairwise(names), chords, turns, strict=True):
        b.add(planar.spectral_beam(3), *ends, section=section, curvature=2 * np.sin(turn / 2) / chord)
    b.fix("node 0")
    if halves == 1:
        b.fix("middle", "x", "phi")
    else:
        b.fix(names[-1])
    b.force("middle", (0, -most * unit * halves / 2))
    return b.build()


print(f"unit of force {1e6 * unit:.4f} µN")

# %% [markdown]
# ## Pushed through
#
# `stop` ends the path at a displacement of the middle, twice the height down, rather than at a load. On the way the
# beam reaches bifurcations. The symmetric state, in which the beam is only pressed flatter, continues but is unstable.
# The beam buckles into a mode of a clamped column: the **second** if its middle may turn, the **third** if not.
#
# `switch={1: 1, 2: 1}` leaves the first bifurcation along this mode, and the second one again. There the branch meets
# the symmetric state, now upside down, and the path follows this state as the load rises.

# %%
models = {"third mode": snapping(1), "second mode": snapping(2)}
paths = {
    mode: fm.path(model, switch={1: 1, 2: 1}, stop={"middle.y": -2 * height}, step=0.05)
    for mode, model in models.items()
}
paths["third mode"]


# %%
def displacement(path, x):
    """Of the middle, down, over the height."""
    return 1 - np.asarray(x)[..., path.labels.coordinates("middle")[1]] / height


found = {}
for mode, path in paths.items():
    found[mode] = [(most * c.load_factor, displacement(path, c.x)) for c in path.critical_points]
    (top, before), (bottom, after) = found[mode]
    print(f"{mode:12} {top:7.2f} at {before:.4f} h, back {bottom:7.2f} at {after:.4f} h")

# %% [markdown]
# With the third mode the beam needs up to 740 units, and half of that to come back: it is **bistable**. With the second
# mode it takes half the force, and hardly any force brings it back. Shaking a chip would do so.
#
# ## A beam with an imperfection
#
# No beam is perfect, and no real beam meets a bifurcation. `imperfection={1: ...}` bends the undeformed beam by its
# first buckling mode, of this amplitude, without stress. Then the beam snaps at a **limit point**, at a lower load. In
# theory the loss is proportional to the power two thirds of the imperfection (Koiter).

# %%
bows = np.array([1e-4, 1e-3, 1e-2]) * thickness
bent = [fm.path(models["third mode"], imperfection={1: bow}, stop={"critical_points": 1}, step=0.05) for bow in bows]
snaps = [path.critical_points[0] for path in bent]
lost = 1 - np.array([c.load_factor for c in snaps]) * most / found["third mode"][0][0]
power = np.diff(np.log(lost)) / np.diff(np.log(bows))
for bow, c, less in zip(bows, snaps, lost, strict=True):
    print(f"bent by {1e9 * bow:5.1f} nm: {c.kind} point at {most * c.load_factor:.2f}, {100 * less:.3f} % lower")
print("powers", power.round(4))

# %%
figure, ax = plt.subplots(figsize=(7, 4.5), layout="constrained")
for mode, path in paths.items():
    points = [(0.0, 0.0), *zip(displacement(path, path.x), most * np.asarray(path.load_factor), strict=True)]
    points = np.array(sorted([*points, *((d, load) for load, d in found[mode])]))
    ax.plot(*points.T, label=mode)
    ax.plot(*np.array([(d, load) for load, d in found[mode]]).T, "ks", markerfacecolor="white")
real = fm.path(models["third mode"], imperfection={1: 0.1 * thickness}, stop={"middle.y": -2 * height})
ax.plot(displacement(real, real.x), most * np.asarray(real.load_factor), ":", label="third, bent by 600 nm")
ax.axhline(0, color="0.6", linewidth=0.8)
ax.set_xlabel("displacement of the middle / h")
ax.set_ylabel("force / (EI h/L³)")
ax.grid(visible=True, alpha=0.3)
ax.legend()
plt.show()

# %% [markdown]
# ## What the numbers are compared with
#
# **The paper** gives 740 at 0.16 h and 370 at 1.92 h for the third mode, from a series of three modes.
#
# **A shallow arch** has a closed form. With the thrust $N^2 = PL^2/EI$, forces and lengths as above and $s$ from the
# quarter point,
# $$W' = \frac{4\pi^3\cos 2\pi s}{4\pi^2 - N^2} + \frac{F}{2N^2}\left(1 - \frac{\cos Ns}{\cos N/4}\right),\qquad
# N^2 = 12\,\frac{h^2}{t^2}\int_{-1/4}^{1/4}\left(\pi^2\cos^2 2\pi s - W'^2\right)ds,$$
# where the shortening of the beam causes the thrust. A clamped column buckles at $\tan N/2 = N/2$ in its second mode
# and at $N = 4\pi$ in its third. For these the last equation is quadratic in $F$, with one root for each side.
#
# Our beams are exact and not shallow: the arch neglects the square of the slope, $(\pi h/L)^2$ = 0.4 %.

# %%
s, weights = np.polynomial.legendre.leggauss(40)
s, weights = s / 4, weights / 4


def shallow(thrust):
    """Force and displacement at which the arch is under a thrust, on either side."""
    made, by_load = np.pi * np.cos(2 * np.pi * s), (1 - np.cos(thrust * s) / np.cos(thrust / 4)) / (2 * thrust**2)
    pressed = made * 4 * np.pi**2 / (4 * np.pi**2 - thrust**2)
    terms = [-(by_load**2), -2 * by_load * pressed, made**2 - pressed**2]
    a, b, c = (float(weights @ term) for term in terms)
    loads = sorted(np.roots([a, b, c - thrust**2 / 12 * (thickness / height) ** 2]), reverse=True)
    return [(load, 1 - weights @ (pressed + load * by_load)) for load in loads]


second = 2 * brentq(lambda n: np.tan(n) - n, 4.4, 4.6)
arch = {"third mode": shallow(4 * np.pi), "second mode": shallow(second)}
for mode, ((top, before), (bottom, after)) in arch.items():
    print(f"{mode:12} {top:7.2f} at {before:.4f} h, back {bottom:7.2f} at {after:.4f} h")
# The paper, to the digits that it gives.
assert np.all(np.abs(np.array(found["third mode"]) - [[740, 0.16], [-370, 1.92]]) < [10, 0.01])
# The arch: forces to 0.4 % of the largest, displacements to 0.4 % of the height.
for mode, expected in arch.items():
    off = np.abs(np.array(found[mode]) - expected)
    assert np.all(off < [4e-3 * expected[0][0], 4e-3])
# Koiter's power is that of small imperfections: its next order is another 2/3 power higher, as are the 2 % lost here.
assert all(c.kind == "limit" for c in snaps)
assert np.allclose(power, 2 / 3, atol=0.02)
