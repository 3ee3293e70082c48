"""Tables of trials made by chance, for the tests of the contrasts."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike


def trial_table(
    samples: Mapping[str, ArrayLike], deterministic: tuple[str, ...] = (), condition: str = "novice", n_cycles: int = 5
) -> pd.DataFrame:
    """One cell: the policies' returns, trial by trial."""
    return pd.concat(
        [
            pd.DataFrame(
                {
                    "condition": condition,
                    "n_cycles": n_cycles,
                    "policy": policy,
                    "trial": np.arange(np.size(returns)),
                    "deterministic": policy in deterministic,
                    "discounted_return": np.asarray(returns, dtype=float),
                }
            )
            for policy, returns in samples.items()
        ],
        ignore_index=True,
    )


def shared_worlds(rng: np.random.Generator, n: int = 40, shift: float = 0.7) -> dict[str, np.ndarray]:
    """Two policies' returns (n,), of which the common world explains more than half of the variance."""
    world = rng.normal(size=n) * 1.2
    return {"a": -10 + world + rng.normal(size=n) + shift, "b": -10 + world + rng.gamma(2, size=n) - 2}
