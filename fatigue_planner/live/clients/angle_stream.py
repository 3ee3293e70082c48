"""A tracker's stream of joint angles by Lab Streaming Layer: found, checked, lost and found again.

A number per channel. Labels are those of the digital human's degrees of freedom, such as `right_elbow_flexion`; other
channels are left alone. Each channel's `unit` says degrees or radians.
"""

import json
import math
from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np
import pylsl
from pylsl.util import TimeoutError as NotYetError

from fatigue_planner.core.errors import SelectionError, listed
from fatigue_planner.human.skeleton import DEGREES_OF_FREEDOM
from fatigue_planner.live.clients.recogniser import Samples, Tracker

Unit = Literal["deg", "rad"]

UNITS: dict[str, Unit] = {
    "deg": "deg", "degree": "deg", "degrees": "deg", "°": "deg", "rad": "rad", "radian": "rad", "radians": "rad",
}  # fmt: skip
MAX_RATE_HZ = 2000.0
# What no joint of a person is turned by.
ABSURD_DEG = 360.0
# A stamp may be ahead of this machine's clock by so much, as far as clocks can be corrected.
AHEAD_S = 1.0
OPEN_WAIT_S = CORRECTION_WAIT_S = 2.0
# A stream that has ended is found for so long.
FORGET_S = 2.0
MAX_SAMPLES = 4096


class AngleStream(Tracker):
    """The stream of a name.

    unit: of all angles, whatever the channels say. wanted: the degrees of freedom, by index, that are to be measured.
    least_rate_hz: fewer samples are too few. Once a stream has fitted, one that does not is told and not listened to.
    """

    def __init__(self, name: str, unit: Unit | None, wanted: Sequence[int], least_rate_hz: float) -> None:
        self._name, self._unit, self._wanted, self._least_hz = name, unit, tuple(wanted), least_rate_hz
        self._resolver = pylsl.ContinuousResolver("name", name, forget_after=FORGET_S)
        self._inlet: Any = None
        self._channels: list[tuple[int, int, float]] = []  # where in a sample, which degree of freedom, its factor
        self._has_fitted = False

    def read(self) -> Samples:
        """See Tracker.read. Raises SelectionError for the first stream, if it cannot be one of joint angles."""
        remarks: list[str] = []
        if self._inlet is None:
            self._open(remarks)
        if self._inlet is None:
            return Samples.none(*remarks)
        try:
            correction_s = self._inlet.time_correction(CORRECTION_WAIT_S)
            values, stamps_s = self._inlet.pull_chunk(0.0, MAX_SAMPLES)
        except NotYetError:
            return Samples.none(f"the clock of {self._name} cannot be compared yet")
        except RuntimeError:  # that of all errors of pylsl
            self._inlet = None
            return Samples.none(f"the stream {self._name} has ended")
        if not stamps_s:
            return Samples.none(*remarks)
        return self._samples(np.array(values, float), np.array(stamps_s) + correction_s, remarks)

    def close(self) -> None:
        """See Tracker.close."""
        if self._inlet is not None:
            self._inlet.close_stream()

    def _samples(self, values: "np.ndarray[Any, Any]", stamps_s: "np.ndarray[Any, Any]", remarks: list[str]) -> Samples:
        """The samples in degrees, without those that no tracker measures; values (T, channels)."""
        angles = np.full((len(values), len(DEGREES_OF_FREEDOM)), np.nan)
        for place, joint, factor in self._channels:
            angles[:, joint] = values[:, place] * factor
        with np.errstate(invalid="ignore"):
            absurd = np.isinf(angles) | (np.abs(angles) > ABSURD_DEG)
        if absurd.any():
            worst = DEGREES_OF_FREEDOM[int(absurd.any(axis=0).argmax())]
            remarks.append(f"{worst} is beyond {ABSURD_DEG:.0f} degrees; such angles do not count")
            angles[absurd] = np.nan
        timely = np.isfinite(stamps_s) & (stamps_s <= pylsl.local_clock() + AHEAD_S)
        if not timely.all():
            remarks.append("time stamps are in the future; such samples do not count")
        return Samples(stamps_s[timely], angles[timely], tuple(remarks))

    def _open(self, remarks: list[str]) -> None:
        """Begin to listen, if the stream is there and can be understood."""
        found = self._resolver.results()
        if len(found) > 1:
            remarks.append(f"{len(found)} streams are called {self._name}; there must be one")
        if len(found) != 1:
            return
        inlet = pylsl.StreamInlet(found[0], recover=False)
        try:
            channels, missing = self._understood(inlet.info(OPEN_WAIT_S))
            inlet.open_stream(OPEN_WAIT_S)
        except UnicodeDecodeError:
            remarks.append(f"the description of {self._name} is not UTF-8")
            return
        except SelectionError as error:
            if not self._has_fitted:
                raise
            remarks.append(f"not listened to: {error}")
            return
        except RuntimeError:  # that of all errors of pylsl
            return
        self._inlet, self._channels, self._has_fitted = inlet, channels, True
        remarks.append(f"the stream {self._name} is there")
        if missing:
            remarks.append(f"it has no {listed(missing)}: reactions are told apart less well than was measured")

    def _understood(self, info: Any) -> tuple[list[tuple[int, int, float]], list[str]]:
        """The channels that are angles, and the degrees of freedom that are missing. Raises SelectionError."""
        if info.channel_format() == pylsl.cf_string:
            raise SelectionError(f"stream {self._name}: is text; should be numbers, an angle per channel.")
        rate_hz = info.nominal_srate()
        if rate_hz != pylsl.IRREGULAR_RATE and not self._least_hz <= rate_hz <= MAX_RATE_HZ:
            raise SelectionError(
                f"stream {self._name}: {rate_hz:g} samples a second; should be {self._least_hz:g} to {MAX_RATE_HZ:g}."
            )
        described = _described(info)
        if described and len(described) != info.channel_count():
            raise SelectionError(
                f"stream {self._name}: {info.channel_count()} channels, of which {len(described)} are described."
            )
        found = []
        for place, (label, said) in enumerate(described):
            if label not in DEGREES_OF_FREEDOM:
                continue
            unit = self._unit or UNITS.get(said.strip().lower())
            if unit is None:
                raise SelectionError(
                    f"stream {self._name}: the unit of {label} is {said!r}; should be degrees or radians, or given "
                    "with --unit."
                )
            found.append((place, DEGREES_OF_FREEDOM.index(label), 1.0 if unit == "deg" else 180 / math.pi))
        joints = [joint for _, joint, _ in found]
        if not set(joints) & set(self._wanted) or len(set(joints)) < len(joints):
            labels = [label for label, _ in described]
            raise SelectionError(
                f"stream {self._name}: its channels are {listed(labels) or 'not labelled'}; should be, each once, "
                f"degrees of freedom of the digital human: {listed(DEGREES_OF_FREEDOM[i] for i in self._wanted)}."
            )
        return found, [DEGREES_OF_FREEDOM[joint] for joint in self._wanted if joint not in joints]


def outlet(name: str) -> Callable[[dict[str, Any]], None]:
    """A stream of texts in JSON, to which what is given to it goes out."""
    info = pylsl.StreamInfo(name, "Markers", 1, pylsl.IRREGULAR_RATE, pylsl.cf_string, f"fatplan {name}")
    stream = pylsl.StreamOutlet(info)
    return lambda said: stream.push_sample([json.dumps(said)])


def _described(info: Any) -> list[tuple[str, str]]:
    """Label and unit of a stream's channels."""
    found, channel = [], info.desc().child("channels").first_child()
    while not channel.empty():
        found.append((channel.child_value("label"), channel.child_value("unit")))
        channel = channel.next_sibling()
    return found
