"""The tiger problem (Kaelbling, Littman & Cassandra 1998), solved by the search that plans for the robot.

    python examples/tiger.py

A tiger is behind one of two doors, gold behind the other. Whoever listens hears the tiger on its side 85 times out
of 100. Once a door has been opened, tiger and gold are hidden again.
"""

import numpy as np

import fatigue_planner as fp

SIDES = ("left", "right")
LISTEN = 2  # actions 0 and 1 open the door of that side
COST, GOLD, TIGER, HEARD_RIGHTLY = -1.0, 10.0, -100.0, 0.85


@fp.compiled
def chances_of_outcomes(_arrays, state, action, chances):
    """The outcome is the side of the tiger after the action; a state is the side before it."""
    for side in range(2):
        chances[side] = 0.5 if action != LISTEN else 1.0 if side == state[0] else 0.0


@fp.compiled
def advance(_arrays, state, action, side):
    """Put the tiger on its new side; the reward is for what was done before."""
    reward = COST if action == LISTEN else TIGER if action == state[0] else GOLD
    state[0] = side
    return reward


@fp.compiled
def chance_of_observation(_arrays, state, action, _side, heard):
    """How likely a tiger is heard on the side `heard`; who opens a door hears nothing of use."""
    return 0.5 if action != LISTEN else HEARD_RIGHTLY if heard == state[0] else 1 - HEARD_RIGHTLY


PROBLEM = fp.Pomdp(
    actions=("open left", "open right", "listen"),
    outcomes=SIDES,
    observations=SIDES,
    discount=0.95,
    arrays=None,
    dynamics=fp.Dynamics(chances_of_outcomes, advance, chance_of_observation),
)
NO_IDEA = fp.ExactBelief(PROBLEM, states=np.array([[0.0], [1.0]]), weights=np.array([0.5, 0.5]))
# The planner for it: with two states, three actions and two things to hear, six steps can be looked through exactly.
LOOKAHEAD = fp.policy({"kind": "lookahead", "depth": 6})
# A search estimates the same; it is for problems in which six steps cannot be looked through.
SEARCH = fp.policy({"kind": "pomcp", "backup": "max", "exploration_constant": 100, "descents": 2000})


def play(settings: fp.PolicySettings, cycles: int, rng: np.random.Generator) -> tuple[float, list[str]]:
    """One game: its discounted return, and what was done and heard."""
    policy, belief, state = settings.build(), NO_IDEA, np.array([float(rng.integers(2))])
    total, log = 0.0, []
    for cycle in range(cycles):
        action = policy.act(belief, rng).action
        state, heard, reward = PROBLEM.sample_step(state, action, rng)
        policy.observe(action, heard)
        belief = belief.update(action, heard, rng)
        total += PROBLEM.discount**cycle * reward
        log.append(f"{PROBLEM.actions[action]} ({SIDES[heard] if action == LISTEN else f'{reward:+g}'})")
    return total, log


if __name__ == "__main__":
    rng = np.random.default_rng(1)
    for name, settings in (("lookahead", LOOKAHEAD), ("pomcp", SEARCH)):
        decision = settings.build().act(NO_IDEA, rng)
        values = ", ".join(
            f"{action} {value:.1f}" for action, value in zip(PROBLEM.actions, decision.values, strict=True)
        )
        print(f"{name}: {values}")
    print("One game:", ", ".join(play(LOOKAHEAD, 10, rng)[1]))
    for name, settings in (("lookahead", LOOKAHEAD), ("pomcp", SEARCH)):
        returns = np.array([play(settings, 50, rng)[0] for _ in range(100)])
        print(f"Mean return of 100 games by {name}: {returns.mean():.1f} ± {returns.std() / 10:.1f} (optimum 17.8)")
