"""Solutions that others are compared with and that take long: kept with their origin in results/solutions.json.

``python -m benchmarks solutions`` computes them anew, prints how far each is from what was kept, and writes them. The
scripts that use one check in every run that integrators or programs which share nothing with it come near.
"""

import datetime
import functools
import json
import sys
from collections.abc import Callable
from typing import Any

from record import RESULTS, save

KEPT = RESULTS / "solutions.json"


def _pendulum(elements: int, order: int, rtol: float) -> Any:
    """Tip of the soft pendulum of swing.py after a second, (2,) [m]."""
    import swing

    import flexmb as fm

    return fm.simulate(swing.pendulum(elements, order), [0.0, swing.END], rtol=rtol).at(f"n{elements}")[-1]


def _guide(*how: bool) -> Any:
    import motion

    return motion.solved(*how)


def _with_shear() -> Any:
    import motion

    return motion.with_shear()


def _net(cells: int) -> Any:
    import nets

    return nets.solved(cells)


# What computes each, and what it is.
SOLUTIONS: dict[str, tuple[Callable[[], Any], str]] = {
    "pendulum": (
        functools.partial(_pendulum, 6, 7, 1e-10),
        "tip of the soft pendulum of swing.py after 1 s, six spectral beams of order 7 at a tolerance of 1e-10",
    ),
    "guide in the plane": (
        functools.partial(_guide, True),
        "x of the bar of motion.py, default solver at a tolerance of 1e-9",
    ),
    "guide in the plane, elongations FIXED": (
        functools.partial(_guide, True, True),
        "x of the bar of motion.py, default solver at a tolerance of 1e-9",
    ),
    "guide in space": (
        functools.partial(_guide, False),
        "x of the bar of motion.py, default solver at a tolerance of 1e-9",
    ),
    "guide in space, spectral beams with shear": (
        _with_shear,
        "displacement of the bar of motion.py, spectral beams of order 4 with shear at a tolerance of 1e-6",
    ),
    **{
        f"net of {cells} meshes": (
            functools.partial(_net, cells),
            f"lower edge of the net of nets.py at its end, {parts} beams a side of a mesh at a tolerance of 1e-5",
        )
        for cells, parts in ((4, "two"), (10, "two"), (22, "one"))
    },
}


@functools.cache
def _all() -> dict[str, Any]:
    return json.loads(KEPT.read_text())["solutions"] if KEPT.exists() else {}


def kept(name: str) -> Any:
    """A solution as it is kept, as an array.

    Args:
        name: One of ``SOLUTIONS``.

    Raises:
        KeyError: It has not been computed.
    """
    import numpy as np

    if name not in _all():
        raise KeyError(f"'{name}' is not in {KEPT.name}: python -m benchmarks solutions computes it.")
    return np.array(_all()[name]["values"])


def main(names: list[str]) -> None:
    """Compute, compare with what was kept, and write.

    Args:
        names: Of solutions; none: all.
    """
    import numpy as np

    import flexmb as fm

    fm.enable_x64()
    every = dict(_all())
    for name in names or SOLUTIONS:
        compute, origin = SOLUTIONS[name]
        values = np.asarray(compute())
        apart = np.max(np.abs(values - kept(name))) if name in every else np.nan
        print(f"{name}: {apart:.1e} m from what was kept", flush=True)
        today = datetime.date.today().isoformat()
        every[name] = {"origin": origin, "date": today, "values": values.tolist()}
        save("solutions", {"solutions": every}, ("jax", "jaxlib", "numpy", "diffrax"))


if __name__ == "__main__":
    main(sys.argv[1:])
