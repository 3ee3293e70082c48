"""The fatigue model: the exact cycle map against direct integration of Eq. 2, and its properties."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fatigue_planner.core.errors import DataFileError
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.fatigue.entries import ENTRIES, fatigue_state
from fatigue_planner.fatigue.load import cycle_profile, loads
from fatigue_planner.fatigue.model import CycleMap
from fatigue_planner.fatigue.parameters import FatigueParameters, FatigueSettings, fatigue_parameters
from fatigue_planner.human.joint_data import maximum_torque
from fatigue_planner.human.model import joint_index
from fatigue_planner.reactions.reaction import Reaction


@pytest.fixture(scope="module")
def parameters(paper: Experiment) -> FatigueParameters:
    return fatigue_parameters(paper.fatigue, maximum_torque("average_man"))


def cycle_map(torque_nm: np.ndarray, time_step_s: float, parameters: FatigueParameters) -> CycleMap:
    share = loads(torque_nm) / parameters.maximum_torque_nm
    return parameters.law.profile(share, time_step_s, parameters).cycle_map()


def integrate(torque_nm: np.ndarray, dt: float, parameters: FatigueParameters, fatigue: np.ndarray) -> np.ndarray:
    """Eq. 2 for tau_cem by a classical Runge-Kutta scheme, mode by mode, as the paper prints it."""
    maximum = parameters.maximum_torque_nm
    tau_cem = (1 - fatigue) * maximum
    for load in loads(torque_nm):
        tiring = load > parameters.threshold * maximum

        def rate(tau: np.ndarray, load: np.ndarray = load, tiring: np.ndarray = tiring) -> np.ndarray:
            fatigued = -parameters.fatigue_rate * tau / maximum * load
            return np.where(tiring, fatigued, parameters.recovery_rate * (maximum - tau))

        for _ in range(2):
            h = dt / 2
            k1 = rate(tau_cem)
            k2 = rate(tau_cem + h / 2 * k1)
            k3 = rate(tau_cem + h / 2 * k2)
            k4 = rate(tau_cem + h * k3)
            tau_cem = tau_cem + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return 1 - tau_cem / maximum


def test_cycle_map_is_the_integral_of_equation_2(
    reactions: tuple[Reaction, ...], parameters: FatigueParameters
) -> None:
    rng = np.random.default_rng(5)
    for reaction in reactions:
        motion = reaction.motion
        mapping = cycle_map(motion.torque_nm, motion.time_step_s, parameters)
        for start in (np.zeros(78), rng.uniform(0, 1, 78)):
            direct = integrate(motion.torque_nm, motion.time_step_s, parameters, start)
            np.testing.assert_allclose(mapping.apply(start), direct, atol=1e-9, rtol=0)


def test_constant_load_agrees_with_an_adaptive_integrator(parameters: FatigueParameters) -> None:
    torque = np.zeros((1600, 39))
    torque[:, 0] = 0.5 * parameters.maximum_torque_nm[0]
    mapping = cycle_map(torque, 0.01, parameters)

    def eq2(_: float, tau: np.ndarray) -> np.ndarray:
        return -0.01667 * tau * 0.5

    exact = solve_ivp(eq2, (0, 16), [0.7], method="DOP853", rtol=1e-12, atol=1e-14).y[0, -1]
    assert mapping.apply(np.full(78, 0.3))[0] == pytest.approx(1 - exact, abs=1e-10)
    assert mapping.apply(np.full(78, 0.3))[1] == pytest.approx(0.3 * np.exp(-0.04 * 16), abs=1e-14)


def test_endurance_matches_the_published_curve(parameters: FatigueParameters) -> None:
    """At 50 % load the capacity meets the load after -ln(f)/(k f) = 83.2 s (Ma et al. 2009)."""
    dt = 0.01
    torque = np.zeros((round(83.16 / dt), 39))
    torque[:, 4] = 0.5 * parameters.maximum_torque_nm[4]
    assert cycle_map(torque, dt, parameters).apply(np.zeros(78))[4] == pytest.approx(0.5, abs=1e-4)


def test_agonist_tires_while_antagonist_recovers(parameters: FatigueParameters) -> None:
    torque = np.zeros((100, 39))
    torque[:, 7] = -0.4 * parameters.maximum_torque_nm[39 + 7]
    after = cycle_map(torque, 0.1, parameters).apply(np.full(78, 0.2))
    assert after[39 + 7] > 0.2 > after[7]


def test_load_at_the_threshold_recovers_and_just_above_tires(parameters: FatigueParameters) -> None:
    at = np.zeros((10, 39))
    at[:, 0] = parameters.threshold[0] * parameters.maximum_torque_nm[0]
    above = at * (1 + 1e-12)
    assert cycle_map(at, 0.1, parameters).offset[0] == 0
    assert cycle_map(above, 0.1, parameters).offset[0] > 0


def test_maps_keep_fatigue_between_zero_and_one_and_its_order(
    reactions: tuple[Reaction, ...], parameters: FatigueParameters
) -> None:
    for reaction in reactions:
        mapping = cycle_map(reaction.motion.torque_nm, reaction.motion.time_step_s, parameters)
        assert (mapping.gain > 0).all() and (mapping.offset >= 0).all()
        assert (mapping.gain + mapping.offset <= 1 + 1e-12).all()


def test_map_does_not_depend_on_the_sampling(parameters: FatigueParameters) -> None:
    torque = np.random.default_rng(2).normal(0, 30, (50, 39))
    coarse = cycle_map(torque, 0.1, parameters)
    fine = cycle_map(np.repeat(torque, 8, axis=0), 0.1 / 8, parameters)
    np.testing.assert_allclose(coarse.gain, fine.gain, rtol=1e-12)
    np.testing.assert_allclose(coarse.offset, fine.offset, atol=1e-13)


def test_factors_on_the_rates_give_the_maps_of_workers_with_these_rates(
    reactions: tuple[Reaction, ...], parameters: FatigueParameters
) -> None:
    """A profile with factors on k and R equals the profile of a worker whose k and R are so; many at once."""
    fatigue_factors, recovery_factors = np.array([[0.5], [2.0]]), np.array([0.3, 1.0, 1.7])
    for reaction in reactions:
        motion = reaction.motion
        profile = cycle_profile(motion, parameters)
        gain, offset = profile.maps(fatigue_factors, recovery_factors)
        assert gain.shape == offset.shape == (2, 3, 78)
        for i, k in enumerate(fatigue_factors[:, 0]):
            for j, R in enumerate(recovery_factors):
                rates = {"fatigue_rate": k * parameters.fatigue_rate, "recovery_rate": R * parameters.recovery_rate}
                other = replace(parameters, **rates)
                exact = integrate(motion.torque_nm, motion.time_step_s, other, np.full(78, 0.3))
                np.testing.assert_allclose(0.3 * gain[i, j] + offset[i, j], exact, atol=1e-9, rtol=0)


def test_every_entry_has_the_strength_of_its_direction(parameters: FatigueParameters) -> None:
    positive, negative = maximum_torque("average_man").vectors()
    assert (positive != negative).any()
    for place, entry in enumerate(ENTRIES):
        freedom, direction = entry.split(":")
        strength = {"positive": positive, "negative": negative}[direction]
        assert parameters.maximum_torque_nm[place] == strength[joint_index(freedom)], entry


def test_names_of_fatigue_reach_their_entries() -> None:
    def named(name: str) -> set[str]:
        return {ENTRIES[i] for i in np.flatnonzero(fatigue_state({name: 0.5}))}

    assert named("lumbar_flexion") == {"lumbar_flexion:positive", "lumbar_flexion:negative"}
    assert named("right_hip_flexion:negative") == {"right_hip_flexion:negative"}
    assert len(named("hip_flexion")) == 4
    assert len(named("back")) == 12 and len(named("shoulder")) == 12 and len(named("all")) == 78
    with pytest.raises(DataFileError, match="unknown joint 'spine'"):
        fatigue_state({"spine": 0.5})


def test_joints_may_differ_from_the_rest(paper: Experiment) -> None:
    """k, R and alpha of single joints; a later name goes before an earlier one, a side before none."""
    settings = FatigueSettings.model_validate(
        {
            **paper.fatigue.model_dump(),
            "joints": {
                "shoulder_flexion": {"fatigue_rate_per_s": 0.028},
                "right_shoulder_flexion:negative": {"fatigue_rate_per_s": 0.05, "threshold": 0.2},
                "lumbar_flexion": {"recovery_rate_per_s": 0.01},
            },
        }
    )
    ours, common = (fatigue_parameters(chosen, maximum_torque("average_man")) for chosen in (settings, paper.fatigue))
    place = ENTRIES.index
    assert ours.fatigue_rate[place("left_shoulder_flexion:positive")] == 0.028
    assert ours.fatigue_rate[place("right_shoulder_flexion:negative")] == 0.05
    assert ours.threshold[place("right_shoulder_flexion:negative")] == 0.2
    assert (
        ours.recovery_rate[[place("lumbar_flexion:positive"), place("lumbar_flexion:negative")]].tolist() == [0.01] * 2
    )
    for name, changed in (("fatigue_rate", 4), ("recovery_rate", 2), ("threshold", 1)):
        assert (getattr(ours, name) != getattr(common, name)).sum() == changed
    torque = np.zeros((100, 39))
    torque[:, 0] = -0.05 * common.maximum_torque_nm[39]  # below the threshold: the back recovers, more slowly
    slow, usual = (cycle_map(torque, 0.1, parameters) for parameters in (ours, common))
    assert slow.gain[39] == pytest.approx(np.exp(-0.1)) and usual.gain[39] == pytest.approx(np.exp(-0.4))
