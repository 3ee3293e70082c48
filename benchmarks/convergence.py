"""What the time step does to the reactions: the cycle maps at halved steps, and what each step costs.

    python benchmarks/convergence.py

For each of the paper's reactions the gains and offsets of all 78 entries, from 20 ms down. A change is
the largest of an entry when the step is halved, as a share of the largest entry (gain or offset); the
observed order is log2 of two successive changes. The experiment's step is the largest that keeps every
change below 1 % with all checks fulfilled.
"""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from fatigue_planner.errors import FailedMotionError
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.experiment.resolve import reaction_requests, worker_fatigue
from fatigue_planner.fatigue.cycle_map import cycle_map
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.motion.verification import measure

PAPER = Path(__file__).parents[1] / "experiments" / "paper.yaml"
STEPS_S = (0.02, 0.01, 0.005, 0.0025, 0.00125)


def main() -> None:
    paper = load_experiment(PAPER)
    print("reaction | time step, ms | change of gains | of offsets | order | energy error | CPU s | verdict")
    print("--- | --- | --- | --- | --- | --- | --- | ---")
    for request in reaction_requests(paper):
        parameters = worker_fatigue(paper)[request.name.worker]
        before, change_before = None, None
        for step_s in STEPS_S:
            controller = request.motion.controller.model_copy(update={"time_step_s": step_s})
            motion_request = replace(request.motion, controller=controller)
            begin = time.process_time()
            try:
                motion = simulate(motion_request)
            except FailedMotionError as error:
                print(f"{request.name} | {step_s * 1e3:g} | | | | | | {error}")
                continue
            spent = time.process_time() - begin
            quality = measure(motion_request, motion)
            cycle = cycle_map(motion.torque_nm, step_s, parameters)
            cells = ["", "", ""]
            if before is not None:
                change = [
                    float(np.abs(now - then).max() / now.max())
                    for now, then in ((cycle.gain, before.gain), (cycle.offset, before.offset))
                ]
                cells[:2] = [f"{100 * part:.3f} %" for part in change]
                if change_before is not None:
                    cells[2] = f"{np.log2(max(change_before) / max(change)):.1f}"
                change_before = change
            before = cycle
            verdict = "; ".join(quality.faults(paper.accuracy)) or quality.verdict(paper.accuracy)
            print(
                f"{request.name} | {step_s * 1e3:g} | {cells[0]} | {cells[1]} | {cells[2]} | "
                f"{quality.energy_error_share:.1e} | {spent:.2f} | {verdict}"
            )


if __name__ == "__main__":
    main()
