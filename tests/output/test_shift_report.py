"""The report of a shift: complete for the worker, silent on groups under five, and a pseudonym nowhere."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from commands import fatplan
from conftest import PAPER
from hypothesis import given, settings
from hypothesis import strategies as st
from journals import opening, stored, write_journal

import fatigue_planner as fp
from fatigue_planner.fatigue.entries import ENTRIES
from fatigue_planner.live.doses import expected_chances
from fatigue_planner.live.events import (
    Advice,
    CameLate,
    Closed,
    Decided,
    Event,
    Noted,
    Observed,
    Rested,
    Resumed,
    WorkerChanged,
)
from fatigue_planner.live.hindsight import Hindsight
from fatigue_planner.live.journal_file import erase, read_journal
from fatigue_planner.live.record import Record, record_of
from fatigue_planner.output.reports.shift.data import Part, ShiftData
from fatigue_planner.output.reports.shift.group import FEWEST, MIN_MINUTES, Times, windows
from fatigue_planner.output.reports.shift.worth import worth_words

CYCLE_S = 16.0
PSEUDONYM = "w-7f3a"


@pytest.fixture(scope="module")
def scenario(cache_folder: Path) -> fp.Scenario:
    experiment = fp.load(PAPER)
    found = fp.scenario(experiment, fp.simulate(experiment, cache_folder), "multiple_novice")
    return replace(found, name="multiple_novice")


def cycle(number: int, at_s: float, fallback: str = "none", **other: object) -> list[tuple[float, Event]]:
    """A cycle that was decided and has ended at some time."""
    decided = {
        "cycle": number, "action": "high", "reason": "the best", "fallback": fallback, "prepared": True,
        "late": number == 3, "duration_s": 0.001,
    }  # fmt: skip
    seen = {"cycle": number, "executed": "high", "observation": ("arm", "back")[number % 2]}
    return [(at_s - CYCLE_S, Decided.model_validate(decided)), (at_s, Observed.model_validate(seen | other))]


def shift(
    task: fp.Scenario, workers: int, cycles: int = 60, close: bool = True, **opened: object
) -> list[tuple[float, Event]]:
    """Workers take turns; one of them is off for three cycles; each rests."""
    events: list[tuple[float, Event]] = [(0.0, opening(task, **opened))]
    at_s, number = 0.0, 0
    for worker in range(workers):
        events.append((at_s, WorkerChanged(worker=f"{worker:016d}")))
        for turn in range(cycles):
            at_s, number = at_s + CYCLE_S, number + 1
            if turn == 5 and worker == 0:
                events.append((at_s - CYCLE_S, Advice(on=False)))
            if turn == 8 and worker == 0:
                events.append((at_s - CYCLE_S, Advice(on=True)))
            if worker == 0 and 5 <= turn < 8:
                events += cycle(number, at_s, "schedule", observation=None, off=True)
            elif turn == 9:
                events += cycle(number, at_s, observation=None)
            elif turn == 10:
                events += cycle(number, at_s, executed="low", observation=None, likelihood={"arm": 0.9, "back": 0.2})
            else:
                events += cycle(number, at_s)
        at_s += 120
        events.append((at_s, Rested(seconds=120.0)))
    events.append((at_s, Noted(text="Anna was late")))
    return [*events, (at_s, Closed())] if close else [*events, *cycle(number + 1, at_s + CYCLE_S)[:1]]


def report(journal: Path, cache: Path, *options: object) -> tuple[dict[str, Any], Path]:
    """What the command writes, and where."""
    done = fatplan("live", "report", journal, "--experiment", PAPER, "--cache", cache, "--json", *options)
    assert done.returncode == 0, done.stderr
    own = "--worker" in options
    return json.loads(done.stdout), journal.with_name(f"{journal.stem}-report{'-own' if own else ''}")


@pytest.fixture(scope="module")
def six(scenario: fp.Scenario, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("six") / "six.fatplan"
    return write_journal(path, stored(shift(scenario, 6)), {f"{0:016d}": PSEUDONYM})


@pytest.mark.slow
def test_a_worker_reads_all_about_his_own_shift(six: Path, cache_folder: Path, scenario: fp.Scenario) -> None:
    document, folder = report(six, cache_folder, "--worker", PSEUDONYM)
    page = (folder / "report.html").read_text()
    assert {path.name for path in folder.iterdir()} == {
        "report.html", "report.json", "fatigue.png", "fatigue.svg", "fatigue.csv", "doses.csv", "pauses.csv",
        "cycles.csv", "worth.csv",
    }  # fmt: skip
    assert folder.stat().st_mode & 0o077 == 0 and all(path.stat().st_mode & 0o077 == 0 for path in folder.iterdir())
    cycles = pd.read_csv(folder / "cycles.csv")
    assert list(cycles["cycle"]) == list(range(1, 61))  # nobody else's
    assert (
        list(cycles["seen"])
        == ["recognised"] * 5 + ["off"] * 3 + ["recognised", "nothing", "likelihood"] + ["recognised"] * 49
    )
    assert "In 3 cycles the belief about you was switched off" in page
    assert "Of 1 cycle nothing was seen" in page
    fatigue = pd.read_csv(folder / "fatigue.csv")
    assert set(fatigue["cycle"]) == {*range(1, 62)} - {6, 7, 8}  # the rest is before cycle 61
    doses = pd.read_csv(folder / "doses.csv").groupby("entry")["dose_s"].sum()
    assert doses["right_shoulder_flexion:positive"] > 100
    worth = pd.read_csv(folder / "worth.csv").set_index("plan")
    assert (worth["low"].dropna() <= worth["saving"].dropna()).all() and len(worth) == 3
    assert re.search(r"<td[^>]*>10</td><td[^>]*>\d\d:\d\d</td>", page) is None  # what was unseen is no deviation
    assert "11" in re.search(r"something else than it was told.*?</table>", page, re.S)[0]  # type: ignore[index]
    assert "Anna" not in page and document["closed"] is True


class Names(HTMLParser):
    """What a page refers to."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.levels: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.links += [value or "" for name, value in attributes if name in {"src", "href"}]
        self.levels += [tag] * (tag in {"h1", "h2", "script", "iframe"})


@pytest.mark.slow
def test_the_page_stands_alone_and_is_the_same_again(six: Path, cache_folder: Path) -> None:
    _, folder = report(six, cache_folder, "--worker", PSEUDONYM)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    names = Names()
    names.feed((folder / "report.html").read_text())
    assert all(link.startswith(("#", "data:")) or (folder / link).is_file() for link in names.links)
    assert names.levels[0] == "h1" and set(names.levels) == {"h1", "h2"}
    report(six, cache_folder, "--worker", PSEUDONYM)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.slow
def test_no_pseudonym_is_in_any_file(six: Path, cache_folder: Path, tmp_path: Path) -> None:
    """So nothing of it is left when it is erased, after which nobody can ask for the report."""
    for options in ((), ("--worker", PSEUDONYM)):
        _, folder = report(six, cache_folder, *options)
        assert not any(PSEUDONYM.encode() in path.read_bytes() for path in folder.iterdir())
    other = tmp_path / "other.fatplan"
    other.write_bytes(six.read_bytes())
    assert erase(other, PSEUDONYM)
    done = fatplan("live", "report", other, "--worker", PSEUDONYM)
    assert done.returncode == 2 and "nobody of this pseudonym worked" in done.stderr


@pytest.mark.slow
def test_means_over_five_or_more(six: Path, cache_folder: Path, scenario: fp.Scenario) -> None:
    """They are the means of what the workers' own reports say; one window, for each hour has fewer."""
    document, folder = report(six, cache_folder)
    table = pd.read_csv(folder / "group.csv")
    assert len(table[["from", "to"]].drop_duplicates()) == 1
    entry = "right_shoulder_flexion:positive"
    (value,) = table.query("measure == 'dose_s_per_hour' and entry == @entry")["value"]
    record = recorded(six)
    data = ShiftData.of("six", record, scenario)
    rates = []
    for worker in record.workers:
        own = data.doses_table(worker)
        off = 3 if worker == record.workers[0] else 0
        rates.append(own[own["entry"] == entry]["dose_s"].sum() / ((60 - off) * CYCLE_S / 3600))
    assert value == pytest.approx(np.mean(rates))
    (rest,) = table[table["measure"] == "pause_min_per_hour"]["value"]
    assert rest == pytest.approx(np.mean([60 * 2 / (2 + (60 - off) * CYCLE_S / 60) for off in (3, 0, 0, 0, 0, 0)]))
    assert "Anna" not in (folder / "report.html").read_text()
    assert document["statements"] == []


def recorded(path: Path) -> Record:
    found = record_of(read_journal(path))
    assert found is not None
    return found


@pytest.mark.parametrize(("workers", "close"), [(4, True), (6, False)])
def test_nothing_is_said_of_fewer_or_of_an_open_shift(
    scenario: fp.Scenario, cache_folder: Path, tmp_path: Path, workers: int, close: bool
) -> None:
    """Nor that one of them switched the belief off, nor how much they worked."""
    journal = write_journal(tmp_path / "few.fatplan", stored(shift(scenario, workers, close=close)))
    document, folder = report(journal, cache_folder)
    page = (folder / "report.html").read_text()
    assert {path.name for path in folder.iterdir()} == {"report.html", "report.json"}
    why = "fewer than 5 worked long enough" if close else "the shift is not closed"
    assert document["statements"] == [
        f"Nothing is said of the workers together, because {why}. Each can have a report of his own "
        "(`fatplan live report --worker`)."
    ]
    text = re.sub(r"<style>.*?</style>|<[^>]+>", " ", page, flags=re.S)
    for word in ("shoulder", "dose", "Pauses", "switched", "recognised", "cycles", str(60 * workers)):
        assert word not in text, word
    assert re.search(r"decided by a fallback\s+none", text)
    if not close:
        assert "it stops in the middle of a cycle at" in text


def as_if_on(event: Event) -> Event:
    """What would have been journalled had nobody been off."""
    if isinstance(event, Observed) and event.off:
        return Observed(cycle=event.cycle, executed=event.executed, observation="arm")
    return event.model_copy(update={"fallback": "none"}) if isinstance(event, Decided) else event


@pytest.mark.slow
def test_one_who_is_off_cannot_be_told_from_the_report_of_all(
    scenario: fp.Scenario, cache_folder: Path, tmp_path: Path
) -> None:
    """The page of four workers is the same whether one was off, but for the times of answers."""
    pages = []
    for number, off in enumerate((True, False)):
        events = shift(scenario, 4)
        if not off:
            events = [(at_s, as_if_on(event)) for at_s, event in events if not isinstance(event, Advice)]
        (tmp_path / str(number)).mkdir()
        journal = write_journal(tmp_path / str(number) / "few.fatplan", stored(events))
        _, folder = report(journal, cache_folder)
        pages.append((folder / "report.html").read_text())
    assert pages[0] == pages[1]


hours_of_a_worker = st.dictionaries(st.integers(0, 9), st.tuples(st.floats(0, 60), st.floats(0, 30)), max_size=10)


@settings(max_examples=30)
@given(st.dictionaries(st.sampled_from([f"w{number}" for number in range(8)]), hours_of_a_worker))
def test_windows_hold_five_or_more_and_no_hour_twice(times: Times) -> None:
    found = windows(times, FEWEST)
    hours = sorted({hour for own in times.values() for hour in own})
    for window in found:
        assert len(window.members) >= FEWEST
        for worker in window.members:
            worked = sum(own[0] for hour, own in times[worker].items() if window.first <= hour <= window.last)
            assert worked >= MIN_MINUTES
    covered = [hour for window in found for hour in range(window.first, window.last + 1)]
    assert covered == (list(range(hours[0], hours[-1] + 1)) if found else [])


def test_windows_by_hand() -> None:
    """Hours with too few join their neighbours; what is left over joins the last window."""
    everybody = [f"w{number}" for number in range(5)]
    times: Times = {worker: {0: (50.0, 0.0), 1: (50.0, 0.0), 2: (50.0, 0.0)} for worker in everybody}
    assert [(one.first, one.last) for one in windows(times, 5)] == [(0, 0), (1, 1), (2, 2)]
    times["w4"] = {1: (9.0, 0.0), 2: (9.0, 0.0)}
    assert [(one.first, one.last) for one in windows(times, 5)] == [(0, 2)]
    times["w4"] = {0: (50.0, 0.0)}
    assert [(one.first, one.last) for one in windows(times, 5)] == [(0, 2)]
    times["w4"] = {}
    assert windows(times, 5) == windows({}, 5) == []


def test_an_empty_journal_and_a_shift_that_only_began(
    scenario: fp.Scenario, cache_folder: Path, tmp_path: Path
) -> None:
    done = fatplan("live", "report", write_journal(tmp_path / "empty.fatplan", []))
    assert done.returncode == 2 and "is empty; no shift was begun" in done.stderr
    began = write_journal(tmp_path / "began.fatplan", stored([(0.0, opening(scenario))]))
    _, folder = report(began, cache_folder)
    assert "Nothing was decided." in (folder / "report.html").read_text()
    done = fatplan("live", "report", began, "--worker", "", "--experiment", PAPER, "--cache", cache_folder)
    assert done.returncode == 2 and "nobody of this pseudonym worked" in done.stderr
    done = fatplan("live", "report", began)
    assert done.returncode == 2 and "names no experiment" in done.stderr


@pytest.mark.slow
def test_another_scenario_is_refused_and_an_earlier_one_not_guessed(
    scenario: fp.Scenario, cache_folder: Path, tmp_path: Path
) -> None:
    """Parts of a shift whose scenario is another are told without estimates."""
    first = shift(scenario, 1, 5, close=False, scenario="another")
    again = [(at_s + 200, event) for at_s, event in shift(scenario, 1, 12)]
    other = write_journal(tmp_path / "other.fatplan", stored(first))
    done = fatplan("live", "report", other, "--experiment", PAPER, "--cache", cache_folder)
    assert done.returncode == 2 and "was written with another scenario" in done.stderr
    two = write_journal(tmp_path / "two.fatplan", stored([*first, *again]), {f"{0:016d}": PSEUDONYM})
    document, folder = report(two, cache_folder, "--worker", PSEUDONYM)
    assert [part["estimates_shown"] for part in document["parts"]] == [False, True]
    assert set(pd.read_csv(folder / "cycles.csv")["part"]) == {1, 2}
    assert set(pd.read_csv(folder / "fatigue.csv")["part"]) == {2}
    assert "no: the scenario was another" in (folder / "report.html").read_text()


@pytest.mark.slow
def test_the_journal_names_its_experiment(scenario: fp.Scenario, cache_folder: Path, tmp_path: Path) -> None:
    """From its own folder, so the report is written from anywhere."""
    (tmp_path / "shifts").mkdir()
    (tmp_path / "mine.yaml").write_bytes(PAPER.read_bytes())
    events = shift(scenario, 1, 3, experiment="../mine.yaml", cache=str(cache_folder))
    events[4:4] = [(40.0, CameLate(seconds=0.08)), (40.0, Resumed(origin="boot"))]
    journal = write_journal(tmp_path / "shifts" / "one.fatplan", stored(events))
    done = fatplan("live", "report", journal, "--output", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "out" / "report.html").read_text()
    assert "started again once." in page
    assert re.search(r"came to the client later than 50 ms.*?1; 80 ms", page, re.S)


def test_parts_have_planned_durations_of_their_own(scenario: fp.Scenario) -> None:
    """As the journal says; an older one does not say it, and its scenario does."""
    events = [(0.0, opening(scenario, scenario="another", planned_s=30.0)), *cycle(1, 30.0, idle_s=5.0)]
    events += [(100.0, opening(scenario)), *cycle(1, 120.0, idle_s=4.0)]
    record = record_of(stored(events))
    assert record is not None
    parts = (Part(record.segments[0], None), Part(record.segments[1], scenario))
    data = ShiftData("two", record, parts)
    assert [data.worked_s(part, part.segment.worked()[0]) for part in parts] == [30.0, CYCLE_S]
    assert [(one.ended_s, one.seconds) for one in data.pauses] == [(0.0, 5.0), (120.0 - CYCLE_S, 4.0)]


def test_a_plan_that_would_have_cost_nothing_is_no_share() -> None:
    """Nothing of nothing is nothing; where only some workers would have had none, the mean still is a share."""
    followed, nothing = np.array([0.0, 1.0, 1.0]), np.zeros(3)
    worth = Hindsight(4, followed, {"none": nothing, "some": np.array([0.0, 0.0, 4.0])})
    assert Hindsight(4, nothing, {"none": nothing}).saving("none") == (0.0, 0.0, 0.0)
    assert worth.saving("none") == (-np.inf, -np.inf, 0.0)
    assert worth.saving("some") == (0.5, -np.inf, 0.75)
    first, second = worth_words(worth)
    assert first == "By the model, none would have cost no fatigue, and what the robot did cost some."
    assert "(90 % interval up to 75.00 %)" in second
    assert worth_words(Hindsight(4, nothing, {"none": nothing}))[0].endswith("(90 % interval 0.00 to 0.00 %).")


def test_doses_of_a_cycle_that_was_not_seen_are_expected_ones(scenario: fp.Scenario) -> None:
    """The dose is that of the reactions by their chances, and the deviation that of the choice."""
    events = [(0.0, opening(scenario)), *cycle(1, CYCLE_S, observation=None)]
    record = record_of(stored(events))
    assert record is not None
    data = ShiftData("one", record, (Part(record.segments[0], scenario),))
    table = data.doses_table("").set_index("entry")
    loads = np.array([profile.load_s for profile in scenario.model.profiles[0]])
    belief = scenario.initial_belief("prior", scenario.model, np.random.default_rng(0))
    chances = expected_chances(belief, 0)
    entry = "lumbar_flexion:negative"
    own = loads[:, ENTRIES.index(entry)]
    assert table.loc[entry, "dose_s"] == pytest.approx(chances @ own)
    assert table.loc[entry, "deviation_s"] == pytest.approx(np.sqrt(chances @ (own - chances @ own) ** 2))


def test_the_card_is_one_page_that_says_what_is_processed(scenario: fp.Scenario, tmp_path: Path) -> None:
    done = fatplan("live", "card", "paper", "--keep-days", 90, "--output", tmp_path / "card.html")
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "card.html").read_text()
    text = " ".join(re.sub(r"<style>.*?</style>|<[^>]+>", " ", page, flags=re.S).split())
    assert len(text) < 4000  # what goes on a page
    for words in ("high and low", "arm and back", "90 days", "advise", "No safety function", "no legal advice"):
        assert words in text, words
    names = Names()
    names.feed(page)
    assert all(link.startswith(("#", "data:")) for link in names.links)
    journal = write_journal(tmp_path / "one.fatplan", stored([(0.0, opening(scenario, experiment="paper"))]))
    done = fatplan("live", "card", journal, "--output", tmp_path / "other.html")
    assert done.returncode == 0, done.stderr
    assert "multiple novice" in (tmp_path / "other.html").read_text()
    assert "no limit is set" in (tmp_path / "other.html").read_text()
    for wrong in (("nowhere",), ("paper", "--condition", "none"), ("paper", "--output", "card.pdf")):
        assert fatplan("live", "card", *wrong, cwd=tmp_path).returncode == 2


def test_a_card_names_what_is_learnt_of_a_hidden_worker(tmp_path: Path) -> None:
    done = fatplan("live", "card", "hidden_worker", "--output", tmp_path / "card.html")
    assert done.returncode == 0, done.stderr
    assert "how fast he tires" in (tmp_path / "card.html").read_text()
