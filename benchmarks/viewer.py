"""Frames a second in which a browser without a graphics card plays a wave through 1984 beams.

``python benchmarks/viewer.py`` prints what README quotes and writes results/viewer.json. It takes Debian's chromium and
chromium-driver, and selenium.
"""

import importlib.util
import shutil
import tempfile
import time
from pathlib import Path

ROWS, COLUMNS, PITCH = 25, 41, 0.1
STATES = 21
SECONDS = 10
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-sync",
)


def lattice(dimension: int):
    """A grid of beams, clamped along one side, and its nodal coordinates at some times of a wave, (STATES, n_x).

    Args:
        dimension: 2 or 3; in space the wave leaves the plane of the grid.
    """
    import numpy as np

    import flexmb as fm
    from flexmb import planar, spatial

    element = planar.beam if dimension == 2 else spatial.beam
    leaf = fm.Rectangle(0.01, 0.0005, fm.Material(E=210e9, G=80e9, rho=7850.0))
    b = fm.Builder()
    for i in range(ROWS):
        for j in range(COLUMNS):
            b.node(f"{i},{j}", (PITCH * j, PITCH * i, 0.0)[:dimension])
            if i:
                b.add(element, f"{i - 1},{j}", f"{i},{j}", section=leaf)
            if j:
                b.add(element, f"{i},{j - 1}", f"{i},{j}", section=leaf)
        b.fix(f"{i},0")
    model = b.build(check=False)
    x = np.tile(np.asarray(model.parameters.reference), (STATES, 1))
    times = np.linspace(0, 1, STATES)
    for name in {entry.of for entry in model.labels.x if entry.kind == "position"}:
        place, turned = model.labels.known(name), model.labels.known(f"{name}.rotation")
        along = x[0, place[0]]
        swing = 0.05 * along * np.sin(2 * np.pi * times)
        x[:, place[1 if dimension == 2 else 2]] += swing * np.sin(4 * along)
        slope = 0.05 * np.sin(2 * np.pi * times) * (np.sin(4 * along) + 4 * along * np.cos(4 * along))
        if dimension == 2:
            x[:, turned[0]] = np.arctan(slope)
        else:
            half = -np.arctan(slope) / 2
            x[:, turned[0]], x[:, turned[2]] = np.cos(half), np.sin(half)
    return model, times, x


def motion_of(model, times, x):
    """A motion as the simulation of one would return it; nothing is integrated.

    Args:
        model: Mechanism.
        times: (n_t,) [s].
        x: (n_t, n_x).
    """
    import numpy as np

    import flexmb as fm

    near = np.zeros((len(times), model.topology.n_e))
    return fm.motion.Motion(times, x, 0 * x, near, np.zeros((len(times), 0)), 0, 0, (), model, "given", "none")


def played(page: Path) -> list[int]:
    """What the page's own counter says in every second, after two to start in.

    Args:
        page: File.
    """
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for flag in (*FLAGS, "--window-size=1100,720", f"--user-data-dir={tempfile.mkdtemp()}"):
        options.add_argument(flag)
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService("/usr/bin/chromedriver"))
    try:
        driver.get(page.as_uri())
        time.sleep(2)
        found = []
        for _ in range(SECONDS):
            time.sleep(1)
            found.append(driver.execute_script("return window.flexmb.framesPerSecond"))
        return found
    finally:
        driver.quit()


def main() -> None:
    """Play both and write what was found."""
    import os
    import statistics

    from record import save

    import flexmb as fm

    browser = shutil.which("chromium") and shutil.which("chromedriver")
    if not browser or importlib.util.find_spec("selenium") is None:
        print("Left out: it takes chromium, chromium-driver and selenium (pip install -e '.[test]').")
        return
    fm.enable_x64()
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for dimension, name in ((2, "plane"), (3, "space")):
            page = Path(folder) / f"{name}.html"
            fm.view(motion_of(*lattice(dimension))).save(page)
            frames = played(page)
            found[name] = {
                "frames per second": {"median": statistics.median(frames), "min": min(frames), "max": max(frames)},
                "page [MB]": round(page.stat().st_size / 1e6, 2),
                "processes waiting": os.getloadavg()[0],
            }
            print(name, found[name])
    save("viewer", found)


if __name__ == "__main__":
    main()
