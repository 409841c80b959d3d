"""Energies, forces and power along the motion of an oscillator, and the file of it, against the closed form."""

import dataclasses
import json

import numpy as np
import pytest
from cases.files import arrays_of
from cases.motions import oscillation, sprung_mass
from references.balances import energy_rate

import flexmb as fm

STIFFNESS, DAMPING, MASS, FORCE, FALL, PRESTRESS = 90.0, 1.2, 0.4, 3.0, 2.0, 0.7
TIMES = np.linspace(0, 0.5, 6)
# Ten times the tolerance of a step, over some tens of steps, of displacements below 0.1 m and rates below 1 m/s.
ERROR = 1e-6


@pytest.fixture(scope="module")
def motion() -> fm.motion.Motion:
    """Under a constant force, gravity along the spring and a prestress."""
    b = sprung_mass(stiffness=STIFFNESS, damping=DAMPING, mass=MASS)
    b.force("mass", (FORCE, 0))
    b.gravity((FALL, 0))
    b.prestress("s", PRESTRESS)
    b.input("mass", "x", name="push")
    return fm.simulate(b.build(), TIMES, rtol=1e-9)


def expected() -> dict[str, np.ndarray]:
    load = FORCE + MASS * FALL - PRESTRESS
    x, v = oscillation(TIMES, STIFFNESS, DAMPING, MASS, load)
    sigma = STIFFNESS * x + DAMPING * v + PRESTRESS
    return {
        "kinetic": MASS * v**2 / 2,
        "elastic": STIFFNESS * x**2 / 2 + PRESTRESS * x,
        "potential": -(FORCE + MASS * FALL) * x,
        "power": -DAMPING * v**2,
        "x": x + 0.4,
        "xd": v,
        "xdd": (FORCE + MASS * FALL - sigma) / MASS,
        "e": x,
        "ed": v,
        "sigma": sigma,
        # What the wall pulls back by.
        "reactions": -sigma,
    }


@pytest.mark.slow
def test_a_prestress_that_grows_stores_energy_in_what_is_strained():
    b = sprung_mass(stiffness=STIFFNESS, damping=DAMPING, mass=MASS)
    b.force("mass", (FORCE, 0))
    b.prestress("s", PRESTRESS, increment=True)
    motion = fm.simulate(b.build(), TIMES, increment=lambda t: 2 * t, rtol=1e-9)
    seen = motion.observe()
    power = -DAMPING * seen.ed[:, 0] ** 2 + 2 * PRESTRESS * seen.e[:, 0]
    np.testing.assert_allclose(seen.power, power, rtol=1e-12, atol=1e-15)  # round-off
    # Round-off of the energy over the step of the differences, which are exact but for that.
    np.testing.assert_allclose(energy_rate(motion, 1e-3), seen.power, atol=1e-9 * np.max(np.abs(power)))


@pytest.mark.slow
def test_what_is_observed_of_an_oscillator(motion):
    seen, places = motion.observe(), {"xdd": "mass", "reactions": "foot"}
    for name, values in expected().items():
        if name in ("x", "xd"):
            continue
        found = np.asarray(getattr(seen, name))
        if found.ndim == 2:
            found = found[:, motion.labels.known(places[name])[0]] if name in places else found[:, 0]
        np.testing.assert_allclose(found, values, atol=ERROR * np.max(np.abs(values)) * 10, err_msg=name)
    np.testing.assert_allclose(seen.energy, seen.kinetic + seen.elastic + seen.potential, rtol=1e-12)


@pytest.mark.slow
def test_the_file_of_a_motion_has_it_all(motion, tmp_path):
    fm.save_motion(motion, tmp_path / "run.npz")
    kept = arrays_of(tmp_path / "run.npz")
    np.testing.assert_array_equal(kept["t"], TIMES)
    x, e = kept["x_names"].tolist(), kept["e_names"].tolist()
    assert x == ["foot.x", "foot.y", "mass.x", "mass.y"]
    assert e == ["s.e1"]
    # Nothing moves the input: it has no column, and no name.
    assert (kept["u"].shape, kept["u_names"].tolist()) == ((len(TIMES), 0), [])
    column = {"x": x.index("mass.x"), "xd": 2, "xdd": 2, "e": 0, "ed": 0, "sigma": 0, "reactions": x.index("foot.x")}
    for name, values in expected().items():
        found = kept[name][:, column[name]] if name in column else kept[name]
        np.testing.assert_allclose(found, values, atol=ERROR * np.max(np.abs(values)) * 10, err_msg=name)
    about = json.loads(str(kept["about"]))
    assert set(about["units"]) == {"t", "u", *expected()}
    assert (about["units"]["sigma"], about["units"]["power"]) == ("N, N m", "W")
    assert (about["form"], about["solver"], about["result"]) == ("coordinates", "Rodas5P", "successful")
    assert about["steps"] == int(motion.steps)


@pytest.mark.slow
def test_the_file_names_the_inputs_of_a_controller(motion, tmp_path):
    fm.save_motion(dataclasses.replace(motion, u=np.ones((len(TIMES), 1))), tmp_path / "run.npz")
    kept = arrays_of(tmp_path / "run.npz")
    assert (kept["u"].shape, kept["u_names"].tolist()) == ((len(TIMES), 1), ["push"])


@pytest.mark.slow
def test_times_that_were_not_reached_are_not_in_the_file(motion, tmp_path):
    found = fm.simulate(motion.model, TIMES, rtol=1e-9, max_steps=20, throw=False)
    fm.save_motion(found, tmp_path / "run.npz")
    kept = arrays_of(tmp_path / "run.npz")
    assert 1 <= len(kept["t"]) < len(TIMES)
    assert all(len(kept[name]) == len(kept["t"]) for name in ("x", "xd", "kinetic", "sigma"))
    assert all(np.all(np.isfinite(kept[name])) for name in ("x", "xd", "kinetic", "sigma"))
    assert json.loads(str(kept["about"]))["result"] == "motion_unfinished"
