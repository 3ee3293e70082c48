"""RockSample (Smith & Simmons 2004): which rocks are worth a visit? With legal and preferred actions, and an end.

    python examples/rock_sample.py

A rover on a grid knows where k rocks lie, but not which are good. It can look at one from afar (the farther, the less
reliable), sample the rock it stands on (good: +10, bad: -10), and leave to the east (+10). Rollouts and preferred
actions are those of Silver & Veness (2010): Monte-Carlo planning in large POMDPs.
"""

from itertools import product
from typing import NamedTuple

import numpy as np

import fatigue_planner as fp

NORTH, EAST, SOUTH, WEST, SAMPLE, CHECK = range(6)  # CHECK + i looks at rock i
NOTHING, GOOD, BAD = range(3)
HALF_EFFICIENCY_DISTANCE = 20.0
# A state: the rover's place x, y, and of every rock whether it is good, whether it has been taken, how many more good
# than bad looks there were, and how many looks.
X, Y, ROCKS, NUMBERS = 0, 1, 2, 4
IS_GOOD, TAKEN, BALANCE, LOOKS = range(NUMBERS)
CERTAIN = 9.0  # the balance after a look from the rock's own cell, which does not err
# Silver's code: preferred actions begin with 10 visits of value 1; no rock is looked at more than 5 times.
PRIOR_VISITS, PRIOR_VALUE, MOST_LOOKS = 10.0, 20.0, 5


class Map(NamedTuple):
    """A square with `size` cells a side and rocks (k, 2): x, y."""

    size: int
    rocks: np.ndarray


@fp.compiled
def of(state, rock, number):
    """A number of a rock."""
    return state[ROCKS + NUMBERS * rock + number]


@fp.compiled
def rock_here(arrays, state):
    """The rock that the rover stands on, or -1."""
    for rock in range(arrays.rocks.shape[0]):
        if arrays.rocks[rock, 0] == state[X] and arrays.rocks[rock, 1] == state[Y] and of(state, rock, TAKEN) == 0:
            return rock
    return -1


@fp.compiled
def chances_of_outcomes(arrays, state, action, chances):
    """The outcome is what a look shows."""
    chances[NOTHING], chances[GOOD], chances[BAD] = 1.0, 0.0, 0.0
    if action >= CHECK:
        rock = action - CHECK
        distance = np.hypot(arrays.rocks[rock, 0] - state[X], arrays.rocks[rock, 1] - state[Y])
        right = 0.5 * (1 + 2 ** (-distance / HALF_EFFICIENCY_DISTANCE))
        chances[NOTHING] = 0.0
        chances[GOOD] = right if of(state, rock, IS_GOOD) == 1 else 1 - right
        chances[BAD] = 1 - chances[GOOD]


@fp.compiled
def advance(arrays, state, action, seen):
    """Move, sample or note what was seen; the reward."""
    if action >= CHECK:
        first = ROCKS + NUMBERS * (action - CHECK)
        near = arrays.rocks[action - CHECK, 0] == state[X] and arrays.rocks[action - CHECK, 1] == state[Y]
        state[first + BALANCE] += (CERTAIN if near else 1.0) * (1.0 if seen == GOOD else -1.0)
        state[first + LOOKS] += 1
    elif action == SAMPLE:
        first = ROCKS + NUMBERS * rock_here(arrays, state)
        reward = 10.0 if state[first + IS_GOOD] == 1 else -10.0
        state[first + IS_GOOD], state[first + TAKEN] = 0.0, 1.0
        return reward
    elif action in (EAST, WEST):
        state[X] += 1.0 if action == EAST else -1.0
        return 10.0 if state[X] == arrays.size else 0.0
    else:
        state[Y] += 1.0 if action == NORTH else -1.0
    return 0.0


@fp.compiled
def chance_of_observation(_arrays, _state, _action, seen, observation):
    """What is seen is what the look shows."""
    return 1.0 if observation == seen else 0.0


@fp.compiled
def has_left(arrays, state):
    """The task ends where the map does, in the east."""
    return state[X] == arrays.size


@fp.compiled
def is_legal(arrays, state, action):
    """Nobody leaves to another side, samples where no rock is, or looks at a rock that has been taken."""
    if action >= CHECK:
        return of(state, action - CHECK, TAKEN) == 0
    if action == SAMPLE:
        return rock_here(arrays, state) >= 0
    if action == NORTH:
        return state[Y] + 1 < arrays.size
    return action == EAST or (state[Y] > 0 if action == SOUTH else state[X] > 0)


@fp.compiled
def is_preferred(arrays, state, action):
    """Sample what looks good; go towards rocks that do not look bad; look at what is uncertain; else leave."""
    here = rock_here(arrays, state)
    if here >= 0 and of(state, here, BALANCE) > 0:
        return action == SAMPLE
    if action >= CHECK:
        rock = action - CHECK
        uncertain = abs(of(state, rock, BALANCE)) < 2 and of(state, rock, LOOKS) < MOST_LOOKS
        if of(state, rock, TAKEN) == 1 or not uncertain:
            return False
    all_bad, towards = True, False
    for rock in range(arrays.rocks.shape[0]):
        if of(state, rock, TAKEN) == 0 and of(state, rock, BALANCE) >= 0:
            all_bad = False
            east, north = arrays.rocks[rock, 0] - state[X], arrays.rocks[rock, 1] - state[Y]
            towards = towards or (action == EAST and east > 0) or (action == WEST and east < 0)
            towards = towards or (action == NORTH and north > 0) or (action == SOUTH and north < 0)
    return action == EAST if all_bad else towards or action >= CHECK


@fp.compiled
def prior(arrays, state, action):
    """Preferred actions seem good from the beginning."""
    return (PRIOR_VISITS, PRIOR_VALUE) if is_preferred(arrays, state, action) else (0.0, 0.0)


@fp.compiled
def rollout(arrays, state, rng):
    """Any preferred action; to the east if there is none."""
    actions = CHECK + arrays.rocks.shape[0]
    preferred = 0
    for action in range(actions):
        preferred += 1 if is_preferred(arrays, state, action) else 0
    wanted = int(rng.random() * preferred)
    for action in range(actions):
        if is_preferred(arrays, state, action):
            if wanted == 0:
                return action
            wanted -= 1
    return EAST


def rock_sample(size: int, rocks: list[tuple[int, int]]) -> fp.Pomdp:
    """RockSample[size, k] with k rocks at these places."""
    return fp.Pomdp(
        actions=("north", "east", "south", "west", "sample", *(f"check {i + 1}" for i in range(len(rocks)))),
        outcomes=("nothing", "good", "bad"),
        observations=("nothing", "good", "bad"),
        discount=0.95,
        arrays=Map(size, np.array(rocks, float)),
        dynamics=fp.Dynamics(
            chances_of_outcomes, advance, chance_of_observation,
            is_legal=is_legal, is_terminal=has_left, prior=prior, rollout=rollout,
        ),
        observation_reveals_outcome=True,
    )  # fmt: skip


def start(problem: fp.Pomdp, place: tuple[int, int]) -> fp.ExactBelief:
    """The rover at a place; every rock is good or bad, with equal chances."""
    states = []
    for good in product((0.0, 1.0), repeat=len(problem.arrays.rocks)):
        states.append([*place, *(number for is_good in good for number in (is_good, 0.0, 0.0, 0.0))])
    return fp.ExactBelief(problem, np.array(states, float), np.full(len(states), 1 / len(states)))


# The maps of the benchmark, as in Silver's code; the rover begins in the middle of the west side.
MAP_7_8 = [(2, 0), (0, 1), (3, 1), (6, 3), (2, 4), (3, 4), (5, 5), (1, 6)]
MAP_11_11 = [(0, 3), (0, 7), (1, 8), (2, 4), (3, 3), (3, 8), (4, 3), (5, 8), (6, 1), (9, 3), (9, 9)]
SEARCH = fp.policy(
    {
        "kind": "pomcp", "backup": "mean", "exploration_constant": 20, "descents": 1024,
        "leaf_value": "random_rollout", "rollout_cycles": 90,
    }
)  # fmt: skip


def play(belief: fp.Belief, settings: fp.PolicySettings, rng: np.random.Generator) -> tuple[float, list[str]]:
    """One game, at most 100 steps: its discounted return, and what was done."""
    problem, policy, log, total = belief.model, settings.build(), [], 0.0
    state = belief.states[rng.choice(len(belief.weights), p=belief.weights)]
    for cycle in range(100):
        action = policy.act(belief, rng).action
        state, seen, reward = problem.sample_step(state, action, rng)
        total += problem.discount**cycle * reward
        log.append(problem.actions[action] + (f" ({problem.observations[seen]})" if seen else ""))
        if problem.has_ended(state):
            break
        belief = belief.update(action, seen, rng)
    return total, log


if __name__ == "__main__":
    belief = start(rock_sample(7, MAP_7_8), (0, 3))
    rng = np.random.default_rng(1)
    print("One game:", ", ".join(play(belief, SEARCH, rng)[1]))
    returns = [play(belief, SEARCH, rng)[0] for _ in range(10)]
    print(f"Mean return of 10 games of RockSample[7,8]: {np.mean(returns):.1f}")
