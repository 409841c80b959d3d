"""The workbench as its users have it: ``flexmb edit`` in a process of its own, and its page in headless Chromium."""

import contextlib
import json
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
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
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
    "--window-size=1280,800",
)


class Process:
    """``flexmb edit`` in a process of its own.

    Attributes:
        address: Of its page.
    """

    def __init__(self, *arguments: Any, folder: Path | None = None):
        call = [sys.executable, "-m", "flexmb", "edit", *map(str, arguments), "--no-browser"]
        self.process = subprocess.Popen(
            call, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder, start_new_session=True
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
def served(*arguments: Any, folder: Path | None = None) -> Iterator[Process]:
    """A running workbench, which is ended afterwards."""
    own = Process(*arguments, folder=folder)
    try:
        yield own
    finally:
        own.end()


@contextlib.contextmanager
def browsing(folder: Path) -> Iterator[Any]:
    """Headless Chromium that reaches this machine alone, quiet where motion is a matter of taste."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    for flag in (*FLAGS, f"--user-data-dir={folder}"):
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
