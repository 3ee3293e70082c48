"""What an experiment says of its statistics."""

from collections.abc import Iterable

from pydantic import Field

from fatigue_planner.core.settings import Name, Settings

POWER = 0.8  # of the smallest detectable difference: the usual one (Cohen 1988, section 2.4)


class Family(Settings):
    """Comparisons that are corrected together (Holm): pairs of policies in some conditions and lengths."""

    policies: tuple[str, ...] | None = Field(
        default=None, description="Policies that are compared; left out, those of `statistics.policies`."
    )
    against: tuple[str, ...] | None = Field(
        default=None, description="Policies they are compared with; left out, every pair among `policies`."
    )
    conditions: tuple[str, ...] | None = Field(default=None, description="Conditions; left out, all.")
    n_cycles: tuple[int, ...] | None = Field(default=None, description="Numbers of cycles; left out, all.")


class StatisticsSettings(Settings):
    """Levels, margins and families, fixed before results are seen."""

    significance_level: float = Field(
        default=0.05, gt=0, lt=1, description="Level of all tests; the paper's is 0.05 (section IV-E)."
    )
    # The cost is quadratic in fatigue, so 1 % of it is half a per cent of fatigue: less than could be felt or measured.
    equivalence_margin: float = Field(
        default=0.01,
        gt=0,
        lt=1,
        description="Difference, as a fraction of the mean cost, below which two policies count as equal.",
    )
    resamples: int = Field(
        default=9999, ge=99, le=1_000_000, description="Resamples of every bootstrap interval and permutation test."
    )
    policies: tuple[str, ...] | None = Field(
        default=None,
        description="Policies that are ranked, compared and drawn beside one another; left out, all. The others are "
        "run, too: what planning is worth over them, their fatigue and their regret are reported.",
    )
    families: dict[Name, Family] = Field(
        default_factory=dict,
        max_length=1000,
        description="Families of comparisons by name. Default: all pairs of policies everywhere are one family.",
    )

    def shown(self, run: Iterable[str]) -> list[str]:
        """Which of the policies that were run are ranked: `policies`, or all where none of them was run."""
        available = list(dict.fromkeys(run))
        return [name for name in available if self.policies is None or name in self.policies] or available
