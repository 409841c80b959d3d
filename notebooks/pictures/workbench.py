"""Films the workbench for README's top: python notebooks/pictures/workbench.py.

Headless Chromium shows the page that ``flexmb edit`` serves: a slider is dragged, the frequency follows, a target of
20 Hz is met. The frames are taken one by one, the mode a step further in each, so that the film is even however long a
picture takes. It needs chromium, chromium-driver and selenium.
"""

import contextlib
import io
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

from cases.documents import spatial_guide  # pyright: ignore
from cases.workbench import ask, browsing, faults, opened, served, until  # pyright: ignore

from flexmb.workbench.document import apply

WIDTH, HEIGHT = 1040, 600
# Time of a frame [ms], and of one while the target is met; swings of the mode in a frame.
FRAME, SLOW, SWING = 90, 220, 1 / 14
QUALITY = 60
# An arrow, since headless Chromium draws no pointer.
POINTER = """
const own = document.createElement("div");
own.id = "film-pointer";
own.innerHTML = '<svg width="22" height="26" viewBox="0 0 22 26">'
  + '<path d="M2 2v19l5-5 4 8 4-2-4-8h7z" fill="#111" stroke="#fff" stroke-width="1.6"/></svg>';
own.style.cssText = "position:fixed;left:0;top:0;z-index:9999;pointer-events:none";
document.body.append(own);
"""


class Film:
    """Frames of a page.

    Attributes:
        page: In the browser.
        frames: Pictures with the time that each stands [ms].
        place: Of the pointer [px].
    """

    def __init__(self, page: Any):
        self.page = page
        self.frames: list[tuple[Image.Image, int]] = []
        self.place = (520.0, 330.0)
        self.swung = 0.0
        page.execute_script(POINTER)

    def take(self, milliseconds: int = FRAME) -> None:
        """A picture, the mode a step further."""
        self.swung += SWING * milliseconds / FRAME
        ask(
            self.page,
            "(w.canvas.swing.state.position = arguments[0] % 1, w.canvas.swing.move(), w.canvas.sceneDirty = true,"
            " document.getElementById('film-pointer').style.translate = `${arguments[1]}px ${arguments[2]}px`)",
            self.swung,
            *self.place,
        )
        self.page.execute_async_script(
            "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => done(0)));"
        )
        own = Image.open(io.BytesIO(self.page.get_screenshot_as_png())).convert("RGB")
        self.frames.append((own, milliseconds))

    def still(self, count: int) -> None:
        """Nothing happens but the swing."""
        for _ in range(count):
            self.take()

    def point(self, selector: str, along: float = 0.5, count: int = 5) -> None:
        """Move the pointer to a part of the page."""
        x, y, width, height = ask(
            self.page,
            "(({x, y, width, height}) => [x, y, width, height])"
            "(document.querySelector(arguments[0]).getBoundingClientRect())",
            selector,
        )
        goal, start = (x + along * width, y + height / 2), self.place
        for i in range(1, count + 1):
            part = (1 - i / count) ** 2
            self.place = tuple(g + part * (s - g) for g, s in zip(goal, start, strict=True))
            self.take()

    def press(self, selector: str) -> None:
        """Press what is pointed at."""
        self.point(selector)
        self.page.execute_script("document.querySelector(arguments[0]).click()", selector)
        self.take()

    def slide(self, name: str, places: list[float]) -> None:
        """Drag the slider of a name through places from 0 to 1, and see the answers of each."""
        selector = f"input[data-name='{name}']"
        for place in places:
            self.point(selector, 0.03 + 0.94 * place, 1)
            self.frames.pop()
            self.page.execute_script(
                "const own = document.querySelector(arguments[0]);"
                "own.value = Number(own.min) + arguments[1] * (own.max - own.min);"
                "own.dispatchEvent(new Event('input', {bubbles: true}));",
                selector,
                place,
            )
            self.settle()
            self.take()
        self.page.execute_script(
            "document.querySelector(arguments[0]).dispatchEvent(new Event('change', {bubbles: true}))", selector
        )
        self.settle()

    def settle(self) -> None:
        """Wait for the answers of what is shown."""
        time.sleep(0.08)
        until(
            self.page,
            "s.state.answers.of_revision === s.state.revision && s.state.scene.of_revision === s.state.revision",
        )

    def save(self, path: Path) -> None:
        """Write the film as animated WebP."""
        pictures, times = zip(*self.frames, strict=True)
        pictures[0].save(
            path, save_all=True, append_images=pictures[1:], duration=list(times), loop=0, quality=QUALITY, method=6
        )


def guide() -> Any:
    """The tutorial's guide in space, with its dimensions as names between bounds, and all that beam theory has."""
    document = spatial_guide()
    leaf = next(thing["id"] for thing in document.things if thing["call"] == "Rectangle")
    bounds = {"t": ("0.5e-3", "0.3e-3", "1e-3"), "L": ("0.1", "0.06", "0.14"), "d": ("0.1", "0.05", "0.2")}
    ops: list[dict[str, Any]] = [
        {"op": "name", "name": name, "to": {"value": value, "low": low, "high": high}}
        for name, (value, low, high) in bounds.items()
    ]
    ops += [
        {"op": "set", "address": f"{leaf}/{key}", "to": to} for key, to in (("shear", "true"), ("warping_length", "L"))
    ]
    return apply(document, [*ops, {"op": "title", "to": "guide"}])[0]


@contextlib.contextmanager
def page_of(document: Any) -> Iterator[Any]:
    """The page of a workbench with a document."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "guide.json"
        file.write_text(document.text)
        with served(file, folder=Path(folder)) as own, browsing(Path(folder) / "browser") as driver:
            size = {"width": WIDTH, "height": HEIGHT, "deviceScaleFactor": 1, "mobile": False}
            driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
            page = opened(driver, own.address)
            until(page, "s.state.answers && s.state.answers.status === 'ok' && s.state.scene", 120)
            time.sleep(1)
            yield page


def filmed(page: Any) -> Film:
    """What happens."""
    page.execute_script("document.getElementById('tab-names').click(); document.getElementById('tab-answers').click();")
    time.sleep(0.5)
    film = Film(page)
    film.still(8)
    film.point("input[data-name='t']", 0.03 + 0.94 * ask(page, _PLACE), 6)
    begin = ask(page, _PLACE)
    ways = [begin + 0.22 * i / 8 for i in range(1, 9)] + [begin + 0.22 - 0.34 * i / 10 for i in range(1, 11)]
    film.slide("t", ways)
    film.still(4)
    film.press("#tab-target")
    value = "#target input[aria-label='Value']"
    film.point(value)
    for text in ("2", "20"):
        page.execute_script(
            "const own = document.querySelector(arguments[0]); own.value = arguments[1];"
            "own.dispatchEvent(new Event('input', {bubbles: true}));",
            value,
            text,
        )
        film.take(2 * FRAME)
    film.press("#find")
    end = time.monotonic() + 60
    while not ask(page, "Object.values(s.state.jobs).some(({kind, status}) => kind === 'target' && status === 'done')"):
        before = ask(page, "s.state.revision")
        while ask(page, "s.state.revision") == before and time.monotonic() < end:
            if ask(page, "Object.values(s.state.jobs).some(({status}) => status !== 'running')"):
                break
            time.sleep(0.01)
        film.take(SLOW)
    film.settle()
    film.still(6)
    film.press("#tab-answers")
    film.still(22)
    return film


_PLACE = "(({value, min, max}) => (value - min) / (max - min))(document.querySelector(\"input[data-name='t']\"))"


def main(path: Path) -> None:
    """Film it.

    Args:
        path: Of the picture.
    """
    with page_of(guide()) as page:
        film = filmed(page)
        assert not (said := faults(page)), said
    film.save(path)
    print(f"{path}: {len(film.frames)} frames, {path.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("workbench.webp"))
