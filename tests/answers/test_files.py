"""Files of arrays: every array under a name of its own, whatever the names are."""

import functools
import json

import numpy as np
import pytest
import scipy.io
from cases.files import arrays_of

import flexmb as fm
from flexmb.answers.answer_files import save
from flexmb.files import save_arrays

NAMES = [
    "f_1",
    "f.1",
    "f 1",
    "f-1",
    "f_1_2",
    "_hidden",
    "1st",
    "Länge",
    "file",
    "allow_pickle",
    "names of arrays",
    "a/b",
    "x" * 70 + "1",
    "x" * 70 + "2",
    "x" * 63,
    "[0]",
    "²",
]


def numbered(names):
    return {name: np.array([float(i), 1.0]) for i, name in enumerate(names)}


def test_npz_keeps_every_name(tmp_path):
    save_arrays(tmp_path / "a.npz", numbered(NAMES), {"units": {}})
    with np.load(tmp_path / "a.npz", allow_pickle=False) as found:
        assert sorted(found.files) == sorted([*NAMES, "about"])
        for name, array in numbered(NAMES).items():
            np.testing.assert_array_equal(found[name], array)


def test_mat_keeps_every_array(tmp_path):
    save_arrays(tmp_path / "a.mat", numbered(NAMES), {"units": {}})
    found = {n: v for n, v in scipy.io.loadmat(tmp_path / "a.mat").items() if not n.startswith("__")}
    meant = json.loads(found.pop("names_of_arrays")[0])
    found.pop("about")
    assert len(found) == len(NAMES)
    for name, array in numbered(NAMES).items():
        (own,) = [n for n in found if meant.get(n, n) == name]
        assert len(own) <= 63
        assert own.isidentifier()
        np.testing.assert_array_equal(found[own].ravel(), array)
    # What MATLAB takes as it is stays.
    assert {"f_1", "f_1_2", "file", "x" * 63} <= set(found)


def test_answers_of_the_command_line_too(tmp_path):
    data = {"x": {"3.a": [1.0], "3_a": [2.0]}, "status": "ok", "frequencies_hz": [1.0, None]}
    save(data, tmp_path / "a.mat")
    found = scipy.io.loadmat(tmp_path / "a.mat")
    values = {float(found[n][0, 0]) for n in found if n.startswith("x_3")}
    assert values == {1.0, 2.0}
    assert np.isnan(found["frequencies_hz"][1, 0])
    save(data, tmp_path / "a.npz")
    assert arrays_of(tmp_path / "a.npz")["x_3.a"] == 1.0


def test_what_is_said_about_all_is_not_written_over(tmp_path):
    with pytest.raises(ValueError, match="'about'"):
        save_arrays(tmp_path / "a.npz", {"about": np.zeros(1)}, {})
    assert not (tmp_path / "a.npz").exists()


def test_a_sweep_keeps_all_its_answers(tmp_path):
    names = ["f.1", "f_1", "file", "y" * 64, "y" * 65]
    functions = {name: functools.partial(np.multiply, i) for i, name in enumerate(names, 1)}
    found = fm.sweep(lambda a: a, functions, fm.design.grid(a=[1.0, 2.0]), compiled=False)
    found.save(tmp_path / "a.mat")
    kept = scipy.io.loadmat(tmp_path / "a.mat")
    meant = json.loads(kept["names_of_arrays"][0])
    for i, name in enumerate(names, 1):
        (own,) = [n for n in kept if meant.get(n, n) == name]
        np.testing.assert_array_equal(kept[own].ravel(), [i, 2 * i])


def test_labels_of_tables_do_not_meet():
    answers = {"f": lambda a: np.array([a, 2 * a]), "f[0]": lambda a: 3 * a, "f_0": lambda a: 4 * a}
    found = fm.sweep(lambda a: a, answers, {"a": [1.0, 2.0]}, compiled=False)
    frame = found.to_pandas()
    assert list(frame.columns) == ["a", "f[0]", "f[1]", "f[0]_", "f_0", "result"]
    np.testing.assert_array_equal([frame[name][1] for name in list(frame.columns)[:5]], [2, 2, 4, 6, 8])
    data = found.to_xarray()
    assert data["f"].dims == ("design", "f_0_")
    assert set(data.data_vars) == {"a", "f", "f[0]", "f_0", "result"}
