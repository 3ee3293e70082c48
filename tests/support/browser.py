"""A page in a headless Chromium, by its DevTools protocol; and axe-core, which finds what some people cannot use."""

import json
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import pytest
from websockets.sync.client import ClientConnection, connect

OPTIONS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--remote-debugging-port=0",
]  # fmt: skip
WAIT_S = 60.0
HAS_CHROMIUM = shutil.which("chromium") is not None
needs_chromium = pytest.mark.skipif(not HAS_CHROMIUM, reason="needs Chromium")
# A4 without its margins of 12 mm, at 96 dots an inch.
PRINTED_PX = (703, 1031)
# WCAG 2.1, levels A and AA.
RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"]


class Page:
    """A tab. requests: all addresses that were asked for; complaints: errors, and what the console was told."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket, self._number = socket, 0
        self.requests: list[str] = []
        self.complaints: list[str] = []
        for domain in ("Page", "Network", "Runtime", "Log"):
            self.call(f"{domain}.enable")

    def call(self, method: str, **parameters: Any) -> Any:
        """A command of the protocol and what it returns."""
        self._number += 1
        self._socket.send(json.dumps({"id": self._number, "method": method, "params": parameters}))
        while True:
            message = json.loads(self._socket.recv(timeout=WAIT_S))
            kind, content = message.get("method"), message.get("params", {})
            if kind == "Network.requestWillBeSent":
                self.requests.append(content["request"]["url"])
            elif kind in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded"):
                self.complaints.append(str(content))
            if message.get("id") == self._number:
                assert "error" not in message, message
                return message["result"]

    def value(self, expression: str) -> Any:
        """What an expression comes to, when it is there."""
        found = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def until(self, expression: str) -> None:
        """Wait until an expression is true; one that fails, as where a page is not there yet, is not."""
        end = time.monotonic() + WAIT_S
        while not self.value(f"(() => {{ try {{ return {expression} }} catch {{ return false }} }})()"):
            assert time.monotonic() < end, (expression, self.value("document.body?.innerText"), self.complaints)
            time.sleep(0.05)

    def open(self, address: str, width: int, scheme: str = "light") -> None:
        """Go to an address, in a window of so many pixels and a colour scheme."""
        self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=width < 500
        )
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.call("Page.navigate", url="about:blank")
        self.call("Page.navigate", url=address)

    def faults(self) -> list[str]:
        """What axe-core finds, as the rule and the element."""
        found = find_spec("axe_core_python")
        assert found is not None and found.origin is not None
        self.value((Path(found.origin).parent / "axe.min.js").read_text(encoding="utf-8") + ";0")
        ran = self.value(
            f"axe.run({{runOnly: {{type: 'tag', values: {json.dumps(RULES)}}}}}).then(r => JSON.stringify(r))"
        )
        result = json.loads(ran)
        assert len(result["passes"]) > 5
        return [f"{one['id']}: {node['html'][:200]}" for one in result["violations"] for node in one["nodes"]]


def printed_when_legible(page: Page, address: str) -> None:
    """Check that a station's page fits its window, wide or narrow, and has no faults; then lay it out as printed."""
    for width in (1400, 390):
        page.open(address, width)
        page.until("document.readyState === 'complete' && document.querySelector('.front') !== null")
        assert page.value("document.documentElement.scrollWidth <= innerWidth"), width
        assert page.faults() == []
    assert page.complaints == []
    page.call("Emulation.setEmulatedMedia", media="print")
    width, height = PRINTED_PX
    page.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)


@contextmanager
def chromium(folder: Path) -> Iterator[Page]:
    """A new tab of a browser with a profile of its own in a folder."""
    command = ["chromium", *OPTIONS, f"--user-data-dir={folder}", "about:blank"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as running:
        try:
            yield from _tab(folder / "DevToolsActivePort")
        finally:
            running.kill()


def _tab(port_file: Path) -> Iterator[Page]:
    end = time.monotonic() + WAIT_S
    while not (port_file.is_file() and port_file.read_text().count("\n")):
        assert time.monotonic() < end, "Chromium does not start"
        time.sleep(0.1)
    port = port_file.read_text().split()[0]
    with urlopen(f"http://127.0.0.1:{port}/json", timeout=WAIT_S) as answer:
        tab = next(one for one in json.load(answer) if one["type"] == "page")
    with connect(tab["webSocketDebuggerUrl"], max_size=None, ping_interval=None) as socket:
        yield Page(socket)
