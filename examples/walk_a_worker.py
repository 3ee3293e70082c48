"""Walk a worker through the paper's task and plot the joint torques.

python examples/walk_a_worker.py [FIGURE]
"""

import sys
from collections.abc import Mapping

from matplotlib.figure import Figure

import fatigue_planner as fp


def torque_figure(reactions: Mapping[str, fp.Reaction]) -> Figure:
    """The torques of the right shoulder, the right wrist and the back over the cycle, a panel per postural reaction."""
    figure = Figure(figsize=(10, 6), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True).flat
    for panel, (name, reaction) in zip(panels, reactions.items(), strict=True):
        torques = reaction.torques_nm()
        for joint in ("right_shoulder_flexion", "right_wrist_deviation", "lumbar_flexion"):
            panel.plot(torques.index, torques[joint], label=joint.replace("_", " "))
        panel.set(title=name, xlabel="time (s)", ylabel="torque (N·m)")
    panel.legend(fontsize="small")
    return figure


if __name__ == "__main__":
    reactions = fp.simulate(fp.load("paper"))
    for name, reaction in reactions.items():
        peaks = reaction.torques_nm().abs().max().nlargest(3)
        print(name, ", ".join(f"{joint} {torque:.0f} N·m" for joint, torque in peaks.items()))
    torque_figure(reactions).savefig(sys.argv[1] if len(sys.argv) > 1 else "torques.png")
