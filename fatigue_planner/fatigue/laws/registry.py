"""The kinds of fatigue laws.

A new kind is a file beside this one and a name in KINDS; from outside the package, `fatigue_planner.register`.
"""

from typing import Annotated

from fatigue_planner.fatigue.laws.law import LAWS, FatigueLaw
from fatigue_planner.fatigue.laws.ma import MaLaw
from fatigue_planner.fatigue.laws.three_compartment import ThreeCompartmentLaw

KINDS = (MaLaw, ThreeCompartmentLaw)
for kind in KINDS:
    LAWS.add(kind)

# The settings of any law.
AnyLaw = Annotated[FatigueLaw, LAWS]
