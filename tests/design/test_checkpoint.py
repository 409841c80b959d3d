"""Checkpoints: a sweep goes on where it ended, and from nothing that is not its own."""

import itertools
import json
import warnings
from concurrent.futures import Executor, Future

import numpy as np
import pytest
from cases.disk import full, not_regular

import flexmb as fm
from flexmb.design.checkpoint import MAGIC, Checkpoint, _packed, _record

DESIGNS = fm.design.grid(size=np.linspace(1.0, 2.0, 8))
FACTOR = 3.0


class Hidden:
    """An answer whose meaning no code shows."""

    def __init__(self, factor):
        self.factor = factor

    def __call__(self, made):
        return self.factor * made


def scaled(made):
    return FACTOR * made


def build(size):
    return size**2


def stop_at(count):
    def stop(done, _):
        if done >= count:
            raise KeyboardInterrupt

    return stop


def begun(path, answers=None, made=build, designs=DESIGNS, *, until=4, **options):
    """A sweep that was interrupted after some designs."""
    with pytest.raises(KeyboardInterrupt):
        fm.sweep(made, answers or {"a": scaled}, designs, **run(path, progress=stop_at(until), **options))


def run(path, **options):
    return {"compiled": False, "chunk": 2, "checkpoint": path, **options}


def test_an_unfinished_sweep_goes_on(tmp_path):
    path, calls, built = tmp_path / "sweep", [], []

    def note(size):
        built.append(float(size))
        return size**2

    begun(path, made=note)
    first = list(built)
    built.clear()
    found = fm.sweep(
        note, {"a": scaled}, DESIGNS, **run(path, progress=lambda done, count: calls.append((done, count)))
    )
    assert calls == [(6, 8), (8, 8)]
    # Each once; the first a second time before, for its model, and what is stored when the sweep goes on.
    sizes = DESIGNS["size"].tolist()
    assert first == [sizes[0], *sizes[:4]]
    assert built == [sizes[0], *sizes[:4:3], *sizes[4:]]
    np.testing.assert_array_equal(found["a"], FACTOR * DESIGNS["size"] ** 2)
    # The designs may be divided otherwise.
    again = fm.sweep(note, {"a": scaled}, DESIGNS, **run(path, chunk=5))
    np.testing.assert_array_equal(again["a"], found["a"])


def test_a_full_disk_is_told_with_the_name_of_the_file(tmp_path):
    path = tmp_path / "sweep"
    begun(path)
    with full(path.stat().st_size), pytest.raises(OSError, match=r"File too large: '.*/sweep'"):
        fm.sweep(build, {"a": scaled}, DESIGNS, **run(path))
    found = fm.sweep(build, {"a": scaled}, DESIGNS, **run(path))
    np.testing.assert_array_equal(found["a"], FACTOR * DESIGNS["size"] ** 2)
    for special in not_regular(tmp_path, ""):
        with pytest.raises(OSError, match="it is no regular file"):
            fm.sweep(build, {"a": scaled}, DESIGNS, **run(special))
        with pytest.raises(OSError, match="it is no regular file"):
            fm.design.Sweep.load(special)


def test_answers_in_any_order_go_on(tmp_path):
    path, answers = tmp_path / "sweep", {"b": scaled, "a": lambda made: made + 0.0}
    fm.sweep(build, answers, DESIGNS, checkpoint=path)
    again = fm.sweep(build, answers, DESIGNS, checkpoint=path)
    np.testing.assert_array_equal(again["b"], FACTOR * again["a"])


def test_the_file_only_grows(tmp_path):
    path, seen = tmp_path / "sweep", []
    fm.sweep(build, {"a": scaled}, DESIGNS, **run(path, progress=lambda *_: seen.append(path.read_bytes())))
    assert all(later.startswith(earlier) for earlier, later in itertools.pairwise(seen))
    assert len({len(later) - len(earlier) for earlier, later in itertools.pairwise(seen)}) == 1


class Backwards(Executor):
    """Does what was submitted in the reverse order, when all of it is known."""

    def __init__(self, count):
        self.count, self.waiting = count, []

    def submit(self, fn, /, *args, **kwargs):
        self.waiting.append((future := Future(), fn, args))
        if len(self.waiting) == self.count:
            for waiting, function, arguments in reversed(self.waiting):
                waiting.set_result(function(*arguments))
        return future


def test_chunks_may_come_in_any_order(tmp_path):
    path = tmp_path / "sweep"
    begun(path, until=2, executor=Backwards(4))
    found = fm.sweep(build, {"a": scaled}, DESIGNS, **run(path))
    np.testing.assert_array_equal(found["a"], FACTOR * DESIGNS["size"] ** 2)


def tuned(length, width=0.018):
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (0, length))
    leaf = fm.Rectangle(width, 5e-4, fm.Material(E=210e9, G=80e9, rho=7850))
    b.add(fm.planar.beam, "foot", "tip", section=leaf, released=(2, 3))
    b.fix("foot")
    return b.build()


def with_width(width):
    return lambda length: tuned(length, width)


LENGTHS = {"length": np.linspace(0.1, 0.2, 6)}


def nth(i):
    return lambda model: fm.frequencies(model)[i]


@pytest.mark.parametrize(
    ("what", "change"),
    [
        ("the designs", {"designs": {"length": np.linspace(0.1, 0.2001, 6)}}),
        ("the names of answers", {"answers": {"g": nth(0)}}),
        ("the meaning of answer 'f'", {"answers": {"f": nth(1)}}),
        ("the meaning of answer 'f'", {"answers": {"f": lambda model: fm.frequencies(model)[0] * 2}}),
        ("the model or a fixed parameter", {"build": with_width(0.02)}),
        ("the function that builds it", {"build": with_width(0.02)}),
        ("`compiled`", {"compiled": False}),
    ],
)
def test_a_checkpoint_of_another_sweep_is_refused(tmp_path, what, change):
    path = tmp_path / "sweep"
    begun(path, {"f": nth(0)}, with_width(0.018), LENGTHS, until=2, compiled=True)
    before = path.read_bytes()
    call = {
        "build": with_width(0.018),
        "answers": {"f": nth(0)},
        "designs": LENGTHS,
        **run(path, compiled=True),
        **change,
    }
    with pytest.raises(ValueError, match=f"Checkpoint '.*sweep' belongs to another sweep, .*{what}"):
        fm.sweep(call.pop("build"), call.pop("answers"), call.pop("designs"), **call)
    assert path.read_bytes() == before


@pytest.mark.slow
def test_the_same_functions_made_anew_go_on(tmp_path):
    path = tmp_path / "sweep"
    begun(path, {"f": nth(0)}, with_width(0.018), LENGTHS, until=2, compiled=True)
    found = fm.sweep(with_width(0.018), {"f": nth(0)}, LENGTHS, **run(path, compiled=True))
    # A cantilever without mass at its tip but for its own: as the inverse square of its length, with its thickness
    # over its length squared, 1e-5, of rotary inertia.
    np.testing.assert_allclose(found["f"] * LENGTHS["length"] ** 2, found["f"][0] * 0.01, rtol=1e-4)


def test_what_no_code_shows_is_found_by_computing_again(tmp_path, monkeypatch):
    path = tmp_path / "sweep"
    begun(path, {"a": Hidden(2.0)})
    for other in (Hidden(2.0 * (1 + 1e-5)), Hidden(np.array([2.0, 2.0])), Hidden(np.nan)):
        with pytest.raises(ValueError, match="belongs to another sweep"):
            fm.sweep(build, {"a": other}, DESIGNS, **run(path))
    # Within round-off it goes on.
    found = fm.sweep(build, {"a": Hidden(2.0 * (1 + 1e-9))}, DESIGNS, **run(path))
    np.testing.assert_allclose(found["a"], 2 * DESIGNS["size"] ** 2, rtol=1e-8)
    path = tmp_path / "of a global"
    begun(path)
    monkeypatch.setattr(f"{__name__}.FACTOR", 4.0)
    with pytest.raises(ValueError, match="meaning of answer 'a'"):
        fm.sweep(build, {"a": scaled}, DESIGNS, **run(path))


def test_designs_that_failed_are_compared_too(tmp_path):
    path = tmp_path / "sweep"

    def refuses(limit):
        holder = Hidden(limit)

        def made(size):
            if size < holder.factor:
                raise fm.ModelError("too small")
            return size

        return made

    begun(path, made=refuses(1.2))
    with pytest.raises(ValueError, match="other codes today"):
        fm.sweep(refuses(0.0), {"a": scaled}, DESIGNS, **run(path))
    found = fm.sweep(refuses(1.2), {"a": scaled}, DESIGNS, **run(path))
    np.testing.assert_array_equal(np.isnan(found["a"]), DESIGNS["size"] < 1.2)


def test_no_damage_gives_another_number(tmp_path):
    path, expected = tmp_path / "sweep", FACTOR * DESIGNS["size"] ** 2
    begun(path)
    whole, outcomes = path.read_bytes(), set()
    cut = [whole[:n] for n in range(0, len(whole), 7)]
    flipped = [whole[:n] + bytes([whole[n] ^ 1 << n % 8]) + whole[n + 1 :] for n in range(0, len(whole), 5)]
    for content in [whole, *cut, *flipped, b"PK\3\4", b"model = 'guide.dat'\n", whole + b"x", whole + whole]:
        path.write_bytes(content)
        try:
            found, said = gone_on(path)
        except ValueError as fault:
            outcomes.add(str(fault).startswith(f"Checkpoint '{path}' is ") and path.read_bytes() == content)
        else:
            outcomes.add("went on" if not said else "incomplete" in str(said[0].message) and "went on after a kill")
            np.testing.assert_array_equal(found["a"], expected)
            np.testing.assert_array_equal(gone_on(path)[0]["a"], expected)
    assert outcomes == {True, "went on", "went on after a kill"}


def gone_on(path):
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        return fm.sweep(build, {"a": scaled}, DESIGNS, **run(path)), said


def test_one_that_was_made_by_hand_is_refused(tmp_path):
    path = tmp_path / "sweep"
    begun(path, until=2)
    rows, codes = np.array([0, 1]), np.zeros(2, "<i4")
    for named in (
        {"codes": codes, "answer a": np.zeros(2)},
        {"": rows, "answer a": np.zeros(2)},
        {"": rows, "codes": codes, "answer b": np.zeros(2)},
        {"": rows, "codes": codes, "answer a": np.zeros(3)},
        {"": rows, "codes": codes + 99, "answer a": np.zeros(2)},
        {"": rows + 99, "codes": codes, "answer a": np.zeros(2)},
        {"": rows, "codes": codes.astype("<f8"), "answer a": np.zeros(2)},
        {"": rows[:0], "codes": codes[:0], "answer a": np.zeros(0)},
    ):
        content = _record(_packed(named))
        path.write_bytes(path.read_bytes() + content)
        with pytest.raises(ValueError, match=r"record 2 (has wrong|is not as|has other)"):
            fm.sweep(build, {"a": scaled}, DESIGNS, **run(path))
        path.write_bytes(path.read_bytes().removesuffix(content))
    said = {"meaning": {"the designs": "others"}, "answers": ["a"], "units": {}}
    path.write_bytes(MAGIC + _record(json.dumps(said).encode()) + _record(_packed({"dimension size": np.ones(8)})))
    with pytest.raises(ValueError, match="belongs to another sweep"):
        fm.sweep(build, {"a": scaled}, DESIGNS, **run(path))


def test_two_sweeps_do_not_write_the_same(tmp_path):
    pytest.importorskip("fcntl")
    path = tmp_path / "sweep"
    with Checkpoint(path, {}, DESIGNS, ["a"], {}), pytest.raises(ValueError, match="being written by another"):
        Checkpoint(path, {}, DESIGNS, ["a"], {})
    Checkpoint(path, {}, DESIGNS, ["a"], {}).close()


def test_what_was_begun_in_vain_leaves_nothing(tmp_path):
    path = tmp_path / "sweep"
    with pytest.raises(AssertionError):
        fm.sweep(build, {"a": _unwanted}, DESIGNS, **run(path))
    assert not path.exists()
    # One design that was computed is kept.
    with pytest.raises(KeyboardInterrupt):
        fm.sweep(build, {"a": scaled}, DESIGNS, **run(path, chunk=1, progress=stop_at(1)))
    assert path.exists()


def test_where_nothing_can_be_written_nothing_is_computed(tmp_path):
    for path in (tmp_path / "none" / "sweep", tmp_path):
        with pytest.raises(OSError, match=str(tmp_path)):
            fm.sweep(build, {"a": _unwanted}, DESIGNS, **run(path))


def _unwanted(made):
    raise AssertionError


def test_an_unfinished_sweep_is_loaded(tmp_path):
    path = tmp_path / "sweep"
    begun(path, units={"a": "Hz"})
    before = path.read_bytes()
    with pytest.warns(fm.FlexmbWarning, match="4 of 8 designs"):
        found = fm.design.Sweep.load(path)
    np.testing.assert_array_equal(found["size"], DESIGNS["size"][:4])
    np.testing.assert_array_equal(found["a"], FACTOR * DESIGNS["size"][:4] ** 2)
    assert (found.units, found.failures(), path.read_bytes()) == ({"a": "Hz"}, {}, before)
    fm.sweep(build, {"a": scaled}, DESIGNS, **run(path))
    found = fm.design.Sweep.load(path)
    np.testing.assert_array_equal(found.axes["size"], DESIGNS["size"])
    np.testing.assert_array_equal(found["a"], FACTOR * DESIGNS["size"] ** 2)
    path.write_bytes(path.read_bytes()[:-9] + b"x" + path.read_bytes()[-8:])
    with pytest.raises(ValueError, match=r"Checkpoint '.*sweep' is damaged: its record 4"):
        fm.design.Sweep.load(path)
