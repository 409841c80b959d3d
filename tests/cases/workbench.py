"""The workbench as its users have it: ``flexmb edit`` in a process of its own, and its page in headless Chromium."""

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

BROWSER, DRIVER = (shutil.which(name) for name in ("chromium", "chromedriver"))
MISSING = [name for name, found in (("chromium", BROWSER), ("chromium-driver", DRIVER)) if not found]
needs_browser = pytest.mark.skipif(bool(MISSING), reason=f"no browser: apt-get install {' '.join(MISSING)}")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


def thing(call: str, name: str | None = None, **args: Any) -> dict[str, Any]:
    """The operation that adds a thing."""
    own = {"call": call, "args": args} | ({} if name is None else {"name": name})
    return {"op": "add", "thing": own}


def cantilever() -> list[dict[str, Any]]:
    """Operations of a leaf spring of 100 x 20 x t mm with a mass of 0.1 kg at its end."""
    return [
        {"op": "name", "name": "t", "to": {"value": "0.5e-3", "low": "0.1e-3", "high": "2e-3"}},
        thing("Material", "steel", E="210e9", G="80e9", rho="0"),
        thing("Rectangle", "leaf", width="0.02", thickness="t", material="steel"),
        thing("node", "A", position=["0", "0"]),
        thing("node", "B", position=["0.1", "0"]),
        thing("planar.beam", "spring", nodes=["A", "B"], section="leaf"),
        thing("fix", node="A", components=""),
        thing("mass", node="B", mass="0.1"),
    ]


class Process:
    """``flexmb edit`` in a process of its own.

    Attributes:
        address: Of its page.
        state: Folder of its journals, in which another one goes on.
    """

    def __init__(self, *arguments: Any, folder: Path | None = None, state: Path | None = None):
        self.state = state or Path(tempfile.mkdtemp())
        self.process = subprocess.Popen(
            [sys.executable, "-m", "flexmb", "edit", *map(str, arguments), "--no-browser"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=folder,
            env={**os.environ, "FLEXMB_STATE": str(self.state)},
            start_new_session=True,
        )
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().strip()
        assert self.address.startswith("http://127.0.0.1:"), self.end()

    def end(self, how: signal.Signals = signal.SIGINT) -> tuple[int, str, str]:
        """Exit status, and what else it wrote, after a signal."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        try:
            rest = self.process.communicate(timeout=60)
        except subprocess.TimeoutExpired:
            self.process.kill()
            rest = self.process.communicate()
        return self.process.returncode, *rest


@contextlib.contextmanager
def served(*arguments: Any, **where: Any) -> Iterator[Process]:
    """A running workbench, which is ended afterwards."""
    own = Process(*arguments, **where)
    try:
        yield own
    finally:
        own.end()


class Client:
    """A page without a browser: asks, and keeps what it is told.

    Attributes:
        told: Newest push of every kind.
        heard: All pushes, in order.
        replies: By number.
    """

    def __init__(self, address: str, page: str = "", greet: bool = True, **options: Any):
        from websockets.sync.client import connect

        origin = re.sub(r"(?<=\d)/.*", "", address)
        to = address.replace("http", "ws", 1) + "socket"
        given = {"origin": origin, "compression": None, "max_size": None, "proxy": None, **options}
        self._held = contextlib.ExitStack()
        self.socket = self._held.enter_context(connect(to, **given))
        self.told: dict[str, dict[str, Any]] = {}
        self.heard: list[dict[str, Any]] = []
        self.replies: dict[int | None, dict[str, Any]] = {}
        self.number = 0
        if greet:
            self.hello = self.ask("hello", page=page or f"page {id(self)}")

    def send(self, verb: str, **arguments: Any) -> int:
        """Send a request and do not wait."""
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "do": verb, **arguments}))
        return self.number

    def ask(self, verb: str, **arguments: Any) -> dict[str, Any]:
        """Reply to a request."""
        return self.reply(self.send(verb, **arguments))

    def reply(self, number: int | None, seconds: float = 30) -> dict[str, Any]:
        """Wait for a reply."""
        self.until(lambda: number in self.replies, seconds)
        return self.replies.pop(number)

    def until(self, there: Callable[[], Any], seconds: float = 30) -> Any:
        """Listen until something is there, and return it."""
        end = time.monotonic() + seconds
        while not (found := there()):
            message = json.loads(self.socket.recv(timeout=max(end - time.monotonic(), 0.01)))
            if "re" in message:
                self.replies[message["re"]] = message
            else:
                self.told[message["tell"]] = message
                self.heard.append(message)
        return found

    def close(self) -> None:
        """Leave."""
        self._held.close()


@contextlib.contextmanager
def browsing(folder: Path, reached: str = "127.0.0.1", size: tuple[int, int] = (1280, 800)) -> Iterator[Any]:
    """Headless Chromium that reaches one host alone, quiet where motion is a matter of taste.

    Args:
        folder: Of what it keeps.
        reached: The host; none where it is empty.
        size: Of its window [px].
    """
    webdriver = pytest.importorskip("selenium.webdriver")
    hosts = "MAP * ~NOTFOUND" + (f", EXCLUDE {reached}" if reached else "")
    own = f"--user-data-dir={folder}", f"--host-resolver-rules={hosts}", f"--window-size={size[0]},{size[1]}"
    options = webdriver.ChromeOptions()
    options.binary_location = str(BROWSER)
    for flag in (*FLAGS, *own):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    try:
        driver.set_page_load_timeout(30)
        driver.set_script_timeout(60)
        quiet = {"features": [{"name": "prefers-reduced-motion", "value": "reduce"}]}
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", quiet)
        yield driver
    finally:
        driver.quit()


def opened(driver: Any, address: str) -> Any:
    """The page of an address, connected; older logs are thrown away."""
    for log in ("browser", "performance"):
        driver.get_log(log)
    driver.get(address)
    until(driver, "window.workbench && s.state.connected && s.state.document")
    return driver


def ask(page: Any, expression: str, *arguments: Any) -> Any:
    """Value of an expression in the page, in which ``s`` is the store and ``w`` the workbench."""
    return page.execute_script(f"const w = window.workbench, s = w && w.store; return {expression};", *arguments)


def wait_for(page: Any, expression: str) -> Any:
    """What a promise in the page becomes; a refusal as {"problem": message}."""
    return page.execute_async_script(
        "const done = arguments[arguments.length - 1], w = window.workbench, s = w.store;"
        f"({expression}).then(done, (fault) => done({{problem: fault.message, address: fault.address}}));"
    )


def until(page: Any, expression: str, seconds: float = 30) -> Any:
    """Wait for something in the page to become true, and return it."""
    end = time.monotonic() + seconds
    while not (found := ask(page, expression)):
        assert time.monotonic() < end, f"{expression} did not become true; console: {faults(page)}"
        time.sleep(0.02)
    return found


def faults(page: Any) -> list[str]:
    """What the console calls severe since it was last asked."""
    return [entry["message"] for entry in page.get_log("browser") if entry["level"] == "SEVERE"]


def requests(page: Any) -> list[str]:
    """Addresses that the page has asked for since this was last asked."""
    messages = [json.loads(entry["message"])["message"] for entry in page.get_log("performance")]
    return [one["params"]["request"]["url"] for one in messages if one["method"] == "Network.requestWillBeSent"]
