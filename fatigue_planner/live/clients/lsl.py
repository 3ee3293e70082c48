"""Lab Streaming Layer: what a recogniser saw comes in, decisions go out as markers; clocks of other machines corrected.

In: a stream with one sample per cycle, at its end: one text, the reaction's name; or a number per preference, how
likely what was measured is under it, with the preferences' names as channel labels. Out, as text:
{"cycle": 4, "action": "low"}.
"""

import json
import math
from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import Any

import pylsl
from pylsl.util import TimeoutError as LslTimeoutError

from fatigue_planner.core.errors import SelectionError, listed, shortened
from fatigue_planner.live.clients.client import Client
from fatigue_planner.live.clients.connection import Address
from fatigue_planner.live.limits import LATE_CYCLES

CORRECTION_WAIT_S = 2.0
# A stamp may be ahead of this machine's clock by so much, as far as clocks can be corrected.
AHEAD_S = 1.0
OPEN_WAIT_S = 2.0
# A stream that has ended is found for so long.
FORGET_S = 2.0


class LslClient(Client):
    """Brings a recogniser's stream to the face.

    name: of the stream. early_s: what is stamped within so many seconds after a cycle began is of the cycle before, in
    which it was measured. out: name of the stream of decisions.
    """

    def __init__(
        self, address: Address, name: str, out: str, say: Callable[[str], None] = lambda _: None, early_s: float = 2.0
    ) -> None:
        super().__init__(address, say)
        self._name, self._early_s = name, early_s
        self._resolver = pylsl.ContinuousResolver("name", name, forget_after=FORGET_S)
        info = pylsl.StreamInfo(out, "Markers", 1, pylsl.IRREGULAR_RATE, pylsl.cf_string, f"fatplan {out}")
        self._outlet = pylsl.StreamOutlet(info)
        self._inlet: Any = None
        self._labels: tuple[str, ...] = ()
        self._reactions: tuple[str, ...] = ()
        self._began_s: OrderedDict[int, float] = OrderedDict()
        self._last_s = -math.inf

    def check(self, actions: tuple[str, ...], reactions: tuple[str, ...]) -> None:
        """See Client.check."""
        self._reactions = reactions

    def look(self, cycle: int, action: str) -> None:
        """See Client.look."""
        if cycle not in self._began_s:
            joined = not self._began_s  # within a cycle, which began some time before
            self._began_s[cycle] = pylsl.local_clock() - (self._early_s if joined else 0)
            while len(self._began_s) > LATE_CYCLES + 1:
                self._began_s.popitem(last=False)
            self._outlet.push_sample([json.dumps({"cycle": cycle, "action": action})])
        if self._inlet is None:
            self._open()
        while self._inlet is not None:
            try:
                correction_s = self._inlet.time_correction(CORRECTION_WAIT_S)
                values, stamp_s = self._inlet.pull_sample(0.0)
            except UnicodeDecodeError:
                self.ignore("the stream's text is not UTF-8")
                continue
            except LslTimeoutError:  # samples stay where they are until the clocks can be compared
                self.say(f"the clock of the stream {self._name} does not answer; what it says is kept back")
                return
            except RuntimeError:  # that of all errors of pylsl
                self._inlet = None
                self.say(f"the stream {self._name} has ended")
                return
            if stamp_s is None or values is None:
                return
            self._take(values, stamp_s + correction_s)

    def close_device(self) -> None:
        """See Client.close_device."""
        if self._inlet is not None:
            self._inlet.close_stream()

    def _open(self) -> None:
        """Begin to listen, if the stream is there and can be understood."""
        found = self._resolver.results()
        if len(found) > 1:
            self.ignore(f"{len(found)} streams are called {self._name}; there must be one")
        if len(found) != 1:
            return
        inlet = pylsl.StreamInlet(found[0], recover=False)
        try:
            info = inlet.info(OPEN_WAIT_S)
            labels = _labels(info)
            is_text = info.channel_format() == pylsl.cf_string and info.channel_count() == 1
            preferences = tuple(self.state["preferences"])
            if not is_text and sorted(labels) != sorted(preferences):
                raise SelectionError(
                    f"stream {self._name}: its channels are {listed(labels) or 'not labelled'}; should be one text, or "
                    f"a number per preference: {listed(preferences)}."
                )
            inlet.open_stream(OPEN_WAIT_S)
        except UnicodeDecodeError:
            self.ignore("the stream's description is not UTF-8")
            return
        except RuntimeError:  # that of all errors of pylsl
            return
        self._labels = () if is_text else labels
        self._inlet = inlet
        self.say(f"the stream {self._name} is there")

    def _take(self, values: Sequence[Any], stamp_s: float) -> None:
        """Say what was seen of the cycle in which it was measured, if that can be."""
        said = self._meaning(values)
        if said is None:
            self.ignore(f"the stream says {shortened(list(values))}, which is no observation")
            return
        cycle = self._cycle_of(stamp_s)
        if cycle is None:
            self.ignore("the stream's time stamp is of no cycle that can be told")
            return
        if stamp_s == self._last_s:
            return
        self._last_s = stamp_s
        self.tell("observe", cycle=cycle, **said)

    def _meaning(self, values: Sequence[Any]) -> dict[str, Any] | None:
        """What a sample says; None for what cannot be."""
        if not self._labels:
            return {"observation": values[0]} if values[0] in self._reactions else None
        if not all(isinstance(one, int | float) and 0 <= one < math.inf for one in values) or not any(values):
            return None
        most = max(1.0, *values)  # only ratios count
        return {"likelihood": {name: one / most for name, one in zip(self._labels, values, strict=True)}}

    def _cycle_of(self, stamp_s: float) -> int | None:
        """The cycle in which something was measured; None for what is stamped in the future, or too long ago."""
        if not stamp_s <= pylsl.local_clock() + AHEAD_S:
            return None
        begun = [cycle for cycle, began_s in self._began_s.items() if began_s + self._early_s <= stamp_s]
        if begun:
            return begun[-1]
        first, began_s = next(iter(self._began_s.items()))
        return first - 1 if began_s <= stamp_s and first > 1 else None


def _labels(info: Any) -> tuple[str, ...]:
    """The labels of a stream's channels."""
    labels, channel = [], info.desc().child("channels").first_child()
    while not channel.empty():
        labels.append(channel.child_value("label"))
        channel = channel.next_sibling()
    return tuple(labels)
