"""The crying baby (POMDPs.jl): feed it or not? Two planners, and the exact value beside them.

    python examples/crying_baby.py

A baby becomes hungry with probability 0.1 a step, and stays so until it is fed. It cries with probability 0.8 if it is
hungry, else 0.1. Feeding costs 5, hunger 10 a step; the discount is 0.9. The values are those of POMDPModels.jl.
"""

import numpy as np

import fatigue_planner as fp

FED, HUNGRY = 0, 1
FEED, IGNORE = 0, 1
CRIES_IF_HUNGRY, CRIES_IF_FED, BECOMES_HUNGRY = 0.8, 0.1, 0.1
COST_OF_FEEDING, COST_OF_HUNGER = 5.0, 10.0


@fp.compiled
def chances_of_outcomes(_arrays, state, action, chances):
    """The outcome is whether the baby is hungry afterwards."""
    hungry = 0.0 if action == FEED else 1.0 if state[0] == HUNGRY else BECOMES_HUNGRY
    chances[FED], chances[HUNGRY] = 1 - hungry, hungry


@fp.compiled
def advance(_arrays, state, action, after):
    """The reward is for the hunger before the action, and for feeding."""
    reward = -COST_OF_HUNGER if state[0] == HUNGRY else 0.0
    state[0] = after
    return reward - COST_OF_FEEDING if action == FEED else reward


@fp.compiled
def chance_of_observation(_arrays, state, _action, _after, cries):
    """Whether the baby cries."""
    chance = CRIES_IF_HUNGRY if state[0] == HUNGRY else CRIES_IF_FED
    return chance if cries == 1 else 1 - chance


PROBLEM = fp.Pomdp(
    actions=("feed", "ignore"),
    outcomes=("fed", "hungry"),
    observations=("quiet", "crying"),
    discount=0.9,
    arrays=None,
    dynamics=fp.Dynamics(chances_of_outcomes, advance, chance_of_observation),
)
JUST_FED = fp.ExactBelief(PROBLEM, states=np.array([[0.0], [1.0]]), weights=np.array([1.0, 0.0]))
POLICIES = {
    "lookahead": fp.policy({"kind": "lookahead", "depth": 6}),
    "pomcp": fp.policy({"kind": "pomcp", "backup": "max", "exploration_constant": 20, "descents": 2000}),
}


def exact_value(points: int = 1001, steps: int = 300) -> float:
    """Value iteration over the probability of hunger, between the points of a grid by interpolation: just fed."""
    grid = np.linspace(0, 1, points)
    values = np.zeros(points)
    for _ in range(steps):
        worth = []
        for action in (FEED, IGNORE):
            hungry = 0 * grid if action == FEED else grid + (1 - grid) * BECOMES_HUNGRY
            worth.append(-COST_OF_HUNGER * grid - (COST_OF_FEEDING if action == FEED else 0))
            for if_hungry, if_fed in ((CRIES_IF_HUNGRY, CRIES_IF_FED), (1 - CRIES_IF_HUNGRY, 1 - CRIES_IF_FED)):
                seen = hungry * if_hungry + (1 - hungry) * if_fed
                worth[-1] = worth[-1] + 0.9 * seen * np.interp(hungry * if_hungry / seen, grid, values)
        values = np.maximum(*worth)
    return float(values[0])


def play(settings: fp.PolicySettings, cycles: int, rng: np.random.Generator) -> float:
    """The discounted return of one game."""
    policy, belief, state, total = settings.build(), JUST_FED, np.array([0.0]), 0.0
    for cycle in range(cycles):
        action = policy.act(belief, rng).action
        state, cries, reward = PROBLEM.sample_step(state, action, rng)
        policy.observe(action, cries)
        belief = belief.update(action, cries, rng)
        total += PROBLEM.discount**cycle * reward
    return total


if __name__ == "__main__":
    rng = np.random.default_rng(1)
    print(f"exact value: {exact_value():.2f}")
    for name, settings in POLICIES.items():
        returns = np.array([play(settings, 60, rng) for _ in range(100)])
        print(f"{name:10} {returns.mean():.1f} ± {returns.std() / 10:.1f} in 100 games")
