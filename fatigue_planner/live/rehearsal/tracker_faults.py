"""The tracker sees nothing, comes late, says a thing twice or otherwise, or says what cannot be."""

from typing import Any

from fatigue_planner.core.errors import FaceRefusedError
from fatigue_planner.live.limits import LATE_CYCLES
from fatigue_planner.live.rehearsal.cell import Cell
from fatigue_planner.live.rehearsal.fault import Fault, Reaction


class TrackerSilent(Fault):
    """Nothing is said of a cycle; the robot asks for the next."""

    name, rate = "tracker_silent", 0.03

    def happen(self, cell: Cell) -> Reaction:
        """See Fault.happen."""
        pose, before = cell.present(), cell.state()["counts"]["unseen"]
        cell.work(pose)
        answer = cell.robot.decide(cell.cycle + 1)
        cell.end(pose, None)
        counted = cell.state()["counts"]["unseen"] == before + 1
        return Reaction("decided from what is foreseen", answer.cycle == cell.cycle and counted)


class TrackerLate(Fault):
    """What was seen is said after the next decision, up to some cycles later than is allowed."""

    name, rate = "tracker_late", 0.02

    def happen(self, cell: Cell) -> Reaction:
        """See Fault.happen."""
        pose = cell.present()
        seen = cell.work(pose)
        cell.robot.decide(cell.cycle + 1)
        blind = cell.end(pose, None)
        later = int(cell.rng.integers(LATE_CYCLES + 2))
        for _ in range(later):
            cell.ordinary()
        in_time = later < LATE_CYCLES
        stands = cell.robot.decide(cell.cycle)
        try:
            answer = cell.tell(blind.cycle, seen)
        except FaceRefusedError as error:
            return Reaction("refused, too late", error.code == 422 and not in_time)
        cell.expect(blind.model_copy(update={"observation": seen, "late": True}))
        return Reaction("taken late, the decision stands", in_time and _says_the_same(answer, stands))


class TrackerDouble(Fault):
    """What was seen is said twice."""

    name, rate = "tracker_double", 0.02

    def happen(self, cell: Cell) -> Reaction:
        """See Fault.happen."""
        pose = cell.present()
        seen = cell.work(pose)
        first = cell.tell(cell.cycle, seen)
        again = cell.tell(cell.cycle, seen)
        cell.end(pose, seen)
        return Reaction("known already", _says_the_same(first, again) and first.recorded == again.recorded)


class TrackerContradictory(Fault):
    """After what was seen something else is said of the same cycle."""

    name, rate = "tracker_contradictory", 0.01

    def is_possible(self, cell: Cell) -> bool:
        """See Fault.is_possible."""
        return len(cell.scenario.model.observations) > 1

    def happen(self, cell: Cell) -> Reaction:
        """See Fault.happen."""
        pose = cell.present()
        seen = cell.work(pose)
        cell.tell(cell.cycle, seen)
        other = next(name for name in cell.scenario.model.observations if name != seen)
        before = cell.state()["counts"]["contradicted"]
        try:
            cell.tell(cell.cycle, other)
            reaction = Reaction("took the second", False)
        except FaceRefusedError as error:
            counted = cell.state()["counts"]["contradicted"] == before + 1
            reaction = Reaction("refused; the first stands", error.code == 409 and counted)
        cell.end(pose, seen)
        return reaction


class TrackerAbsurd(Fault):
    """Numbers that are none, reactions that there are not, cycles far away, texts without an end."""

    name, rate = "tracker_absurd", 0.02

    def happen(self, cell: Cell) -> Reaction:
        """See Fault.happen."""
        pose = cell.present()
        before = cell.state()
        said = self._absurd(cell)
        try:
            cell.tracker.call("observe", **said)
            reaction = Reaction("taken", False)
        except FaceRefusedError as error:
            after = cell.state()
            untouched = all(after[name] == before[name] for name in ("cycle", "recorded", "joints", "counts"))
            reaction = Reaction(f"refused with {error.code}", error.code in (413, 422) and untouched)
        seen = cell.work(pose)
        cell.tell(cell.cycle, seen)
        cell.end(pose, seen)
        return reaction

    def _absurd(self, cell: Cell) -> dict[str, Any]:
        some, number = cell.scenario.model.outcomes[0], cell.cycle
        values = (float("nan"), float("inf"), -1.0, 0.0, 1e308, "much", None, True)
        return (
            {"cycle": number, "likelihood": {some: values[cell.rng.integers(len(values))]}},
            {"cycle": number, "likelihood": {}},
            {"cycle": number, "likelihood": {"flies": 0.5}},
            {"cycle": number, "observation": "flies"},
            {"cycle": number, "observation": some, "likelihood": {some: 1.0}},
            {"cycle": number, "executed": "\0"},
            {"cycle": number, "duration_s": -1.0},
            {"cycle": number + 5, "observation": some},
            {"cycle": number - 50, "observation": some},
            {"cycle": str(number), "observation": some},
            {"cycle": number, "observation": "x" * 100_000},
        )[cell.rng.integers(11)]


def _says_the_same(one: object, other: object) -> bool:
    return all(getattr(one, name) == getattr(other, name) for name in ("cycle", "action", "fallback"))
