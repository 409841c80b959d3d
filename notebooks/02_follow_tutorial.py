# %% [markdown]
# # The tutorial, chapters 2 to 4
#
# **Question.** Does flexmb compute the numbers that the SPACAR tutorial prints, from its input files and from Python?
#
# The tutorial *Prototype modelling of mechanical systems* (WA 1239, University of Twente, 2012) models one mechanism
# three times: as a mass on a spring, in the plane, and in space. The input files of all its models ship with flexmb.
# This notebook reads every model from its file. It also builds the main model of each chapter in Python.

# %%
import control
import matplotlib.pyplot as plt
import numpy as np

import flexmb as fm
from flexmb import planar, spatial
from flexmb.mechanisms import mechanism_path

fm.enable_x64()
cache = fm.enable_cache(thorough=False)


def shipped(name):
    """A mechanism that ships with flexmb; on the command line: flexmb run `name`.dat --mode 7."""
    return fm.read_spacar(mechanism_path(name)).builder.build(dofs="named")


printed = {}  # what the tutorial prints: number, its last digit, and what is computed here

# %% [markdown]
# ## Chapter 2: a mass on a spring
#
# One truss has the sway stiffness of the two leaf springs. The stage is a point mass at its end. The file defines a
# planar truss (`PLTRUSS`) between nodes 1 and 2. Node 1 is fixed, and the elongation of the truss is released. The x
# coordinate of node 2 is the degree of freedom.

# %%
print(mechanism_path("pf1dtrx").read_text())

# %% [markdown]
# In Python, the same mechanism has names in place of numbers. `Rigidity` is a section that is defined by its numbers.
# Here these are the axial rigidity $EA = k\,l$ and the mass per length.

# %%
b = fm.Builder()
b.node("ground", (0, 0))
b.node("stage", (0.1, 0))
b.add(
    planar.truss,
    "ground",
    "stage",
    name="guide",
    section=fm.Rigidity(EA=94.5, mass=0.1413),
    damping=fm.Damping(EA=0.00365),
)
b.fix("ground")
b.fix("stage", "y")
b.mass("stage", 0.206)
b.dof("stage", "x")
b.force("stage", (1.0, 0))
b.input("stage", "x")
b.output("stage", "x")
in_python, from_file = b.build(), shipped("pf1dtrx")
print(fm.frequencies(in_python), fm.frequencies(from_file))
print(fm.equilibrium(from_file).at("2"))

# %% [markdown]
# Mode 7 of SPACAR is `fm.frequencies`, and mode 9 is `fm.to_statespace`. Section 2.2 uses the elongation as degree of
# freedom instead. The answer is the same.

# %%
system = fm.to_statespace(from_file)
print(control.tf(system))
printed["2.1 frequency [Hz]"] = 10.6584, 4, fm.frequencies(from_file)[0]
printed["2.1 position under 1 N [m]"] = 0.1011, 4, fm.equilibrium(from_file).at("2")[0]
printed["2.1 stiffness/mass [1/s²]"] = 4485, 0, -system.A[1, 0]
printed["2.1 damping/mass [1/s]"] = 0.1732, 4, -system.A[1, 1]
printed["2.1 1/mass [1/kg]"] = 4.746, 3, system.B[1, 0]
printed["2.2 frequency [Hz]"] = 10.6584, 4, fm.frequencies(shipped("pf1dtre"))[0]

# %% [markdown]
# Section 2.3 leaves further models as exercises: a flexible support, a flexible base of the actuator, an internal mode,
# and all of them together. The actuator then acts between two bodies, so the input is a stress in an element. The
# tutorial prints no numbers for these models. Their lowest frequencies are:

# %%
for name in ("pf1dsupport", "pf1dsupport2", "pf1dinternal", "pf1dfull"):
    print(f"{name:<14}", np.round(fm.frequencies(shipped(name)), 3), "Hz")

# %% [markdown]
# ## Chapter 3: the guide in the plane
#
# The guide has three planar beams. In the file, odd nodes are positions and even nodes are rotations. In Python, one
# name means both. The stage is a rigid beam, so its mass is placed at its ends. Two masses at the ends have too much
# rotary inertia. Each end therefore has the negative rotary inertia $-mb^2/12$.

# %%
leaf = fm.Rigidity(EA=1.89e6, EIy=0.039375, mass=0.07065)
internal = fm.Damping(EA=0.3654, EIy=5.3e-6)


def planar_guide(released, dofs):
    b = fm.Builder()
    for name, place in {"A": (0, 0), "B": (0, 0.1), "C": (0.1, 0.1), "D": (0.1, 0)}.items():
        b.node(name, place)
    b.add(planar.beam, "A", "B", name="left", section=leaf, damping=internal, released=released)
    b.add(planar.beam, "B", "C", name="stage")
    b.add(planar.beam, "C", "D", name="right", section=leaf, damping=internal, released=released)
    for foot in "AD":
        b.fix(foot)
    for end in "BC":
        b.mass(end, 0.103, inertia=-0.0001716)
    b.dof("B", *dofs)
    b.input("C", "x")
    for node, coordinate in (("B", "x"), ("B", "y"), ("C", "x"), ("C", "y"), ("B", "phi"), ("C", "phi")):
        b.output(node, coordinate)
    return b.build()


one, one_file = planar_guide((2, 3), ("x",)), shipped("pf2d")
print(fm.frequencies(one), fm.frequencies(one_file))

# %% [markdown]
# Buckling (mode 8): a load of 1 N acts downwards on the left end of the bar. `fm.buckling` computes the load multiplier
# at which the guide buckles, with its sign.

# %%
buckling = fm.buckling(shipped("pf2db"))
print(buckling.multipliers)
figure = fm.plot.modes(buckling)

# %%
system = fm.to_statespace(one_file)
print(np.round(system.C, 6))
printed["3.1 frequency [Hz]"] = 10.6448, 4, fm.frequencies(one_file)[0]
printed["3.1 buckling load [N]"] = 78.75, 4, buckling.multipliers[0]
printed["3.1 stiffness/mass [1/s²]"] = 4473, 0, -system.A[1, 0]
printed["3.1 damping/mass [1/s]"] = 0.6021, 4, -system.A[1, 1]
printed["3.1 1/mass [1/kg]"] = 4.734, 3, system.B[1, 0]

# %% [markdown]
# The rows of $C$ for y and for the rotation are zero: in the straight position the stage moves sideways only.
#
# Section 3.2 lets the leaf springs stretch. The guide then has three degrees of freedom.

# %%
three, three_file = planar_guide((1, 2, 3), ("x", "y", "phi")), shipped("pf2d3dof")
figure = fm.plot.modes(fm.modes(three))
frequencies = fm.frequencies(three_file)
print(fm.frequencies(three), frequencies)
printed["3.2 first frequency [kHz]"] = 0.0106, 4, frequencies[0] / 1e3
printed["3.2 second frequency [kHz]"] = 2.1290, 4, frequencies[1] / 1e3

# %% [markdown]
# The third printed frequency, 3583.3 Hz, depends on the fourth digit of the printed rotary inertia. With the printed
# inertia, flexmb computes 3585.1 Hz.
#
# ## Chapter 4: the guide in space
#
# A spatial beam has six deformations: 1 elongation, 2 torsion, 3 and 4 bending that displaces along local z, 5 and 6
# bending that displaces along local y. Its `y` vector is the direction of its local y axis. Two whole leaf springs
# constrain the rotation of the bar about its own axis twice. One of them therefore has a cut, which releases one more
# bending (see notebook 03).

# %%
rigidity = {"EA": 1.89e6, "GIt": 0.05895, "EIz": 0.039375, "mass": 0.07065}
damping = {"EA": 0.3654, "GIt": 6.5e-6, "EIz": 5.3e-6}
whole, cut = fm.Rigidity(**rigidity, EIy=51.03), fm.Rigidity(**rigidity)

b = fm.Builder()
for name, place in {"A": (0, 0, 0), "B": (0, 0, 0.1), "C": (0, 0.1, 0.1), "D": (0, 0.1, 0)}.items():
    b.node(name, place)
own = fm.Damping(**damping, EIy=1.9e-4)
b.add(spatial.beam, "A", "B", name="whole", section=whole, damping=own, y=(0, 1, 0), released=(2, 5, 6))
b.add(spatial.beam, "B", "C", name="bar", section=fm.Rigidity(mass=1.9994), y=(0, 0, 1), released=())
b.add(
    spatial.beam, "C", "D", name="cut", section=cut, damping=fm.Damping(**damping), y=(0, 1, 0), released=(2, 3, 5, 6)
)
b.fix("A")
b.fix("D")
b.mass("C", 0.006)
b.dof("B", "y")
b.input("C", "y")
b.output("B", "y")
space, space_file = b.build(), shipped("pf3d")
print(fm.frequencies(space), fm.frequencies(space_file))

# %%
system = fm.to_statespace(space_file)
printed["4.1 frequency [Hz]"] = 10.6464, 4, fm.frequencies(space_file)[0]
printed["4.1 stiffness/mass [1/s²]"] = 4475, 0, -system.A[1, 0]
printed["4.1 damping/mass [1/s]"] = 0.6023, 4, -system.A[1, 1]
printed["4.1 1/mass [1/kg]"] = 4.735, 3, system.B[1, 0]

# %% [markdown]
# Section 4.2 uses two beams for the whole leaf spring and three for the cut leaf spring: 19 degrees of freedom. The
# tutorial does not print the dimensions of the cut. The dimensions in the shipped file are fitted to two of the printed
# frequencies. The other frequencies are therefore a test to about one in 10⁵. The first frequency is 3 in 10⁴ below the
# print, for an unknown reason.

# %%
fine = shipped("pf3d19dof")
modes = fm.modes(fine)
figure = fm.plot.modes(modes, [0, 1, 2, 4])
for number, value in enumerate((10.6469, 148.5680, 252.1481, 270.9347, 619.9492)):
    print(f"mode {number + 1}: {modes.frequencies[number]:9.4f} Hz, printed {value:9.4f}")

# %% [markdown]
# The model with one degree of freedom is sufficient for the transfer from the actuator to the stage. The Bode plots of
# both models are almost equal (figure 4.8 of the tutorial), because the actuator excites none of the other modes.

# %%
hertz = np.geomspace(1, 1000, 1500)
fine_system = fm.to_statespace(fine)
figure, ax = plt.subplots(layout="constrained")
for label, state_space, output, style in (("19 DOF", fine_system, "2", "-"), ("1 DOF", system, "2", "--")):
    row = state_space.output_labels.index(f"position 3 {output}")
    response = state_space[row, 0](2j * np.pi * hertz)
    ax.loglog(hertz, np.abs(response), style, label=label)
ax.set_xlabel("frequency [Hz]")
ax.set_ylabel("position of node 3 per force [m/N]")
ax.grid(visible=True, alpha=0.3)
ax.legend()
plt.show()

# %% [markdown]
# ## All printed numbers
#
# The allowed difference is half a unit of the last printed digit. The frequencies of section 4.2 are the exception
# described above.

# %%
for what, (number, digits, found) in printed.items():
    print(f"{what:<28}{number:>10.{digits}f}{float(found):>14.{digits + 2}f}")
    assert abs(float(found) - number) <= 0.5000001 * 10.0**-digits, what
assert np.allclose(modes.frequencies[1:5], [148.5680, 252.1481, 270.9347, 619.9492], rtol=5e-5)
assert np.allclose([in_python.parameters.reference[2], *fm.frequencies(in_python)], [0.1, *fm.frequencies(from_file)])
for a, c in ((one, one_file), (three, three_file), (space, space_file)):
    assert np.allclose(fm.frequencies(a), fm.frequencies(c), rtol=1e-9)
