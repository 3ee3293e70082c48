"""Where a load exceeds what is left: against integration tick by tick."""

from types import SimpleNamespace

import numpy as np
import pytest

from fatigue_planner.fatigue.capacity import Capacity, Shortfall, capacity
from fatigue_planner.fatigue.entries import ENTRIES, entry_indices
from fatigue_planner.fatigue.laws.law import FatigueLaw
from fatigue_planner.fatigue.laws.ma import MaLaw
from fatigue_planner.fatigue.laws.three_compartment import ThreeCompartmentLaw
from fatigue_planner.fatigue.parameters import FatigueParameters, FatigueSettings, fatigue_parameters
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.model import joint_index

LAWS = [MaLaw(kind="ma"), ThreeCompartmentLaw(kind="3cc_r")]
STEP = 0.5


def parameters_of(law: FatigueLaw) -> FatigueParameters:
    return fatigue_parameters(FatigueSettings(law=law), maximum_torque("average_man"))


def cycle(elbow: float, knee: float, parameters: FatigueParameters) -> Capacity:
    """The elbow holds a share of its strength for 20 s from 5 s on, the knee one for 4 s at the end, of 40 s."""
    torque = np.zeros((80, 39))
    strength = parameters.maximum_torque_nm
    torque[10:50, joint_index("right_elbow_flexion")] = elbow * strength[ENTRIES.index("right_elbow_flexion:positive")]
    torque[72:, joint_index("left_knee_flexion")] = -knee * strength[ENTRIES.index("left_knee_flexion:negative")]
    return capacity(SimpleNamespace(torque_nm=torque, configuration=np.zeros((80, 46)), time_step_s=STEP), parameters)


def lived_through(own: Capacity, law: FatigueLaw, parameters: FatigueParameters, cycles: int) -> Shortfall | None:
    """The first shortfall, by small steps through cycle after cycle."""
    fatigue, steps = np.zeros(78), 100
    flows = law.flows(own.share, parameters)
    for number in range(1, cycles + 1):
        for tick, share in enumerate(own.share):
            for _ in range(steps):
                fade = parameters.fatigue_rate * flows.slowing[tick] + parameters.recovery_rate * flows.recovering[tick]
                grow = parameters.fatigue_rate * flows.tiring[tick]
                middle = fatigue + STEP / steps / 2 * (grow - fade * fatigue)
                fatigue = fatigue + STEP / steps * (grow - fade * middle)
            short = np.flatnonzero(share > 1 - fatigue)
            if short.size:
                return Shortfall(number, ENTRIES[short[0]], tick * STEP)
    return None


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize(("elbow", "knee"), [(0.3, 0.2), (0.5, 0.2), (0.72, 0.2), (0.2, 0.95), (0.7, 0.8), (0.2, 1.1)])
def test_the_first_shortfall_is_found(law: FatigueLaw, elbow: float, knee: float) -> None:
    parameters = parameters_of(law)
    own = cycle(elbow, knee, parameters)
    assert own.if_repeated() == lived_through(own, law, parameters, 60)


@pytest.mark.parametrize("law", LAWS)
def test_the_highest_start_is_just_enough(law: FatigueLaw) -> None:
    """A little more fatigue at the start is too much, at the end of what is asked."""
    parameters = parameters_of(law)
    own = cycle(0.6, 0.2, parameters)
    elbow = ENTRIES.index("right_elbow_flexion:positive")
    start = np.zeros(78)
    start[elbow] = own.highest_start[elbow] - 1e-9
    assert 0.05 < start[elbow] < 0.4 and own.first_shortfall(start) is None
    start[elbow] += 2e-9
    assert own.first_shortfall(start) == Shortfall(1, "right_elbow_flexion:positive", 49 * STEP)


def test_nothing_asked_is_never_too_much() -> None:
    parameters = parameters_of(LAWS[0])
    rested = cycle(0.05, 0.05, parameters)
    assert rested.if_repeated() is None
    assert rested.first_shortfall(np.full(78, 0.9)) is None
    tired = np.zeros(78)
    tired[entry_indices("right_elbow_flexion:positive", "")] = 0.99
    assert rested.first_shortfall(tired) is None  # he recovers before the load comes
    assert cycle(0.3, 0.05, parameters).first_shortfall(tired) == Shortfall(1, "right_elbow_flexion:positive", 5.0)
