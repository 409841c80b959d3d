import gc
import hashlib
import math
import os
import time
from importlib.metadata import version
from pathlib import Path

# What tests compute beside the package, one operation at a time, is compiled quickly too. XLA reads this once. Flags
# are part of what kept code is known by, so that each stands once, also where a worker inherits them.
os.environ["XLA_FLAGS"] = " ".join(
    dict.fromkeys(
        [
            *os.environ.get("XLA_FLAGS", "").split(),
            "--xla_backend_optimization_level=0",
            *(["--xla_cpu_use_fusion_emitters=false"] if version("jaxlib") < "0.11" else []),
            "--xla_cpu_parallel_codegen_split_count=1",
        ]
    )
)

# LAPACK's threads wait for work at full speed, beside the other worker: a twentieth of the processor's time. Workers
# inherit this.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import hypothesis
import jax
import pytest

import flexmb as fm
from flexmb.compilation.compile import compile_thoroughly, make_room
from flexmb.setup import cache_folder

fm.enable_x64()
# Compiled code is kept beside the user's own, so that a second run is quick.
CACHE = cache_folder() / "tests"
fm.enable_cache(CACHE, thorough=False)


def use_cache():
    """Switch to the cache of the tests, without counting again what lies in it."""
    compile_thoroughly(False, keep=True)
    jax.config.update("jax_compilation_cache_dir", str(CACHE))


# Where in Python each operation was written is kept with a program, for some percent of its compilation; nobody
# reads it here.
jax.config.update("jax_traceback_in_locations_limit", 0)
# Silent promotion is how a float32 gets into a model. (Rank promotion is left as it is: the package relies on it.)
jax.config.update("jax_numpy_dtype_promotion", "strict")

# The same examples in every run, few of them; the first call compiles, so that no deadline holds. Explaining a failure
# runs it a hundred times more.
phases = tuple(phase for phase in hypothesis.Phase if phase is not hypothesis.Phase.explain)
hypothesis.settings.register_profile(
    "flexmb", deadline=None, derandomize=True, max_examples=10, database=None, phases=phases
)
hypothesis.settings.load_profile("flexmb")


HERE = Path(__file__).parent
TOO_LATE = "after the time of --until"


def pytest_addoption(parser):
    text = "what becomes of tests marked as slow; out where no file is named, in where one is"
    parser.addoption("--slow", choices=("out", "in", "only"), help=text)
    text = "begin no test after this time [s since 1970], and name those that are left out"
    parser.addoption("--until", type=float, default=math.inf, metavar="TIME", help=text)
    text = "files in an order that follows from this text, such as a commit; by default the largest first"
    parser.addoption("--order", metavar="TEXT", help=text)


def is_slow(item):
    """Whether a test is marked as slow. A mark with names marks these parameters alone."""
    return any(not mark.args or item.callspec.id in mark.args for mark in item.iter_markers("slow"))


def slow_ones(config):
    """What becomes of slow tests: who names files or tests wants all of them."""
    return config.option.slow or ("in" if config.option.file_or_dir else "out")


def pytest_collection_modifyitems(config, items):
    # Tests of the whole package and large files take longest; they begin first.
    place: dict = {item.path: (len(item.path.parts), -item.path.stat().st_size) for item in items}
    if seed := config.option.order:
        place = {path: hashlib.sha256(f"{seed} {path.relative_to(HERE)}".encode()).digest() for path in place}
    items.sort(key=lambda item: place[item.path])
    asked = slow_ones(config)
    if asked != "in":
        left = [item for item in items if is_slow(item) == (asked == "out")]
        items[:] = [item for item in items if is_slow(item) != (asked == "out")]
        config.hook.pytest_deselected(items=left)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    if time.time() > item.config.option.until:
        pytest.skip(TOO_LATE)


def pytest_terminal_summary(terminalreporter, config):
    late = [one.nodeid for one in terminalreporter.stats.get("skipped", ()) if TOO_LATE in str(one.longrepr)]
    if late:
        terminalreporter.write_line("\n".join([f"Left out, since it was too late to begin them: {len(late)}", *late]))
    if slow_ones(config) == "out":
        terminalreporter.write_line("Left out: tests marked as slow. --slow=in runs them too, --slow=only them alone.")


@pytest.fixture(scope="module", autouse=True)
def _compiled_code_is_given_back():
    """Where it takes much room; otherwise what files have in common is compiled once. A worker takes four gigabytes."""
    # A command that an earlier module ran has switched to its own.
    use_cache()
    yield
    if make_room(0.3):
        gc.collect()


@pytest.fixture
def compilations():
    """Names of the programs that are compiled, or read from disk."""
    count = []

    def listen(event: str, duration_secs: float, **kwargs: str | int) -> None:
        if event == "/jax/core/compile/backend_compile_duration":
            count.append(str(kwargs.get("fun_name")))

    jax.monitoring.register_event_duration_secs_listener(listen)
    yield count
    jax.monitoring.unregister_event_duration_listener(listen)
