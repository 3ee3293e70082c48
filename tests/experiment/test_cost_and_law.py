"""What an experiment file says of laws, rates, costs and strengths is checked before any work."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from conftest import PAPER, ROOT
from forgotten_plugins import forgotten_plugins

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.core.plugins import load_plugin
from fatigue_planner.experiment.build import cycle_profiles, scenario, worker_fatigue
from fatigue_planner.experiment.loader import load_experiment, parse_experiment, read_content
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.reactions.reaction import Reaction


def paper_with(**sections: object) -> Experiment:
    return parse_experiment({**read_content(PAPER), **sections}, "mine.yaml")


@pytest.mark.parametrize(
    ("sections", "message"),
    [
        ({"fatigue": {"law": {"kind": "mma"}}}, "fatigue.law.kind = 'mma': "),
        ({"fatigue": {"law": {"kind": "ma", "k": 1.0}}}, "fatigue.law.k: unknown key"),
        ({"fatigue": {"rates": "frey"}}, "fatigue.rates = 'frey': neither one of frey_law_2012, frey_law_avin_2010"),
        ({"fatigue": {"rates": "frey_law_2012"}}, "are rates of the law 3cc_r; the law is ma"),
        ({"fatigue": {"rest_multiplier": 15.0}}, "rest_multiplier: the law ma has none; 3cc_r has"),
        ({"fatigue": {"joints": {"bach": {"threshold": 0.2}}}}, "unknown joint 'bach'; did you mean 'back'?"),
        ({"fatigue": {"strength_by_angle": ("schanne",)}}, "'schanne' is neither one of anderson_leg"),
        ({"cost": {"fatigue": "worst"}}, "cost.fatigue = 'worst': "),
        ({"cost": {"weights": {"wrist": 11.0}}}, "cost.weights.wrist = 11.0: input should be less than or equal to 10"),
        ({"cost": {"weights": {"writs": 1.0}}}, "cost.weights.writs: unknown joint 'writs'; did you mean 'wrist'?"),
        ({"cost": {"posture": ({"kind": "upper_arm_raised"},)}}, "cost.posture.0.weight: is missing"),
        ({"cost": {"posture": ({"kind": "crouching", "weight": 1.0},)}}, "cost.posture.0.kind = 'crouching': "),
    ],
)
def test_a_wrong_setting_is_refused_with_its_place(sections: dict[str, object], message: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(json.loads(json.dumps({**read_content(PAPER), **sections}))))
    with pytest.raises(ExperimentError, match=re.escape(message)):
        load_experiment(path)


def test_what_needs_a_quadratic_refuses_the_worst_joint_by_name() -> None:
    content = read_content(PAPER)
    grid = content["benchmark"]
    search = {"kind": "pomcp", "backup": "max", "exploration_constant": 0.1, "descents": 500, "leaf_value": "bound"}
    grid = {**grid, "policies": {**grid["policies"], "planned": search}}
    message = (
        r"benchmark.policies.planned.leaf_value: bound needs a cost that is quadratic in fatigue; cost.fatigue is "
    )
    with pytest.raises(ExperimentError, match=f"{message}worst_joint"):
        parse_experiment({**content, "cost": {"fatigue": "worst_joint"}, "benchmark": grid}, "mine.yaml")
    parse_experiment({**content, "benchmark": grid}, "mine.yaml")


def test_an_experiment_that_says_nothing_has_the_papers_law_rates_and_cost(paper: Experiment) -> None:
    content = read_content(PAPER)
    del content["fatigue"]
    silent = parse_experiment(content, "mine.yaml")
    assert silent.fatigue == paper.fatigue and silent.cost == paper.cost
    parameters = worker_fatigue(silent)["average_man"]
    assert set(parameters.fatigue_rate) == {0.01667} and set(parameters.recovery_rate) == {0.04}
    assert parameters.by_angle is None


def test_the_example_of_a_law_of_ones_own_plans(reactions: tuple[Reaction, ...]) -> None:
    """Found by its name, with the paper's rates; its cycle maps against small steps through its own equation."""
    with forgotten_plugins():
        load_plugin(ROOT / "examples/own_fatigue_law.py")
        law = {"kind": "ma_always_recovering", "recovery_under_load": 0.5}
        mine = paper_with(fatigue={"law": law})
        profiles = cycle_profiles(mine, reactions)
        task = scenario(mine, profiles, mine.benchmark.conditions["single_novice"])
        assert task.model.active_entries.size > 40  # without a threshold nearly every joint tires a little
        parameters = worker_fatigue(mine)["average_man"]
        motion = reactions[0].motion
        f, steps = np.full(78, 0.3), 40
        load = np.hstack([np.maximum(motion.torque_nm, 0), np.maximum(-motion.torque_nm, 0)])
        for s in load / parameters.maximum_torque_nm:
            for _ in range(steps):
                h = motion.time_step_s / steps
                recovery = 0.04 * np.where(s > 0, 0.5, 1.0)
                middle = f + h / 2 * (0.01667 * s * (1 - f) - recovery * f)
                f = f + h * (0.01667 * s * (1 - middle) - recovery * middle)
        np.testing.assert_allclose(profiles[reactions[0].name].cycle_map().apply(np.full(78, 0.3)), f, atol=1e-9)
