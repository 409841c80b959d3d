# %% [markdown]
# # No more model than the question needs
#
# **Question.** How many degrees of freedom does a model of a guide need, for a controller that acts up to 100 Hz, and
# for one that acts up to 200 Hz?
#
# A fine model of a guide has tens of degrees of freedom, and most of them do not matter for a question. An expert fixes
# deformations that do not matter and gives reasons. `fm.lean` does the same, with a bound on the error.

# %%
import matplotlib.pyplot as plt
import numpy as np

import flexmb as fm
from flexmb.mechanisms import mechanism_path

fm.enable_x64()
cache = fm.enable_cache(thorough=False)

# %% [markdown]
# ## The fine model
#
# The guide of the tutorial (WA 1239, 2012, section 4.2) with all deformations free. It has two leaf springs. One is
# partly cut, so that it bends sideways too and the guide is exactly constrained. The whole leaf spring consists of two
# beams, the cut one of three.

# %%
fine = fm.read_spacar(mechanism_path("pf3d19dof")).builder.build()
ax = fm.plot.mechanism(fine)
print(f"{fine.topology.n_q} degrees of freedom; frequencies [Hz]:", np.round(fm.frequencies(fine)[:4], 2))

# %% [markdown]
# ## Up to 100 Hz
#
# `fm.lean` takes the frequencies that matter and the allowed error. Its result prints what it left out, and an estimate
# of the error in frequencies, stiffness and frequency responses.

# %%
slow = fm.lean(fine, bandwidth=100.0, tolerance=0.01)
print(slow)

# %% [markdown]
# One degree of freedom, as in section 4.1 of the tutorial. The result is an ordinary model for every analysis.
#
# ## Up to 200 Hz
#
# In this band the cut leaf spring vibrates, at 148.6 Hz.

# %%
fast = fm.lean(fine, bandwidth=200.0, tolerance=0.01)
print(fast)

# %% [markdown]
# The frequency responses of all three, from the force on the stage to its position along it:

# %%
hertz = np.geomspace(5, 400, 600)
row = [s.name for s in fine.labels.outputs].index("position 5.2")
responses = {}
figure, ax = plt.subplots(layout="constrained")
for label, model, style in (("fine", fine, "-"), ("up to 100 Hz", slow.model, "--"), ("up to 200 Hz", fast.model, ":")):
    system = fm.to_statespace(model)
    responses[label] = system(2j * np.pi * hertz)[row].ravel()
    count = model.topology.n_q
    shown = f"{label}: {count} degree{'s' if count > 1 else ''} of freedom"
    ax.loglog(hertz, np.abs(responses[label]), style, label=shown)
ax.set_xlabel("frequency [Hz]")
ax.set_ylabel("response [m/N]")
ax.grid(visible=True, alpha=0.3)
ax.legend()
plt.show()

# %% [markdown]
# Here all three agree, since the drive hardly excites the vibration of the cut leaf spring. `fm.lean` keeps it because
# it lies in the band, where a shaking ground or a sensor elsewhere may excite or see it.
#
# ## A model that is too lean
#
# `fm.design.too_lean` finds what a model lacks for a question: here the inner vibrations of leaf springs that are one
# beam each.

# %%
coarse = fm.read_spacar(mechanism_path("pf3d")).builder.build()
for reason in fm.design.too_lean(coarse, bandwidth=200.0):
    print(reason)

# %% [markdown]
# ## What the numbers are compared with
#
# The tutorial's own frequencies are 10.647 Hz for the guide, and 148.57 Hz for the vibration of the cut leaf spring. An
# expert would take one and two degrees of freedom.

# %%
printed = np.array([10.6469, 148.568])
assert slow.model.topology.n_q == 1
assert fast.model.topology.n_q == 2
assert slow.error.worst <= 0.01
assert fast.error.worst <= 0.01
assert np.allclose(fm.frequencies(slow.model), printed[:1], rtol=0.01)
away = (hertz < 100) & (np.abs(hertz / printed[0] - 1) > 0.1)  # a tenth and more away from the resonance
assert np.max(np.abs(responses["up to 100 Hz"] / responses["fine"] - 1)[away]) < 0.01
assert np.allclose(fm.frequencies(fast.model), printed, rtol=0.01)
assert fm.design.too_lean(coarse, bandwidth=100.0) == ()
assert len(fm.design.too_lean(coarse, bandwidth=200.0)) == 2
