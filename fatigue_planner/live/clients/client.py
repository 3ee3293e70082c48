"""What stands between the face and a device: an extension point with a kind per device."""

import threading
import time
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable
from typing import Any

from fatigue_planner.core.errors import FaceRefusedError, FaceUnreachableError, SelectionError
from fatigue_planner.live.clients.connection import Address, Answer, Connection, Watch

# A device is looked at so often.
LOOK_EVERY_S = 0.05
# The device is not looked at while a face that is away is waited for.
PATIENCE_S = 2.0


class Client(ABC):
    """A process of its own that follows a shift: `look` is called after every change of the state, and regularly.

    ignored: by reason, how often something was not believed. say: where messages go, each once per reason in a row.
    state: what the face said last, as `SessionState`.
    """

    def __init__(self, address: Address, say: Callable[[str], None]) -> None:
        self.connection = Connection(address, PATIENCE_S)
        self.ignored: Counter[str] = Counter()
        self.state: dict[str, Any] = {}
        self._watch, self._tell, self._said = Watch(address), say, ""

    @abstractmethod
    def look(self, cycle: int, action: str) -> None:
        """See what is new, at the device and at the face, where this action was decided for the cycle going on."""

    @abstractmethod
    def close_device(self) -> None:
        """Let go of the device."""

    @abstractmethod
    def check(self, actions: tuple[str, ...], reactions: tuple[str, ...]) -> None:
        """Raise SelectionError if the client cannot work with these actions and reactions of the experiment."""

    def run(self, stop: threading.Event) -> None:
        """Follow the shift until told to stop.

        Raises SelectionError if it is a rehearsal, or has actions that the client does not know.
        """
        self._watch.start()
        number, answered_s = 0, time.monotonic()
        checked: object = None
        try:
            while not stop.is_set():
                number, state = self._watch.newest(number, LOOK_EVERY_S)
                if state is None:
                    if time.monotonic() - answered_s > PATIENCE_S:
                        self.say("the face does not answer")
                    continue
                answered_s, self.state = time.monotonic(), state
                if state["rehearsal"]:
                    raise SelectionError("the shift is a rehearsal; no device takes part in it.")
                names = tuple(state["actions"]), tuple(state["reactions"])
                if names != checked:  # another shift may have come in its place
                    self.check(*names)
                    checked = names
                if state["action"] is None:
                    self.tell("decide")  # and another state comes
                else:
                    self.look(state["cycle"], state["action"])
        finally:
            self._watch.end()
            self.connection.close()
            self.close_device()

    def tell(self, name: str, **said: object) -> Answer | None:
        """Say something to the face; what it refuses is counted and said, and changes nothing."""
        try:
            return self.connection.call(name, **said)
        except FaceRefusedError as error:
            self.ignore(str(error))
        except FaceUnreachableError as error:
            self.say(str(error))
        return None

    def ignore(self, reason: str) -> None:
        """Something was not believed."""
        self.ignored[reason] += 1
        self.say(reason)

    def say(self, message: str) -> None:
        """A message for people, once until another comes."""
        if message != self._said:
            self._said = message
            self._tell(message)
