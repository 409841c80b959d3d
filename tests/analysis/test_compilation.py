"""What is compiled depends on sizes alone: another support, connection or dimension reuses the code."""

import jax
import pytest

import flexmb as fm
from flexmb import planar


@pytest.fixture
def compilations():
    """Counts programs handed to the compiler, cached on disk or not."""
    count = []

    def listen(event: str, duration_secs: float, **kwargs: str | int) -> None:
        if event == "/jax/core/compile/backend_compile_duration":
            count.append(duration_secs)

    jax.monitoring.register_event_duration_secs_listener(listen)
    yield count
    jax.monitoring.unregister_event_duration_listener(listen)


def frame(thickness: float, *, support: str, braces: tuple[str, str]) -> fm.Model:
    """Two uprights, a rigid bar and a brace, held at one of two feet and guided at the other."""
    section = fm.Rectangle(0.018, thickness, fm.Material(210e9, 80e9, 7850.0))
    b = fm.Builder()
    for name, position in {"A": (0, 0), "B": (0, 0.1), "C": (0.1, 0.1), "D": (0.1, 0)}.items():
        b.node(name, position)
    b.add(planar.beam, "A", "B", section=section)
    b.add(planar.beam, "C", "D", section=section)
    b.add(planar.beam, "B", "C")
    b.add(planar.truss, *braces, section=fm.Rigidity(EA=50.0))
    b.fix("A" if support == "A" else "D")
    b.fix("D" if support == "A" else "A", "y", "phi")
    b.mass("B", 0.1)
    b.mass("C", 0.1)
    for i in (1, 2, 3):
        b.dof("beam 1", i)
    b.dof("beam 2", 2)
    return b.build()


def test_same_sizes_do_not_compile_again(compilations):
    first = fm.frequencies(frame(5e-4, support="A", braces=("A", "C")))
    assert compilations  # the counter counts
    compilations.clear()
    others = [
        fm.frequencies(frame(6e-4, support="A", braces=("A", "C"))),
        fm.frequencies(frame(5e-4, support="D", braces=("A", "C"))),
        fm.frequencies(frame(5e-4, support="A", braces=("D", "B"))),
    ]
    assert not compilations
    assert all(abs(float(f[0] / first[0]) - 1) > 1e-3 for f in others)


def test_another_size_compiles(compilations):
    frame_of_beams = frame(5e-4, support="A", braces=("A", "C"))
    fm.frequencies(frame_of_beams)
    compilations.clear()
    b = fm.Builder()
    b.node("A", (0, 0))
    b.node("B", (0, 0.1))
    b.add(planar.beam, "A", "B", section=fm.Rectangle(0.01, 3e-4, fm.Material(210e9, 80e9, 7850.0)))
    b.fix("A")
    fm.frequencies(b.build())
    assert compilations
