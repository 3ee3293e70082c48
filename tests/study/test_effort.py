"""How long a decision may take: the counts behind the estimate against the work that is done, and what is refused."""

import math
import re
from collections import Counter
from typing import Any

import numpy as np
import pytest
from plain_python import interpreted, plant_in_search
from small_problems import NOISY, belief_in, pomcp, relaxed, small_model, two_starts

from fatigue_planner.core.errors import ExperimentError
from fatigue_planner.planners import lookahead
from fatigue_planner.planners.lookahead import LookaheadPolicy, LookaheadSettings
from fatigue_planner.planners.pomcp.policy import PomcpPolicy
from fatigue_planner.pomdp import simd
from fatigue_planner.pomdp.beliefs.belief import Belief
from fatigue_planner.pomdp.beliefs.moments import belief_in_moments
from fatigue_planner.study.benchmark import effort
from fatigue_planner.study.benchmark.effort import check_effort, seconds_of


def ahead(depth: int, leaf_value: str = "none") -> LookaheadSettings:
    return LookaheadSettings(kind="lookahead", depth=depth, leaf_value=leaf_value, rollout_cycles=7)


@pytest.fixture
def work(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Counts maps of cycles and values of plans; everything runs as plain Python."""
    done: Counter[str] = Counter()
    plainly = simd._plain

    def counting(gain: Any, offset: Any, state: Any, row: int, store: bool, squares: bool) -> float:
        done["maps" if squares else "plans"] += 1
        return plainly(gain, offset, state, row, store, squares)

    monkeypatch.setattr(simd, "_plain", counting)
    plant_in_search(monkeypatch)
    made = lookahead.lookahead_kernel
    monkeypatch.setattr(lookahead, "lookahead_kernel", lambda *which: interpreted(made(*which)))
    return done


def estimated(what: str, settings: Any, belief: Belief, monkeypatch: pytest.MonkeyPatch) -> float:
    """How many maps of cycles or values of plans the estimate counts."""
    nothing, one = (0, 0), (1, 0)
    monkeypatch.setattr(effort, "MAP", one if what == "maps" else nothing)
    monkeypatch.setattr(effort, "PLAN", one if what == "plans" else nothing)
    monkeypatch.setattr(effort, "NEW_PLAN", nothing)
    monkeypatch.setattr(effort, "KNOWN", nothing)
    for name in ("SHARE", "CHOICE"):
        monkeypatch.setattr(effort, name, 0)
    monkeypatch.setattr(effort, "SLOWER", 1e9)
    return seconds_of(settings, belief)


BELIEFS = {
    "novice": relaxed(small_model(0.0)),
    "expert": two_starts(small_model(math.inf)),
    "of some expertise": two_starts(small_model(25.0)),
    "recognised with error": two_starts(small_model(25.0, NOISY)),
    "many states": belief_in(small_model(0.0), np.random.default_rng(1).random((20, 3)), np.full(20, 0.05)),
}


@pytest.mark.parametrize("leaf_value", ["none", "greedy_rollout", "random_rollout"])
@pytest.mark.parametrize("name", BELIEFS)
def test_a_lookahead_applies_the_maps_that_are_counted(
    name: str, leaf_value: str, work: Counter[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    belief, settings = BELIEFS[name], ahead(2, leaf_value)
    if name == "many states" and leaf_value != "none":
        belief = belief_in(belief.model, np.zeros((9, 3)), np.full(9, 1 / 9))
    LookaheadPolicy(settings).act(belief, np.random.default_rng(0))
    assert work["maps"] <= estimated("maps", settings, belief, monkeypatch) <= 4 * work["maps"]


@pytest.mark.parametrize("name", BELIEFS)
def test_a_lookahead_values_no_more_plans_than_are_counted(
    name: str, work: Counter[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """All plans are counted; those that are nowhere the best are left out."""
    belief, settings = BELIEFS[name], ahead(2, "bound")
    LookaheadPolicy(settings).act(belief, np.random.default_rng(0))
    kept = belief_in_moments(belief).model.bound_arrays.constant.shape[1]
    counted = estimated("plans", settings, belief, monkeypatch) * kept / effort.most_plans(2)
    assert work["plans"] <= round(counted) <= 1.5 * work["plans"]


def test_a_novices_search_applies_no_more_maps_than_are_counted(
    work: Counter[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A novice's tree is even, but of four branches: its descents are half as deep as is assumed."""
    belief, settings = BELIEFS["novice"], pomcp(300, 0.01)
    PomcpPolicy(settings).act(belief, np.random.default_rng(0))
    assert work["maps"] <= estimated("maps", settings, belief, monkeypatch) <= 7 * work["maps"]


@pytest.mark.parametrize("name", ["expert", "of some expertise", "recognised with error"])
@pytest.mark.parametrize("leaf_value", ["none", "bound"])
def test_a_search_goes_no_deeper_than_along_one_path(
    name: str, leaf_value: str, work: Counter[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    belief, settings = BELIEFS[name], pomcp(100, 0.0, leaf_value=leaf_value)
    PomcpPolicy(settings).act(belief, np.random.default_rng(0))
    assert work["maps"] <= estimated("maps", settings, belief, monkeypatch)


def test_an_expert_who_is_never_tired_in_one_way_is_searched_along_one_path(
    work: Counter[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One way tires nobody. From two states, as from one the steps would be recalled; each action is tried once."""
    model = small_model(math.inf)
    gain, offset = (table.reshape(1, 2, 2, -1)[..., :3].copy() for table in (model.arrays.gain, model.arrays.offset))
    offset[:, 0, 0] = 0
    idle = model.with_maps(gain, offset, model.workers)
    at_rest = belief_in(idle, np.array([[0.0, 0, 0], [1e-9, 0, 0]]), np.full(2, 0.5))
    settings = pomcp(100, 0.0, backup="max")
    PomcpPolicy(settings).act(at_rest, np.random.default_rng(0))
    assert work["maps"] <= estimated("maps", settings, at_rest, monkeypatch) <= 2 * work["maps"]


# --- what is refused ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("settings", "belief"),
    [
        (ahead(30), BELIEFS["novice"]),
        (ahead(30, "bound"), BELIEFS["many states"]),
        (ahead(20), BELIEFS["recognised with error"]),
        (pomcp(1_000_000, leaf_value="greedy_rollout", rollout_cycles=1000), BELIEFS["novice"]),
    ],
)
def test_what_takes_too_long_is_refused_and_what_is_named_instead_is_accepted(settings: Any, belief: Belief) -> None:
    with pytest.raises(ExperimentError) as refused:
        check_effort("benchmark.policies.p", settings, belief, 2.0)
    message = str(refused.value)
    key = "depth" if settings.kind == "lookahead" else "descents"
    assert message.startswith(f"benchmark.policies.p.{key} = {getattr(settings, key)}: ")
    instead = re.search(r"Take (\d+) or less", message)
    assert instead is not None
    accepted = settings.model_copy(update={key: int(instead[1])})
    check_effort("benchmark.policies.p", accepted, belief, 2.0)
    assert "benchmark.max_decision_s allows 2 s" in message or "1e+07 are allowed" in message


def test_more_time_may_be_allowed_but_not_more_memory() -> None:
    check_effort("p", ahead(12), BELIEFS["novice"], 2.0)
    with pytest.raises(ExperimentError, match=r"p\.depth = 14: a decision may take 7\.9 s"):
        check_effort("p", ahead(14), BELIEFS["novice"], 2.0)
    check_effort("p", ahead(14), BELIEFS["novice"], 20.0)
    with pytest.raises(ExperimentError, match="beliefs would have"):
        check_effort("p", ahead(30), BELIEFS["recognised with error"], 3600.0)


def test_where_nothing_is_short_enough_that_is_said() -> None:
    search = pomcp(1000, leaf_value="greedy_rollout", rollout_cycles=10_000)
    with pytest.raises(ExperimentError, match="Take another leaf value or policy, or allow more"):
        check_effort("p", search, BELIEFS["novice"], 1e-6)


def test_a_budget_of_time_is_what_it_says() -> None:
    settings = pomcp(5).model_copy(update={"descents": None, "seconds": 100.0})
    check_effort("p", settings, BELIEFS["novice"], 2.0)
