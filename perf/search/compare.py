"""A decision of 5000 descents: fatigue_planner's search, the same by hand in C++, pomdp-py and plain Python.

    python perf/search/compare.py [--figure FILE]

CPU seconds of a decision as ratios to the C++ search, medians of interleaved rounds. First a check that all searches
do the same: values of the root's actions, and the mean depth of a descent. pomdp-py runs in a separate environment,
made when it is first needed. What is missing (a C++ compiler, pomdp-py) is left out, with a message.

Equal everywhere: the problem, the number of descents, no rollout, UCB1 with untried actions first, mean backup.
Different:
- random numbers: NumPy's generator, xoshiro256+ in C++, Python's `random` in pomdp-py. Where the worker's choice
  is certain (expert), the trees of C++ and fatigue_planner must be the same, elsewhere equal within noise;
- the C++ search keeps its memory and its tables of log and square root between decisions;
- pomdp-py: POMCP with its rollout overridden by 0; it has no max backup; its UCB1 has log(N + 1) for log N and
  scores in single precision; weighted beliefs become 1000 particles. The model is a BlackboxModel.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from collections import defaultdict
from pathlib import Path
from typing import Any

os.environ |= {f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "OMP", "MKL")}
sys.path.append(str(Path(__file__).parents[1]))

import numpy as np
from by_hand import CompilerMissingError, SearchByHand
from cases import DESCENTS, Case, by_hand, ours
from environments import PeerMissingError, environment_of
from problems import Problem, experiment_problems, synthetic_problem

from fatigue_planner.planners.pomcp.policy import PomcpPolicy

HERE = Path(__file__).parent
REQUIREMENTS = HERE / "requirements.txt"
CONSTANTS = (0.1, 0.001)
BACKUPS = ("mean", "max")
ROUNDS = 21
SLOW_ROUNDS = 2  # of pomdp-py and plain Python, with the first constant only
SEEDS = 100  # of the check
PARTICLES = 1000
SAME = 0.05  # how far the values of a slow search, from few rounds, may differ


class Peer:
    """A search in another process: one line of JSON in, one out."""

    def __init__(self, python: Path | str, script: str, **environment: str) -> None:
        self.process = subprocess.Popen(
            [python, HERE / script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            env=os.environ | environment,
        )  # fmt: skip
        self._problem: Problem | None = None

    def ask(self, request: dict[str, Any]) -> dict[str, Any]:
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError("the process of a peer ended")
        reply: dict[str, Any] = json.loads(line)
        return reply

    def decide(self, case: Case, seed: int) -> dict[str, Any]:
        model, belief = case.problem.model, case.problem.belief
        active = model.active_entries.size
        states = belief.states[:, :active]
        if case.problem is not self._problem:
            self._problem = case.problem
            arrays = model.arrays
            shape = arrays.n_actions, len(model.outcomes), -1
            gain, offset = (table.reshape(shape)[..., :active].tolist() for table in (arrays.gain, arrays.offset))
            self.ask({
                "gain": gain, "offset": offset, "expertise": str(arrays.expertise[0]),
                "discount": model.discount, "cost_scale": arrays.cost.scale,
            })  # fmt: skip
        copies = np.rint(belief.weights * PARTICLES).astype(int) if belief.weights.size > 1 else [1]
        return self.ask({
            "seed": seed, "descents": case.descents, "discount": model.discount, "exploration_constant": case.constant,
            "particles": np.repeat(states, copies, axis=0).tolist(),
            "states": states.tolist(), "weights": belief.weights.tolist(),
            "settings": case.settings.model_dump(),
        })  # fmt: skip

    def close(self) -> None:
        self.process.communicate()


def check(cases: list[Case]) -> None:
    """Check that the C++ search and ours do the same. Raises AssertionError."""
    print(f"The same searches? Root values of C++ and ours over {SEEDS} seeds (expert: the same tree):")
    for case in cases:
        model = case.problem.model
        certain = bool(np.isinf(model.arrays.expertise[0]))
        search = SearchByHand(model)
        seeds = range(3 if certain else SEEDS)
        pairs = [(by_hand(search, case, seed), ours(case, 1000 + seed)) for seed in seeds]
        hand, own = (np.array([pair[side].values for pair in pairs]) for side in (0, 1))
        if certain:
            worst = np.abs(hand - own).max()
            same = all(np.array_equal(a.tried, b.tried) and np.isclose(a.depth, b.depth) for a, b in pairs)
            print(f"  {case}: largest difference {worst:.1e}, counts and depth {'equal' if same else 'DIFFER'}")
            assert same and worst <= 1e-12, case
        else:
            error = np.sqrt((hand.var(axis=0, ddof=1) + own.var(axis=0, ddof=1)) / len(hand))
            deviation = np.abs(hand.mean(axis=0) - own.mean(axis=0)) / error
            print(f"  {case}: differences of the means {np.round(deviation, 1)} standard errors")
            assert (deviation < 4.5).all(), case


def race(cases: list[Case], peers: dict[str, Peer]) -> None:
    """Print the CPU time per decision of all searches, in turn."""
    print(f"\nCPU time of a decision of {DESCENTS} descents as multiples of C++ (mean depth of a descent in brackets;")
    print(f"medians of {ROUNDS} interleaved rounds, {SLOW_ROUNDS} of the slow ones; quartiles of ours after it):")
    for case in cases:
        search = SearchByHand(case.problem.model)
        own_policy = PomcpPolicy(case.settings)
        seconds: dict[str, list[float]] = defaultdict(list)
        values: dict[str, list[list[float]]] = defaultdict(list)
        reference = by_hand(search, case, 0).values
        depths = {"ours": ours(case, 0).depth, "c++": by_hand(search, case, 0).depth}
        for seed in range(ROUNDS + 1):
            rng = np.random.default_rng(seed)
            begin = time.process_time()
            by_hand(search, case, seed)
            middle = time.process_time()
            own_policy.act(case.problem.belief, rng)
            end = time.process_time()
            if seed == 0:
                continue  # warms up
            seconds["c++"].append(middle - begin)
            seconds["ours"].append(end - middle)
            for name, peer in peers.items():
                if seed > SLOW_ROUNDS or case.constant != CONSTANTS[0] or (name, case.backup) == ("pomdp-py", "max"):
                    continue
                reply = peer.decide(case, seed)
                seconds[name].append(reply["cpu_s"])
                values[name].append(reply["values"])
                depths[name] = reply.get("depth", depths["ours"])
        base = statistics.median(seconds["c++"])
        ratios = np.quantile(np.array(seconds["ours"]) / np.array(seconds["c++"]), [0.25, 0.75])
        texts = [f"C++ {base * 1e3:.2f} ms ({depths['c++']:.2f})"]
        texts += [
            f"{name} {statistics.median(seconds[name]) / base:.3g} x ({depths[name]:.2f})"
            for name in ("ours", *peers) if name in seconds
        ]  # fmt: skip
        print(f"  {case}: {'; '.join(texts)}; {ratios[0]:.2f}-{ratios[1]:.2f}", flush=True)
        for name, found in values.items():
            off = np.abs(np.mean(found, axis=0) / reference - 1).max()
            assert off < SAME, f"{name} finds other values of the root's actions, {off:.1%} off"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--figure", type=Path, help="also write the figure of cost per descent to this file")
    options = parser.parse_args()
    if options.figure:
        from scaling import write_figure  # noqa: PLC0415

        write_figure(options.figure)
    problems = [*experiment_problems("paper"), synthetic_problem(), synthetic_problem(expertise=np.inf)]
    cases = [Case(problem, c, backup) for problem in problems for c in CONSTANTS for backup in BACKUPS]
    try:
        SearchByHand(problems[0].model)
    except CompilerMissingError as error:
        print(f"comparison of the searches skipped: {error}")
        return
    print(__doc__[__doc__.index("Equal everywhere") :])
    check(cases)
    peers = {"plain Python": Peer(sys.executable, "plain_python.py", NUMBA_DISABLE_JIT="1")}
    try:
        peers["pomdp-py"] = Peer(environment_of("pomdp-py", "pomdp_py", REQUIREMENTS), "pomdp_py_search.py")
    except PeerMissingError as error:
        print(f"pomdp-py left out, it is not available: {error}")
    try:
        race(cases, peers)
    finally:
        for peer in peers.values():
            peer.close()


if __name__ == "__main__":
    main()
