"""The report: a page that stands alone, whose every figure has its data and its words."""

import re
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from conftest import PAPER, ROOT
from forgotten_plugins import forgotten_plugins
from published import COMMAND, publish

from fatigue_planner.core.errors import ClaimsError, PluginError
from fatigue_planner.core.plugins import load_plugin
from fatigue_planner.core.provenance import publish_manifest
from fatigue_planner.core.text import listing, percent, percent_range, significant
from fatigue_planner.ergonomics.indicators.iso_11226 import ArmHold, arm_hold
from fatigue_planner.experiment.build import cycle_profiles, reaction_requests
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.entries import ENTRIES, JOINT_GROUPS, highest_fatigue
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.output.figures.style import FigureFolder, Picture
from fatigue_planner.output.reports.page import Code, Points, Section, Table, Text, page
from fatigue_planner.output.reports.results.compare import compare, compare_page, compare_text
from fatigue_planner.output.reports.results.report import SECTIONS, SectionWriter, report, report_section
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.output.reports.results.sections.fatigue import fatigue_table
from fatigue_planner.output.reports.results.sections.findings import findings
from fatigue_planner.output.reports.results.sections.postures import overhead_sentences
from fatigue_planner.output.reports.results.sections.reactions import cycle_map_table
from fatigue_planner.output.reports.results.sections.returns import estimate_table
from fatigue_planner.output.reports.results.sections.settings import origins
from fatigue_planner.output.reports.results.sections.worth import worth_section
from fatigue_planner.output.reports.study.finished import read_study, studies_of
from fatigue_planner.output.reports.study.page import deciding
from fatigue_planner.planners.registry import policy
from fatigue_planner.reactions.reaction import Reaction, digests
from fatigue_planner.study.benchmark.results import load_results
from fatigue_planner.study.benchmark.selection import Selection, selected
from fatigue_planner.study.benchmark.tables import actions_of

UNCLAIMED = PAPER.with_name("planners.yaml")  # no file of claims lies beside it


class Page(HTMLParser):
    """What a browser would look for in a page, and whether its tags fit together."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in {"meta", "link", "img", "br"}:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def small(paper: Experiment) -> Experiment:
    """Two policies, five cycles, four runs; and no claims, which are about the whole grid."""
    return selected(paper, Selection([5], None, ["alternating", "greedy"], 4, None, None))


@pytest.fixture(scope="module")
def folder(small: Experiment, reactions: tuple[Reaction, ...], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("results")
    publish(small, reactions, folder)
    return folder


def report_data(
    experiment: Experiment, reactions: tuple[Reaction, ...], folder: Path, file: Path = UNCLAIMED
) -> ReportData:
    tables = load_results(experiment, folder, COMMAND)
    profiles = cycle_profiles(experiment, reactions)
    commands = ["fatplan simulate", "fatplan report"]
    return ReportData(experiment, reactions, profiles, tables, folder, file, commands)


@pytest.fixture(scope="module")
def made(
    small: Experiment, reactions: tuple[Reaction, ...], folder: Path, tmp_path_factory
) -> tuple[str, FigureFolder]:
    file = tmp_path_factory.mktemp("experiment") / "mine.yaml"
    file.write_text(PAPER.read_text())
    figures = FigureFolder(folder)
    return report(report_data(small, reactions, folder, file), figures), figures


@pytest.mark.slow
def test_the_page_stands_alone(made: tuple[str, FigureFolder]) -> None:
    text, _ = made
    read = Page(text)
    assert not read.open and not [tag for tag, _ in read.tags if tag in {"script", "iframe", "object"}]
    loaded = [attributes[key] for tag, attributes in read.tags for key in ("src",) if attributes.get(key)]
    assert loaded and all(str(source).startswith("data:image/svg+xml;base64,") for source in loaded)
    links = [str(attributes["href"]) for _, attributes in read.tags if "href" in attributes]
    assert all(link.startswith(("#", "data:")) or "/" not in link for link in links)
    assert "http" not in re.sub(r"base64,[\w+/=]+", "", text)


@pytest.mark.slow
def test_every_figure_has_its_data_and_its_words(made: tuple[str, FigureFolder]) -> None:
    text, figures = made
    read = Page(text)
    images = [attributes for tag, attributes in read.tags if tag == "img"]
    assert len(images) >= 7
    assert all(len(str(image["alt"])) > 40 for image in images)
    files = {str(attributes["href"]) for _, attributes in read.tags if str(attributes.get("href", "")).endswith(".csv")}
    for file in files:
        assert (figures.folder / file).stat().st_size > 0, file
    assert {path.name for path in figures.files if path.suffix == ".csv"} <= files


@pytest.mark.slow
def test_the_first_sentences_say_what_planning_is_worth(
    small: Experiment, reactions: tuple[Reaction, ...], made: tuple[str, FigureFolder], tmp_path: Path
) -> None:
    policies = {
        "low": policy({"kind": "fixed", "action": "low"}),
        "tired": policy({"kind": "threshold", "fatigue_threshold": 0.1}),
        "rotation": policy("periodic"),
        "greedy": policy("greedy"),
        "ahead": policy({"kind": "lookahead", "depth": 2, "leaf_value": "bound"}),
    }
    grid = small.benchmark.model_copy(update={"policies": policies})
    experiment = small.model_copy(update={"benchmark": grid, "figures": {}})
    publish(experiment, reactions, tmp_path)
    data = report_data(experiment, reactions, tmp_path)
    (first, *_) = findings(data)
    cost = -pd.read_csv(tmp_path / "trials.csv").groupby(["condition", "policy"])["discounted_return"].mean()
    share = 1 - cost["single_novice", "ahead"] / cost["single_novice", "low"]
    assert first.startswith(f"Single novice, 5 cycles: planning (`ahead`) costs {percent(share)} (")
    assert "less than the best fixed action (`low`)" in first and "closing the loop is worth" in first
    section = worth_section(data, FigureFolder(tmp_path))
    assert section is not None and len(pd.read_csv(tmp_path / "worth.csv")) == 3 * 4
    assert "What planning is worth is not known: the benchmark has no policy of kind" in made[0]


@pytest.mark.slow
def test_the_same_tables_make_the_same_page_and_stay_as_they_are(
    small: Experiment, reactions: tuple[Reaction, ...], folder: Path, made: tuple[str, FigureFolder], tmp_path: Path
) -> None:
    before = {path.name: path.read_bytes() for path in folder.glob("*.csv")}
    file = tmp_path / "mine.yaml"
    file.write_text(PAPER.read_text())
    again = report(report_data(small, reactions, folder, file), FigureFolder(folder))
    assert again == made[0]
    assert {path.name: path.read_bytes() for path in folder.glob("*.csv")} == before


@pytest.mark.slow
def test_the_page_says_what_the_tables_say(
    paper: Experiment, small: Experiment, reactions: tuple[Reaction, ...], folder: Path, made: tuple[str, FigureFolder]
) -> None:
    """Other tables, other numbers: those of another seed."""
    other = selected(small, Selection(None, None, None, None, None, 1))
    elsewhere = folder / "other"
    publish(other, reactions, elsewhere)
    text = report(report_data(other, reactions, elsewhere), FigureFolder(elsewhere))
    assert "seed 1." in text and "seed 2023." in made[0]
    trials = pd.read_csv(folder / "trials.csv")
    mean = trials[trials["policy"] == "alternating"].groupby("condition")["discounted_return"].mean()["single_novice"]
    assert f"({significant(mean)})" in made[0] and f"({significant(mean)})" not in text


@pytest.mark.slow
def test_claims_are_judged_where_their_file_lies_beside_the_experiments(
    small: Experiment, reactions: tuple[Reaction, ...], folder: Path, tmp_path: Path
) -> None:
    file, claims = tmp_path / "mine.yaml", tmp_path / "mine_claims.yaml"
    file.write_text(PAPER.read_text())
    claims.write_text(
        "experiment: mine.yaml\nclaims:\n  one:\n    place: here\n    quote: greedy beats alternating\n"
        "    conditions: [single_novice]\n    n_cycles: [5]\n    relation: better_mean\n"
        "    policies: [greedy]\n    others: [alternating]\n"
    )
    text = report(report_data(small, reactions, folder, file), FigureFolder(tmp_path))
    assert "greedy beats alternating" in text and "Of 1 claim of the paper, 1 is reproduced" in text


@pytest.fixture
def own_sections(monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, SectionWriter]]:
    """A quick one of the report's sections; what a test adds is forgotten after it."""
    sections = {"provenance": SECTIONS["provenance"]}
    with forgotten_plugins():
        monkeypatch.setattr("fatigue_planner.output.reports.results.report.SECTIONS", sections)
        yield sections
        monkeypatch.undo()


def test_the_section_of_a_plug_in_ends_the_page(
    small: Experiment, reactions: tuple[Reaction, ...], folder: Path, own_sections: dict[str, SectionWriter]
) -> None:
    """Loaded twice it is there once; a section that has nothing to say is left out."""
    for _ in range(2):
        load_plugin(ROOT / "examples/own_report_section.py")

    @report_section
    def nothing(report_data: ReportData, figures: FigureFolder) -> Section | None:
        return None

    assert list(own_sections) == ["provenance", "last_cycle", "nothing"]
    figures = FigureFolder(folder)
    text = report(report_data(small, reactions, folder), figures)
    assert re.findall(r"<h2>(.*?)</h2>", text) == ["1. Provenance", "2. The last cycle"]
    costs = pd.read_csv(folder / "trials.csv").query("policy == 'greedy' and condition == 'multiple_novice'")
    assert f"{costs['final_cost'].mean():.6f}" in text
    assert {"last_cycle.png", "last_cycle.svg", "last_cycle.csv"} <= {path.name for path in figures.files}


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("return 1 / 0", r"'broken' of .*mine.py: line 4: ZeroDivisionError: division by zero"),
        ("return 'text'", r"'broken' of .*mine.py: returned str, not a Section"),
    ],
)
def test_a_section_that_fails_is_named(
    small: Experiment, reactions: tuple[Reaction, ...], folder: Path, own_sections: dict[str, SectionWriter],
    tmp_path: Path, body: str, words: str,
) -> None:  # fmt: skip
    file = tmp_path / "mine.py"
    file.write_text(
        f"import fatigue_planner as fp\n@fp.report_section\ndef broken(report_data, figures):\n    {body}\n"
    )
    load_plugin(file)
    with pytest.raises(PluginError, match=words):
        report(report_data(small, reactions, folder), FigureFolder(folder))


def test_a_section_does_not_take_anothers_name(own_sections: dict[str, SectionWriter], tmp_path: Path) -> None:
    text = "import fatigue_planner as fp\n@fp.report_section\ndef {}(report_data, figures): pass\n"
    for number, name in enumerate(("provenance", "mine")):
        file = tmp_path / f"first_{number}.py"
        file.write_text(text.format(name))
        if name == "mine":
            load_plugin(file)
            file = tmp_path / "second.py"
            file.write_text(text.format(name))
        with pytest.raises(PluginError, match=rf"{file.name}: the report section '{name}' is already defined in "):
            load_plugin(file)
    assert list(own_sections) == ["provenance", "mine"]


def test_claims_about_another_experiment_are_refused(
    small: Experiment, reactions: tuple[Reaction, ...], folder: Path, tmp_path: Path
) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(PAPER.read_text())
    (tmp_path / "other.yaml").write_text(PAPER.read_text())
    text = PAPER.with_name("paper_claims.yaml").read_text().replace("experiment: paper.yaml", "experiment: other.yaml")
    (tmp_path / "mine_claims.yaml").write_text(text)
    with pytest.raises(ClaimsError, match=r"experiment: is .*other.yaml; should be mine.yaml"):
        report(report_data(small, reactions, folder, file), FigureFolder(tmp_path))


def test_shares_are_of_the_anchors_cost(small: Experiment, reactions: tuple[Reaction, ...], folder: Path) -> None:
    one = report_data(small, reactions, folder)
    table = estimate_table(one.results.contrasts, one.results.trials, "greedy").set_index("condition")
    cost = -one.results.trials.groupby(["condition", "policy"])["discounted_return"].mean()
    for condition in small.benchmark.conditions:
        expected = cost[condition, "alternating"] / cost[condition, "greedy"] - 1
        assert table.loc[condition, "extra_cost_share"] == pytest.approx(expected, rel=1e-9)


def test_a_study_of_other_reactions_or_settings_is_not_shown(paper: Experiment, tmp_path: Path) -> None:
    folder = tmp_path / "study"
    folder.mkdir()
    (folder / "lessons.txt").write_text("Planning pays.\n")
    headline = {"planner": "greedy", "condition": "single_novice", "n_cycles": 5}
    note = {
        "study": {"name": "study", "baselines": ["random"], "headline": headline, "space_filling": None},
        "experiment": paper.plain(),
        "seed": 1, "figures": [], "reactions": digests(reaction_requests(paper)),
    }  # fmt: skip
    publish_manifest(folder, "sensitivity", note, [folder / "lessons.txt"])
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "manifest.json").write_text('{"sensitivity": {}}')
    (found,) = studies_of(paper, tmp_path)
    assert found.conclusions == ["Planning pays."] and not found.combines
    assert studies_of(paper.model_copy(update={"discount": 0.9}), tmp_path) == []
    publish_manifest(folder, "sensitivity", note | {"reactions": {"a": "other"}}, [folder / "lessons.txt"])
    assert studies_of(paper, tmp_path) == []


def test_levels_that_are_numbers_and_names_that_look_like_some_are_text(paper: Experiment, tmp_path: Path) -> None:
    """A study of ranges alone, and a planner called inf."""
    row = {
        "condition": "single_novice", "n_cycles": 5, "planner": "inf", "baseline": "NaN", "factor": "alpha",
        "share": 0.5, "share_low": 0.4, "share_high": 0.6, "p_value": 0.01, "rank_share": 0.5, "rank_p_value": 0.01,
        "chance": 0.1, "swing": 0.05, "least_at": "0.1", "most_at": "0.2",
    }  # fmt: skip
    (tmp_path / "lessons.txt").write_text("")
    pd.DataFrame([row]).to_csv(tmp_path / "importance.csv", index=False)
    headline = {"planner": "inf", "condition": "single_novice", "n_cycles": 5}
    study = {"name": "study", "baselines": ["NaN"], "headline": headline, "space_filling": {"points": 4, "seed": 1}}
    note = {"study": study, "experiment": paper.plain(), "seed": 1, "figures": [], "reactions": {}}
    publish_manifest(tmp_path, "sensitivity", note, [tmp_path / "lessons.txt", tmp_path / "importance.csv"])
    (table,) = deciding(read_study(tmp_path), "")
    assert isinstance(table, Table) and "0.1 → 0.2" in table.rows[0] and table.rows[0][0] == "NaN"


def test_identical_folders_are_called_so(small: Experiment, reactions: tuple[Reaction, ...], folder: Path) -> None:
    text = compare_text(compare(folder, folder))
    assert text.count("the same in every run") == 6 and "Settings:\n  They are the same." in text and "n/a" not in text


def test_folders_with_nothing_in_common_are_told_apart(
    small: Experiment, reactions: tuple[Reaction, ...], tmp_path: Path
) -> None:
    """No table without rows, and no setting as the text of a Python object."""
    (rested, *others) = small.initial_beliefs["multiple"]
    beliefs = {**small.initial_beliefs, "multiple": (rested.model_copy(update={"probability": 0.9}), *others)}
    for name, chosen in (("a", "greedy"), ("b", "alternating")):
        own = selected(small, Selection(None, ["single_expert"], [chosen], None, None, None))
        publish(own.model_copy(update={"initial_beliefs": beliefs}) if name == "b" else own, reactions, tmp_path / name)
    found = compare(tmp_path / "a", tmp_path / "b")
    text, page_text = compare_text(found), compare_page(found, FigureFolder(tmp_path), "x")
    for shown in (text, page_text):
        assert "condition, number of cycles and policy) is in both" in shown and "p (Holm)" not in shown
        assert "Only in A: single_expert/5/greedy." in shown and "{" not in re.sub(
            "<style>.*</style>", "", shown, flags=re.S
        )
    assert not (tmp_path / "x.csv").exists()
    probability = small.initial_beliefs["multiple"][0].probability
    told = [line.split() for line in text.splitlines()]
    assert ["initial_beliefs.multiple[0].probability", str(probability), "0.9"] in told
    assert ["benchmark.policies.greedy.kind", "greedy", "–"] in told


def test_blocks_are_escaped_and_numbered() -> None:
    blocks = [
        Text("a < b & `code <i>`"), Points(["one"]), Code("x > y"), Picture("<svg/>", "caption", 'say "so"', "a.csv"),
        Table("numbers", ["name", "value"], [["<b>", "−1"], ["c", "2"]], "t.csv"), Table("more", ["x"], [["–"]]),
    ]  # fmt: skip
    text = page("A & B", "sub", [], [Section("One & only", blocks)])
    assert not Page(text).open
    for piece in (
        "<title>A &amp; B</title>", "a &lt; b &amp; <code>code &lt;i&gt;</code>", "x &gt; y", "&#34;so&#34;",
        "<b>Figure 1.</b>", "<b>Table 1.</b>", "<b>Table 2.</b>",
        '<td class="right">−1</td>', '<td class="left">&lt;b&gt;',
        'href="#one---only"',
    ):  # fmt: skip
        assert piece in text, piece


def test_words() -> None:
    assert (significant(-0.00123456), significant(float("nan"))) == ("−0.00123", "n/a")
    assert (percent(0.12345, 1), percent(-0.5, 0), percent(float("nan"))) == ("12.3 %", "−50 %", "n/a")
    assert percent_range(-0.01, 0.02, 0) == "−1 to 2 %"
    assert [listing(items) for items in ([], ["a"], ["a", "b"], ["a", "b", "c"])] == ["", "a", "a and b", "a, b and c"]


def test_joint_groups_hold_every_entry_once() -> None:
    places = np.concatenate(list(JOINT_GROUPS.values()))
    assert sorted(places) == list(range(len(ENTRIES)))
    assert {"back", "neck", "right_wrist", "left_knee"} <= set(JOINT_GROUPS)
    fatigue = np.zeros((3, 78))
    fatigue[1, ENTRIES.index("thoracic_flexion:negative")] = 0.4
    assert highest_fatigue(fatigue)["back"].tolist() == [0, 0.4, 0] and not highest_fatigue(fatigue)["neck"].any()


def test_fatigue_table_by_hand() -> None:
    fatigue = np.zeros((2, 3, 78))
    fatigue[0, 2, ENTRIES.index("right_wrist_deviation:positive")] = 1.0
    table = fatigue_table({("c", "p"): fatigue})
    wrist = table[table["joint_group"] == "right_wrist"]
    assert list(wrist["cycle"]) == [1, 2, 3] and list(wrist["highest_fatigue"]) == [0, 0, 0.5]


def test_cycle_maps_settle_where_repetition_leads(
    small: Experiment, reactions: tuple[Reaction, ...], folder: Path
) -> None:
    one = report_data(small, reactions, folder)
    table = cycle_map_table(one)
    profiles = cycle_profiles(small, reactions)
    fatigue, (name, profile) = np.zeros(78), next(iter(profiles.items()))
    for _ in range(3000):
        fatigue = profile.cycle_map().apply(fatigue)
    own = table[(table["action"] == name.action) & (table["preference"] == name.preference)]
    for row in own.itertuples():
        assert fatigue[ENTRIES.index(str(row.entry))] == pytest.approx(row.fatigue_if_repeated, abs=1e-9)


def test_origins_of_settings() -> None:
    text = (
        "tool:\n  mass_kg: 5   # [paper IV-A] in the hand\n  held: cycle   # open: or work\n"
        "# open: a comment alone\nlist:\n  - {a: 1}\nname: x # nothing\nfatigue:  # [paper IV-B]\n"
    )
    found = [(one.key, one.value, one.place, one.comment) for one in origins(text)]
    assert found == [
        ("tool.mass_kg", "5", "IV-A", "in the hand"), ("tool.held", "cycle", None, "or work"),
        ("fatigue", "", "IV-B", ""),
    ]  # fmt: skip


def test_two_folders_side_by_side(small: Experiment, reactions: tuple[Reaction, ...], tmp_path: Path) -> None:
    fewer = selected(small, Selection(None, ["single_novice"], None, 3, None, None))
    heavier = fewer.model_copy(update={"discount": 0.9})
    publish(small, reactions, tmp_path / "a")
    publish(fewer, reactions, tmp_path / "b")
    publish(heavier, reactions, tmp_path / "c")
    same = compare(tmp_path / "a", tmp_path / "b")
    assert set(same.contrasts["difference"]) == {0.0} and list(same.contrasts["trials"]) == [3, 3]
    assert same.only[1] == [] and "single_expert/5/greedy" in same.only[0]
    other = compare(tmp_path / "b", tmp_path / "c")
    assert other.settings == {"discount": ("0.95", "0.9")} and (other.contrasts["difference"] < 0).all()
    first = pd.read_csv(tmp_path / "b" / "trials.csv")
    assert other.contrasts["first_mean"].iloc[0] == pytest.approx(
        first[first["policy"] == "alternating"]["discounted_return"].mean()
    )
    assert "  discount  0.95  0.9\n" in compare_text(other) and "Versions:\n  They are the same." in compare_text(other)


def test_raised_arms_are_timed_and_counted_for_every_policy(
    small: Experiment, reactions: tuple[Reaction, ...], folder: Path
) -> None:
    """Alternating takes the high object in three of five cycles; a hold of 4 s or less is passing by."""
    first = reactions[0]
    shoulder = 7 + DEGREES_OF_FREEDOM.index("left_shoulder_flexion")
    raised = first.motion.configuration.copy()
    raised[:, shoulder] = 0
    raised[200:700, shoulder], raised[900:1200, shoulder] = np.radians(95), np.radians(120)
    hold = arm_hold(replace(first, motion=replace(first.motion, configuration=raised)))
    assert hold.longest_s == pytest.approx(5, abs=0.02) and 100 < hold.highest_deg < 130 and hold.overhead
    assert not ArmHold(4.0, 130).overhead
    holds = {reaction.name: ArmHold(27.3 if reaction.name.action == "high" else 0.0, 97) for reaction in reactions}
    data = report_data(small, reactions, folder)
    (sentence, *others) = overhead_sentences(data, holds)
    assert len(others) == len(small.benchmark.conditions) - 1
    actions = pd.read_csv(folder / "actions.csv")
    own = actions[(actions["condition"] == "single_novice") & (actions["policy"] == "greedy")]["actions"]
    share = np.mean([action == 0 for text in own for action in actions_of(str(text))])
    assert f"{percent(float(share), 0)} (`greedy`)" in sentence and "(`alternating`)" in sentence
    assert "The longest hold is 27.3 s (high/" in sentence and "ISO 11226 accepts none above 60°" in sentence
    assert overhead_sentences(data, {reaction.name: ArmHold(0.0, 20.0) for reaction in reactions}) == []


@pytest.mark.slow
def test_motions_that_no_person_would_make_are_listed(made: tuple[str, FigureFolder]) -> None:
    assert "0 motions of 4 could be a person" in made[0] and "face turned away from the work by" in made[0]
