"""The kinds of factors a study can name.

To add one: write its settings (see `factor.FactorSettings`) and name them in AnyFactor.
"""

from typing import Annotated

from pydantic import Field

from fatigue_planner.study.sensitivity.factors.choice import ChoiceSettings
from fatigue_planner.study.sensitivity.factors.range import RangeSettings
from fatigue_planner.study.sensitivity.factors.scale import ScaleSettings

AnyFactor = Annotated[RangeSettings | ScaleSettings | ChoiceSettings, Field(discriminator="kind")]
