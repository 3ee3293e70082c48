"""Your own agent: learn what to do from the environment, with nothing but NumPy, and set it beside the planners.

    python examples/train_agent.py

It learns a table of values (Q-learning) of what was done and seen in the last three cycles, in a few seconds, and
keeps it in q_table.npy. Then the table is a policy like all others: `{kind: agent, agent: "train_agent:TableAgent",
data: q_table.npy}` in an experiment file, with `fatplan benchmark mine.yaml --plugin examples/train_agent.py`.
"""

import io
from pathlib import Path

import numpy as np

import fatigue_planner as fp

ACTIONS, REACTIONS, REMEMBERED = 2, 2, 3
EVENTS = ACTIONS * REACTIONS + 1  # what can have happened in a cycle, or nothing yet
ENVIRONMENTS, EPISODES, CYCLES = 1000, 60, 100
CURIOUS, SLOWING = 0.3, 0.6  # how often it tries anything; by which power of their number updates become smaller


def followed(memory, action, reaction):
    """The last cycles as one number, after one more cycle; works for arrays, too."""
    return (memory * EVENTS + 1 + action * REACTIONS + reaction) % EVENTS**REMEMBERED


class TableAgent:
    """Takes the action of highest value in a table (memories, actions), the content of a NumPy file."""

    def __init__(self, data):
        self.values = np.load(io.BytesIO(data))
        self.memory, self.action = 0, None

    def __call__(self, observation, rng):
        """Asked once per cycle, with the last reaction that was recognised."""
        if self.action is not None:
            self.memory = followed(self.memory, self.action, observation)
        self.action = int(self.values[self.memory].argmax())
        return self.action


def learn(tasks, discount: float, rng: np.random.Generator) -> np.ndarray:
    """The table of values after many episodes in a vector environment: Q-learning."""
    values = np.zeros((EVENTS**REMEMBERED, ACTIONS))
    updates = np.zeros(values.size)
    for episode in range(EPISODES):
        tasks.reset(seed=2023 if episode == 0 else None)
        memory = np.zeros(ENVIRONMENTS, int)
        for _ in range(CYCLES):
            tried = rng.integers(ACTIONS, size=ENVIRONMENTS)
            action = np.where(rng.random(ENVIRONMENTS) < CURIOUS, tried, values[memory].argmax(axis=1))
            reaction, reward, *_ = tasks.step(action)
            after = followed(memory, action, reaction)
            cell, target = memory * ACTIONS + action, reward + discount * values[after].max(axis=1)
            count = np.bincount(cell, minlength=values.size)
            total = np.bincount(cell, target, minlength=values.size)
            met = count > 0
            updates[met] += 1
            values.flat[met] += (total[met] / count[met] - values.flat[met]) / updates[met] ** SLOWING
            memory = after
    return values


if __name__ == "__main__":
    experiment = fp.load("paper")
    scenario = fp.scenario(experiment, fp.simulate(experiment), "single_novice")
    tasks = fp.vector_environment(scenario, ENVIRONMENTS, n_cycles=CYCLES)
    np.save("q_table.npy", learn(tasks, scenario.model.discount, np.random.default_rng(0)))
    fp.load_plugin(Path(__file__))
    policies = {name: experiment.benchmark.policies[name] for name in ("greedy", "pomcp_0.1", "pomcpMax_0.1")}
    policies["learned"] = {"kind": "agent", "agent": "train_agent:TableAgent", "data": "q_table.npy"}
    table = fp.run_trials(scenario, policies, n_cycles=CYCLES, trials=20, seed=1)
    costs = -table.pivot(index="trial", columns="policy", values="discounted_return")
    for name, cost in costs.items():
        more = cost - costs["learned"]
        print(
            f"{name:13} cost {cost.mean():.5f}, {more.mean():+.5f} ± {more.std() / len(more) ** 0.5:.5f} beside learned"
        )
