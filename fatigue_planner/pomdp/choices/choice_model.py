"""What a choice model is: by how much a worker likes preferences, whatever they cost.

In a multinomial logit (Train, Discrete Choice Methods with Simulation, 2nd ed. 2009, section 3.1) the chance of u is
proportional to the exponential of its utility. That of Eq. 4 is -beta c(u, f). A choice model adds log-odds w:

    P(u | f, a, v) is proportional to exp(w(u | v) - beta c(u, f)),    v: the choice before, or none.

As fatigue enters by c alone, every planner, belief and bound treats all kinds alike: by a table of the log-odds. Where
its rows differ, the choice before is part of the state.
"""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fatigue_planner.core.plugins import Registry
from fatigue_planner.core.settings import Name, Settings

Array = NDArray[np.float64]

# A log-odds of 20 is a ratio of chances of half a billion: more nobody can tell.
MAX_LOG_ODDS = 20.0
LogOdds = Annotated[float, Field(ge=-MAX_LOG_ODDS, le=MAX_LOG_ODDS)]
Offsets = Annotated[dict[Name, LogOdds], Field(max_length=100)]


class ChoiceModel(Settings):
    """A choice model; every kind has `kind: Literal["its name"]`, keys of its own, and says its `log_odds`.

    >>> experiment.choice_models
    {}
    """

    kind: str

    @abstractmethod
    def log_odds(self, preferences: Sequence[str]) -> Array:
        """w by preference: (1, U) where the choice before does not matter, else (1 + U, U); row 0: nothing before.

        Row 1 + v: after a choice of preference v. Only differences within a row count.
        """

    def preferences_named(self) -> Mapping[str, Sequence[str]]:
        """The preferences that the settings name, by key: they must be the experiment's."""
        return {}


CHOICE_MODELS = Registry("choice model", ChoiceModel)  # type: ignore[type-abstract]


def offsets_of(offsets: Mapping[str, float], preferences: Sequence[str]) -> Array:
    """The offsets (1, U) of all preferences; those that are left out have 0."""
    return np.array([[offsets.get(name, 0.0) for name in preferences]])
