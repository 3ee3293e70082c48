"""Ranges of motion of the model beside the sources'."""

from fatigue_planner.human.joint_data import ranges_of_motion
from fatigue_planner.output.reports.human.markdown import number, outside, table, verdict
from fatigue_planner.output.reports.human.references import references


def ranges_section() -> str:
    """Both ends of every range, what the sources say, and whether the model is between them."""
    rows, inside, cited = [], {}, []
    for row in references().ranges_of_motion:
        name = " + ".join(freedom.replace("_", " ") for freedom in row.freedoms)
        for end in (0, 1):
            ours = [ranges_of_motion()[freedom] for freedom in row.freedoms]
            value = sum(motion.max if end else motion.min for motion in ours)
            said = {source: ends[end] for source, ends in row.ranges.items() if ends[end] is not None}
            cited += [source for source in row.ranges if source not in cited]
            if not said:
                continue
            known = [angle for angle in said.values() if angle is not None]
            bounds = (min(known), max(known))
            label = f"{name}, {'most' if end else 'least'}"
            inside[f"{label} ({_distance(value, bounds)})"] = bounds[0] <= value <= bounds[1]
            listed = ", ".join(f"{source} {number(angle, 0)}" for source, angle in said.items())
            rows.append([label, number(value, 0), listed, verdict(value, bounds)])
    return "\n\n".join(
        [
            "## Ranges of motion",
            table(["end of the range", "model, °", "sources, °", "verdict"], rows),
            "“inside” is between the smallest and the largest value of the sources; directions as in "
            "`human/data/ranges_of_motion.yaml`. Joints with no source are left out.",
            outside("the sources' values", inside),
            references().cite(*cited),
        ]
    )


def _distance(value: float, bounds: tuple[float, float]) -> str:
    nearest = min(max(value, bounds[0]), bounds[1])
    return f"by {number(abs(value - nearest), 0)}°"
