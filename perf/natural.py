"""The natural human beside the bars of plausible motion, and his speed beside the paper's human.

    python perf/natural.py [experiment.yaml ...]

The worst of every measure over all reactions of the experiments, by default of those that ship, with the paper's
task as the natural human does it, and how far pelvis and head are turned, for which there is no bar; the same for
random targets, on which nothing was tuned; then ticks per second of both humans, on the paper's reactions,
interleaved.
"""

import os
import sys
import time
from dataclasses import asdict
from pathlib import Path

# One thread of linear algebra, as in `fatplan simulate`.
os.environ |= {f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "OMP", "MKL")}

import numpy as np

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.loader import load_experiment, parse_experiment, read_content
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.anthropometry import Anthropometry
from fatigue_planner.human.kinematics import poses_of, tree_of
from fatigue_planner.human.skeleton import BODIES
from fatigue_planner.motion import posture_measures as posture
from fatigue_planner.motion.motion import Motion
from fatigue_planner.motion.physiology.facing import heading
from fatigue_planner.motion.plausibility import BARS, measure_plausibility
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.motion.verification import measure

EXPERIMENTS = Path(__file__).parents[1] / "experiments"
SHIPPED = ("paper", "pose_grid", "co_transport", "workers")
ROUNDS = 5


def natural(file: Path) -> Experiment:
    """The experiment of a file with the natural human in his own stance."""
    content = read_content(file)
    for worker in content.get("workers", {}).values():
        for key in ("human", "natural_posture_deg"):
            worker.pop(key, None)
    return parse_experiment(content | {"human": "natural"}, str(file))


def unseen(human: str) -> Experiment:
    """Random targets in front of a worker, for either hand or both, with and without orientation."""
    random, actions = np.random.default_rng(5), {}
    for index in range(16):
        side, sign = (("right", -1), ("left", 1))[index % 2]
        y = sign * random.uniform(-0.1, 0.45)
        place = {"x": random.uniform(0.2, 0.55), "y": y, "z": random.uniform(0.35, 1.75)}
        goal = {"position_m": place}
        if index % 3:
            turn = {"y": float(random.choice([-120, -90, -60, 0])), "z": float(random.choice([0, 30 * sign]))}
            goal["orientation_deg"] = turn
        goals = {f"{side}_hand": goal}
        if index % 5 == 0:
            other = "left" if side == "right" else "right"
            goals[f"{other}_hand"] = {"position_m": place | {"y": -y}}
        actions[f"random{index}"] = goals
    upright = {"kind": "segment_upright", "segment": "thorax", "weight": 1.0, "stiffness_per_s2": 80.0}
    content = {
        "name": f"random_{human}", "human": human, "tool": {"mass_kg": 2.0}, "actions": actions,
        "cycle": {"reach_s": 3.0, "work_s": 1.0, "return_s": 3.0},
        "preferences": {"arm": {"tasks": (upright,)}, "as_he_likes": {"tasks": ()}},
    }  # fmt: skip
    return parse_experiment(content, "random targets")


def plausible(experiment: Experiment) -> None:
    """Print how many reactions can be used, and how many of these are plausible."""
    usable = fine = 0
    requests = reaction_requests(experiment)
    for request in requests:
        try:
            motion = simulate(request.motion)
        except FailedMotionError:
            continue
        seen, quality = measure_plausibility(request.motion, motion), measure(request.motion, motion)
        if quality.work_hand_error_m <= experiment.accuracy.hand_error_m:
            usable += 1
            fine += not seen.findings()
    print(f"{experiment.name}: {len(requests)} reactions, {usable} with the hands on target, {fine} of them plausible")


def turned_deg(person: Anthropometry, motion: Motion) -> dict[str, float]:
    """How far the pelvis is turned on the feet and the head in the chest, in the middle of the work."""
    middle = motion.middle("work")
    poses = poses_of(tree_of(person), motion.configuration[middle : middle + 1])
    neck = posture.turn(poses, "head", "thorax")[0]
    angles = heading(poses.rotation[0, BODIES.index("pelvis")]), np.arctan2(neck[1, 0], neck[1, 1])
    return dict(zip(("pelvis_turned_deg", "neck_twist_deg"), np.abs(np.degrees(angles)).tolist(), strict=True))


def table(experiments: list[Experiment]) -> None:
    """Print the worst value of every measure, where it is, and its bar; and what cannot be used."""
    worst: dict[str, tuple[float, str]] = {}
    turned: dict[str, list[float]] = {}
    count, beyond, leans = 0, [], {}
    for experiment in experiments:
        for request in reaction_requests(experiment):
            name, count = f"{experiment.name}/{request.name}", count + 1
            try:
                motion = simulate(request.motion)
            except FailedMotionError as error:
                beyond.append(f"{name}: {error}")
                continue
            seen, quality = measure_plausibility(request.motion, motion), measure(request.motion, motion)
            leans[name] = seen.lean_deg
            values = {key: value for key, value in asdict(seen).items() if isinstance(value, float)}
            values |= {"hand_error_m": quality.work_hand_error_m, "eased_ticks": quality.eased_ticks}
            values |= {"equation_of_motion_nm": quality.equation_of_motion_nm, "energy": quality.energy_error_share}
            values["tissue_violation_nm"] = quality.tissue_violation_nm
            for key, angle in turned_deg(request.motion.worker.anthropometry(), motion).items():
                turned.setdefault(key, []).append(angle)
                values[key] = angle
            for key, value in values.items():
                worst[key] = max(worst.get(key, (-1.0, "")), (value, name))
            texts = [finding.text for finding in seen.findings()] + quality.faults(experiment.accuracy)
            beyond += [f"{name}: {text}" for text in texts]
    print(f"{count} reactions; the worst of every measure:")
    for key, (value, name) in worst.items():
        bar = f"{BARS[key].most:g}" if key in BARS else "-"
        print(f"  {key:<24} {value:10.3g}  bar {bar:>6}  {name}")
    print("medians:", {key: f"{np.median(angles):.1f}" for key, angles in turned.items()})
    for name, lean in leans.items():
        if name.endswith(("low/arm", "low/back")):
            print(f"  lean of {name}: {lean:.1f} deg")
    print(f"{len(beyond)} beyond a bar:", *beyond, sep="\n  ")


def speed() -> None:
    """Print the ticks per second of both humans, each reaction's fastest of several rounds in turn."""
    requests = {
        human: [request.motion for request in reaction_requests(experiment)]
        for human, experiment in (
            ("paper", load_experiment(EXPERIMENTS / "paper.yaml")), ("natural", natural(EXPERIMENTS / "paper.yaml")),
        )
    }  # fmt: skip
    fastest: dict[tuple[str, int], float] = {}
    ticks = 0
    for _ in range(ROUNDS + 1):  # the first compiles
        ticks = 0
        for index in range(len(requests["paper"])):
            for human, own in requests.items():
                begin = time.process_time()
                ticks += len(simulate(own[index]).torque_nm)
                spent = time.process_time() - begin
                fastest[human, index] = min(spent, fastest.get((human, index), spent))
    rates = {human: ticks / 2 / sum(s for (of, _), s in fastest.items() if of == human) for human in requests}
    print({human: f"{rate:.0f} ticks/s" for human, rate in rates.items()}, f"{rates['natural'] / rates['paper']:.2f} x")


if __name__ == "__main__":
    files = [Path(name) for name in sys.argv[1:]] or [EXPERIMENTS / f"{name}.yaml" for name in SHIPPED]
    table([natural(file) for file in files])
    for human in ("paper", "natural"):
        plausible(unseen(human))
    speed()
