"""Debian's Chromium through its driver, by the W3C protocol: a page at a width and in a colour scheme."""

import base64
import json
import shutil
import socket
import subprocess
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

NEEDED = ("chromium", "chromedriver")


class Browser:
    """One window.

    Parameters
    ----------
    driver : str
        Address of the driver.
    """

    def __init__(self, driver: str) -> None:
        arguments = [
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--no-first-run",
        ]
        arguments += ["--disable-background-networking", "--disable-component-update", "--disable-sync"]
        wanted = {
            "goog:chromeOptions": {"args": arguments, "binary": shutil.which("chromium")},
            "goog:loggingPrefs": {"performance": "ALL", "browser": "ALL"},
        }
        self._at = driver
        made = self._ask("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})
        self._at = f"{driver}/session/{made['sessionId']}"

    def look(self, url: str, width: int, height: int = 900, *, dark: bool = False) -> None:
        """Open a page."""
        self.cdp(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600},
        )
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.cdp("Emulation.setEmulatedMedia", {"features": [scheme]})
        self._ask("POST", "/url", {"url": url})

    def run(self, script: str) -> Any:
        """Return what a function body returns in the page."""
        return self._ask("POST", "/execute/sync", {"script": script, "args": []})

    def until(self, script: str, seconds: float = 60.0) -> Any:
        """Wait until a function body returns something true, and return it."""
        end = time.monotonic() + seconds
        while not (found := self.run(script)):
            assert time.monotonic() < end, f"not within {seconds:g} s: {script}"
            time.sleep(0.1)
        return found

    def requests(self) -> list[str]:
        """Return the address of every request since this was asked last."""
        entries = self._ask("POST", "/se/log", {"type": "performance"})
        messages = [json.loads(entry["message"])["message"] for entry in entries]
        return [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]

    def complaints(self) -> list[str]:
        """Return what the page's console says since this was asked last: errors, and what a policy blocked."""
        return [str(entry["message"]) for entry in self._ask("POST", "/se/log", {"type": "browser"})]

    def picture(self, file: Path) -> None:
        """Write the whole page as PNG."""
        # a window as tall as the page has no scroll bar: the page is as wide as the window then
        size = self.run("return [window.innerWidth, document.documentElement.scrollHeight]")
        clip = {"x": 0, "y": 0, "width": size[0], "height": size[1], "scale": 1}
        made = self.cdp("Page.captureScreenshot", {"captureBeyondViewport": True, "clip": clip})
        file.write_bytes(base64.b64decode(made["data"]))

    def cdp(self, command: str, parameters: dict[str, Any]) -> Any:
        """Give a command of the DevTools protocol."""
        return self._ask("POST", "/goog/cdp/execute", {"cmd": command, "params": parameters})

    def close(self) -> None:
        """Close the window."""
        self._ask("DELETE", "")

    def _ask(self, method: str, path: str, body: dict[str, Any] | None = None) -> Any:
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self._at + path, data, method=method)  # noqa: S310 (the driver's own)
        with urllib.request.urlopen(request, timeout=120.0) as answer:  # noqa: S310
            return json.load(answer)["value"]


@contextmanager
def opened_browser() -> Iterator[Browser]:
    """Yield a browser; the test is skipped where Chromium or its driver is not installed."""
    missing = [name for name in NEEDED if shutil.which(name) is None]
    if missing:
        pytest.skip(f"needs {' and '.join(missing)}: apt install chromium chromium-driver")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    driver = subprocess.Popen([str(shutil.which("chromedriver")), f"--port={port}"], stdout=subprocess.DEVNULL)
    try:
        end = time.monotonic() + 60.0
        while True:
            try:
                browser = Browser(f"http://127.0.0.1:{port}")
                break
            except OSError:
                assert time.monotonic() < end, "the driver does not answer"
                time.sleep(0.2)
        try:
            yield browser
        finally:
            browser.close()
    finally:
        driver.terminate()
        driver.wait(30.0)
