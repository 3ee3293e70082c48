"""The kinds of choice models.

A new kind is a file beside this one and a name in KINDS; from outside the package, `fatigue_planner.register`.
"""

from typing import Annotated

from fatigue_planner.pomdp.choices.boltzmann import BoltzmannChoice
from fatigue_planner.pomdp.choices.choice_model import CHOICE_MODELS, ChoiceModel
from fatigue_planner.pomdp.choices.inertia import InertiaChoice
from fatigue_planner.pomdp.choices.offset import OffsetChoice

KINDS = (BoltzmannChoice, OffsetChoice, InertiaChoice)
for kind in KINDS:
    CHOICE_MODELS.add(kind)

# The settings of any choice model.
AnyChoiceModel = Annotated[ChoiceModel, CHOICE_MODELS]
