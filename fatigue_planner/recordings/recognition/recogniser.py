"""The recogniser: for every action, the reactions' distributions and how often they are confused."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fatigue_planner.core.errors import RecognitionError, listed
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.recordings.recognition.action_model import MIN_PEOPLE, ActionModel
from fatigue_planner.recordings.recognition.calibration import fitted_temperature, posterior
from fatigue_planner.recordings.recognition.confusion import (
    Confusion,
    design_effect,
    group_names,
    groups_of,
    merged,
    told_apart,
)
from fatigue_planner.recordings.recognition.repetitions import Repetitions, of_stream, part_ends_s

Array = NDArray[np.float64]

# The least of which a part's mean is taken: of one alone it would depend on when it came.
PART_SAMPLES = 2


@dataclass(frozen=True)
class KnownAction:
    """What is known of the reactions to an action.

    apart (C, C): how many of two are told apart after the whole motion; groups (C,): which are one to the robot.
    lapse: how probable a motion is that is like none of them, one in as many as were tried.
    """

    model: ActionModel
    apart: Array
    groups: NDArray[np.int64]
    confusion: Confusion
    lapse: float

    def posterior(self, angles_deg: Array, temperature: Array) -> Array:
        """How probable each preference is after each part, (N, C, K), for motions (N, K, all degrees of freedom)."""
        likelihood = merged(self.model.log_likelihood(angles_deg), self.groups)
        return posterior(likelihood, temperature, self.lapse)


@dataclass(frozen=True)
class Recogniser:
    """Says how likely a motion is under each reaction to the action that the robot took.

    temperature (N_PARTS,): by what the likelihoods are flattened after each part, so that probabilities are true.
    """

    cycle: Cycle
    actions: Mapping[str, KnownAction]
    temperature: Array

    def probabilities(self, action: str, angles_deg: Array) -> dict[str, float]:
        """How probable each reaction is, were all equally likely before: what `likelihood` of a live shift takes.

        angles_deg (K, J): the mean angles over the K parts that are over, of all degrees of freedom (see
        `repetitions.of_stream`); with no part over, all are equal. Raises RecognitionError for an unknown action.
        """
        known = self._known(action)
        preferences = known.model.preferences
        if not len(angles_deg):
            return dict.fromkeys(preferences, 1 / len(preferences))
        found = known.posterior(angles_deg[None], self.temperature)
        return dict(zip(preferences, found[0, :, -1].tolist(), strict=True))

    def of_stream(self, action: str, times_s: Array, angles_deg: Array) -> dict[str, float]:
        """The same of a stream that may still grow: times (T,) in s since the cycle began, angles (T, J)."""
        return self.probabilities(action, of_stream(times_s, angles_deg, self.cycle))

    @property
    def joints(self) -> list[int]:
        """The degrees of freedom, by index, of which some action wants to know the angle."""
        return sorted({joint for known in self.actions.values() for joint in known.model.joints.tolist()})

    @property
    def least_rate_hz(self) -> float:
        """How many samples a second are needed, so that `PART_SAMPLES` fall into every part."""
        return PART_SAMPLES / float(np.diff(part_ends_s(self.cycle), prepend=0.0).min())

    def _known(self, action: str) -> KnownAction:
        if action not in self.actions:
            raise RecognitionError(f"action {action!r}: the recogniser knows {listed(self.actions)}.")
        return self.actions[action]


@dataclass(frozen=True)
class HeldOut:
    """The repetitions of an action, each judged by a model that does not know the person.

    log_likelihood (N, C, N_PARTS); truth (N,): which preference it was; people (N,).
    """

    preferences: tuple[str, ...]
    log_likelihood: Array
    truth: NDArray[np.int64]
    people: NDArray[np.str_]

    @classmethod
    def of(cls, repetitions: Repetitions, preferences: tuple[str, ...]) -> Self:
        """By leaving one person out, again and again."""
        found = np.empty((len(repetitions), len(preferences), repetitions.angles_deg.shape[1]))
        for person in np.unique(repetitions.people):
            own = repetitions.people == person
            model = ActionModel.fit(repetitions.where(~own), preferences)
            found[own] = model.log_likelihood(repetitions.angles_deg[own])
        truth = np.array([preferences.index(name) for name in repetitions.preferences.tolist()])
        return cls(preferences, found, truth, repetitions.people)

    def apart(self) -> Array:
        """How many of two equally likely reactions are told apart after the whole motion, (C, C)."""
        return told_apart(self.log_likelihood[:, :, -1], self.truth)

    def probability(self, temperature: Array, groups: NDArray[np.int64], lapse: float) -> Array:
        """How probable each group is after each part, (N, groups, N_PARTS), all reactions equally likely before."""
        probability = posterior(merged(self.log_likelihood, groups), temperature, lapse)
        of_groups = [probability[:, groups == one].sum(axis=1) for one in range(groups.max() + 1)]
        return np.stack(of_groups, axis=1)

    def chosen(self, temperature: Array, groups: NDArray[np.int64]) -> NDArray[np.int64]:
        """As which group each repetition is recognised after each part, (N, N_PARTS), all equally likely before."""
        return np.asarray(self.probability(temperature, groups, 0.0).argmax(axis=1))

    def right_share(self, temperature: Array, groups: NDArray[np.int64]) -> Array:
        """The share that is recognised after each part, (N_PARTS,), every preference counting the same."""
        right = self.chosen(temperature, groups) == groups[self.truth][:, None]
        shares = [right[self.truth == one].mean(axis=0) for one in range(len(self.preferences))]
        return np.asarray(np.mean(shares, axis=0))


def train(repetitions: Repetitions, cycle: Cycle, told_apart_from: float) -> tuple[Recogniser, dict[str, HeldOut]]:
    """The recogniser of labelled repetitions, and how each of its actions did with people it did not know.

    Preferences come in the order in which they first appear; those of which less than the share `told_apart_from` is
    right, were the two equally likely, are one to the robot. Raises RecognitionError where too few people show a
    reaction: without any one of them, `MIN_PEOPLE` must be left.
    """
    held_out, models = {}, {}
    for action in dict.fromkeys(repetitions.actions.tolist()):
        own = repetitions.where(repetitions.actions == action)
        preferences = tuple(dict.fromkeys(own.preferences.tolist()))
        for preference in preferences:
            n = len(set(own.people[own.preferences == preference].tolist()))
            if n <= MIN_PEOPLE:
                raise RecognitionError(
                    f"{action}/{preference}: repetitions of {n} people; at least {MIN_PEOPLE + 1} are needed, as each "
                    "is judged by what the others did."
                )
        held_out[action] = HeldOut.of(own, preferences)
        models[action] = ActionModel.fit(own, preferences)
    apart = {action: one.apart() for action, one in held_out.items()}
    groups = {action: groups_of(one, told_apart_from) for action, one in apart.items()}
    temperature = fitted_temperature(
        [(merged(one.log_likelihood, groups[action]), one.truth) for action, one in held_out.items()]
    )
    chosen = {action: one.chosen(temperature, groups[action])[:, -1] for action, one in held_out.items()}
    effect = _effect(held_out, chosen, groups)
    known = {}
    for action, one in held_out.items():
        names = group_names(one.preferences, groups[action])
        counts = np.zeros((len(one.preferences), len(names)), np.int64)
        np.add.at(counts, (one.truth, chosen[action]), 1)
        confusion = Confusion(one.preferences, names, counts, counts.sum(axis=1) / effect)
        lapse = 1 / (len(one.truth) + 2)  # Laplace's rule: none of those that were tried was like none of the reactions
        known[action] = KnownAction(models[action], apart[action], groups[action], confusion, lapse)
    return Recogniser(cycle, known, temperature), held_out


def _effect(
    held_out: Mapping[str, HeldOut], chosen: Mapping[str, NDArray[np.int64]], groups: Mapping[str, NDArray[np.int64]]
) -> float:
    """The design effect of the repetitions of people, one for all actions."""
    right = [chosen[action] == groups[action][one.truth] for action, one in held_out.items()]
    labels = [f"{action}/{truth}" for action, one in held_out.items() for truth in one.truth]
    people = np.concatenate([one.people for one in held_out.values()])
    reactions, whose = (np.unique(names, return_inverse=True)[1] for names in (labels, people))
    return design_effect(np.concatenate(right), reactions, whose)
