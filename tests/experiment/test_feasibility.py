"""What the workers cannot perform is left out, and said; everything else stays."""

from dataclasses import replace

import pytest

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.experiment.build import cycle_profiles, scenario
from fatigue_planner.experiment.feasibility import omissions, performable_actions, without_infeasible
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.reactions.reaction import Reaction, ReactionName


@pytest.fixture
def two(paper: Experiment) -> Experiment:
    """The paper's experiment, one of its conditions with a second worker."""
    conditions = {
        name: condition.model_copy(update={"worker": "other" if name == "single_expert" else "average_man"})
        for name, condition in paper.benchmark.conditions.items()
    }
    return paper.model_copy(
        update={
            "workers": {**paper.workers, "other": paper.workers["average_man"]},
            "benchmark": paper.benchmark.model_copy(update={"conditions": conditions}),
        }
    )


def named(*names: str) -> set[ReactionName]:
    return {ReactionName(*name.split("/")) for name in names}


def test_an_action_is_left_if_it_can_be_performed_with_every_preference(
    two: Experiment, reactions: tuple[Reaction, ...]
) -> None:
    others = [replace(reaction, name=reaction.name._replace(worker="other")) for reaction in reactions]
    others = [reaction for reaction in others if reaction.name[1:] != ("high", "back")]
    profiles = cycle_profiles(two, (*reactions, *others))
    conditions = two.benchmark.conditions
    assert scenario(two, profiles, conditions["single_novice"]).model.actions == ("high", "low")
    assert scenario(two, profiles, conditions["single_expert"]).model.actions == ("low",)
    assert without_infeasible(two, profiles) is two
    assert omissions(two, profiles) == ["other cannot perform high (with back): left out of this worker's conditions."]


def test_a_condition_without_actions_is_left_out_everywhere(two: Experiment) -> None:
    performed = named(*(f"average_man/{action}/{how}" for action in two.actions for how in two.preferences))
    assert performable_actions(two, "other", performed) == ()
    left = without_infeasible(two, performed)
    assert list(left.benchmark.conditions) == ["single_novice", "multiple_novice"]
    assert left.figures == {"figure5a": ("single_novice",), "figure5b": ("multiple_novice",)}
    assert list(left.statistics.families) == ["single_novice", "multiple_novice"]
    assert omissions(two, performed)[-1] == (
        "Condition single_expert is left out: other can perform no action with every preference."
    )
    with pytest.raises(FailedMotionError, match="other can perform no action"):
        scenario(two, {}, two.benchmark.conditions["single_expert"])
    with pytest.raises(FailedMotionError, match=r"no condition can be run\. average_man cannot perform high \("):
        without_infeasible(two, set())


def test_nothing_is_left_out_where_everything_can_be_performed(
    paper: Experiment, reactions: tuple[Reaction, ...]
) -> None:
    performed = {reaction.name for reaction in reactions}
    assert without_infeasible(paper, performed) is paper and omissions(paper, performed) == []
