"""Strengths beside measured ones, and the sets that ship with the package."""

from fatigue_planner.human.model import Worker
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM, SIDES
from fatigue_planner.human.strength_sets import load_strengths, shipped_sets
from fatigue_planner.output.reports.human.markdown import noteworthy, number, table
from fatigue_planner.output.reports.human.references import references

COLUMNS = ("kamon", "anderson_young", "anderson_older")
# Entries that the table of the sets shows: the joints that carry the paper's task.
SHOWN = {
    "back extension": "lumbar_flexion:negative",
    "shoulder flexion": "right_shoulder_flexion:positive",
    "elbow flexion": "right_elbow_flexion:positive",
    "radial deviation": "right_wrist_deviation:positive",
    "hip extension": "right_hip_flexion:negative",
    "knee extension": "right_knee_flexion:negative",
    "plantar flexion": "right_ankle_flexion:negative",
}


def _torques(name: str) -> dict[str, tuple[float, str]]:
    """Torque in N.m and source of every entry of a set by name, the right side's twice: with and without side."""
    found = {}
    for (freedom, direction), entry in load_strengths(name).entries.items():
        for shown in (freedom, freedom.removeprefix("right_")):
            found[f"{shown}:{direction}"] = (entry.torque_nm, entry.source)
    return found


def strengths_section(worker: Worker) -> str:
    """The worker's strengths beside every source that measured the same entry."""
    torques = _torques(worker.strength)
    others = [name for name in references().strengths if name not in COLUMNS]
    rows, cited = [], []
    deviations: dict[str, float] = {}
    for entry in _entries():
        torque, source = torques[entry]
        measured = {name: row.torque_nm(entry, worker) for name, row in references().strengths.items()}
        known = {name: value for name, value in measured.items() if value is not None}
        cited += [name for name in known if name not in cited]
        cells = [entry.replace("_", " ").replace(":", ", "), number(torque)]
        for name in COLUMNS:
            cells += [number(measured[name], 0), number(torque / known[name], 2) if name in known else "–"]
        listed = [
            f"{name} {number(known[name])} ({number(torque / known[name], 2)})" for name in others if name in known
        ]
        rows.append([*cells, ", ".join(listed) or "–", source])
        deviations |= {f"{cells[0]} from {name}": torque / value - 1 for name, value in known.items()}
    header = ["entry (right side)", "set, N·m"]
    for name in COLUMNS:
        header += [f"{name}, N·m", "ratio"]
    return "\n\n".join(
        [
            f"## Strengths: `{worker.strength}` against measured ones",
            table([*header, "others, N·m (ratio)", "the set's own source"], rows),
            "A ratio is the set's value by the source's: 1 where the source is the set's own. Measured strengths vary "
            "with posture, method and group; the model's are constant over the range, as in the paper.",
            noteworthy("a source", deviations),
            references().cite(*sorted(cited, key=list(references().strengths).index)),
        ]
    )


def _entries() -> list[str]:
    """Entries of the middle and the right side, in the model's order, without side."""
    freedoms = [name.removeprefix("right_") for name in DEGREES_OF_FREEDOM if not name.startswith(f"{SIDES[1]}_")]
    return [f"{freedom}:{direction}" for freedom in freedoms for direction in ("positive", "negative")]


def sets_section() -> str:
    """The sets that ship with the package, with what tells them apart."""
    rows = []
    for name in shipped_sets():
        strengths, torques = load_strengths(name), _torques(name)
        shown = [number(torques[entry][0]) for entry in SHOWN.values()]
        rows.append([f"`{name}`", strengths.population, *shown])
    return "\n\n".join(
        [
            "## Strength sets",
            table(["set", "who", *(f"{name}, N·m" for name in SHOWN)], rows),
            "Each file of `human/data/strengths` names a source for each number, and whether it was read, recalled, "
            "computed or assumed. A worker's `strength` selects a set or a file of your own.",
        ]
    )
