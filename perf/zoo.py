"""The problem zoo against published and exact values: examples/tiger, crying_baby, rock_sample and light_dark.

    python perf/zoo.py [NAME] [--games N]

Every line: the mean discounted return of some games with its standard error, CPU seconds per game, and the value it is
held against. About 40 minutes on one core for everything.
"""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "examples"))
import crying_baby
import light_dark
import rock_sample
import tiger

import fatigue_planner as fp

Game = Callable[[np.random.Generator], float]
SEED = 2026


def rocks(size: int, places: list[tuple[int, int]], start: tuple[int, int], descents: int) -> Game:
    """A game of RockSample with this budget."""
    belief = rock_sample.start(rock_sample.rock_sample(size, places), start)
    settings = rock_sample.SEARCH.model_copy(update={"descents": descents})
    return lambda rng: rock_sample.play(belief, settings, rng)[0]


def lookahead(depth: int) -> fp.PolicySettings:
    """The exact lookahead."""
    return fp.policy({"kind": "lookahead", "depth": depth})


class Remembered:
    """Decides once for every belief: the tiger's few beliefs come again and again."""

    def __init__(self, settings: fp.PolicySettings) -> None:
        self._policy, self._known = settings.build(), {}

    def build(self) -> "Remembered":
        """Itself, for every game."""
        return self

    def act(self, belief: fp.Belief, rng: np.random.Generator) -> fp.Decision:
        """The decision in this belief, or one that is the same but for rounding."""
        key = round(float(belief.weights[0]), 9)
        if key not in self._known:
            self._known[key] = self._policy.act(belief, rng)
        return self._known[key]

    def observe(self, _action: int, _observation: int) -> None:
        """Nothing is learned."""


def tigers(depth: int) -> Game:
    """A game of 50 steps."""
    policy = Remembered(lookahead(depth))
    return lambda rng: tiger.play(policy, 50, rng)[0]  # type: ignore[arg-type]


SEVEN, ELEVEN = (7, rock_sample.MAP_7_8, (0, 3)), (11, rock_sample.MAP_11_11, (0, 5))
# Name: games, the game, and what its return is held against.
ZOO: dict[str, tuple[int, Game, str]] = {
    "tiger, lookahead 6": (10_000, tigers(6), "17.76 optimum, 17.70 this policy, exactly (value iteration)"),
    "crying baby, lookahead 6": (
        1000, lambda rng: crying_baby.play(crying_baby.POLICIES["lookahead"], 60, rng), "-16.31 exact",
    ),
    "crying baby, pomcp": (1000, lambda rng: crying_baby.play(crying_baby.POLICIES["pomcp"], 60, rng), "-16.31 exact"),
    "light-dark, pomcpow": (
        1000, lambda rng: light_dark.play(light_dark.SEARCH, rng)[0],
        "POMCPOW 56.1 ± 0.6, DESPOT 54.2 ± 1.1 (Sunberg & Kochenderfer 2018, table 1)",
    ),
    "RockSample[7,8], 1024": (400, rocks(*SEVEN, 1024), "15.5 ... 19.5 (Silver & Veness 2010)"),
    "RockSample[7,8], 4096": (400, rocks(*SEVEN, 4096), "18; Silver's code 19.1 ± 0.9"),
    "RockSample[11,11], 1024": (100, rocks(*ELEVEN, 1024), "none for this budget"),
    "RockSample[11,11], 4096": (100, rocks(*ELEVEN, 4096), "none for this budget"),
}  # fmt: skip


def main() -> None:
    """Play the games of all whose name contains NAME."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("name", nargs="?", default="")
    parser.add_argument("--games", type=int)
    given = parser.parse_args()
    for name, (games, play, reference) in ZOO.items():
        if given.name in name:
            rng, count = np.random.default_rng(SEED), given.games or games
            play(rng)
            begin = time.process_time()
            returns = np.array([play(rng) for _ in range(count)])
            seconds = (time.process_time() - begin) / count
            error = returns.std(ddof=1) / np.sqrt(count)
            print(f"{name}: {returns.mean():.2f} ± {error:.2f} in {count} games, {seconds:.3f} s each; {reference}")


if __name__ == "__main__":
    main()
