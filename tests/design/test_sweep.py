"""Sweeps: the same numbers as one by one, failures beside the others, files, checkpoints, executors."""

import contextlib
import multiprocessing
import tracemalloc
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import jax
import numpy as np
import pytest
import scipy.io
from cases import design_cases, mechanisms
from cases.files import arrays_of
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar
from flexmb.design.evaluate import _is_of_libraries

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
    assert picked == approx(grid["first_frequency"][1, 1])


def test_files(grid, tmp_path):
    import scipy.io

    grid.save(tmp_path / "a.npz")
    np.testing.assert_array_equal(arrays_of(tmp_path / "a.npz")["first_frequency"], grid["first_frequency"])
    grid.save(tmp_path / "a.mat")
    np.testing.assert_array_equal(scipy.io.loadmat(tmp_path / "a.mat")["first_frequency"], grid["first_frequency"])
    with pytest.raises(ValueError, match=r"\.npz or \.mat"):
        grid.save(tmp_path / "a.csv")


@pytest.mark.parametrize("ending", ["npz", "mat"])
def test_a_saved_sweep_is_loaded(tmp_path, ending):
    grid = fm.design.grid({"a": [1.0, 2.0, 3.0], "wall thickness": [0.1, 0.2]})
    values = np.arange(12.0).reshape(6, 2)
    answers = {"pair": values, "f": np.where(values[:, 0] == 4, np.nan, values[:, 0])}
    codes = np.array([0, 0, 3, 0, 8, 0], np.int32)
    for designs in (grid, fm.design.Designs({"a": np.ones((6, 1)), "b": np.arange(6)})):
        path = tmp_path / f"sweep.{ending}"
        fm.design.Sweep(designs, answers, codes, {"f": "Hz"}).save(path)
        found = fm.design.Sweep.load(path)
        assert (found.units, found.failures()) == ({"f": "Hz"}, {"not_converged": 1})
        np.testing.assert_equal(found.answers, answers)
        np.testing.assert_equal(dict(found.designs), dict(designs))
        np.testing.assert_equal(found.axes, designs.axes)


def test_other_files_are_no_sweep(tmp_path, monkeypatch):
    # Long names of folders are shortened in messages.
    monkeypatch.chdir(tmp_path)
    np.savez(tmp_path / "other.npz", a=[1.0])
    fm.design.Sweep(fm.design.grid(a=[1.0, 2.0]), {"f": np.ones(2)}, np.zeros(2), {}).save(tmp_path / "sweep.npz")
    whole = (tmp_path / "sweep.npz").read_bytes()
    (tmp_path / "cut.npz").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "flipped.npz").write_bytes(whole.replace("shapes".encode("utf-32-le"), "shapex".encode("utf-32-le")))
    (tmp_path / "study.toml").write_bytes(b"model = 'guide.dat'")
    (tmp_path / "nothing").write_bytes(b"")
    for path in tmp_path.iterdir():
        if path.name != "sweep.npz":
            with pytest.raises(ValueError, match=f"'{path.name}' is no sweep"):
                fm.design.Sweep.load(path.name)
    with pytest.raises(FileNotFoundError):
        fm.design.Sweep.load(tmp_path / "none")


def test_the_front_of_a_circle_and_of_a_simplex():
    """Of a quarter of a disk the arc is the front; of the points of a lattice those on x + y + z = 1."""
    r, phi = np.meshgrid(np.linspace(0.1, 1, 10), np.linspace(0, np.pi / 2, 13), indexing="ij")
    x, y = (r * np.cos(phi)).ravel(), (r * np.sin(phi)).ravel()
    codes = np.zeros(130, np.int32)
    # The best of all has no answer, another one failed.
    y[5], codes[120] = np.nan, 3
    pair = np.stack([np.where(np.arange(130) == 5, 9.0, x), y], axis=1)
    found = fm.design.Sweep(fm.design.Designs({"a": np.arange(130)}), {"pair": pair, "y": -y}, codes, {"y": "m"})
    front = found.pareto(minimize="y", maximize=["pair[0]"])
    assert front.left_out == 2
    np.testing.assert_array_equal(front.rows, [129, 128, 127, 126, 125, 124, 123, 122, 121, 119, 118, 117])
    np.testing.assert_allclose(np.hypot(*front["pair"][:9].T), 1, rtol=1e-15)
    assert "12 of 130 designs" in str(front)
    assert front.sweep["a"].tolist() == front.rows.tolist()
    lattice = np.stack(np.meshgrid(*[np.arange(11)] * 3), axis=-1).reshape(-1, 3)
    inside = lattice[lattice.sum(axis=1) >= 10]
    many = fm.design.Sweep(fm.design.Designs({"n": inside}), {}, np.zeros(len(inside)), {})
    best = many.pareto(minimize=["n[0]", "n[1]", "n[2]"])
    assert len(best) == 66
    assert np.all(best["n"].sum(axis=1) == 10)


def test_the_front_of_many_designs_in_no_order():
    """More than are compared at a time: by the definition, each with all others."""
    costs = np.random.default_rng(4).integers(0, 60, (1500, 2)).astype(float)
    made = fm.design.Sweep(fm.design.Designs({"n": np.arange(1500)}), {"cost": costs}, np.zeros(1500), {})
    better = np.all(costs[:, None] <= costs, axis=2) & np.any(costs[:, None] < costs, axis=2)
    found = made.pareto(minimize=["cost[0]", "cost[1]"])
    np.testing.assert_array_equal(np.sort(found.rows), np.flatnonzero(~better.any(axis=0)))


@pytest.mark.parametrize(
    ("call", "fault", "words"),
    [
        ({}, ValueError, "no criteria"),
        ({"minimize": "g"}, KeyError, "no answer or dimension 'g'"),
        ({"minimize": "f", "maximize": "f"}, ValueError, "'f' is given twice"),
        ({"minimize": "pair"}, ValueError, r"'pair\[0\]'"),
        ({"minimize": "pair[2]"}, KeyError, "no entry"),
        ({"minimize": "nothing"}, ValueError, "none of the 2 designs"),
    ],
)
def test_fronts_that_cannot_be(call, fault, words):
    answers = {"f": np.ones(2), "pair": np.ones((2, 2)), "nothing": np.full(2, np.nan)}
    with pytest.raises(fault, match=words):
        fm.design.Sweep(fm.design.grid(a=[1.0, 2.0]), answers, np.zeros(2), {}).pareto(**call)


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
    assert found["decay"][2] / found["decay"][0] == approx(2, rel=1e-6)


def test_sets_of_designs():
    cube = fm.design.latin_hypercube(8, seed=1, a=(0.0, 1.0), b=(10.0, 20.0))
    for name, low, width in (("a", 0.0, 1.0), ("b", 10.0, 10.0)):
        # One design in each of the eight slices.
        assert sorted(np.floor((cube[name] - low) / width * 8)) == list(range(8))
    np.testing.assert_array_equal(cube["a"], fm.design.latin_hypercube(8, seed=1, a=(0.0, 1.0), b=(10.0, 20.0))["a"])
    import scipy.stats

    drawn = fm.design.monte_carlo(2000, seed=2, a=scipy.stats.norm(3.0, 0.1), b=(1.0, 2.0))
    assert np.mean(drawn["a"]) == approx(3.0, abs=4 * 0.1 / np.sqrt(2000))  # four deviations of the mean
    assert 1.0 <= drawn["b"].min() < drawn["b"].max() <= 2.0
    for call, words in (
        (lambda: fm.design.latin_hypercube(3, a=(1.0, 1.0)), "Bounds of 'a' are empty"),
        (lambda: fm.design.monte_carlo(0, a=(1.0, 2.0)), "at least 1"),
        (lambda: fm.design.grid(a=[]), "Axis 'a'"),
        (lambda: fm.design.Designs({"a": [1, 2], "b": [1]}), "a 2, b 1"),
    ):
        with pytest.raises(ValueError, match=words):
            call()


def double(value):
    return 2 * value


def twice(made):
    return 2.0 * made


def cache_in_use():
    return jax.config.values["jax_compilation_cache_dir"]


@pytest.mark.parametrize("ending", ["npz", "mat"])
def test_a_file_that_unpacks_to_much_more_is_refused_before(tmp_path, ending):
    path, zeros = tmp_path / f"a.{ending}", {"a": np.zeros(2**23)}
    if ending == "npz":
        np.savez_compressed(path, **zeros)
    else:
        scipy.io.savemat(path, zeros, do_compression=True)
    assert path.stat().st_size < 2**17
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match="unpacks to more than 100 times its size"):
            fm.design.Sweep.load(path)
        # The content of the file, and pieces of one MB.
        assert tracemalloc.get_traced_memory()[1] < 2**23
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("ending", ["npz", "mat"])
def test_a_sweep_that_was_packed_is_loaded(grid, tmp_path, ending):
    grid.save(path := tmp_path / f"a.{ending}")
    if ending == "npz":
        with np.load(path) as file:
            np.savez_compressed(path, **dict(file))
    else:
        own = {name: array for name, array in scipy.io.loadmat(path).items() if not name.startswith("__")}
        scipy.io.savemat(path, own, do_compression=True, long_field_names=True)
    np.testing.assert_array_equal(fm.design.Sweep.load(path)["first_frequency"], grid["first_frequency"])


@pytest.mark.slow
def test_an_executor_gives_the_same(grid):
    with ThreadPoolExecutor(2) as pool:
        found = fm.sweep(design_cases.unloaded_guide, first_frequency, grid.designs, chunk=4, executor=pool)
    np.testing.assert_allclose(found["first_frequency"], grid["first_frequency"], rtol=1e-12)


@pytest.mark.filterwarnings("ignore")
def test_a_pool_that_forks_is_refused():
    with ProcessPoolExecutor(1, multiprocessing.get_context("fork")) as pool:
        with pytest.raises(ValueError, match=r"forked processes.*get_context\('spawn'\)"):
            fm.sweep(double, {"twice": twice}, {"value": [1.0, 2.0]}, compiled=False, executor=pool)


@pytest.mark.slow
@pytest.mark.parametrize("usable", [True, False])
def test_processes_use_the_cache_where_they_can(tmp_path, usable):
    folder = tmp_path / "cache"
    folder.mkdir() if usable else folder.write_text("no folder")
    before = cache_in_use()
    jax.config.update("jax_compilation_cache_dir", str(folder))
    try:
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
            found = fm.sweep(double, {"twice": twice}, {"value": [1.0, 2.0]}, compiled=False, executor=pool)
            used = pool.submit(cache_in_use).result()
    finally:
        jax.config.update("jax_compilation_cache_dir", before)
    np.testing.assert_array_equal(found["twice"], [4.0, 8.0])
    assert used == (str(folder) if usable else None)


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


@pytest.mark.slow
def test_a_bar_says_how_far_a_sweep_is(capsys):
    fm.sweep(
        lambda a: a, lambda a: 2 * a, fm.design.grid(a=np.arange(1.0, 6.0)), compiled=False, chunk=2, progress=True
    )
    printed = capsys.readouterr()
    assert "designs" in printed.err
    assert "5/5" in printed.err
    assert printed.out == ""


def long_cantilever(thickness):
    b = fm.Builder()
    section = fm.Rectangle(0.02, thickness, fm.Material(E=210e9, G=80e9, rho=7850.0))
    for i in range(41):
        b.node(f"n{i}", (i / 400, 0.0))
    for i in range(40):
        b.add(planar.beam, f"n{i}", f"n{i + 1}", section=section)
    b.fix("n0")
    b.force("n40", (0.0, 1e-6))
    return b.build(check=False)


SPARSE = {
    "frequency": lambda m: fm.frequencies(m, count=1, sparse=True)[0],
    "place": lambda m: fm.equilibrium(m, sparse=True).position("n40")[1],
}


def known_of_long(thickness):
    """Closed forms of its first frequency [Hz] and of where the force puts its end [m]."""
    stiffness = 210e9 * 0.02 * thickness**3 / 12
    hertz = 1.8751040687**2 / (2 * np.pi * 0.1**2) * np.sqrt(stiffness / (7850 * 0.02 * thickness))
    return hertz, 1e-6 * 0.1**3 / (3 * stiffness)


@pytest.mark.slow
def test_answers_of_large_mechanisms_in_sweeps():
    """By sparse factors on the host, under the trace of a sweep."""
    thickness = np.array([2e-4, 4e-4])
    swept = fm.sweep(long_cantilever, SPARSE, fm.design.grid(thickness=thickness.tolist()))
    hertz, place = known_of_long(thickness)
    np.testing.assert_allclose(swept["place"], place, rtol=1e-6)
    # Rotary inertia, which the closed form leaves out: 3e-6 of the thicker one.
    np.testing.assert_allclose(swept["frequency"], hertz, rtol=5e-6)


@pytest.mark.slow
def test_answers_of_large_mechanisms_in_searches():
    """By sparse factors on the host, under the trace of a search."""
    target = {"frequency": 1.5 * float(known_of_long(2e-4)[0])}
    found = fm.tune(long_cantilever, SPARSE, {"thickness": 2e-4}, {"thickness": (1e-4, 1e-3)}, targets=target)
    assert found.dimensions["thickness"] == approx(3e-4, rel=5e-6)


@pytest.mark.slow
def test_derivatives_of_large_mechanisms_in_one_program():
    """By sparse factors on the host, under the trace of a derivative."""
    place = known_of_long(2e-4)[1]
    slope = fm.jit(jax.grad(lambda thickness: SPARSE["place"](long_cantilever(thickness))))(2e-4)
    np.testing.assert_allclose(slope, -3 * place / 2e-4, rtol=1e-6)


def cosine(height):
    return np.cos(height)


def by_number(how):
    def build(height):
        known = {"numpy": cosine, "float": float, "if": lambda of: of if of > 0 else 0.1}[how](height)
        return mechanisms.planar_guide(T * known).build()

    return build


@pytest.mark.parametrize("how", ["numpy", "float", "if"])
def test_what_needs_the_number_of_a_dimension_is_told_by_its_line(how):
    line = {"numpy": r"return np.cos\(height\)", "float": "known = ", "if": "known = "}[how]
    words = rf"The function of dimensions 'build' needs the number of a dimension in line \d+ of test_sweep.py \({line}"
    answers = {"f": lambda model: fm.frequencies(model)[0]}
    for ask in (
        lambda build: fm.sweep(build, answers, {"height": np.array([0.9, 1.0])}),
        lambda build: fm.sensitivities(build, answers, {"height": 1.0}),
    ):
        with pytest.raises(TypeError, match=words):
            ask(by_number(how))
    named = {"f": lambda model: float(fm.frequencies(model)[0])}
    with pytest.raises(TypeError, match=r"Answer 'f' needs the number of a dimension in line \d+ of test_sweep.py"):
        fm.sensitivities(lambda height: mechanisms.planar_guide(T * height).build(), named, {"height": 1.0})


def test_files_of_libraries_are_told_from_those_of_users():
    package = Path(fm.__file__).parent
    for file in (package / "errors.py", contextlib.__file__, np.__file__, "<string>"):
        assert _is_of_libraries(str(file))
    for file in (__file__, package.with_name("flexmb_designs") / "mine.py"):
        assert not _is_of_libraries(str(file))
