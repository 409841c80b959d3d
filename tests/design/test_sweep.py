"""Sweeps: the same numbers as one by one, failures beside the others, files, checkpoints, executors."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from cases import design_cases, mechanisms

import flexmb as fm

T = mechanisms.THICKNESS


def first_frequency(model):
    return fm.frequencies(model)[0]


def closed_form(t, w):
    """E1 [Hz]."""
    return np.sqrt(2 * 210e9 * w * t**3 / 0.1**3 / (0.206 + 26 / 35 * 7850 * w * t * 0.1)) / (2 * np.pi)


@pytest.fixture(scope="module")
def grid():
    designs = fm.design.grid(thickness=np.linspace(0.3e-3, 0.8e-3, 4), width=[0.01, 0.02])
    return fm.sweep(design_cases.unloaded_guide, first_frequency, designs, chunk=3, units={"first_frequency": "Hz"})


def test_grid_is_the_closed_form(grid):
    t, w = np.meshgrid(*grid.axes.values(), indexing="ij")
    assert grid["first_frequency"].shape == (4, 2)
    np.testing.assert_allclose(grid["first_frequency"], closed_form(t, w), rtol=1e-9)  # round-off times its condition
    assert not grid.failures()


def test_labels_go_to_pandas(grid):
    pytest.importorskip("pandas")
    frame = grid.to_pandas()
    assert list(frame.columns) == ["thickness", "width", "first_frequency", "result"]
    assert frame.attrs["units"] == {"first_frequency": "Hz"}
    np.testing.assert_array_equal(frame["first_frequency"], np.ravel(grid["first_frequency"]))
    assert set(frame["result"]) == {"successful"}


def test_labels_go_to_xarray(grid):
    pytest.importorskip("xarray")
    data = grid.to_xarray()
    assert data["first_frequency"].dims == ("thickness", "width")
    assert data["first_frequency"].attrs["units"] == "Hz"
    picked = float(data["first_frequency"].sel(width=0.02).isel(thickness=1))
    assert picked == pytest.approx(grid["first_frequency"][1, 1])


def test_files(grid, tmp_path):
    import scipy.io

    grid.save(tmp_path / "a.npz")
    np.testing.assert_array_equal(np.load(tmp_path / "a.npz")["first_frequency"], grid["first_frequency"])
    grid.save(tmp_path / "a.mat")
    np.testing.assert_array_equal(scipy.io.loadmat(tmp_path / "a.mat")["first_frequency"], grid["first_frequency"])
    with pytest.raises(ValueError, match=r"\.npz or \.mat"):
        grid.save(tmp_path / "a.csv")


def test_one_design_that_fails_stops_no_other():
    designs = {"thickness": [0.4e-3, -0.5e-3, 0.6e-3, np.nan]}
    found = fm.sweep(design_cases.loaded_guide, {"load": lambda m: fm.buckling_loads(m)[0]}, designs)
    assert [fm.RESULTS(c).name for c in found.codes[[0, 1, 2]]] == ["successful", "impossible_design", "successful"]
    assert found.codes[3] != fm.RESULTS.successful
    assert np.isnan(found["load"][[1, 3]]).all()
    # T3: 78.75 N at 0.5 mm, with the cube of the thickness.
    np.testing.assert_allclose(found["load"][[0, 2]], 78.75 * np.array([0.8, 1.2]) ** 3, rtol=1e-6)
    assert sum(found.failures().values()) == 2


def test_analyses_that_cannot_be_traced_go_one_by_one():
    def damped(model):
        return np.max(np.real(fm.poles(model)))

    def build(thickness, ratio):
        if thickness > 1:
            raise fm.ModelError("too thick")
        return mechanisms.planar_guide(thickness, ratio=ratio).build()

    designs = {"thickness": [T, 2.0, T], "ratio": [0.005, 0.005, 0.01]}
    found = fm.sweep(build, {"decay": damped}, designs, compiled=False)
    assert found.failures() == {"impossible_design": 1}
    # Closed form: decay = zeta sqrt(k/m0) with the damping of both leaf springs (T 2.15) halves and doubles with zeta.
    assert found["decay"][2] / found["decay"][0] == pytest.approx(2, rel=1e-6)


def test_sets_of_designs():
    cube = fm.design.latin_hypercube(8, seed=1, a=(0.0, 1.0), b=(10.0, 20.0))
    for name, low, width in (("a", 0.0, 1.0), ("b", 10.0, 10.0)):
        # One design in each of the eight slices.
        assert sorted(np.floor((cube[name] - low) / width * 8)) == list(range(8))
    np.testing.assert_array_equal(cube["a"], fm.design.latin_hypercube(8, seed=1, a=(0.0, 1.0), b=(10.0, 20.0))["a"])
    import scipy.stats

    drawn = fm.design.monte_carlo(2000, seed=2, a=scipy.stats.norm(3.0, 0.1), b=(1.0, 2.0))
    assert np.mean(drawn["a"]) == pytest.approx(3.0, abs=4 * 0.1 / np.sqrt(2000))  # four deviations of the mean
    assert 1.0 <= drawn["b"].min() < drawn["b"].max() <= 2.0
    for call, words in (
        (lambda: fm.design.latin_hypercube(3, a=(1.0, 1.0)), "Bounds of 'a' are empty"),
        (lambda: fm.design.monte_carlo(0, a=(1.0, 2.0)), "at least 1"),
        (lambda: fm.design.grid(a=[]), "Axis 'a'"),
        (lambda: fm.design.Designs({"a": [1, 2], "b": [1]}), "a 2, b 1"),
    ):
        with pytest.raises(ValueError, match=words):
            call()


def test_an_executor_gives_the_same(grid):
    with ThreadPoolExecutor(2) as pool:
        found = fm.sweep(design_cases.unloaded_guide, first_frequency, grid.designs, chunk=4, executor=pool)
    np.testing.assert_allclose(found["first_frequency"], grid["first_frequency"], rtol=1e-12)


@pytest.mark.filterwarnings("ignore")
def test_a_cluster_gives_the_same(grid):
    distributed = pytest.importorskip("distributed")
    # A worker is another process: functions are sent by value and compiled there.
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        found = fm.sweep(
            design_cases.unloaded_guide, first_frequency, grid.designs, chunk=4, executor=client.get_executor()
        )
    np.testing.assert_allclose(found["first_frequency"], grid["first_frequency"], rtol=1e-12)


def test_wrong_calls_name_the_dimension():
    with pytest.raises(ValueError, match="Dimension 'depth' is not one of unloaded_guide"):
        fm.sweep(design_cases.unloaded_guide, first_frequency, {"depth": [1.0]})
    with pytest.raises(ValueError, match="`chunk` must be at least 1"):
        fm.sweep(design_cases.unloaded_guide, first_frequency, {"thickness": [T]}, chunk=0)
    with pytest.raises(fm.ModelError, match="defined twice"):
        fm.sweep(lambda t: fm.Builder().node("a", (0, 0)) and _twice(), first_frequency, {"t": [1.0]})


def _twice():
    b = fm.Builder()
    b.node("a", (0, 0))
    b.node("a", (0, 0))


def test_a_bar_says_how_far_a_sweep_is(capsys):
    fm.sweep(
        lambda a: a, lambda a: 2 * a, fm.design.grid(a=np.arange(1.0, 6.0)), compiled=False, chunk=2, progress=True
    )
    printed = capsys.readouterr()
    assert "designs" in printed.err
    assert "5/5" in printed.err
    assert printed.out == ""
