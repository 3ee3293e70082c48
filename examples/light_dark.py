"""Light-dark (Sunberg & Kochenderfer 2018): is it worth a detour to see where one is? With continuous observations.

    python examples/light_dark.py

A robot on a line does not know where it is. It moves by 1 or 10, at a cost of 1; whoever stops ends the task, with
+100 in the origin and -100 elsewhere. It measures its place, with a standard deviation of its distance to the light at
10: in the dark there is little to see. Numbers as in the authors' ContinuousPOMDPTreeSearchExperiments.jl.
"""

from typing import NamedTuple

import numpy as np

import fatigue_planner as fp

MOVES = (-10.0, -1.0, 0.0, 1.0, 10.0)
STOP = 2
LIGHT, RADIUS, LEAST_DEVIATION, DISCOUNT = 10.0, 30, 1e-4, 0.95
PLACE, STOPPED = 0, 1  # a state


class Known(NamedTuple):
    """values (61,): what each place would be worth to a robot that knew it."""

    values: np.ndarray


@fp.compiled
def chances_of_outcomes(_known, _state, _action, chances):
    """Nothing about a move is left to chance."""
    chances[0] = 1.0


@fp.compiled
def advance(_known, state, action, _outcome):
    """Move, or stop."""
    if action == STOP:
        state[STOPPED] = 1.0
        return 100.0 if state[PLACE] == 0 else -100.0
    state[PLACE] = min(max(state[PLACE] + MOVES[action], -RADIUS), RADIUS)
    return -1.0


@fp.compiled
def has_stopped(_known, state):
    """The task ends when the robot stops."""
    return state[STOPPED] == 1


@fp.compiled
def measure(_known, state, _action, _outcome, measured, rng):
    """Draw a measured place."""
    measured[0] = rng.normal(state[PLACE], abs(state[PLACE] - LIGHT) + LEAST_DEVIATION)


@fp.compiled
def density(_known, state, _action, _outcome, measured):
    """The density of a measured place."""
    deviation = abs(state[PLACE] - LIGHT) + LEAST_DEVIATION
    return np.exp(-0.5 * ((measured[0] - state[PLACE]) / deviation) ** 2) / (np.sqrt(2 * np.pi) * deviation)


@fp.compiled
def value_if_known(known, state):
    """What the state is worth to who knows it: more than it can be worth to the robot."""
    return known.values[int(state[PLACE]) + RADIUS]


def values_if_known() -> np.ndarray:
    """Value iteration over the places -30 ... 30."""
    places = np.arange(-RADIUS, RADIUS + 1)
    stop = np.where(places == 0, 100.0, -100.0)
    values = np.zeros(places.size)
    for _ in range(200):
        moved = [-1 + DISCOUNT * values[np.clip(places + int(m), -RADIUS, RADIUS) + RADIUS] for m in MOVES if m]
        values = np.maximum(stop, np.max(moved, axis=0))
    return values


PROBLEM = fp.Pomdp(
    actions=("left 10", "left 1", "stop", "right 1", "right 10"),
    outcomes=("moved",),
    observations=("measured place",),
    discount=DISCOUNT,
    arrays=Known(values_if_known()),
    dynamics=fp.Dynamics(
        chances_of_outcomes, advance, density,
        draw_observation=measure, is_terminal=has_stopped, bound=value_if_known,
    ),
)  # fmt: skip
PLACES = np.arange(-RADIUS, RADIUS + 1.0)
NO_IDEA = fp.ExactBelief(PROBLEM, np.column_stack([PLACES, 0 * PLACES]), np.full(PLACES.size, 1 / PLACES.size))
# The constants of the authors' POMCPOW.
SEARCH = fp.policy(
    {
        "kind": "pomcpow", "exploration_constant": 90, "observations_k": 5, "observations_alpha": 0.0667,
        "leaf_value": "bound", "descents": 10_000,
    }
)  # fmt: skip


def play(settings: fp.PolicySettings, rng: np.random.Generator) -> tuple[float, list[str]]:
    """One game, at most 100 steps: its discounted return, and what was done and measured."""
    policy, belief, total, log = settings.build(), NO_IDEA, 0.0, []
    state = np.array([rng.choice(PLACES), 0.0])
    for cycle in range(100):
        action = policy.act(belief, rng).action
        state, measured, reward = PROBLEM.sample_step(state, action, rng)
        total += DISCOUNT**cycle * reward
        log.append(f"{PROBLEM.actions[action]} ({measured[0]:.0f})" if action != STOP else f"stop at {state[PLACE]:g}")
        if PROBLEM.has_ended(state):
            break
        belief = belief.update(action, measured, rng)
    return total, log


if __name__ == "__main__":
    rng = np.random.default_rng(1)
    print("One game:", ", ".join(play(SEARCH, rng)[1]))
    print(f"Mean return of 20 games: {np.mean([play(SEARCH, rng)[0] for _ in range(20)]):.1f}")
