"""The operators' page in a real browser, beside a real server."""

import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from browser import Page, chromium, needs_chromium
from servers import Server, start

from fatigue_planner.live.events import Acknowledged, Rested
from fatigue_planner.live.face.page import PAGE
from fatigue_planner.live.journal_file import read_journal

pytestmark = [pytest.mark.slow, needs_chromium]
NEWS = "(document.getElementById('action')?.textContent ?? '–') !== '–'"
FAINT = {"light": "#808080", "dark": "#666666"}  # of less contrast than 4.5


@pytest.fixture(scope="module")
def server(cache_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A shift with alarms on: the worker bends his back all the time, and was not seen in the last cycle."""
    running = start(tmp_path_factory.mktemp("page") / "shift.fatplan", cache_folder, "--limit", 0.25)
    with running.process:
        decision = running.call("/v1/decide", {})[1]
        for seen in (*["back"] * 20, None):
            said = {"cycle": decision["cycle"], "executed": "low", "observation": seen}
            decision = running.call("/v1/observe", said)[1]
        yield running
        running.process.kill()


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    with chromium(tmp_path_factory.mktemp("chromium")) as tab:
        yield tab


@pytest.fixture(autouse=True)
def nothing_left(page: Page) -> None:
    page.call("Page.navigate", url="about:blank")
    page.requests.clear()
    page.complaints.clear()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1400, 390])
def test_everybody_can_use_it(page: Page, server: Server, scheme: str, width: int) -> None:
    """axe-core finds nothing (contrast, names, roles); nothing runs out of the window; nobody else is asked."""
    page.open(f"http://127.0.0.1:{server.port}/#{server.act}", width, scheme)
    page.until(NEWS)
    page.until(
        "document.querySelectorAll('#joints tr').length === 8 && document.querySelectorAll('#doses tr').length === 8"
    )
    assert page.value("getComputedStyle(document.body).backgroundColor") == (
        "rgb(255, 255, 255)" if scheme == "light" else "rgb(18, 18, 18)"
    )
    assert page.faults() == []
    assert page.value("document.documentElement.scrollWidth <= innerWidth")
    asked = {address.removeprefix(f"http://127.0.0.1:{server.port}") for address in page.requests}
    assert {one for one in asked if not one.startswith(("data:", "about:"))} == {"/", "/v1/events"}
    assert page.complaints == []
    # what axe would find: the faintest text made fainter, a name taken away
    page.value(f"document.documentElement.style.setProperty('--quiet', '{FAINT[scheme]}')")
    page.value("document.querySelector('label').remove(); document.getElementById('ask').hidden = false")
    assert {fault.partition(":")[0] for fault in page.faults()} == {"color-contrast", "label"}


def test_it_says_what_counts(page: Page, server: Server) -> None:
    page.open(f"http://127.0.0.1:{server.port}/#{server.view}", 1400)
    page.until(NEWS)
    shown = page.value("document.body.innerText")
    assert "Take a pause of " in shown
    assert "lumbar lateral, negative: above 0.25 with probability 100 %; a pause of " in shown
    assert "A matter of work design" in shown
    assert "right wrist deviation, positive: above with probability 100 %" in shown
    assert "at rest half of it is gone after 17 s" in shown
    assert "Not seen 1 (1 in a row)" in shown
    assert float(page.value("parseFloat(getComputedStyle(document.getElementById('action')).fontSize)")) > 150
    # a screen reader is told of the pose, of faults and of pauses, and of nothing that ticks
    live = page.value(
        "[...document.querySelectorAll('[aria-live], [role=status], [role=alert]')].map(one => one.id).join()"
    )
    assert live == "fault,pause-title,action"
    said = "['fault', 'pause-title', 'action'].map(name => document.getElementById(name).textContent).join()"
    before = page.value(said)
    time.sleep(2.5)
    assert page.value(said) == before


def test_it_says_how_well_the_worker_is_seen_and_explained(page: Page, cache_folder: Path, tmp_path: Path) -> None:
    """Few surprises are counted; many, and cycles that are not seen, are faults in words."""
    server = start(tmp_path / "shift.fatplan", cache_folder)
    with server.process:
        decision = server.call("/v1/decide", {})[1]

        def work(seen: str | None, cycles: int) -> None:
            nonlocal decision
            for _ in range(cycles):
                decision = server.call("/v1/observe", {"cycle": decision["cycle"], "observation": seen})[1]

        work("unclear", 2)
        work("arm", 3)
        page.open(f"http://127.0.0.1:{server.port}/#{server.view}", 390)
        page.until("document.body.innerText.includes('Surprises 2 in 5 seen')")
        shown = page.value("document.body.innerText")
        assert "Model fits" in shown
        assert page.value("document.getElementById('fault').textContent") == ""
        work("unclear", 9)
        work(None, 3)
        page.until("document.getElementById('fault').textContent.includes('not seen for 3 cycles')")
        assert "Surprises 11 in 14 seen" in page.value("document.body.innerText")
        said = page.value("document.getElementById('fault').textContent")
        assert "Degraded: the worker was not seen for 3 cycles" in said
        assert "The model does not fit this worker: 11 surprises in 14 cycles seen" in said
        assert "Model does not fit" in page.value("document.body.innerText")
        assert page.faults() == []
        assert page.value("document.documentElement.scrollWidth <= innerWidth")
        server.call("/v1/advise", {"on": False})
        page.until("document.body.innerText.includes('Model off')")
        server.process.kill()


def test_only_who_may_act_has_buttons(page: Page, server: Server) -> None:
    page.open(f"http://127.0.0.1:{server.port}/#{server.view}", 1400)
    page.until(NEWS)
    assert page.value("getComputedStyle(document.getElementById('buttons')).display") == "none"
    page.open(f"http://127.0.0.1:{server.port}/#{server.act}", 1400)
    page.until(f"{NEWS} && !document.getElementById('buttons').hidden")
    assert page.value("location.hash") == ""
    page.value("document.getElementById('seen').click()")
    page.until("document.getElementById('seen').hidden && document.getElementById('why').innerText.includes('(seen)')")
    page.value("document.getElementById('break').click()")
    page.until("document.getElementById('pause-title').textContent === 'Pause'")
    page.until("document.getElementById('left').textContent.endsWith('left')")
    page.value("began -= 60000")  # a minute ago
    page.until("document.getElementById('pause-title').textContent === 'The pause is long enough'")
    page.value("document.getElementById('break').click()")
    page.until("document.getElementById('pause').hidden")
    events = [one.event for one in read_journal(server.journal)]
    (rested,) = (one for one in events if isinstance(one, Rested))
    assert 60 < rested.seconds < 90
    assert sum(isinstance(one, Acknowledged) for one in events) == 1


def test_it_says_when_the_news_stop(page: Page, cache_folder: Path, tmp_path: Path) -> None:
    server = start(tmp_path / "shift.fatplan", cache_folder)
    with server.process:
        server.call("/v1/decide", {})
        page.open(f"http://127.0.0.1:{server.port}/#{server.view}", 1400)
        page.until(NEWS)
        assert page.value("document.getElementById('fault').textContent") == ""
        server.process.kill()
    page.until("document.getElementById('fault').textContent.startsWith('No news since ')")


def test_it_asks_for_a_token(page: Page, server: Server) -> None:
    page.open(f"http://127.0.0.1:{server.port}/#wrong", 390)
    page.until("document.getElementById('ask')?.hidden === false")
    assert page.faults() == []
    fault = "document.getElementById('fault').textContent"
    page.value("state = {counts: {}, fits: true, fallback: 'none'}, last = 1")  # one of before the server was restarted
    time.sleep(1.5)
    assert page.value(fault) == "A token is needed"
    page.value(f"document.getElementById('token').value = '{server.view}'")
    page.value("document.querySelector('#ask button').click()")
    page.until(NEWS)
    assert "A token is needed" not in page.value(fault)
    assert len(PAGE.encode()) <= 30_000
