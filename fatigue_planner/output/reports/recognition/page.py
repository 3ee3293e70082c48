"""The page of a recogniser: how often it errs and about what, how soon it knows, whether its probabilities are true."""

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from fatigue_planner.core.files import publish_text
from fatigue_planner.core.provenance import versions
from fatigue_planner.core.text import counted, fixed, format_label, listing, percent
from fatigue_planner.output.figures.style import FigureFolder
from fatigue_planner.output.reports.page import REPORT_FILE, Block, Code, Points, Section, Table, Text, page
from fatigue_planner.output.reports.recognition.pictures import confusion_figure, early_figure, reliability_figure
from fatigue_planner.recordings.recognition import tables
from fatigue_planner.recordings.recognition.recogniser import HeldOut, Recogniser
from fatigue_planner.recordings.recognition.stored import StoredRecogniser
from fatigue_planner.study.statistics.pairing import records

FLOOR = (
    "This is a floor: every reaction is repeated with the simulated errors of motion capture only, and simulated "
    "people of one preference differ by their bodies only. Real ones vary, so real errors are more frequent."
)


@dataclass(frozen=True)
class Judged:
    """A recogniser, what decided it, and how each of its actions did with people it did not know."""

    stored: StoredRecogniser
    recogniser: Recogniser
    held_out: Mapping[str, HeldOut]

    def known_from_s(self) -> dict[str, float | None]:
        """By action, when a reaction is known; None: never."""
        return {name: tables.known_from_s(self.recogniser, one, name) for name, one in self.held_out.items()}


def recognition_report(judged: Judged, figures: FigureFolder, command: str) -> dict[str, pd.DataFrame]:
    """Write the page, its figures and tables into the folder; the tables by name. Raises OutputFolderError."""
    recogniser, held_out = judged.recogniser, judged.held_out
    made = {
        "confusion": tables.confusion_table(recogniser),
        "pairs": tables.pair_table(recogniser),
        "early": tables.early_table(recogniser, held_out),
        "calibration": tables.calibration_table(recogniser, held_out),
        "reliability": tables.reliability_table(recogniser, held_out),
    }
    sections = [
        _confusions(judged, made["confusion"], figures),
        _pairs(made["pairs"], figures),
        _early(judged, made["early"], figures),
        _calibration(made["calibration"], made["reliability"], figures),
        _rests_on(judged, command),
    ]
    words = [*_summary(judged, made), *([FLOOR] if judged.stored.is_simulated else [])]
    subtitle = (
        f"{judged.stored.experiment}. Written by fatplan {versions()['fatplan']} from "
        f"{counted(sum(len(one.truth) for one in held_out.values()), 'repetition')} of "
        f"{counted(len(_people(judged)), 'person', 'people')}; everybody was judged by what the others did."
    )
    path = figures.folder / REPORT_FILE
    publish_text(path, page("Recognising reactions", subtitle, [Points(words)], sections))
    figures.files.append(path)
    return made


def _people(judged: Judged) -> set[str]:
    return {name for one in judged.held_out.values() for name in one.people.tolist()}


def _summary(judged: Judged, made: Mapping[str, pd.DataFrame]) -> list[str]:
    """What one learns."""
    found = []
    for action, one in judged.held_out.items():
        known = judged.recogniser.actions[action]
        share = one.right_share(judged.recogniser.temperature, known.groups)[-1]
        since = judged.known_from_s()[action]
        when = "not even after the whole cycle" if since is None else f"after {fixed(since)} s of the cycle"
        found.append(
            f"`{action}`: {percent(share, 0)} of the repetitions are recognised in the end; "
            f"{percent(tables.KNOWN_FROM, 0)} {when}."
        )
    merged = made["pairs"][made["pairs"]["merged"]]
    found += [f"{_pair(row)} are one reaction to the robot." for row in records(merged)]
    beyond = made["calibration"][made["calibration"]["error"] > made["calibration"]["chance"]]
    if len(beyond):
        where = [f"{row['action']} after {row['after']}" for row in records(beyond)]
        found.append(
            f"Probabilities are farther from the truth than chance explains in {len(beyond)} of "
            f"{counted(len(made['calibration']), 'case')}: {listing(where)}."
        )
    else:
        found.append("Probabilities are as true as could be found out with so many repetitions.")
    return found


def _pair(row: Mapping[str, object]) -> str:
    return f"`{row['action']}`: {format_label(str(row['one']))} and {format_label(str(row['other']))}"


def _confusions(judged: Judged, table: pd.DataFrame, figures: FigureFolder) -> Section:
    """A matrix for every action, as a picture and as numbers."""
    confusions = {action: known.confusion for action, known in judged.recogniser.actions.items()}
    words = [
        f"{format_label(action)}: "
        + listing(
            [
                f"{format_label(name)} {fixed(float(one.probability()[row].max()), 2)} as "
                f"{format_label(one.recognised[int(one.probability()[row].argmax())])}"
                for row, name in enumerate(one.preferences)
            ]
        )
        for action, one in confusions.items()
    ]
    caption = "The probability that a reaction (left) is recognised as another (below), after the whole cycle."
    blocks: list[Block] = [
        figures.add("confusion", confusion_figure(confusions), table, caption, "; ".join(words) + ".")
    ]
    for action, one in confusions.items():
        probability, (lower, upper) = one.probability(), one.interval()
        rows = [
            [
                format_label(name), str(int(one.counts[row].sum())), fixed(float(one.effective[row]), 0),
                *(
                    f"{probability[row, column]:.2f} ({lower[row, column]:.2f} to {upper[row, column]:.2f})"
                    for column in range(len(one.recognised))
                ),
            ]
            for row, name in enumerate(one.preferences)
        ]  # fmt: skip
        header = ["shown", "repetitions", "worth", *(f"as {format_label(name)}" for name in one.recognised)]
        blocks.append(Table(f"`{action}`: recognised as what, with 95 % intervals.", header, rows, "confusion.csv"))
    blocks.append(
        Text(
            "Repetitions of one person resemble each other: the intervals count them for what they are worth. No "
            "probability is 0, as what was not seen in so many repetitions may still happen. `recognition.yaml` has "
            "the matrices as an experiment takes them."
        )
    )
    return Section("What is taken for what", blocks)


def _pairs(table: pd.DataFrame, figures: FigureFolder) -> Section:
    rows = [
        [
            format_label(row["action"]), f"{format_label(row['one'])} and {format_label(row['other'])}",
            fixed(row["difference_deg"]), percent(row["told_apart"], 0), "yes" if row["merged"] else "no",
        ]
        for row in records(table)
    ]  # fmt: skip
    caption = (
        "Every pair of reactions: root mean square of the difference of their mean angles during work, over all "
        "degrees of freedom; how many of the two, equally likely, are told apart; whether they are one to the robot."
    )
    header = ["action", "pair", "apart, °", "told apart", "one"]
    return Section("Which reactions are one", [Table(caption, header, rows, figures.add_table("pairs", table))])


def _early(judged: Judged, table: pd.DataFrame, figures: FigureFolder) -> Section:
    since = judged.known_from_s()
    known = listing([f"{name} after {fixed(at)} s" for name, at in since.items() if at is not None])
    never = listing([name for name, at in since.items() if at is None])
    words = [f"{percent(tables.KNOWN_FROM, 0)} are recognised: {known}."] if known else []
    words += [f"Never so many: {never}."] if never else []
    caption = (
        "The share of repetitions that is recognised by what was seen until then, every reaction counting the same; "
        f"dashed: {percent(tables.KNOWN_FROM, 0)}. Reactions that are one count as one."
    )
    picture = figures.add("early", early_figure(table, judged.recogniser.cycle), table, caption, " ".join(words))
    return Section("How soon a reaction is known", [picture])


def _calibration(table: pd.DataFrame, bins: pd.DataFrame, figures: FigureFolder) -> Section:
    picture = figures.add(
        "reliability",
        reliability_figure(bins),
        bins,
        "How often it is right, over how probable it held what it recognised; all actions together. A point for every "
        "tenth of probability, the larger the more repetitions; on the line it is right as often as it says.",
        listing(
            [
                f"after {row['after']}, of {row['repetitions']} held {fixed(row['probability'], 2)} probable "
                f"{fixed(row['right'], 2)} were right"
                for row in records(bins[bins["repetitions"] == bins.groupby("after")["repetitions"].transform("max")])
            ]
        )
        + ".",
    )
    rows = [
        [
            format_label(row["action"]), str(row["after"]), str(row["repetitions"]), fixed(row["error"], 3),
            fixed(row["expected"], 3), fixed(row["chance"], 3),
            "farther" if row["error"] > row["chance"] else "as chance",
        ]
        for row in records(table)
    ]  # fmt: skip
    caption = (
        "Expected calibration error: how far probabilities are from how often they are right, the mean over tenths. "
        "True: the mean error that true probabilities show on as many repetitions; chance: 95 % of them stay below."
    )
    header = ["action", "after", "repetitions", "error", "true", "chance", "verdict"]
    return Section(
        "Whether the probabilities are true",
        [
            picture,
            Table(caption, header, rows, figures.add_table("calibration", table)),
            Text(
                "A calibration error is never below 0, so that even true probabilities show one: the column `true`. Of "
                "20 cases one is beyond chance by chance."
            ),
        ],
    )


def _rests_on(judged: Judged, command: str) -> Section:
    stored = judged.stored
    rows = [
        ["key", stored.key[:16]],
        ["people", str(len(_people(judged)))],
        ["degrees of freedom", str(len(judged.recogniser.joints))],
        ["two reactions are one below", percent(stored.told_apart_from, 0)],
    ]
    if (capture := stored.capture) is None:
        rows.append(["repetitions", f"{len(stored.reactions)}, recorded"])
    else:
        rows += [
            ["error of a session", f"{fixed(capture.offset_deg)}°"],
            ["error that changes", f"{fixed(capture.noise_deg)}°, over {fixed(capture.correlation_time_s)} s"],
            ["repetitions of each reaction", f"{capture.repetitions}, simulated"],
            ["seed", str(capture.seed)],
        ]
    return Section(
        "What this rests on",
        [
            Table("With what the recogniser was trained.", ["what", "value"], rows),
            Text("This command writes it again:"),
            Code(command),
        ],
    )
