"""The fatigue POMDP in pomdp-py, planned by its POMCP: one decision per request.

Runs in pomdp-py's own environment (requirements.txt) and knows nothing of fatplan: `compare.py` sends one line
of JSON on standard input (the model once, then decisions) and gets one line of JSON back. A decision is timed
in CPU time from the agent's belief to the chosen action.

The model is a BlackboxModel, as pomdp-py's documentation has it for generative models. Its states, actions and
observations are Python objects; the numbers are NumPy's.
"""

import json
import random
import sys
import time

import numpy as np
import pomdp_py


class Named:
    """A hashable number, the base class of actions and observations."""

    def __init__(self, number):
        self.number = number

    def __hash__(self):
        return hash(self.number)

    def __eq__(self, other):
        return self.number == other.number


class Action(Named, pomdp_py.Action):
    pass


class Observation(Named, pomdp_py.Observation):
    pass


class State(pomdp_py.State):
    def __init__(self, fatigue):
        self.fatigue = fatigue

    def __hash__(self):
        return hash(self.fatigue.tobytes())

    def __eq__(self, other):
        return np.array_equal(self.fatigue, other.fatigue)


class FatigueModel(pomdp_py.BlackboxModel):
    """Eq. 4 and 5 with observations that are the preferences."""

    def __init__(self, gain, offset, expertise, cost_scale):
        self.gain, self.offset = gain, offset
        self.expertise, self.cost_scale = expertise, cost_scale
        self.observations = [Observation(u) for u in range(gain.shape[1])]

    def sample(self, state, action):
        gain, offset = self.gain[action.number], self.offset[action.number]
        if self.expertise == 0:
            u = int(random.random() * len(gain))
            fatigue = gain[u] * state.fatigue + offset[u]
            cost = self.cost_scale * fatigue.dot(fatigue)
        else:
            all_fatigue = gain * state.fatigue + offset
            costs = self.cost_scale * np.square(all_fatigue).sum(axis=1)
            excess = costs - costs.min()
            weights = (excess == 0) * 1.0 if self.expertise == np.inf else np.exp(-self.expertise * excess)
            u = int(np.searchsorted(np.cumsum(weights), random.random() * weights.sum(), side="right"))
            fatigue, cost = all_fatigue[u], costs[u]
        return State(fatigue), self.observations[u], -float(cost), 1  # pomdp-py also expects the number of steps


class Policy(pomdp_py.RolloutPolicy):
    def __init__(self, actions):
        self.actions = actions

    def sample(self, state):
        return random.choice(self.actions)

    def rollout(self, state, history=None):
        return self.sample(state)

    def get_all_actions(self, state=None, history=None):
        return self.actions


class WithoutRollout(pomdp_py.POMCP):
    """A descent ends at the leaf it adds."""

    def _rollout(self, state, history, root, depth):
        return 0.0


def steps(node):
    """The number of steps that all descents took below a node."""
    total, open_nodes = 0, [node]
    while open_nodes:
        for branch in open_nodes.pop().children.values():
            total += branch.num_visits
            open_nodes.extend(branch.children.values())
    return total


def decide(model, actions, request):
    random.seed(request["seed"])
    particles = [State(np.array(fatigue)) for fatigue in request["particles"]]
    # the first simulation only creates the root
    planner = WithoutRollout(
        max_depth=1_000_000,
        num_sims=request["descents"] + 1,
        discount_factor=request["discount"],
        exploration_const=request["exploration_constant"],
        rollout_policy=Policy(actions),
    )
    begin = time.process_time()
    agent = pomdp_py.Agent(pomdp_py.Particles(particles), Policy(actions), blackbox_model=model)
    planner.plan(agent)
    seconds = time.process_time() - begin
    root = agent.tree
    return {
        "cpu_s": seconds,
        "values": [root[action].value for action in actions],
        "tried": [root[action].num_visits for action in actions],
        "depth": steps(root) / request["descents"],
    }


def main():
    model, actions = None, []
    for line in sys.stdin:
        request = json.loads(line)
        if "gain" in request:
            gain, offset = np.array(request["gain"]), np.array(request["offset"])
            model = FatigueModel(gain, offset, float(request["expertise"]), request["cost_scale"])
            actions = [Action(number) for number in range(len(gain))]
            reply = {"ready": True}
        else:
            reply = decide(model, actions, request)
        print(json.dumps(reply), flush=True)


if __name__ == "__main__":
    main()
