"""What an experiment says of its statistics."""

from pydantic import Field

from fatigue_planner.core.settings import Name, Settings

POWER = 0.8  # of the smallest detectable difference: the usual one (Cohen 1988, section 2.4)


class Family(Settings):
    """Comparisons that are corrected together (Holm): pairs of policies in some conditions and lengths.

    What is left out means all; without `against` every pair among `policies` is compared.
    """

    policies: tuple[str, ...] | None = None
    against: tuple[str, ...] | None = None
    conditions: tuple[str, ...] | None = None
    n_cycles: tuple[int, ...] | None = None


class StatisticsSettings(Settings):
    """Levels, margins and families, fixed before results are seen.

    equivalence_margin: the difference, as a share of the mean cost, below which two policies count as equal. The cost
        is quadratic in fatigue, so 1 % of it is half a per cent of fatigue, less than could be felt or measured.
    families: by name; without any, all pairs of policies in all conditions and lengths are one family.
    """

    significance_level: float = Field(gt=0, lt=1)
    equivalence_margin: float = Field(default=0.01, gt=0, lt=1)
    resamples: int = Field(default=9999, ge=99, le=1_000_000)
    families: dict[Name, Family] = Field(default_factory=dict, max_length=1000)
