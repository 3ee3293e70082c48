"""The zoo (examples/) and the small problem with every function, compiled: as plain Python, exact, as published.

`python perf/zoo.py` measures what is published with all its games.
"""

import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import crying_baby
import light_dark
import numpy as np
import pytest
import rock_sample
import tiger
from any_problem import ASK, HELP, ON, TURN_BACK, ferry, ferry_values, line
from scipy import stats
from small_problems import lookahead

from fatigue_planner.planners.pomcp.sparse.policy import Search, SparsePolicy
from fatigue_planner.pomdp.beliefs.belief import Belief

FALSE_ALARM = 1e-6
WIDE = (1.0, 0.3, 2.0, 0.25)
MANY = (1e6, 0.0, 1e6, 0.0)


def grown(belief: Belief, seed: int = 1, **others: Any) -> Any:
    search = Search("mean", "fixed", 5.0, "random_rollout", 10, 150, None)._replace(**others)
    policy = SparsePolicy(search)
    return policy.tree(belief, np.random.default_rng(seed), 0.0)


def searched() -> dict[str, Any]:
    """Trees of all that is new: forbidden, preferred, ending, widened; values of a lookahead."""
    helped, small = ferry(**HELP), rock_sample.start(rock_sample.rock_sample(3, [(1, 1), (2, 0)]), (0, 1))
    trees = {
        "ferry": grown(ferry(), backup="max", exploration="scaled", leaf_value="greedy_rollout"),
        "helped": grown(helped),
        "bound": grown(helped, leaf_value="bound", widening=WIDE),
        "line": grown(line(), widening=WIDE),
        "rocks": grown(small),
    }
    values = {name: {part: getattr(tree, part).tobytes() for part in tree._fields} for name, tree in trees.items()}
    return values | {"lookahead": lookahead(helped, 3, leaf_value="bound").tobytes()}


SEARCHED = """
import pickle, sys
from pathlib import Path
from test_zoo import searched
Path(sys.argv[1]).write_bytes(pickle.dumps(searched()))
"""


@pytest.mark.slow
def test_compiled_search_of_any_problem_equals_plain_python_bit_for_bit(tmp_path: Path) -> None:
    """The same trees and values, to the last bit, with the compiler switched off."""
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    environment = os.environ | {"PYTHONPATH": path, "NUMBA_DISABLE_JIT": "1"}
    subprocess.run([sys.executable, "-c", SEARCHED, tmp_path / "plain"], env=environment, check=True)
    plain, ours = pickle.loads((tmp_path / "plain").read_bytes()), searched()
    assert len(plain) == 6
    for name, expected in plain.items():
        assert ours[name] == expected, name


@pytest.mark.slow
@pytest.mark.parametrize(
    ("backup", "widening", "tolerance"), [("max", None, 0.1), ("mean", None, 0.4), ("mean", MANY, 0.4)]
)
def test_values_converge_where_actions_are_forbidden_and_the_task_ends(
    backup: str, widening: Any, tolerance: float
) -> None:
    """The best action's value after 50,000 descents against recursion; t-test of 8 searches, false alarm 1e-6.

    The last case is POMCPOW with room for every observation: its weighted beliefs are then as right as POMCP's.
    """
    exact = ferry_values(0.4, 0, 60)
    best = max(exact, key=lambda action: exact[action])
    assert best == ASK and exact[ASK] - max(exact[ON], exact[TURN_BACK]) > 0.3
    options = {"backup": backup, "widening": widening, "leaf_value": "none", "exploration_constant": 10.0}
    trees = [grown(ferry(), seed, descents=50_000, **options) for seed in range(8)]
    found = np.array([tree.nodes["value"][0][best] for tree in trees]) - exact[best]
    noise = stats.t.isf(FALSE_ALARM / 2, 7) * stats.sem(found)
    assert noise < 1.0 and abs(found.mean()) < tolerance + noise


def highest(returns: list[float]) -> float:
    """The upper end of the confidence interval of the mean, one-sided: a lower true mean is a false alarm of 1e-6."""
    return float(np.mean(returns) + stats.t.isf(FALSE_ALARM, len(returns) - 1) * stats.sem(returns))


@pytest.mark.slow
def test_the_zoo_is_not_below_what_is_published() -> None:
    """As far as few games can tell (false alarm 1e-6 each); spread and all games: perf/zoo.py."""
    rng = np.random.default_rng(5)
    rocks = rock_sample.start(rock_sample.rock_sample(7, rock_sample.MAP_7_8), (0, 3))
    found = [rock_sample.play(rocks, rock_sample.SEARCH, rng)[0] for _ in range(15)]
    assert highest(found) > 15.5 and np.mean(found) > 12
    found = [light_dark.play(light_dark.SEARCH, rng)[0] for _ in range(100)]
    assert highest(found) > 56.1 and np.mean(found) > 50
    assert crying_baby.exact_value() == pytest.approx(-16.31, abs=0.01)


@pytest.mark.slow
def test_what_the_lookahead_does_to_the_tiger_is_worth_almost_the_optimum() -> None:
    """Exactly, by the probability of the tiger behind the left door after every history: 17.70 of 17.76."""
    policy, memory = tiger.LOOKAHEAD.build(), {}

    def act(net: int) -> int:
        if net not in memory:
            left = 1 / (1 + (0.15 / 0.85) ** net)
            belief = tiger.fp.ExactBelief(tiger.PROBLEM, tiger.NO_IDEA.states, np.array([left, 1 - left]))
            memory[net] = policy.act(belief, np.random.default_rng(0)).action
        return memory[net]

    def worth(steps: int, best: bool) -> dict[int, float]:
        after = dict.fromkeys(range(-steps - 1, steps + 2), 0.0)
        for left_to_go in range(1, steps + 1):
            now = {}
            for net in range(-steps - 1 + left_to_go, steps + 2 - left_to_go):
                left = 1 / (1 + (0.15 / 0.85) ** net)
                heard = 0.85 * left + 0.15 * (1 - left)
                values = [10 - 110 * left + 0.95 * after[0], 10 - 110 * (1 - left) + 0.95 * after[0]]
                values.append(-1 + 0.95 * (heard * after[net + 1] + (1 - heard) * after[net - 1]))
                now[net] = max(values) if best else values[act(net)]
            after = now
        return after

    assert worth(50, best=True)[0] == pytest.approx(17.76, abs=0.01)
    assert worth(50, best=False)[0] == pytest.approx(17.70, abs=0.01)
