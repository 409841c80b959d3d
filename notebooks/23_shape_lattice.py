# %% [markdown]
# # A lattice that takes a wanted shape
#
# **Question.** A lattice of 1000 beams is clamped at one side and pulled down at the other. How thick must each beam be
# for its top edge to become two steps of a staircase?
#
# A lattice of squares without diagonals is soft in shear: its beams bend, and hardly stretch. The thickness of the
# beams determines the shear of each column, so thicknesses can shape the edge. A printer makes each beam as thick as
# required.

# %%
import warnings
from itertools import pairwise

import jax
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np
import scipy.optimize
import scipy.sparse
import scipy.sparse.linalg
from matplotlib.collections import LineCollection

import flexmb as fm
from flexmb import planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)
# Some beams stretch by 1.4 % or turn by 0.25 rad, where one cubic beam is some percent off. This is accepted here.
warnings.filterwarnings("ignore", category=fm.errors.CoarseWarning)

# %% [markdown]
# ## The lattice
#
# 40 by 12 cells of 5 mm, of printed rubber (TPU), 10 mm deep. The wall holds the left ends, without beams along it; 2 N
# are spread over the right side. Sparse solvers need no degrees of freedom, so `build(check=False)` does not search for
# them.

# %%
columns, rows, cell, width, load = 40, 12, 5e-3, 10e-3, 2.0
rubber = fm.Material(E=60e6, G=20e6, rho=1200)
across = [((i, j), (i + 1, j)) for i in range(columns) for j in range(rows + 1)]
upward = [((i + 1, j), (i + 1, j + 1)) for i in range(columns) for j in range(rows)]
beams = across + upward

b = fm.Builder()
for i in range(columns + 1):
    for j in range(rows + 1):
        b.node(f"{i},{j}", (cell * i, cell * j))
for (i, j), (k, m) in beams:
    b.add(planar.beam, f"{i},{j}", f"{k},{m}", section=fm.Rectangle(width, 0.5e-3, rubber))
for j in range(rows + 1):
    b.fix(f"0,{j}")
    b.force(f"{columns},{j}", (0, -load / (rows + 1)))
lattice = b.build(check=False)
print(len(beams), "beams,", len(lattice.parameters.reference), "coordinates")

# %% [markdown]
# ## A thousand dimensions
#
# `with_property` puts a thousand thicknesses into the model as one array, in the order in which the beams were added,
# without building it again. The wanted edge is a curve. The objective is the distance of the nodes of the edge from
# this curve.

# %%
length, height, drop = columns * cell, rows * cell, 30e-3


def wanted(x):
    """Height of the top edge where it is at x: two steps of a staircase, rounded [m]."""
    s = jnp.clip(x / length, 0, 1)
    return height - drop * (s - jnp.sin(4 * jnp.pi * s) / (4 * jnp.pi))


def bent(thickness):
    return fm.equilibrium(lattice.with_property("section.thickness", thickness), sparse=True)


edge = np.array([lattice.labels.known(f"{i},{rows}") for i in range(1, columns + 1)])


def misses(thickness):
    """How far each node of the edge is above the curve, (40,) [m]."""
    x, y = bent(thickness).x[edge].T
    return y - wanted(x)


def deviation(thickness):
    """Mean square of it, in the first lattice one."""
    return jnp.mean(misses(thickness) ** 2) / square_at_start


start, square_at_start = np.full(len(beams), 0.5e-3), 1.0
square_at_start = float(deviation(start))
print(f"of equal thickness the edge misses by {1e3 * np.sqrt(square_at_start):.1f} mm (root mean square)")

# %% [markdown]
# ## The derivative by a thousand thicknesses
#
# `jax.grad` finds all derivatives by one more solution with the last factors of the equilibrium, for any number of
# thicknesses ([timing](../benchmarks/README.md#designs-of-many-beams)). Along any one direction a difference quotient
# must agree.

# %%
gradient = jax.grad(deviation)(start)
along, step = np.random.default_rng(0).standard_normal(len(beams)), 1e-6
near, far = ((float(deviation(start + k * step * along)) - float(deviation(start - k * step * along))) for k in (1, 2))
difference, derivative = (8 * near - far) / (12 * step), float(gradient @ along)
print(f"{difference:.8g} by differences, {derivative:.8g} by the derivative")

# %% [markdown]
# ## The search
#
# Thicknesses from 0.2 to 1 mm, on a logarithmic scale. Beams that are too thin to carry the load have no equilibrium:
# the search then returns to thicker ones.

# %%
thinnest, thickest = 0.2e-3, 1e-3
with_gradient = jax.value_and_grad(lambda u: deviation(thinnest * jnp.exp(u * np.log(thickest / thinnest))))
history = []


def merit(u):
    try:
        value, slope = with_gradient(jnp.asarray(u))
    except fm.AnalysisError:
        return 10.0, np.zeros_like(u)
    history.append(float(value))
    return float(value), np.asarray(slope)


found = scipy.optimize.minimize(
    merit,
    np.log(start / thinnest) / np.log(thickest / thinnest),
    jac=True,
    method="L-BFGS-B",
    bounds=[(0, 1)] * len(beams),
    options={"maxfun": 60, "maxcor": 20, "ftol": 0, "gtol": 1e-9},
)
thickness = thinnest * np.exp(found.x * np.log(thickest / thinnest))
left = np.asarray(misses(thickness))
print(f"after {len(history)} equilibria and gradients:")
mean, most = 1e3 * np.sqrt(np.mean(left**2)), 1e3 * np.max(np.abs(left))
print(f"the edge misses by {mean:.2f} mm (root mean square), {most:.2f} mm at most")


# %%
def draw(ax, thickness, title):
    at = bent(thickness).x
    node = {(i, j): at[lattice.labels.known(f"{i},{j}")] for i in range(columns + 1) for j in range(rows + 1)}
    lines = [1e3 * np.array([node[p], node[q]]) for p, q in beams]
    drawn = LineCollection(lines, linewidths=3e3 * thickness, array=1e3 * thickness, cmap="viridis_r")
    drawn.set_clim(1e3 * thinnest, 1e3 * thickest)
    ax.add_collection(drawn)
    x = np.linspace(0, length, 200)
    ax.plot(1e3 * x, 1e3 * wanted(x), "r:", label="wanted")
    ax.set(aspect="equal", title=title, xlabel="x [mm]", ylabel="y [mm]")
    ax.legend(loc="lower left")
    return drawn


figure, axes = plt.subplots(1, 2, figsize=(12, 4), layout="constrained", sharey=True)
draw(axes[0], start, "all beams 0.5 mm")
figure.colorbar(draw(axes[1], thickness, "each beam of its own thickness"), label="thickness [mm]")
plt.show()

# %%
figure, axes = plt.subplots(1, 2, figsize=(11, 3.2), layout="constrained")
axes[0].semilogy(1e3 * np.sqrt(square_at_start * np.minimum.accumulate(history)))
axes[0].set(xlabel="equilibria with gradient", ylabel="root mean square [mm]")
jacobian = np.asarray(jax.jacrev(misses)(thickness))
scatter = 0.02e-3 * np.linalg.norm(jacobian, axis=1)
axes[1].plot(1e3 * length * np.arange(1, columns + 1) / columns, 1e3 * scatter)
axes[1].set(xlabel="place in the lattice [mm]", ylabel="scatter of the edge [mm]")
plt.show()

# %% [markdown]
# ## How precisely must it be printed?
#
# On the right: scatter of the edge if every thickness has an independent error of 0.02 mm (standard deviation). One
# call of `jax.jacrev` returns the derivative of each of its forty heights by every thickness. Errors of single beams
# average out; a common error does not:

# %%
common = 0.02e-3 * jacobian.sum(axis=1)
print(f"each by itself: {1e3 * np.max(scatter):.2f} mm; all together: {1e3 * np.max(abs(common)):.2f} mm")

# %% [markdown]
# ## What the lattice is compared with
#
# An independent program in plain NumPy: corotational beams as in textbooks (Crisfield 1991), which share no equation
# with the beams above, four in place of each.


# %%
def textbook(thickness, parts=4, load_steps=6):
    """Height over the curve of the edge, (40,) [m], by corotational beams."""
    places, ends, points = {}, [], []

    def number(key, place):
        if key not in places:
            places[key] = len(points)
            points.append(place)
        return places[key]

    for p, q in beams:
        chain = [p, *((p, q, k) for k in range(1, parts)), q]
        spots = [cell * (np.array(p) + (np.array(q) - p) * k / parts) for k in range(parts + 1)]
        numbers = [number(key, spot) for key, spot in zip(chain, spots, strict=True)]
        ends += pairwise(numbers)
    points, ends, h = np.array(points), np.array(ends), np.repeat(thickness, parts)
    EA, EI = rubber.E * width * h, rubber.E * width * h**3 / 12
    dofs = (3 * ends[:, :, None] + np.arange(3)).reshape(-1, 6)
    long = np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1)
    first = np.arctan2(*(points[ends[:, 1]] - points[ends[:, 0]]).T[::-1])
    moves = np.ones(3 * len(points), bool)
    force, u = np.zeros(3 * len(points)), np.zeros(3 * len(points))
    for j in range(rows + 1):
        moves[3 * places[0, j] : 3 * places[0, j] + 3] = False
        force[3 * places[columns, j] + 1] = -load / (rows + 1)
    for share in np.arange(1, load_steps + 1) / load_steps:
        for _ in range(20):
            at = points + u.reshape(-1, 3)[:, :2]
            d = at[ends[:, 1]] - at[ends[:, 0]]
            now, angle = np.linalg.norm(d, axis=1), np.arctan2(d[:, 1], d[:, 0]) - first
            turn = u.reshape(-1, 3)[ends, 2] - angle[:, None]
            c, s = d.T / now
            o, zero = np.ones_like(c), np.zeros_like(c)
            r, z = np.stack([-c, -s, zero, c, s, zero], 1), np.stack([s, -c, zero, -s, c, zero], 1)
            turns = np.stack([np.stack([zero, zero, o, zero, zero, zero], 1), np.stack([zero] * 5 + [o], 1)], 1)
            B = np.concatenate([r[:, None], turns - (z / now[:, None])[:, None]], axis=1)
            C = np.zeros((len(ends), 3, 3))
            C[:, 0, 0], C[:, 1, 1], C[:, 2, 2] = EA / long, 4 * EI / long, 4 * EI / long
            C[:, 1, 2] = C[:, 2, 1] = 2 * EI / long
            stress = np.einsum("nij,nj->ni", C, np.concatenate([(now - long)[:, None], turn], axis=1))
            K = np.einsum("nai,nab,nbj->nij", B, C, B) + (stress[:, 0] / now)[:, None, None] * np.einsum(
                "ni,nj->nij", z, z
            )
            mixed = np.einsum("ni,nj->nij", r, z)
            K += ((stress[:, 1] + stress[:, 2]) / now**2)[:, None, None] * (mixed + mixed.transpose(0, 2, 1))
            inner = np.bincount(dofs.ravel(), np.einsum("nai,na->ni", B, stress).ravel(), len(u))
            shape = (len(u), len(u))
            at_rows, at_columns = np.repeat(dofs, 6, axis=1).ravel(), np.tile(dofs, (1, 6)).ravel()
            whole = scipy.sparse.coo_array((K.ravel(), (at_rows, at_columns)), shape).tocsr()
            change = scipy.sparse.linalg.spsolve(whole[moves][:, moves].tocsc(), (share * force - inner)[moves])
            u[moves] += change
            if np.max(np.abs(change)) < 1e-9:
                break
    top = [places[i, rows] for i in range(1, columns + 1)]
    x, y = (points + u.reshape(-1, 3)[:, :2])[top].T
    return y - np.asarray(wanted(x))


own = textbook(thickness)
print(f"largest difference of the edge: {1e3 * np.max(abs(own - left)):.3f} mm of {1e3 * drop:.0f} mm")

assert len(beams) == 1000
assert abs(derivative / difference - 1) < 1e-6
assert np.sqrt(square_at_start) > 2e-3
assert np.sqrt(np.mean(left**2)) < 0.15e-3
assert np.max(abs(own - left)) < 0.3e-3
