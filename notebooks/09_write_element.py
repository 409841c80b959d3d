# %% [markdown]
# # Write your own element
#
# **Question.** How do you write a notch hinge as an element of your own, and does a guide on four of them have the
# right stiffness?
#
# A notch hinge is a block with two circular cuts that leave a thin neck. It bends at the neck and is stiff elsewhere. A
# mechanism has many of them, and one number of each matters: the rotational stiffness of the neck.

# %%
import warnings

import jax.numpy as jnp
import numpy as np

import flexmb as fm
from flexmb import planar

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# ## The deformations
#
# An element is **one function** from the coordinates of its nodes to its deformations. Its signature declares
# everything: positional parameters are the nodes, annotated with their kinds; `ref` contains the same coordinates in
# the undeformed mechanism; keyword-only parameters are properties.
#
# The hinge joins a body with a point p and a body with a point q. Its centre is in the middle between them. It has
# three deformations: the relative rotation, and the distance between the centre as seen by either body, along and
# across the hinge. They must be zero in the undeformed mechanism, and must not change when the whole mechanism moves as
# a rigid body. Therefore the distance is measured in axes of body p.


# %%
def turned(angle, vector):
    cosine, sine = jnp.cos(angle[0]), jnp.sin(angle[0])
    return jnp.stack([cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1]])


def notch_hinge(p: fm.Point2, rot_p: fm.Angle, q: fm.Point2, rot_q: fm.Angle, *, ref):
    half = (ref.q - ref.p) / 2
    along = half / jnp.linalg.norm(half)
    gap = (q - turned(rot_q - ref.rot_q, half)) - (p + turned(rot_p - ref.rot_p, half))
    own = turned(-(rot_p - ref.rot_p), gap)
    bend = (rot_q - ref.rot_q) - (rot_p - ref.rot_p)
    return jnp.stack([bend[0], own @ along, along[0] * own[1] - along[1] * own[0]])


# %% [markdown]
# ## The stiffness
#
# A companion function with the same parameter names returns the stiffness matrix between deformations and stress
# resultants. The height of the hinge at the distance x from the neck is $h(x) = t + 2r - 2\sqrt{r^2 - x^2}$. As a beam
# of varying height it has the compliances
#
# $$\frac1{k_\varphi} = \int_{-r}^{r}\frac{12\,dx}{E\,b\,h^3}, \qquad \frac1{k_x} = \int_{-r}^{r}\frac{dx}{E\,b\,h} .$$
#
# With $x = r\sin\theta$ the integrands are smooth, and a Gauss rule suffices. The third deformation, across the hinge,
# has no stiffness: it stays FIXED, since only 1 and 2 are `released`. Nothing is registered; all derivatives follow
# from these two functions.

# %%
nodes, weights = np.polynomial.legendre.leggauss(120)  # on -1 to 1


def stiffnesses(radius, neck, depth, E):
    theta = jnp.pi / 2 * nodes
    height = neck + 2 * radius * (1 - jnp.cos(theta))
    slice_of = radius * jnp.cos(theta) * jnp.pi / 2 * weights
    bending = jnp.sum(12 * slice_of / (E * depth * height**3))
    tension = jnp.sum(slice_of / (E * depth * height))
    return 1 / bending, 1 / tension


def notch_stiffness(*, ref, radius: float, neck: float, depth: float, E: float):
    rotation, tension = stiffnesses(radius, neck, depth, E)
    return jnp.diag(jnp.stack([rotation, tension, 0.0 * tension]))


notch = fm.Element(notch_hinge, stiffness=notch_stiffness, released=(1, 2))
print("properties:", list(notch.properties))

# %% [markdown]
# ## A guide on four notch hinges
#
# Two cranks of 60 mm carry a stage. Each crank is a rigid beam between two hinges. `b.add` takes the new element like
# any other, and answers are differentiable by its properties.

# %%
radius, neck, depth, E = 5e-3, 0.3e-3, 10e-3, 71e9
crank, apart = 60e-3, 0.1  # between the centres of the hinges


def guide(neck):
    hinge = {"radius": radius, "neck": neck, "depth": depth, "E": E}
    b = fm.Builder()
    for side, x in (("left", 0.0), ("right", apart)):
        for name, y in (("foot", -radius), ("low", radius), ("high", crank - radius), ("top", crank + radius)):
            b.node(f"{side} {name}", (x, y))
        b.add(notch, f"{side} foot", f"{side} low", name=f"{side} lower hinge", **hinge)
        b.add(planar.beam, f"{side} low", f"{side} high", name=f"{side} crank")
        b.add(notch, f"{side} high", f"{side} top", name=f"{side} upper hinge", **hinge)
        b.fix(f"{side} foot")
        b.mass(f"{side} top", 0.1)
    b.add(planar.beam, "left top", "right top", name="stage")
    return b.build()


model = guide(neck)
modes = fm.modes(model)
figure = fm.plot.modes(modes)
print("frequencies [Hz]:", np.round(modes.frequencies, 2))

# %% [markdown]
# The first mode is the motion, the others stretch the necks. `fm.stiffness` and `jax.grad` work as with built-in
# elements:

# %%
drive = float(fm.stiffness(model, "left top", "x"))
by_neck = fm.sensitivities(guide, {"drive": lambda model: fm.stiffness(model, "left top", "x")}, {"neck": neck})
print(f"drive stiffness {drive:.3f} N/m; one percent of the neck makes {by_neck.table[0, 0]:.3f} percent of it")

# %% [markdown]
# ## Is it an element?
#
# The commonest mistake is a deformation that changes in a rigid motion. `fm.check_element` tests this and everything
# else that the analyses rely on, in states near several undeformed mechanisms. It returns how accurately each law
# holds, or raises an error that names the broken laws. Here is an element whose distance is measured in global axes
# instead of axes of body p:

# %%
sizes = {"radius": radius, "neck": neck, "depth": depth, "E": E}
checked = fm.check_element(notch, apart=2 * radius, **sizes)
print(checked)


def in_global_axes(p: fm.Point2, rot_p: fm.Angle, q: fm.Point2, rot_q: fm.Angle, *, ref):
    half = (ref.q - ref.p) / 2
    return (q - turned(rot_q - ref.rot_q, half)) - (p + turned(rot_p - ref.rot_p, half))


try:
    fm.check_element(in_global_axes, apart=2 * radius)
except fm.ModelError as fault:
    refused = str(fault)
print(refused)

# %% [markdown]
# ## What the numbers are compared with
#
# *The neck.* A thin neck bends only near its middle, where $h \approx t + x^2/r$. The integral then has the closed form
# of Paros and Weisbord, $k_\varphi = \frac{2Eb\,t^{5/2}}{9\pi\sqrt r}$, with an error of the order $t/r$.
#
# *A finer model.* One hinge as 60 cubic beams, each with its height in the middle. A moment turns its end.
#
# *The guide.* When the stage moves by x, each of the four hinges turns by x over the length of the crank. So the drive
# stiffness is $4k_\varphi/l^2$.

# %%
rotation, tension = (float(k) for k in stiffnesses(radius, neck, depth, E))
paros = 2 * E * depth * neck**2.5 / (9 * np.pi * np.sqrt(radius))
print(f"neck: {rotation:.4f} N m/rad, thin-neck formula {paros:.4f} N m/rad")

# Slices of the height of a neck, by beam theory: that is what is compared.
warnings.filterwarnings("ignore", category=fm.BeamTheoryWarning)
count = 60
edges = radius * np.sin(np.linspace(-np.pi / 2, np.pi / 2, count + 1))
b = fm.Builder()
for i, x in enumerate(edges):
    b.node(f"n{i}", (x, 0))
for i, x in enumerate((edges[1:] + edges[:-1]) / 2):
    height = neck + 2 * radius - 2 * np.sqrt(radius**2 - x**2)
    section = fm.Rectangle(depth, height, fm.Material(E=E, G=27e9))
    b.add(planar.beam, f"n{i}", f"n{i + 1}", section=section)
b.fix("n0")
fine = float(fm.stiffness(b.build(), f"n{count}", "phi"))
print(f"as 60 beams: {fine:.4f} N m/rad")

assert max(checked.deviations.values()) < 1e-8
assert "changes by" in refused
assert abs(rotation / paros - 1) < 2 * neck / radius
assert abs(fine / rotation - 1) < 0.01
assert abs(drive / (4 * rotation / crank**2) - 1) < 1e-4  # the necks stretch a little
