"""The effect of the time step on the reactions: the cycle maps at halved steps, and what each step costs.

    python perf/convergence.py

For each of the paper's reactions the gains and offsets of all 78 entries, from 20 ms down. A change is
the largest of any entry when the step is halved, as a fraction of the largest entry (gain or offset); the
observed order is log2 of two successive energy errors, and of two successive root mean squares of the
changes. Those are noisy: a load that crosses the threshold of fatigue, or a joint that arrives at the end
of its range, does so at a whole tick.

All steps keep the changes below 1 %. The experiment takes 10 ms, not 20: there the hand's stiffness of
1600 / s^2 has sqrt(1600) x 0.02 s = 0.8, and from 0.83 on the semi-implicit step is unstable.
"""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from fatigue_planner.core.errors import FailedMotionError
from fatigue_planner.experiment.build import reaction_requests, worker_fatigue
from fatigue_planner.experiment.loader import load_experiment
from fatigue_planner.fatigue.load import cycle_profile
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.motion.verification import measure

PAPER = Path(__file__).parents[1] / "experiments" / "paper.yaml"
STEPS_S = (0.02, 0.01, 0.005, 0.0025, 0.00125)


def main() -> None:
    paper = load_experiment(PAPER)
    print("reaction | time step, ms | change of gains | of offsets | order | energy error | order | CPU s | verdict")
    print("--- | --- | --- | --- | --- | --- | --- | --- | ---")
    for request in reaction_requests(paper):
        parameters = worker_fatigue(paper)[request.name.worker]
        before, change_before, energy_before = None, None, None
        for step_s in STEPS_S:
            controller = request.motion.controller.model_copy(update={"time_step_s": step_s})
            motion_request = replace(request.motion, controller=controller)
            begin = time.process_time()
            try:
                motion = simulate(motion_request)
            except FailedMotionError as error:
                print(f"{request.name} | {step_s * 1e3:g} | | | | | | | {error}")
                continue
            spent = time.process_time() - begin
            quality = measure(motion_request, motion)
            cycle = cycle_profile(motion, parameters).cycle_map()
            cells = ["", "", ""]
            if before is not None:
                change = [
                    float(np.abs(now - then).max() / now.max())
                    for now, then in ((cycle.gain, before.gain), (cycle.offset, before.offset))
                ]
                cells[:2] = [f"{100 * fraction:.3f} %" for fraction in change]
                both = np.concatenate([cycle.gain - before.gain, cycle.offset - before.offset])
                rms = float(np.sqrt(np.mean(both**2)))
                if change_before is not None:
                    cells[2] = f"{np.log2(change_before / rms):.1f}"
                change_before = rms
            energy = quality.energy_error_share
            energy_order = f"{np.log2(energy_before / energy):.2f}" if energy_before else ""
            before, energy_before = cycle, energy
            verdict = "; ".join(quality.faults(paper.accuracy)) or quality.verdict(paper.accuracy)
            print(
                f"{request.name} | {step_s * 1e3:g} | {cells[0]} | {cells[1]} | {cells[2]} | "
                f"{energy:.1e} | {energy_order} | {spent:.2f} | {verdict}"
            )


if __name__ == "__main__":
    main()
