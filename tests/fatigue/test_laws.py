"""The fatigue laws: exact cycle maps against fine integration, the full three-compartment model, endurance, rest."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.entries import ENTRIES, entry_indices
from fatigue_planner.fatigue.laws.law import FatigueLaw, Rates
from fatigue_planner.fatigue.laws.ma import MaLaw
from fatigue_planner.fatigue.laws.three_compartment import ThreeCompartmentLaw
from fatigue_planner.fatigue.load import load_share
from fatigue_planner.fatigue.model import TickProfile
from fatigue_planner.fatigue.parameters import FatigueParameters, FatigueSettings, fatigue_parameters
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.reactions.reaction import Reaction

MA, THREE = MaLaw(kind="ma"), ThreeCompartmentLaw(kind="3cc_r")


def parameters_of(law: FatigueLaw) -> FatigueParameters:
    return fatigue_parameters(FatigueSettings(law=law), maximum_torque("average_man"))


def change(law: FatigueLaw, f: np.ndarray, s: np.ndarray, rates: Rates) -> np.ndarray:
    """df/dt as the laws' authors write it."""
    rests = s <= rates.threshold
    if law.kind == "ma":
        return np.where(rests, -rates.recovery_rate * f, rates.fatigue_rate * s * (1 - f))
    recovery = np.where(rests, rates.rest_multiplier, 1.0) * rates.recovery_rate
    return np.where(rests, 0.0, s) * rates.fatigue_rate - recovery * f


@pytest.mark.parametrize("law", [MA, THREE])
def test_cycle_maps_are_the_integral_of_the_law(law: FatigueLaw, reactions: tuple[Reaction, ...]) -> None:
    """Runge-Kutta, eight steps a tick, over every reaction: the maps are exact to 1e-9."""
    parameters = parameters_of(law)
    fatigue = np.random.default_rng(1).uniform(0, 1, 78)
    for reaction in reactions:
        motion = reaction.motion
        share, f, h = load_share(motion, parameters), fatigue.copy(), motion.time_step_s / 8
        for s in share:
            for _ in range(8):
                k1 = change(law, f, s, parameters)
                k2 = change(law, f + h / 2 * k1, s, parameters)
                k3 = change(law, f + h / 2 * k2, s, parameters)
                k4 = change(law, f + h * k3, s, parameters)
                f = f + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        mapping = law.profile(share, motion.time_step_s, parameters).cycle_map()
        assert np.abs(mapping.apply(fatigue) - f).max() < 1e-9
        assert (f > fatigue).any() and (f < fatigue).sum() > 50


def test_the_closed_form_of_ma_is_that_of_its_flows(reactions: tuple[Reaction, ...]) -> None:
    """Sums over runs and the product tick by tick are the same map, for any factors of the rates."""
    parameters = parameters_of(MA)
    faster, sooner = np.array([1.0, 0.3, 5.0]), np.array([1.0, 4.0, 0.2])
    for reaction in reactions:
        share, step = load_share(reaction.motion, parameters), reaction.motion.time_step_s
        closed = MA.profile(share, step, parameters)
        ticks = TickProfile.of(MA.flows(share, parameters), step, parameters.fatigue_rate, parameters.recovery_rate)
        assert (closed.tires == ticks.tires).all() and 0 < closed.tires.sum() < 78
        np.testing.assert_allclose(closed.maps(faster, sooner), ticks.maps(faster, sooner), rtol=1e-11, atol=1e-15)


@pytest.mark.parametrize("law", [MA, THREE])
def test_the_load_counts_while_it_is_above_the_threshold(law: FatigueLaw, reactions: tuple[Reaction, ...]) -> None:
    parameters, motion = parameters_of(law), reactions[0].motion
    share = load_share(motion, parameters)
    expected = [sum(s for s in of if s > 0.1) * motion.time_step_s for of in share.T]
    np.testing.assert_allclose(law.profile(share, motion.time_step_s, parameters).load_s, expected, rtol=1e-12)
    assert 0 < np.count_nonzero(expected) < 78


def test_factors_are_factors_of_the_rates(reactions: tuple[Reaction, ...]) -> None:
    """3CC-r with F and R multiplied is 3CC-r with the multiplied F and R; r stays."""
    own = parameters_of(THREE)
    share, step = load_share(reactions[0].motion, own), reactions[0].motion.time_step_s
    gain, offset = THREE.profile(share, step, own).maps(np.array([[2.0], [0.5]]), np.array([3.0, 0.1, 1.0]))
    assert gain.shape == offset.shape == (2, 3, 78)
    other = Rates(0.5 * own.fatigue_rate, 0.1 * own.recovery_rate, own.rest_multiplier, own.threshold)
    changed = THREE.profile(share, step, other).cycle_map()
    np.testing.assert_allclose([gain[1, 1], offset[1, 1]], [changed.gain, changed.offset], rtol=1e-13)


def full_model(share: np.ndarray, step: float, F: float, R: float, r: float, threshold: float) -> float:
    """M_F after a cycle of the whole three-compartment model (Xia & Frey Law 2008), from rest, by small Euler steps.

    A controller with L_D = L_R = 10 per s activates and releases muscle; recovery is r R while nothing is asked.
    """
    active, fatigued, substeps = 0.0, 0.0, 20
    h = step / substeps
    for s in np.where(share > threshold, share, 0.0):
        recovery = R if s > 0 else r * R
        for _ in range(substeps):
            resting = 1 - active - fatigued
            drive = 10 * (min(s - active, resting) if active < s else s - active)
            tired = F * active - recovery * fatigued
            active, fatigued = active + h * (drive - F * active), fatigued + h * tired
    return fatigued


def test_the_reduced_form_is_close_to_the_full_model(
    reactions: tuple[Reaction, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    """The lag of the controller, 0.1 s, changes what a cycle of 16 s adds to fatigue by less than 1 %."""
    parameters = parameters_of(THREE)
    worst = 0.0
    for reaction in reactions:
        share, step = load_share(reaction.motion, parameters), reaction.motion.time_step_s
        offset = THREE.profile(share, step, parameters).cycle_map().offset
        for entry in np.argsort(-offset)[:4]:
            rates = [float(values[entry]) for values in vars(parameters).values() if isinstance(values, np.ndarray)][:4]
            full = full_model(share[:, entry], step, *rates)
            worst = max(worst, abs(offset[entry] / full - 1))
            assert abs(offset[entry] - full) < 5e-4
    with capsys.disabled():
        print(f" [reduced against full 3CC-r after a cycle: at most {100 * worst:.2f} %]", end="")
    assert 1e-4 < worst < 0.01


@pytest.mark.parametrize(("law", "entry"), [(MA, "elbow_flexion:positive"), (THREE, "back"), (THREE, "wrist")])
def test_endurance_is_when_the_load_is_all_that_is_left(law: FatigueLaw, entry: str) -> None:
    """Against an adaptive integrator that stops where f = 1 - s."""
    parameters = parameters_of(law)
    index = entry_indices(entry, "")[0]
    for s in (0.2, 0.5, 0.8):

        def rate(_: float, f: np.ndarray, s: float = s) -> np.ndarray:
            return change(law, np.full(78, f[0]), np.full(78, s), parameters)[index : index + 1]

        def spent(_: float, f: np.ndarray, s: float = s) -> float:
            return f[0] - (1 - s)

        spent.terminal = True  # type: ignore[attr-defined]
        solved = solve_ivp(rate, (0, 1e5), [0.0], events=spent, rtol=1e-10, atol=1e-12)
        assert law.endurance_s(s, parameters)[index] == pytest.approx(solved.t_events[0][0], rel=1e-6)


def test_some_loads_can_be_held_for_ever() -> None:
    """3CC-r settles at F s / R, so a load below R / (F + R) never ends; nor does one at the threshold."""
    parameters = parameters_of(THREE)
    low = parameters.recovery_rate / (parameters.fatigue_rate + parameters.recovery_rate)
    free = Rates(parameters.fatigue_rate, parameters.recovery_rate, parameters.rest_multiplier, np.zeros(78))
    back = entry_indices("back", "")[0]
    assert np.isinf(THREE.endurance_s(float(low[back]) - 1e-9, free)[back])
    assert np.isfinite(THREE.endurance_s(float(low[back]) + 1e-9, free)[back])
    for law in (MA, THREE):
        assert np.isinf(law.endurance_s(0.1, parameters_of(law))).all()


def test_rest_is_as_fast_as_the_law_says(paper: Experiment) -> None:
    """Ma: R; 3CC-r: r R. The half-life is ln 2 over it: 17 s for the paper, a minute for 3CC-r's trunk."""
    ma = fatigue_parameters(paper.fatigue, maximum_torque("average_man"))
    assert set(ma.law.rest_rate(ma)) == {0.04}
    three = parameters_of(THREE)
    for joint, rate in {"ankle": 0.0087, "back": 0.01125, "elbow": 0.0141, "wrist": 0.0192, "knee": 0.02235}.items():
        assert three.law.rest_rate(three)[entry_indices(joint, "")] == pytest.approx(rate, abs=1e-9), joint
    assert len(ENTRIES) == 78
