"""What an observer would say of the postures: motions no person would make, and upper arms held above 60 degrees."""

from collections.abc import Mapping, Sequence

import numpy as np

from fatigue_planner.core.text import counted, format_label, listing, percent
from fatigue_planner.ergonomics.held_posture import HELD_S
from fatigue_planner.ergonomics.indicators.iso_11226 import UPPER_ARM, ArmHold
from fatigue_planner.output.reports.page import Block, Table, Text
from fatigue_planner.output.reports.results.report_data import ReportData
from fatigue_planner.reactions.reaction import Reaction, ReactionName

RAISED_DEG, ACCEPTED_S = UPPER_ARM.most_deg, UPPER_ARM.shortest_s
FEW = 12  # reactions that are listed one by one


def overhead_sentences(report_data: ReportData, holds: Mapping[ReactionName, ArmHold]) -> list[str]:
    """For every condition each policy's share of cycles with a raised arm, and the limit; none if no arm is held."""
    sentences = []
    for condition, settings in report_data.experiment.benchmark.conditions.items():
        worker = report_data.experiment.worker_of(settings)
        own = {name[1:]: hold for name, hold in holds.items() if name.worker == worker}
        held = {name: hold for name, hold in own.items() if hold.overhead}
        if not held:
            continue
        shares = []
        for policy in report_data.policies:
            runs = report_data.courses.get((condition, report_data.longest, policy), ())
            taken = [reaction in held for run in runs for reaction in run.reactions]
            if taken:
                shares.append(f"{percent(float(np.mean(taken)), 0)} (`{policy}`)")
        worst = max(held, key=lambda name: held[name].longest_s)
        sentences.append(
            f"{format_label(condition).capitalize()}, {report_data.longest} cycles: an upper arm is held above "
            f"{RAISED_DEG:g}° in {listing(shares)} of the cycles. The longest hold is {held[worst].longest_s:.1f} s "
            f"({'/'.join(worst)}, up to {held[worst].highest_deg:.0f}°); ISO 11226 accepts none above {RAISED_DEG:g}°, "
            f"and at {RAISED_DEG:g}° at most {ACCEPTED_S:g} s."
        )
    return sentences


def plausibility_blocks(reactions: Sequence[Reaction], holds: Mapping[ReactionName, ArmHold]) -> list[Block]:
    """The verdicts: what was recorded, which motions no person would make, what is wrong with them; raised arms."""
    simulated = [reaction for reaction in reactions if not reaction.key.recorded]
    blocks = _recorded_blocks([reaction for reaction in reactions if reaction.key.recorded])
    if simulated:
        blocks += _simulated_blocks(simulated)
    return [*blocks, *_hold_table(reactions, holds)]


def _recorded_blocks(recorded: Sequence[Reaction]) -> list[Block]:
    if not recorded:
        return []
    words = (
        f"{counted(len(recorded), 'reaction was', 'reactions were')} recorded, not simulated; what is not good about a "
        "recording is said, and it is used all the same."
    )
    rows = [
        [str(reaction.name), reaction.key.recorded, "; ".join(reaction.quality.remarks()) or "nothing"]
        for reaction in recorded[:FEW]
    ]
    return [Text(words), Table("Recordings.", ["reaction", "key of the import", "what is not good"], rows)]


def _simulated_blocks(reactions: Sequence[Reaction]) -> list[Block]:
    odd = [reaction for reaction in reactions if reaction.findings]
    verdict = f"{counted(len(reactions) - len(odd), 'motion')} of {len(reactions)} could be a person's"
    if not odd:
        words = (
            f"{verdict}: postures, gaze, free arms, ends of range, torque steps and clearances are within their bars."
        )
        return [Text(words)]
    rows = [[str(reaction.name), "; ".join(finding.text for finding in reaction.findings)] for reaction in odd[:FEW]]
    words = (
        f"{verdict}; the others are possible, but implausible: they are used all the same, and what follows from them "
        f"is to be read with care.{f' The first {FEW} of them:' if len(odd) > FEW else ''}"
    )
    table = Table("What no person would do, and the bar.", ["reaction", "what"], rows)
    return [Text(words), table]


def _hold_table(reactions: Sequence[Reaction], holds: Mapping[ReactionName, ArmHold]) -> list[Block]:
    rows = [
        [str(reaction.name), f"{hold.highest_deg:.0f}", f"{hold.longest_s:.1f}"]
        for reaction in reactions
        if (hold := holds[reaction.name]).overhead
    ]
    if not rows:
        return []
    header = ["reaction", "highest upper arm, °", f"longest hold above {RAISED_DEG:g}°, s"]
    caption = f"Upper arms held above {RAISED_DEG:g}° for more than {HELD_S:g} s; ISO 11226 accepts none."
    return [Table(caption, header, rows[:FEW])]
