"""Measured modes paired by shape, measured responses from arrays and files."""

import diffrax
import numpy as np
import pytest

import flexmb as fm
from flexmb import planar

MASS = 2.0
SENSORS = ("left.x", "right.x")


def carts(left, right, between=0.0):
    """Two masses on springs of their own, and a weak spring between them."""
    b = fm.Builder()
    for name, place in {"wall": 0, "left": 1, "right": 2, "end": 3}.items():
        b.node(name, (place, 0))
    for p, q, stiffness in (("wall", "left", left), ("left", "right", between), ("right", "end", right)):
        b.add(planar.truss, p, q, name=f"{p} to {q}", section=fm.Rigidity(EA=stiffness))
    for name in ("wall", "end"):
        b.fix(name)
    for name in ("left", "right"):
        b.fix(name, "y")
        b.mass(name, MASS)
        b.dof(name, "x")
    b.input("left", "x")
    b.output("right", "x")
    return b.build()


def damped_carts(left, right, between, damping):
    b = fm.Builder()
    for name, place in {"wall": 0, "left": 1}.items():
        b.node(name, (place, 0))
    b.add(planar.truss, "wall", "left", name="rod", section=fm.Rigidity(EA=left), damping=fm.Damping(EA=damping))
    b.fix("wall")
    b.fix("left", "y")
    b.mass("left", MASS)
    b.dof("left", "x")
    b.input("left", "x")
    b.output("left", "x")
    return b.build()


def cart_frequency(stiffness):
    return np.sqrt(stiffness / MASS) / (2 * np.pi)


@pytest.mark.slow
def test_modes_are_paired_by_their_shapes_where_they_cross():
    truth = {"left": 300.0, "right": 100.0}
    hertz = [cart_frequency(truth["left"]), cart_frequency(truth["right"])]
    # At the start the cart on the right is the stiffer one: numbers would pair each with the other.
    start, bounds = {"left": 150.0, "right": 200.0}, {"left": (10.0, 1000.0), "right": (10.0, 1000.0)}

    def build(left, right):
        return carts(left, right, 1e-3)

    data = fm.measured_modes(hertz, 1e-3, shapes=np.eye(2), at=SENSORS)
    found = fm.fit(build, data, start, bounds)
    assert found.parameters["left"] == pytest.approx(truth["left"], rel=1e-4)
    assert found.parameters["right"] == pytest.approx(truth["right"], rel=1e-4)
    by_number = fm.fit(build, fm.measured_modes(sorted(hertz), 1e-3), start, bounds)
    assert by_number.parameters["left"] == pytest.approx(truth["right"], rel=1e-4)


@pytest.mark.slow
def test_a_shape_without_partner_is_refused_by_its_number():
    b = {"left": (10.0, 1000.0), "right": (10.0, 1000.0)}
    # Both shapes move the cart on the left.
    data = fm.measured_modes([1.5, 2.0], 1e-3, shapes=[[1.0, 1.0], [0.0, 0.1]], at=SENSORS)
    with pytest.raises(ValueError, match=r"Mode 2 of measurement 'frequencies', 2 Hz, has no partner"):
        fm.fit(lambda left, right: carts(left, right, 1e-3), data, {"left": 100.0, "right": 300.0}, b)
    wrong = fm.measured_modes([1.5], 1e-3, shapes=[[1.0]], at=["middle.x"])
    with pytest.raises(KeyError, match=r"no coordinate 'middle\.x' for a sensor"):
        fm.fit(lambda left: carts(left, 100.0, 1e-3), wrong, {"left": 100.0}, {"left": (10, 1000)})
    with pytest.raises(ValueError, match="2 frequencies and 1 sensors"):
        fm.measured_modes([1.0, 2.0], 1e-3, shapes=np.eye(2), at=["left.x"])


@pytest.mark.slow
def test_shapes_are_not_paired_with_modes_of_an_unsymmetric_stiffness():
    """Its frequencies are those of poles: a symmetric solver of modes would be wrong by a quarter under this force."""
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (1, 0))
    b.add(planar.beam, "foot", "tip", name="beam", section=fm.Rigidity(EA=1e4, EIy=1.0, mass=1.0))
    b.fix("foot")
    b.force("tip", (-6.0, 0), follower=True)
    data = fm.measured_modes([0.7], 0.1, shapes=[[1.0]], at=["tip.y"])
    with pytest.raises(NotImplementedError, match="stiffness is unsymmetric"):
        data.answer(b.build())


def test_a_mode_beyond_the_last_is_refused():
    data = fm.measured_modes([1.5], 1e-3, numbers_of_modes=[3])
    with pytest.raises(ValueError, match="'frequencies' has mode 3, but the model has 2 modes"):
        fm.fit(lambda left: carts(left, 100.0, 1e-3), data, {"left": 100.0}, {"left": (10, 1000)})


def test_a_magnitude_and_a_complex_deviation_are_no_parts_of_a_response():
    hertz, response = np.array([1.0, 2.0]), np.array([1 - 1j, -0.5 - 0.1j])
    with pytest.warns(fm.FlexmbWarning, match="'response' is real and positive at all frequencies, like a magnitude"):
        fm.measured_response(hertz, np.abs(response), 0.1)
    with pytest.raises(ValueError, match="'response': deviations"):
        fm.measured_response(hertz, response, 0.1 * response)


@pytest.mark.parametrize("logarithmic", [False, True])
def test_a_response_gives_stiffness_damping_gain_and_delay(logarithmic):
    truth = {"stiffness": 200.0, "damping": 1.0, "gain": 1.1, "delay": 2e-3}
    hertz = np.linspace(0.2, 4.0, 60)
    s = 2j * np.pi * hertz
    clean = truth["gain"] * np.exp(-s * truth["delay"]) / (MASS * s**2 + truth["damping"] * s + truth["stiffness"])
    deviation = 0.01 * np.abs(clean)
    rng = np.random.default_rng(0)
    noisy = clean + deviation * (rng.standard_normal(60) + 1j * rng.standard_normal(60))
    data = fm.measured_response(hertz, noisy, deviation, gain="gain", delay="delay", logarithmic=logarithmic)
    start = {"stiffness": 160.0, "damping": 0.8, "gain": 1.0, "delay": 0.0}
    bounds = {"stiffness": (20, 2000), "damping": (0.01, 10), "gain": (0.5, 2), "delay": (-0.01, 0.01)}
    found = fm.fit(lambda stiffness, damping: damped_carts(stiffness, 1, 1, damping), data, start, bounds)
    assert found.result is fm.RESULTS.successful
    for name, value in truth.items():
        # Four deviations of a normal distribution: missed once in 16 000.
        assert abs(found.parameters[name] - value) < 4 * found.deviation[name]
        assert found.deviation[name] < 0.02 * value + 1e-4
    if logarithmic:
        # Other responses would be taken for logarithms of ratios.
        with pytest.raises(ValueError, match="'response' is logarithmic: flexmb compares"):
            found.again(np.concatenate([noisy.real, noisy.imag])[None])


def test_parameters_of_a_measurement_alone():
    readings = np.array([1.3, 1.32])
    data = fm.measured(lambda model, offset: fm.frequencies(model)[:2] + offset, readings, 0.01)
    found = fm.fit(lambda: carts(100.0, 100.0), data, {"offset": 0.0}, {"offset": (-1.0, 1.0)})
    assert found.parameters["offset"] == pytest.approx(np.mean(readings) - cart_frequency(100.0), rel=1e-9)
    assert found.deviation["offset"] == pytest.approx(0.01 / np.sqrt(2), rel=1e-9)
    with pytest.raises(ValueError, match=r"Dimension 'left' of .* is not given"):
        fm.fit(carts, data, {"offset": 0.0}, {"offset": (-1.0, 1.0)})


@pytest.mark.slow
def test_a_time_history_gives_stiffness_and_damping():
    truth, force, times = {"stiffness": 200.0, "damping": 1.0}, 10.0, np.linspace(0.0, 3.0, 40)
    decay = truth["damping"] / (2 * MASS)
    rate = np.sqrt(truth["stiffness"] / MASS - decay**2)
    swing = np.exp(-decay * times) * (np.cos(rate * times) + decay / rate * np.sin(rate * times))
    noisy = 1 + force / truth["stiffness"] * (1 - swing) + 1e-4 * np.random.default_rng(0).standard_normal(40)

    def history(model):
        # A fit differentiates forward.
        motion = fm.simulate(
            model, times, loads={"left.x": lambda time: force + 0 * time}, adjoint=diffrax.ForwardMode()
        )
        return motion.position("left", "x")

    data = fm.measured(history, noisy, 1e-4, over=times, label="time [s]")
    start, bounds = {"stiffness": 160.0, "damping": 0.8}, {"stiffness": (20, 2000), "damping": (0.01, 10)}
    found = fm.fit(lambda stiffness, damping: damped_carts(stiffness, 1, 1, damping), data, start, bounds)
    assert found.result is fm.RESULTS.successful
    for name, value in truth.items():
        # Four deviations of a normal distribution: missed once in 16 000.
        assert abs(found.parameters[name] - value) < 4 * found.deviation[name]
        assert found.deviation[name] < 0.01 * value


def test_a_displacement_gives_a_temperature():
    def rod(warming):
        steel = fm.Material(E=210e9, G=80e9, rho=7850, alpha=12e-6)
        b = fm.Builder()
        b.node("wall", (0, 0))
        b.node("end", (1, 0))
        b.add(planar.truss, "wall", "end", name="rod", section=fm.Rectangle(0.01, 0.01, steel))
        b.fix("wall")
        b.fix("end", "y")
        b.temperature("rod", warming)
        b.dof("end", "x")
        return b.build()

    found = fm.fit(rod, {"displacement end.x": (6e-4, 6e-6)}, {"warming": 20.0}, {"warming": (-100.0, 200.0)})
    # Displacement over length and coefficient of expansion. The elongation relates to the undeformed length.
    assert found.parameters["warming"] == pytest.approx(50.0, rel=1e-6)
    assert found.deviation["warming"] == pytest.approx(0.5, rel=1e-6)


@pytest.mark.filterwarnings("ignore:The model does not fit the data:flexmb.FlexmbWarning")
@pytest.mark.parametrize("logarithmic", [False, True])
def test_a_poor_fit_of_a_response_advises_logarithms(logarithmic):
    s = 2j * np.pi * np.linspace(0.2, 4.0, 20)
    clean = 1 / (MASS * s**2 + s + 200.0)
    data = fm.measured_response(s.imag / (2 * np.pi), clean, 0.01 * np.abs(clean), logarithmic=logarithmic)
    # The stiffness is wrong, and fixed.
    found = fm.fit(lambda damping: damped_carts(160.0, 1, 1, damping), data, {"damping": 0.8}, {"damping": (0.1, 10)})
    assert found.result is fm.RESULTS.poor_fit
    assert ("logarithmic=True) has fewer local minima" in found.reason) is not logarithmic


def test_bad_responses_are_refused_by_name():
    with pytest.raises(ValueError, match="3 frequencies and 2 values"):
        fm.measured_response([1.0, 2.0, 3.0], [1.0, 2.0])
    with pytest.raises(ValueError, match="not finite, number 2 of 3"):
        fm.measured_response([1.0, 2.0, 3.0], [1.0, np.nan, 1.0])
    with pytest.raises(ValueError, match="has no logarithm"):
        fm.measured_response([1.0, 2.0], [0.0, 1.0], logarithmic=True)


@pytest.mark.parametrize("logarithmic", [False, True])
def test_a_response_in_another_unit_is_refused(logarithmic):
    s = 2j * np.pi * np.linspace(0.2, 4.0, 20)
    millimetres = 1000 / (MASS * s**2 + s + 200.0)
    data = fm.measured_response(s.imag / (2 * np.pi), millimetres, 1e-3, logarithmic=logarithmic)
    with pytest.raises(ValueError, match=r"'response' are about 1e\+03 times the values that the model computes"):
        fm.fit(lambda left: damped_carts(left, 1, 1, 1.0), data, {"left": 200.0}, {"left": (20, 2000)})
