"""What tests cost, in seconds of the processor: `python -m pytest -p costs [-n 2] [tests ..]`.

The clock on the wall says little on a machine that does other work. Counted are a worker's own time and that of the
processes that it waited for, and beside it what JAX took to trace, lower and compile, on the wall.
"""

import collections
import os

import pytest

SHOWN = 40
STAGES = ("/jax/core/compile/jaxpr_trace_duration", "/jax/core/compile/jaxpr_to_mlir_module_duration")
BACKEND = "/jax/core/compile/backend_compile_duration"
jaxs = collections.Counter()


def listen(event: str, duration: float, **_: str | int) -> None:
    if event in (*STAGES, BACKEND):
        jaxs["seconds"] += duration
        jaxs["programs"] += event == BACKEND


def pytest_collection_finish() -> None:
    import jax

    jax.monitoring.register_event_duration_secs_listener(listen)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item: pytest.Item):
    item.stash[START] = (sum(os.times()[:4]), dict(jaxs))
    yield


START = pytest.StashKey[tuple[float, dict[str, float]]]()


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item: pytest.Item) -> None:
    spent, before = item.stash[START]
    found = [jaxs[name] - before.get(name, 0) for name in ("seconds", "programs")]
    # By a report, since that is what workers send.
    item.user_properties.append(("cost", [sum(os.times()[:4]) - spent, *found]))


def pytest_terminal_summary(terminalreporter) -> None:
    rows, files = {}, collections.defaultdict(lambda: [0.0, 0.0, 0])
    for reports in terminalreporter.stats.values():
        for report in reports:
            for name, cost in getattr(report, "user_properties", ()):
                if name == "cost":
                    rows[report.nodeid] = cost
    for test, cost in rows.items():
        files[test.partition("::")[0]] = [a + b for a, b in zip(files[test.partition("::")[0]], cost, strict=True)]
    for title, table in (("files", files), ("tests", rows)):
        terminalreporter.section(f"what {title} cost: processor [s], JAX on the wall [s], programs")
        for name, cost in sorted(table.items(), key=lambda row: -row[1][0])[:SHOWN]:
            terminalreporter.write_line("{:8.1f} {:8.1f} {:6.0f}  ".format(*cost) + name)
    terminalreporter.write_line(f"{sum(cost[0] for cost in rows.values()):8.1f} s of the processor in all")
