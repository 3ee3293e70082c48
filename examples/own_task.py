"""Your own task: one hand, two heights, a taller woman. Where should the robot present the object?

python examples/own_task.py
"""

from pathlib import Path

import fatigue_planner as fp

TASK = """
name: bench
workers:
  anna: {height_m: 1.80, mass_kg: 70, sex: female, strength: average_woman}
tool: {mass_kg: 2}
actions:
  table: {right_hand: {position_m: {x: 0.45, y: -0.2, z: 0.95}, orientation_deg: {y: -90}}}
  shelf: {right_hand: {position_m: {x: 0.45, y: -0.2, z: 1.30}, orientation_deg: {y: -90}}}
"""

if __name__ == "__main__":
    file = Path("bench.yaml")
    file.write_text(TASK)
    experiment = fp.load(file)
    reactions = fp.simulate(experiment)
    for name, reason in reactions.failures.items():
        print(f"{name} cannot be performed: {reason}")
    scenario = fp.scenario(experiment, reactions)
    decision = fp.decide(scenario, "greedy")
    print(f"First the {decision.action}: {decision.reason}.")
    run = fp.run(scenario, {"kind": "lookahead", "depth": 3}, n_cycles=50)
    print(run.cycles["action"].value_counts().to_string())
    print("Most tired:", run.fatigue.iloc[-1].nlargest(3).round(3).to_dict())
