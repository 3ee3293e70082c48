"""A worker who tires and recovers at rates that the robot does not know, and infers from what it sees.

python examples/hidden_worker.py
"""

import fatigue_planner as fp

PLANNER = {"kind": "lookahead", "depth": 2}


def compare(scenario: fp.Scenario, n_cycles: int, trials: int) -> dict[str, float]:
    """The mean returns of three planners that differ only in what they know about the worker."""
    knowledge = ("average", "prior", "truth")
    table = fp.run_trials(scenario, {knows: PLANNER | {"knows": knows} for knows in knowledge}, n_cycles, trials)
    return table.groupby("policy")["discounted_return"].mean().to_dict()


if __name__ == "__main__":
    experiment = fp.load("hidden_worker")
    scenario = fp.scenario(experiment, fp.simulate(experiment), "hidden_rates")
    for knows, mean in compare(scenario, n_cycles=20, trials=5).items():
        print(f"knows the {knows:8} {mean:.4f}")
