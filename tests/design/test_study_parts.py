"""Every kind of answer that a study may ask for, of a cantilever, against the textbook."""

import numpy as np
import pytest
import scipy.linalg
from cases.tolerances import approx

from flexmb.design.study_file import read_study

L, W, T, E, RHO = 0.2, 0.02, 2e-3, 200e9, 8000.0
MASS, INERTIA, STRENGTH = 0.3, 4e-4, 5e8
# So small that they neither stiffen the beam nor turn its end: by 1e-4 rad, and a 1e-4 of the buckling load.
MOMENT = 1e-4 * E * W * T**3 / 12 / L
FORCE = 1e-4 * E * W * T**3 / 12 / L**2

OWN = f"""
import flexmb as fm

def arm(length):
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (length, 0))
    section = fm.Rectangle({W}, {T}, fm.Material(E={E}, G={E} / 2.6, rho={RHO}, strength={STRENGTH}), rotary=False)
    b.add(fm.planar.beam, "foot", "tip", name="arm", section=section, released=(2, 3))
    b.fix("foot")
    b.mass("tip", {MASS}, inertia={INERTIA})
    b.force("tip", ({-FORCE}, 0))
    b.force("tip.rotation", ({MOMENT},))
    return b.build()

def twice(model):
    return 2 * fm.mass(model)
"""

STUDY = f"""model = "own:arm"
[parameters]
length = {{ value = {L}, lower = 0.1, upper = 0.3 }}
[answers]
first = {{ frequency = 1 }}
second = {{ frequency = 2 }}
column = {{ load_multiplier = 1 }}
higher = {{ load_multiplier = 2 }}
mass = {{ mass = true }}
sway = {{ stiffness = "tip", axis = "y" }}
turn = {{ stiffness = "tip", axis = "phi" }}
raised = {{ coordinate = "tip", component = 2 }}
reached = {{ coordinate = "tip", component = 1 }}
stress = {{ stress = true }}
used = {{ utilisation = true }}
leaf = {{ stress = "arm" }}
moved = {{ displacement = true }}
along = {{ displacement = "tip", axis = "y" }}
bearing = {{ reaction = "foot", axis = "phi" }}
push = {{ force = "tip", axis = "x" }}
twist = {{ moment = "tip", axis = "phi" }}
bent = {{ deformation = "arm", number = 3 }}
normal = {{ stress_resultant = "arm", number = 1 }}
text = "stiffness tip.y"
own = "own:twice"
[tune]
minimize = "mass"
"""


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    (folder / "own.py").write_text(OWN)
    (folder / "study.toml").write_text(STUDY)
    return read_study(folder / "study.toml")


def expected():
    """Of one beam with cubic bending, whose mass and stiffness matrices are those of every textbook."""
    ei, m = E * W * T**3 / 12, RHO * W * T * L
    stiffness = ei / L**3 * np.array([[12, -6 * L], [-6 * L, 4 * L**2]])
    mass = m / 420 * np.array([[156, -22 * L], [-22 * L, 4 * L**2]]) + np.diag([MASS, INERTIA])
    # Geometric stiffness of a column under a unit of thrust.
    thrust = np.array([[36, -3 * L], [-3 * L, 4 * L**2]]) / (30 * L)
    hertz = np.sqrt(scipy.linalg.eigvalsh(stiffness, mass)) / (2 * np.pi)
    multipliers = scipy.linalg.eigvalsh(stiffness, thrust) / FORCE
    return {
        "first": hertz[0],
        "second": hertz[1],
        # 2.486 and 32.18 EI/L^2.
        "column": multipliers[0],
        "higher": multipliers[1],
        "mass": m + MASS,
        "sway": 3 * ei / L**3,
        "turn": ei / L,
        "raised": MOMENT * L**2 / (2 * ei),
        "reached": L,
        "stress": 6 * MOMENT / (W * T**2) + FORCE / (W * T),
        "used": (6 * MOMENT / (W * T**2) + FORCE / (W * T)) / STRENGTH,
        "leaf": 6 * MOMENT / (W * T**2) + FORCE / (W * T),
        "moved": MOMENT * L**2 / (2 * ei),
        "along": MOMENT * L**2 / (2 * ei),
        # The clamp holds against the moment at the tip.
        "bearing": -MOMENT,
        "push": -FORCE,
        "twist": MOMENT,
        "bent": -MOMENT * L**2 / (2 * ei),
        "normal": -FORCE,
        "text": 3 * ei / L**3,
        "own": 2 * (m + MASS),
    }


@pytest.mark.slow("first", "second")
@pytest.mark.filterwarnings("ignore:At the load multiplier")
@pytest.mark.parametrize("name", expected())
def test_answer(study, name):
    # What the small loads add is of their size.
    assert float(study.answers[name](study.build(length=L))) == approx(expected()[name], rel=1e-3, abs=0)


@pytest.mark.slow
def test_every_kind_is_asked_for():
    from flexmb.design.study_file import kinds

    assert all(f"{{ {kind} = " in STUDY for kind in kinds() if kind != "multiplier")
