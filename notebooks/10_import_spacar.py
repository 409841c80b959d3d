# %% [markdown]
# # Import a SPACAR or SPACAR Light model
#
# **Question.** I have an input file of SPACAR, or a script of SPACAR Light. What must I change, and do I get the same
# numbers?
#
# flexmb reads a `.dat` file without changes. A SPACAR Light script is MATLAB, so you retype its lines in Python; names
# and meaning stay. Both return an ordinary model for every analysis of flexmb.

# %%
import tempfile
from pathlib import Path

import numpy as np

import flexmb as fm

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# ## An input file
#
# `fm.read_spacar` takes a path or the text itself. Numbers may be arithmetic expressions of parameters in braces, so
# that an old file becomes a design study. This is the planar guide of the tutorial (WA 1239, 2012, section 3.1) with
# its thickness as parameter:

# %%
text = """
PLBEAM 1 1 2 3 4        % left leaf spring: positions 1 and 3, rotations 2 and 4
PLBEAM 2 3 4 5 6        % bar
PLBEAM 3 5 6 7 8        % right leaf spring
X 1 0 0
X 3 0 0.1
X 5 0.1 0.1
X 7 0.1 0
FIX 1
FIX 2
FIX 7
FIX 8
RLSE 1 2 3
RLSE 3 2 3
DYNX 3 1
END
HALT
XM 3 0.103
XM 5 0.103
EM 1 {7850*0.018*t}
EM 3 {7850*0.018*t}
ESTIFF 1 {210e9*0.018*t} {210e9*0.018*t**3/12}
ESTIFF 3 {210e9*0.018*t} {210e9*0.018*t**3/12}
END
END
VISUALIZATION
BEAMPROPS 1 3
"""


def from_file(t):
    return fm.read_spacar(text, numbers={"t": t}).builder.build(dofs="named")


read = fm.read_spacar(text, numbers={"t": 0.5e-3})
print("read without effect:", *read.warnings, sep="\n  ")
model = from_file(0.5e-3)
print("frequency [Hz]:", fm.frequencies(model))
ax = fm.plot.mechanism(model, names=True)

# %% [markdown]
# Nodes and elements have their numbers as names. Nothing is ignored silently: `warnings` names drawing keywords, and
# one error lists all mistakes with line and keyword.

# %%
try:
    fm.read_spacar(text.replace("RLSE 3 2 3", "RLSE 3 2 5").replace("FIX 8", "FIX 9"), numbers={"t": 0.5e-3})
except fm.SpacarError as error:
    print(error)

# %% [markdown]
# You can add to the builder before you build it, and write it as a file by `fm.write_spacar`. A model from a file has
# the same features as one from Python, including derivatives:

# %%
sensitivities = fm.sensitivities(from_file, {"frequency": lambda model: fm.frequencies(model)[0]}, {"t": 0.5e-3})
print(sensitivities)
with tempfile.TemporaryDirectory() as folder:
    fm.write_spacar(read, Path(folder) / "guide.dat")
    written = (Path(folder) / "guide.dat").read_text()
print(*written.splitlines()[:6], "...", sep="\n")

# %% [markdown]
# ## A SPACAR Light script
#
# In MATLAB one writes `nprops(1).fix = true; eprops(1).elems = [1 3];`. In Python the lines differ only by `True`,
# commas and `fm.spacar.StructArray`. A guide in space with two beams per leaf spring first moves to −5 mm (initial
# load), then to +5 mm (increment):

# %%
nodes = [[0, 0, 0], [0, 0.1, 0], [0.05, 0.1, 0], [0.05, 0, 0]]
elements = [[1, 2], [2, 3], [3, 4]]
nprops, eprops, opt = fm.spacar.StructArray(), fm.spacar.StructArray(), fm.spacar.Struct()
nprops(1).fix = True
nprops(4).fix = True
nprops(2).displ_initial_x = -5e-3
nprops(2).displ_x = 10e-3
eprops(1).elems = [1, 3]
eprops(1).emod, eprops(1).smod, eprops(1).dens = 210e9, 80e9, 7800
eprops(1).cshape, eprops(1).dim, eprops(1).orien = "rect", [50e-3, 0.5e-3], [0, 0, 1]
eprops(1).nbeams = 2
eprops(1).flex = [1, 2, 3, 4, 5, 6]
eprops(2).elems = 2
eprops(2).dens, eprops(2).cshape, eprops(2).dim, eprops(2).orien = 2700, "rect", [50e-3, 25e-3], [0, 0, 1]
opt.loadsteps = 5

out = fm.spacar.spacar_light(nodes, elements, nprops, eprops, opt)
ax = fm.plot.mechanism(out.model, at=out.linearizations[-1])

# %% [markdown]
# The results have the names of SPACAR Light. Since the drive holds x, the frequencies belong to the other motions.

# %%
position = np.array([float(out.step(i + 1).node(3).p[0]) for i in range(out.load_factors.shape[1])])
support = 1 / np.asarray(out.node(3).CMglob[1, 1, :])
for x, stiffness, hertz in zip(position - 0.05, support, out.freq[0], strict=True):
    print(f"stroke {1e3 * x:6.2f} mm: support stiffness {stiffness * 1e-6:7.3f} N/μm, first frequency {hertz:7.2f} Hz")

# %% [markdown]
# ## An ordinary model
#
# `fm.spacar.spacar_light_model` takes the same arguments and returns the model alone. Here the script has no drive, so
# the guide is free to move, and the code computes the drive stiffness.

# %%
undriven = fm.spacar.StructArray()
undriven(1).fix = True
undriven(4).fix = True
free = fm.spacar.spacar_light_model(nodes, elements, undriven, eprops, opt)
drive = float(fm.stiffness(free, "n3", "x"))
print(f"drive stiffness {drive:.3f} N/m; frequencies {np.round(fm.frequencies(free)[:3], 2)} Hz")

# %% [markdown]
# ## What the numbers are compared with
#
# *The file.* The tutorial prints 10.6448 Hz. *The script.* In the middle of its stroke the guide carries a load by
# tension of two leaf springs. The load on node 3 is above one of them, so the stiffness there is $EA/l$ of this leaf
# spring. The drive stiffness of two leaf springs clamped at both ends is $24EI/l^3$.

# %%
nearest = int(np.argmin(np.abs(position - 0.05)))
tension = 210e9 * 50e-3 * 0.5e-3 / 0.1
sway = 24 * 210e9 * 50e-3 * 0.5e-3**3 / 12 / 0.1**3
print(f"EA/l = {tension * 1e-6:.3f} N/μm, 24 EI/l³ = {sway:.3f} N/m")
assert round(float(fm.frequencies(model)[0]), 4) == 10.6448
assert abs(position[nearest] - 0.05) < 1e-9
assert abs(support[nearest] / tension - 1) < 0.01
assert abs(drive / sway - 1) < 1e-3
