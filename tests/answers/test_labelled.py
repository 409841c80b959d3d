"""Results as arrays of xarray, tables of pandas and universal files: values, units, names, and the way back."""

import sys

import numpy as np
import pytest
from cases.mechanisms import planar_guide, spatial_guide

import flexmb as fm
from flexmb import planar
from flexmb.control import FrequencyResponse
from flexmb.errors import FlexmbWarning

xarray = pytest.importorskip("xarray")
pytest.importorskip("pandas")

HERTZ = np.linspace(0.5, 30.0, 60)


@pytest.fixture(scope="module")
def model():
    return planar_guide(force=(2.0, -1.0), elongation=True).build()


@pytest.fixture(scope="module")
def response():
    b = planar_guide()
    b.output("left1", "x", quantity="velocity")
    return fm.frequency_response(b.build(), HERTZ, loss_factor=0.02)


@pytest.mark.slow
def test_a_response_keeps_its_complex_numbers_names_and_units(response):
    data = response.to_xarray()
    assert data.response.dims == ("frequency", "output", "input")
    np.testing.assert_array_equal(data.response, response.response)
    np.testing.assert_array_equal(data.frequency, HERTZ)
    assert data.frequency.attrs["units"] == "Hz"
    assert np.iscomplexobj(data.response)
    assert np.any(data.response.values.imag)
    picked = data.response.sel(output="velocity left1.x", input="force right1.x")
    np.testing.assert_allclose(picked, 2j * np.pi * HERTZ * response.of("position left1.x"), rtol=1e-12)
    units = data.response_units.sel(input="force right1.x")
    assert [str(units.sel(output=name).item()) for name in ("position left1.x", "velocity left1.x")] == ["m/N", "m/s/N"]
    assert str(units.sel(output="position left1.phi").item()) == "rad/N"
    only = fm.frequency_response(planar_guide().build(), HERTZ, outputs="position left1.x", loss_factor=0.02)
    assert only.to_xarray().response.attrs["units"] == "m/N"


def test_a_response_as_a_table(response):
    frame = response.to_pandas()
    column = "response[position left1.x, force right1.x]"
    np.testing.assert_array_equal(frame["frequency"], HERTZ)
    np.testing.assert_array_equal(frame[column], response.of("position left1.x"))
    assert (frame.attrs["units"]["frequency"], frame.attrs["units"][column]) == ("Hz", "m/N")


def test_a_response_goes_through_a_universal_file(response, tmp_path):
    pyuff = pytest.importorskip("pyuff")
    response.save(tmp_path / "plant.uff")
    sets = pyuff.UFF(str(tmp_path / "plant.uff")).read_sets()
    assert [one["type"] for one in sets] == [164] + [58] * len(response.outputs)
    velocity = next(one for one in sets if one.get("id4") == "velocity left1.x")
    # Frequency response; response along x of a velocity, reference along x of a force: numbers of the format.
    named = "func_type rsp_dir ref_dir ordinate_spec_data_type orddenom_spec_data_type abscissa_spec_data_type"
    assert [velocity[name] for name in named.split()] == [4, 1, 1, 11, 13, 18]
    turned = next(one for one in sets if one.get("id4") == "position left1.phi")
    assert (turned["rsp_dir"], turned["rsp_node"] == velocity["rsp_node"]) == (6, True)
    assert velocity["rsp_node"] != velocity["ref_node"]
    # Twelve digits.
    largest = np.max(np.abs(response.of("velocity left1.x")))
    np.testing.assert_allclose(velocity["data"], response.of("velocity left1.x"), rtol=0, atol=1e-11 * largest)
    again = FrequencyResponse.load(tmp_path / "plant.uff")
    assert (again.outputs, again.inputs) == (response.outputs, response.inputs)
    np.testing.assert_array_equal(again.hertz, HERTZ)
    np.testing.assert_allclose(again.response, response.response, rtol=1e-11, atol=1e-11)
    assert list(again.to_xarray().response_units.values.ravel()) == list(
        response.to_xarray().response_units.values.ravel()
    )


def test_a_measured_response_is_read(tmp_path):
    pyuff = pytest.importorskip("pyuff")
    values = np.array([1.0 + 1j, 2.0 - 1j, 0.5j])
    one = pyuff.prepare_58(
        func_type=4, rsp_node=12, rsp_dir=-3, ref_node=7, ref_dir=1, data=values, x=np.array([1.0, 2.5, 7.0]),
        id1="hammer", rsp_ent_name="NONE", ref_ent_name="NONE", abscissa_spacing=0, binary=0,
        ordinate_spec_data_type=12, abscissa_spec_data_type=18, orddenom_spec_data_type=13,
    )  # fmt: skip
    pyuff.UFF(str(tmp_path / "measured.unv")).write_sets([one], "overwrite")
    found = FrequencyResponse.load(tmp_path / "measured.unv")
    assert (found.outputs, found.inputs) == (("12 -z",), ("7 x",))
    np.testing.assert_array_equal(found.hertz, [1.0, 2.5, 7.0])
    np.testing.assert_array_equal(found.of(), values)


def test_a_response_in_millimetres_is_read_in_si_units(tmp_path):
    """Data set 164: divided by the factors, numbers of the file are in SI units."""
    pyuff = pytest.importorskip("pyuff")
    units = {"type": 164, "units_code": 5, "units_description": "mm", "temp_mode": 1, "length": 1e3, "force": 1e3}
    units |= {"temp": 1.0, "temp_offset": 273.15}
    about = {"ref_node": 7, "ref_dir": 1, "rsp_node": 12, "x": np.array([1.0, 2.0]), "id1": "shaker", "binary": 0}
    about |= {"rsp_ent_name": "NONE", "ref_ent_name": "NONE", "abscissa_spacing": 1, "abscissa_spec_data_type": 18}
    values = np.array([1.0 + 1j, 2.0 - 1j])

    def loaded(output, direction, kind):
        one = pyuff.prepare_58(
            func_type=4, rsp_dir=direction, data=values, ordinate_spec_data_type=output, orddenom_spec_data_type=kind,
            **about,
        )  # fmt: skip
        pyuff.UFF(str(tmp_path / "mm.unv")).write_sets([units, one], "overwrite")
        return FrequencyResponse.load(tmp_path / "mm.unv").of()

    # mm/mN is m/N; rad/mN is 1e3 rad/N.
    np.testing.assert_allclose(loaded(8, 2, 13), values, rtol=1e-12)
    np.testing.assert_allclose(loaded(8, 6, 13), 1e3 * values, rtol=1e-12)
    np.testing.assert_allclose(loaded(13, 1, 12), values, rtol=1e-12)
    with pytest.raises(ValueError, match="is not in SI units and does not state the quantities of its signals"):
        loaded(0, 1, 13)


def test_universal_files_that_cannot_be(response, tmp_path):
    pytest.importorskip("pyuff")
    with pytest.raises(ValueError, match=r"\.uff, \.unv or \.csv"):
        response.save(tmp_path / "plant.txt")
    with pytest.raises(FileNotFoundError, match="nowhere"):
        response.save(tmp_path / "nowhere" / "plant.uff")
    (tmp_path / "empty.uff").write_text("nothing\n", encoding="ascii")
    with pytest.raises(ValueError, match=r"empty\.uff"):
        FrequencyResponse.load(tmp_path / "empty.uff")
    with pytest.raises(FileNotFoundError):
        FrequencyResponse.load(tmp_path / "missing.uff")
    uneven = fm.frequency_response(planar_guide().build(), [1.0, 2.0000001, 7.0])
    with pytest.warns(FlexmbWarning, match=r"2\.0000001 Hz becomes 2 Hz"):
        uneven.save(tmp_path / "uneven.uff")


@pytest.mark.slow
def test_a_path_goes_through_netcdf(model, tmp_path):
    path = fm.path(model)
    data = path.to_xarray()
    data.to_netcdf(tmp_path / "path.nc")
    with xarray.open_dataset(tmp_path / "path.nc") as kept:
        assert kept.attrs["result"] == "successful"
        np.testing.assert_array_equal(kept["load_factor"], path.load_factor)
        np.testing.assert_array_equal(kept["left1.y"], path.position("left1", "y"))
        np.testing.assert_array_equal(kept["left1.phi"], path.rotation("left1", "phi"))
        units = [kept[name].attrs["units"] for name in ("load_factor", "left1.y", "left1.phi")]
    assert units == ["1", "m", "rad"]
    assert data["left1.y"].dims == ("step",)
    asked = path.to_xarray("reaction left0.x", "frequency 1")
    np.testing.assert_array_equal(asked["reaction left0.x"], path.reaction("left0", "x"))
    np.testing.assert_allclose(asked["frequency 1"], path.frequencies[:, 0], rtol=1e-12)
    assert [asked[name].attrs["units"] for name in asked] == ["N", "Hz"]
    frame = path.to_pandas("reaction left0.x")
    assert list(frame.columns) == ["load_factor", "reaction left0.x"]
    assert frame.attrs["units"]["reaction left0.x"] == "N"
    with pytest.raises(KeyError, match="nowhere"):
        path.to_xarray("nowhere.x")


@pytest.mark.slow
def test_rotations_in_space_stand_about_the_axes():
    path = fm.path(spatial_guide(force=(0, 1.0, 0), extra=(5,)).build())
    data = path.to_xarray()
    for axis in ("rx", "ry", "rz"):
        np.testing.assert_array_equal(data[f"left1.{axis}"], path.rotation("left1", axis))
    assert np.ptp([data[f"left1.{axis}"][-1] for axis in ("rx", "ry", "rz")]) > 0
    assert data["left1.rx"].attrs["units"] == "rad"
    assert not [name for name in data.data_vars if "l0" in str(name) or "rotation" in str(name)]


@pytest.mark.slow
def test_a_motion_stands_over_time(model, tmp_path):
    times = np.linspace(0, 0.02, 5)
    motion = fm.simulate(model, times)
    data = motion.to_xarray("left1.x", "acceleration left1.x", "kinetic")
    data.to_netcdf(tmp_path / "motion.nc")
    with xarray.open_dataset(tmp_path / "motion.nc") as kept:
        np.testing.assert_array_equal(kept["time"], times)
        np.testing.assert_array_equal(kept["left1.x"].sel(time=0.01), motion.position("left1", "x")[2])
        np.testing.assert_array_equal(kept["acceleration left1.x"], motion.acceleration("left1", "x"))
        assert [kept[name].attrs["units"] for name in ("time", "acceleration left1.x", "kinetic")] == [
            "s",
            "m/s^2",
            "J",
        ]


@pytest.mark.slow
def test_strokes_and_modes(model):
    b = planar_guide(elongation=True, dofs=False)
    b.prescribe("left1", "x", 1.0, increment=True)
    strokes = np.array([0.0, 1e-3, 2e-3])
    found = fm.equilibria(b.build(), increment=strokes)
    data = found.to_xarray("left1.x", "reaction left1.x")
    np.testing.assert_array_equal(data["increment"], strokes)
    np.testing.assert_array_equal(data["reaction left1.x"], found.reaction("left1", "x"))
    with pytest.raises(KeyError, match="frequency 1"):
        found.to_xarray("frequency 1")
    modes = fm.modes(model)
    frame = modes.to_pandas("frequency")
    np.testing.assert_array_equal(frame["frequency"], modes.frequencies)
    assert list(frame["mode"]) == [1, 2, 3]
    with pytest.raises(KeyError, match="eigenvalue"):
        modes.to_pandas("stiffness")


@pytest.mark.slow
def test_stress_by_element_and_place(model):
    stress = fm.stress(model)
    data = stress.to_xarray("von Mises", "normal force")
    assert data["von Mises"].dims == ("element", "place")
    assert [data[name].attrs["units"] for name in data] == ["Pa", "N"]
    largest = float(data["von Mises"].max())
    assert largest == float(np.max(stress.von_mises))
    frame = stress.to_pandas("von Mises")
    assert list(frame.columns) == ["element", "place", "von Mises"]
    assert frame["von Mises"].max() == largest


@pytest.mark.parametrize("name", ["xarray", "pandas", "pyuff"])
def test_what_is_missing_is_named(model, response, tmp_path, monkeypatch, name):
    monkeypatch.setitem(sys.modules, name, None)
    ask = {
        "xarray": response.to_xarray,
        "pandas": response.to_pandas,
        "pyuff": lambda: response.save(tmp_path / "a.uff"),
    }
    with pytest.raises(ImportError, match=rf"{name}: pip install 'flexmb\[io\]'"):
        ask[name]()


@pytest.mark.slow
def test_noise_and_inputs_along_a_trajectory_have_names_and_units():
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("cart", (0.5, 0))
    b.add(planar.truss, "wall", "cart", section=fm.Rigidity(EA=200.0), damping=fm.Damping(EA=1.0))
    b.mass("cart", 4.0)
    b.fix("wall")
    b.fix("cart", "y")
    b.dof("cart", "x")
    b.input("cart", "x", name="push")
    b.output("cart", "x", quantity="velocity", name="speed")
    model = b.build()
    budget = fm.control.noise_budget(model, np.linspace(1, 3, 101), sources={"push": 1e-4})
    data = budget.to_xarray()
    assert data.density.dims == ("frequency", "output", "source")
    np.testing.assert_array_equal(data.density.sel(output="speed", source="push"), budget.spectrum("speed"))
    assert list(budget.to_pandas().columns) == ["frequency", "density[speed, push]", "below[speed, push]"]
    times = np.linspace(0, 0.5, 6)
    nominal = fm.trajectory.inverse_dynamics(model, {"cart.x": fm.trajectory.quintic(0.0, 0.01, 0.5)}, times)
    data = nominal.to_xarray()
    np.testing.assert_array_equal(data.nominal_input.sel(input="push"), nominal.u0[:, 0])
    assert data.nominal_input.attrs["units"] == "N"
    assert data.nominal_output.attrs["units"] == "m/s"
    assert list(data.freedom) == ["cart.x"]
    data = fm.trajectory.time_varying(nominal).to_xarray()
    assert list(data.rate) == [f"d/dt {name}" for name in data.state.values]
    np.testing.assert_allclose(data.A[0], [[0, 1], [-200.0 / 0.5 / 4, -1.0 / 0.5 / 4]], rtol=1e-12)


def test_a_response_as_columns(response, tmp_path):
    response.save(tmp_path / "plant.csv")
    table = np.genfromtxt(tmp_path / "plant.csv", delimiter=",", names=True, deletechars="", replace_space=" ")
    assert table.dtype.names[0] == "hertz"
    np.testing.assert_array_equal(table["hertz"], HERTZ)
    expected = response.of("velocity left1.x")
    np.testing.assert_array_equal(table["imaginary velocity left1.x by force right1.x"], expected.imag)
    one = FrequencyResponse(response.hertz, response.response[:, :1], response.outputs[:1], response.inputs)
    one.save(tmp_path / "one.csv")
    assert (tmp_path / "one.csv").read_text().splitlines()[0] == "hertz,real,imaginary"
    with pytest.raises(ValueError, match=r"ends in \.uff, \.unv or \.csv, not 'one\.mat'\. For other programs use"):
        one.save(tmp_path / "one.mat")
