"""Compiled programs are kept on disk, and nothing answers for another."""

import calendar
import collections
import dataclasses
import enum
import functools
import importlib.metadata
import logging
import os
import sys
import time
import types
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.interpolate
from cases.disk import full
from cases.tolerances import approx

import flexmb as fm
from flexmb import planar, setup, spatial
from flexmb.compilation import host, kept
from flexmb.compilation.compile import compile_thoroughly, jit
from flexmb.compilation.program import captured_of_time
from flexmb.elements.element import Element
from flexmb.linear import linearize
from flexmb.math import linear
from flexmb.mechanics.sparse_order import SparseOrder, order_of
from flexmb.model.model import Entry
from flexmb.motion import drive
from flexmb.motion.rosenbrock import Rodas5P


@pytest.fixture
def folder(tmp_path):
    """Where programs are kept, as with ``fm.enable_cache()``."""
    before = jax.config.values["jax_compilation_cache_dir"]
    fresh()
    compile_thoroughly(True, keep=True)
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    yield tmp_path / "programs"
    jax.config.update("jax_compilation_cache_dir", before)
    compile_thoroughly(False, keep=True)


def test_a_full_disk_keeps_no_part_of_a_program(tmp_path):
    path = tmp_path / "programs" / "name"
    with full(), pytest.raises(OSError, match="too large"):
        kept._write(path, b"x" * 10**5)
    assert list(path.parent.iterdir()) == []


def cantilever(element) -> fm.Model:
    b = fm.Builder()
    b.node("foot", (0, 0))
    b.node("tip", (0.1, 0))
    b.add(element, "foot", "tip", section=fm.Rectangle(0.018, 5e-4, fm.Material(210e9, 80e9, 7850.0)))
    b.fix("foot")
    b.mass("tip", 0.1)
    b.force("tip", (0.0, -1.0))
    return b.build()


def fresh() -> None:
    """What a new process starts with."""
    jax.clear_caches()


def names(folder) -> set[str]:
    return {file.name for file in folder.iterdir()} if folder.exists() else set()


@pytest.mark.slow
def test_a_second_process_takes_what_the_first_kept(folder, caplog):
    first = fm.linearize(cantilever(planar.spectral_beam(2)))
    before = names(folder)
    assert before
    fresh()
    with caplog.at_level(logging.DEBUG, "flexmb"):
        second = fm.linearize(cantilever(planar.spectral_beam(2)))
    assert before == names(folder)
    assert "traced" not in caplog.text
    assert second.matrices.symmetric
    for one, other in zip(jax.tree.leaves(first.matrices), jax.tree.leaves(second.matrices), strict=True):
        np.testing.assert_array_equal(one, other)


# A small function of the package, to be quick.
product = jit(linear.multiplied)
A, B = np.arange(4.0).reshape(2, 2), np.array([[1.0, 2.0], [3.0, 5.0]])


@pytest.mark.slow
def test_derivatives_and_batches_go_through(folder):
    np.testing.assert_array_equal(product(A, B), A @ B)
    assert len(names(folder)) == 1
    np.testing.assert_array_equal(jax.jacfwd(lambda s: product(s * A, B))(1.0), A @ B)
    np.testing.assert_array_equal(jax.grad(lambda s: jnp.sum(product(s * A, B)))(1.0), np.sum(A @ B))
    np.testing.assert_array_equal(jax.vmap(product)(np.stack([A, B]), np.stack([B, A])), [A @ B, B @ A])


def law_of(k):
    return lambda e, ed: k * e


def spring_of(law):
    b = fm.Builder()
    b.node("wall", (0, 0))
    b.node("cart", (1, 0))
    b.add(planar.spring_damper(law), "wall", "cart")
    b.fix("wall")
    b.fix("cart", "y")
    b.mass("cart", 1.0)
    b.force("cart", (1.0, 0.0))
    return b.build()


@pytest.mark.slow
def test_what_a_user_wrote_is_traced(folder):
    models = [spring_of(law_of(k)) for k in (10.0, 20.0)]
    before = names(folder)
    moved = [float(fm.equilibrium(model).at("cart")[0]) - 1 for model in models]
    assert moved == approx([0.1, 0.05], rel=1e-9)  # F/k
    amplitude = {"value": 2.0}.get
    assert float(jit(lambda x: amplitude("value") * x)(jnp.array(1.0))) == 2.0
    assert names(folder) == before


def law_of_text(text):
    """A law of a file whose text was changed: of the same name, file and line."""
    module = {"__name__": "my_laws"}
    exec(compile(f"def law(e, ed):\n    return {text}", "my_laws.py", "exec"), module)
    return module["law"]


@pytest.mark.slow
def test_a_law_whose_text_changed_is_not_answered_by_the_former_one(folder):
    for text, moved in (("10.0 * e", 0.1), ("20.0 * e", 0.05)):
        fresh()
        assert float(fm.equilibrium(spring_of(law_of_text(text))).at("cart")[0]) - 1 == approx(moved, rel=1e-9)


def test_laws_and_tables_of_time_can_be_known_in_another_process():
    law = fm.trajectory.quintic(0.0, 1.0, 0.5)
    for given, shape in ((law, ()), (drive.Table([0.0, 1.0], np.ones((2, 3))), (3,))):
        taken, found = captured_of_time(given)
        assert found == shape
        kept.as_nested_text(jax.tree.structure(taken))
    with pytest.raises(TypeError, match="cannot be known in another process"):
        kept.as_nested_text(jax.tree.structure(captured_of_time(lambda t: 2 * law(t))[0]))


# -- fifty ways to confuse it ---------------------------------------------------------------------------------------


class Amplitude:
    def __init__(self, value):
        self.value = value

    def __call__(self, t):
        return self.value * t

    def __repr__(self):
        return "Amplitude"


class Text(str):
    scale = 1.0


class Count(int):
    pass


class Number(float):
    pass


class Table(dict):
    pass


class Row(tuple):
    pass


class Matrix(np.ndarray):
    pass


class Pair(NamedTuple):
    a: int
    b: int


class Colour(enum.Enum):
    RED = 1


@dataclasses.dataclass(frozen=True)
class Likeness:
    of: str
    component: int
    symbol: str
    kind: str


class Own(Element):
    pass


Likeness.__module__, Likeness.__qualname__ = Entry.__module__, Entry.__qualname__


@jax.custom_jvp
def with_its_own_derivative(x):
    return x


def attributed(value):
    def function(t):
        return vars(function)["scale"] * t

    vars(function).update(scale=value)
    return function


def closing_over(value):
    return lambda t: value * t


def of_default(value):
    return lambda t, by=value: by * t


def recursive():
    def function(x):
        return function(x)

    return function


def of_package(code, **changes):
    """A function that says it is the package's."""
    function = types.FunctionType(code, changes.pop("globals", vars(linearize)), "linearize")
    for name, value in changes.items():
        setattr(function, name, value)
    return function


def renamed(function, like):
    return functools.wraps(like)(function)


def view(values, **kind):
    return np.asarray(values, **kind)


ENTRY = Entry("a", 1, "x", "position")
# Never known: of a user's, or with parts that cannot be seen.
REFUSED = [
    lambda t: t,
    closing_over(2.0),
    of_default(2.0),
    attributed(2.0),
    recursive(),
    renamed(lambda x: x, jnp.sin),
    renamed(lambda x: x, linearize.matrices),
    jax.jit(lambda x: x),
    with_its_own_derivative,
    np.frompyfunc(lambda x: x, 1, 1),
    np.vectorize(lambda x: x),
    functools.partial(jnp.add, 1.0),
    jax.tree_util.Partial(lambda x: x),
    {"a": 1.0}.get,
    [3.0, 1.0].index,
    Amplitude(1.0),
    Amplitude(1.0).__call__,
    Amplitude,
    Pair(1, 2),
    Pair,
    Colour.RED,
    Text("a"),
    Count(1),
    Number(1.0),
    Table(a=1),
    Row((1, 2)),
    np.zeros(2).view(Matrix),
    np.array([Amplitude(1.0)], object),
    np.ma.masked_array([1.0, 2.0], [False, True]),
    np.float64(1.0),
    jnp.ones(2),
    collections.OrderedDict(a=1),
    collections.Counter("ab"),
    collections.deque([1, 2]),
    {1, 2},
    frozenset([1]),
    range(3),
    slice(1),
    iter([1]),
    memoryview(b"ab"),
    bytearray(b"ab"),
    np.random.default_rng(0),
    scipy.interpolate.CubicSpline([0.0, 1.0, 2.0], [0.0, 1.0, 0.0]),
    os.environ,
    np,
    open(os.devnull, encoding="utf-8"),
    Likeness("a", 1, "x", "position"),
    Own(planar.beam.deformation),
    dataclasses.replace(planar.beam, stiffness=lambda *, ref: jnp.eye(3)),
    of_package((lambda x: x).__code__),
    of_package(linearize.matrices.__code__, globals=dict(vars(linearize))),
    of_package(linearize.matrices.__code__, globals={"__name__": "flexmb.linear.linearize"}),
    of_package(linearize.matrices.__code__, kept=closing_over(1.0)),
    10**6000,
    jax.random.key(0),
    jax.tree.structure(Pair(1, 2)),
    planar.spring_damper(lambda e, ed: e),
]
# Alike in print, equal, or both the package's, but not the same.
UNLIKE = [
    (1, 1.0),
    (1, True),
    (0.0, -0.0),
    ("1", 1),
    ("a", b"a"),
    (0.1, np.nextafter(0.1, 1.0).item()),
    ((1, 2), [1, 2]),
    ([1, [2]], [[1], 2]),
    (("ab", "c"), ("a", "bc")),
    ({"a": 1, "b": 2}, {"a": 2, "b": 1}),
    ({1: "a"}, {"1": "a"}),
    (None, "None"),
    (..., "Ellipsis"),
    (view([1, 2]), view([1, 2], dtype="int32")),
    (view([1.0, 2.0]), view([[1.0, 2.0]])),
    (view([1.0, 2.0]), view([1.0, np.nextafter(2.0, 3.0)])),
    (np.arange(2000.0), np.r_[np.arange(999.0), 0.0, np.arange(1000.0, 2000.0)]),
    (ENTRY, dataclasses.replace(ENTRY, component=2)),
    (ENTRY, tuple(vars(ENTRY).values())),
    (planar.beam, planar.truss),
    (planar.beam, spatial.beam),
    (planar.beam, dataclasses.replace(planar.beam, released=(1,))),
    (planar.spectral_beam(2), planar.spectral_beam(3)),
    (spatial.spectral_beam(2), spatial.spectral_beam(2, shear=True)),
    (linearize.matrices, linearize.matrices_at),
    (linearize.matrices, of_package(linearize.matrices_at.__code__)),
    (linearize.matrices, of_package(linearize.matrices.__code__, __defaults__=(1,))),
    (linearize.matrices, of_package(linearize.matrices.__code__, scale=2.0)),
    (of_package(linearize.matrices.__code__, scale=1.0), of_package(linearize.matrices.__code__, scale=2.0)),
    (jax.tree.leaves(Rodas5P()), jax.tree.leaves(Rodas5P(jumps=True))),
    (jax.tree.structure((1, 2)), jax.tree.structure([1, 2])),
    (jax.tree.structure({"a": 1}), jax.tree.structure({"b": 1})),
    (float, int),
    (Entry, Element),
]


@pytest.mark.parametrize("thing", REFUSED, ids=lambda thing: type(thing).__name__)
def test_what_cannot_be_known_has_no_description(thing):
    with pytest.raises((TypeError, ValueError, RecursionError, AttributeError)):
        kept.as_nested_text([thing])


@pytest.mark.parametrize(("one", "other"), UNLIKE)
def test_unlike_things_are_described_unlike(one, other):
    first, second = kept.as_nested_text([one]), kept.as_nested_text([other])
    assert repr(first) != repr(second)
    assert repr(kept.as_nested_text([one])) == repr(first)


def test_there_are_fifty_ways():
    assert len(REFUSED) + len(UNLIKE) >= 50


def test_settings_are_part_of_the_key(monkeypatch):
    before = repr(kept._surroundings())
    for name, value in {
        "jax_default_prng_impl": "rbg",
        "jax_threefry_partitionable": False,
        "jax_default_matmul_precision": "float32",
        "jax_numpy_dtype_promotion": "standard",
        "jax_debug_nans": True,
    }.items():
        old = getattr(jax.config, name)
        jax.config.update(name, value)
        try:
            assert repr(kept._surroundings()) != before, name
        finally:
            jax.config.update(name, old)
    assert repr(kept._surroundings()) == before
    with jax.default_matmul_precision("float32"):
        assert repr(kept._surroundings()) != before
    with monkeypatch.context() as patch:
        patch.setenv("EQX_ON_ERROR", "breakpoint")
        assert repr(kept._surroundings()) != before
    monkeypatch.setattr(jax, "default_backend", lambda: "another device")
    assert repr(kept._surroundings()) != before


def test_the_text_of_the_package_is_part_of_the_key(monkeypatch, tmp_path):
    room = tmp_path / "flexmb" / "room"
    room.mkdir(parents=True)
    monkeypatch.setattr(kept, "__file__", str(room / "kept.py"))
    texts = []
    for name, text in (("a.py", "x = 1"), ("a.py", "x = 2"), ("b.py", "x = 2"), ("note.txt", "x = 3")):
        for old in room.glob("*.py"):
            if name.endswith(".py"):
                old.unlink()
        (room / name).write_text(text)
        texts.append(kept._text.__wrapped__())
    assert len(set(texts[:3])) == 3
    assert texts[3] == texts[2]


def test_a_text_that_may_have_changed_since_it_was_read_is_not_known(monkeypatch):
    kept._surroundings()
    kept._refuse_changed.cache_clear()
    monkeypatch.setattr(kept, "begun", 0)
    with pytest.raises(TypeError, match=r"the text of flexmb\..* changed, maybe after it was read"):
        kept._surroundings()


@pytest.mark.parametrize("library", kept.LIBRARIES)
def test_versions_of_libraries_are_part_of_the_key(monkeypatch, library):
    before, version = kept._text.__wrapped__(), importlib.metadata.version
    monkeypatch.setattr(importlib.metadata, "version", lambda name: "another" if name == library else version(name))
    assert kept._text.__wrapped__() != before


@pytest.mark.slow
def test_a_number_is_kept_of_known_functions_alone(folder):
    def leap_years(first, last):
        """By what a new process knows, which remembers nothing."""
        return kept.remembered(calendar.leapdays)(first, last)

    # Leap years from 2000 to 2011.
    assert leap_years(2000, 2012) == 3
    (file,) = folder.iterdir()
    kept._write(file, b"5")
    assert leap_years(2000, 2012) == 5
    assert leap_years(2000, 2013) == 4
    file.write_bytes(b"5")
    assert leap_years(2000, 2012) == 3
    before = names(folder)
    assert kept.remembered(lambda first, last: last - first)(2000, 2012) == 12
    assert names(folder) == before


# -- files ----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_flipped_bit_is_noticed(folder):
    product(A, B)
    (file,) = folder.iterdir()
    whole, rng = file.read_bytes(), np.random.default_rng(0)
    for place in [0, 63, 64, 70, *rng.integers(0, len(whole), 16)]:
        damaged = bytearray(whole)
        damaged[place] ^= 1 << int(rng.integers(8))
        file.write_bytes(damaged)
        fresh()
        np.testing.assert_array_equal(product(A, B), A @ B)
        assert file.read_bytes() != damaged


@pytest.mark.parametrize("content", [b"", b"no program", b"\n\n", None])
def test_a_foreign_file_is_no_program(folder, content):
    product(A, B)
    (file,) = folder.iterdir()
    file.unlink()
    # A program for arguments of the same types.
    jit(linear.solved_by_factor)(A, B)
    (other,) = folder.iterdir()
    file.write_bytes(other.read_bytes() if content is None else content)
    foreign = file.read_bytes()
    fresh()
    np.testing.assert_array_equal(product(A, B), A @ B)
    assert file.read_bytes() != foreign


@pytest.mark.filterwarnings("ignore:Error writing persistent compilation cache")
def test_a_full_or_missing_place_falls_back_to_compiling(folder, monkeypatch, caplog):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    with caplog.at_level(logging.DEBUG, "flexmb"):
        np.testing.assert_array_equal(product(A, B), A @ B)
    assert "No space left" in caplog.text
    assert not names(folder)


def test_a_result_that_cannot_be_written_down_is_not_kept(folder, caplog):
    @functools.partial(jax.tree_util.register_dataclass, data_fields=["value"], meta_fields=["mark"])
    @dataclasses.dataclass
    class Marked:
        value: jax.Array
        mark: str

    program = jax.jit(lambda x: kept.call_kept(lambda x: Marked(2 * x, "twice"), ("something plain",), (x,)))
    with caplog.at_level(logging.DEBUG, "flexmb"):
        found = program(jnp.ones(2))
    assert "is not kept" in caplog.text
    assert not names(folder)
    assert found.mark == "twice"
    np.testing.assert_array_equal(found.value, [2.0, 2.0])


@pytest.fixture
def settings_restored(monkeypatch):
    names = (
        "jax_compilation_cache_dir",
        "jax_persistent_cache_min_compile_time_secs",
        "jax_persistent_cache_min_entry_size_bytes",
    )
    before = {name: jax.config.values[name] for name in names}
    yield
    for name, value in before.items():
        jax.config.update(name, value)
    compile_thoroughly(False, keep=True)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="owners and modes are those of POSIX")
@pytest.mark.parametrize("mode", [0o777, 0o720, 0o702])
def test_a_folder_that_others_can_write_into_is_refused(tmp_path, settings_restored, mode):
    tmp_path.chmod(mode)
    with pytest.raises(PermissionError, match="Others may write"):
        fm.enable_cache(tmp_path)
    tmp_path.chmod(0o755)
    fm.enable_cache(tmp_path)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="owners and modes are those of POSIX")
def test_a_folder_of_programs_that_others_can_write_into_is_refused(tmp_path, settings_restored):
    tmp_path.chmod(0o700)
    (tmp_path / "programs").mkdir()
    (tmp_path / "programs").chmod(0o777)
    with pytest.raises(PermissionError, match=r"Others may write code into '.*programs'"):
        fm.enable_cache(tmp_path)


def test_the_folder_of_programs_is_the_users_alone(folder):
    product(A, B)
    assert folder.stat().st_mode & 0o077 == 0


def test_a_folder_of_another_user_is_refused(tmp_path, settings_restored, monkeypatch):
    monkeypatch.setattr(os, "getuid", lambda: tmp_path.stat().st_uid + 1, raising=False)
    with pytest.raises(PermissionError, match="belongs to another user"):
        fm.enable_cache(tmp_path)


def test_a_new_folder_is_the_users_alone(tmp_path, settings_restored):
    assert fm.enable_cache(tmp_path / "a" / "b").stat().st_mode & 0o077 == 0


def test_the_oldest_files_go_first(tmp_path, settings_restored, monkeypatch):
    monkeypatch.setattr(setup, "LARGEST_CACHE", 250)
    (tmp_path / "programs").mkdir()
    (tmp_path / "programs" / "left.7-7.part").write_bytes(b"")
    os.utime(tmp_path / "programs" / "left.7-7.part", (1e9, 1e9))
    (tmp_path / "programs" / "written.8-8.part").write_bytes(b"")
    for age, name in enumerate(["new-cache", "programs/one", "old-cache", "programs/old"]):
        (tmp_path / name).write_bytes(bytes(100))
        os.utime(tmp_path / name, (1e9 - age, 1e9 - age))
    tmp_path.chmod(0o700)

    def left():
        fm.enable_cache(tmp_path)
        return {str(file.relative_to(tmp_path)) for file in tmp_path.rglob("*") if file.is_file()} - {
            "looked_at",
            "programs/written.8-8.part",
        }

    assert left() == {"new-cache", "programs/one"}
    # Once an hour.
    (tmp_path / "old-cache").write_bytes(bytes(100))
    os.utime(tmp_path / "old-cache", (1e9 - 9, 1e9 - 9))
    assert "old-cache" in left()
    an_hour_ago = time.time() - 3601
    os.utime(tmp_path / "looked_at", (an_hour_ago, an_hour_ago))
    assert left() == {"new-cache", "programs/one"}


def pendulum():
    b = fm.Builder()
    b.gravity((0.0, -9.81))
    b.node("pivot", (0.0, 0.0))
    b.node("bob", (1.0, 0.0))
    b.add(planar.truss, "pivot", "bob", section=fm.Rigidity(mass=0.0), released=())
    b.fix("pivot")
    b.mass("bob", 1.0)
    return b.build()


@pytest.mark.slow
def test_a_simulation_is_kept(folder, caplog):
    model, times = pendulum(), np.linspace(0, 0.5, 3)
    first = fm.simulate(model, times).x
    before = names(folder)
    assert before
    fresh()
    with caplog.at_level(logging.DEBUG, "flexmb"):
        second = fm.simulate(model, times).x
    assert names(folder) == before
    assert "traced" not in caplog.text
    np.testing.assert_array_equal(first, second)


def test_equinox_imported_before_is_told(tmp_path, settings_restored, monkeypatch):
    monkeypatch.delenv("EQX_ON_ERROR")
    monkeypatch.setitem(sys.modules, "equinox", types.ModuleType("equinox"))
    tmp_path.chmod(0o700)
    with pytest.warns(fm.FlexmbWarning, match=r"Equinox was imported before enable_cache\(\)"):
        fm.enable_cache(tmp_path)
    # It is set now, as a user may have.
    fm.enable_cache(tmp_path)


def test_what_calls_the_host_is_kept(folder, caplog, monkeypatch):
    """By a text in its program, which another process reads: places of a sparse matrix among it."""
    solved = jit(SparseOrder.solved)

    def answer():
        order = order_of(cantilever(planar.beam).topology)
        pieces = tuple(np.full((len(of), 1, 1), 2.0) * np.eye(len(of[0])) for of in order.unknowns)
        return solved(order, pieces, np.zeros(order.places.count), np.ones(order.places.count))

    found = answer()
    kept_now = names(folder)
    assert len(kept_now) >= 1
    fresh()
    host._calls.clear()
    seen = []
    monkeypatch.setattr(host, "program_on_disk", seen.append)
    with caplog.at_level(logging.DEBUG, "flexmb"):
        np.testing.assert_array_equal(answer(), found)
    assert names(folder) == kept_now
    assert "traced" not in caplog.text
    # So that an interruption is held back while it runs.
    assert any(host.TARGET.encode() in program for program in seen)
    # The tip's mass is an element of its own, which does not turn.
    np.testing.assert_allclose(found, [1 / 4, 1 / 4, 1 / 2], rtol=1e-15)
