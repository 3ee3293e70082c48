"""The policy `agent`: a function or class from outside that knows nothing of fatplan, such as a trained network."""

import inspect
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Field, PrivateAttr, model_validator

from fatigue_planner.core.errors import PluginError, shortened
from fatigue_planner.core.files import digest_of_bytes
from fatigue_planner.core.plugins import named_in_plugin, source_of_plugin
from fatigue_planner.planners.policy import (
    Decision,
    Policy,
    PolicySettings,
    action_number,
    expected_action,
    plain_decision,
)
from fatigue_planner.pomdp.beliefs.belief import Belief

MAX_LENGTH = 200
# The content goes with every piece of work to the processes that do it.
MAX_DATA_BYTES = 64_000_000


def _module_and_name(text: str) -> str:
    module, _, name = text.partition(":")
    if not all(part.isidentifier() for part in [*module.split("."), name]):
        raise ValueError("should be a module and a name in it, with a colon between them: my_agents:act")
    return text


class AgentPolicy(Policy):
    """Asks an agent, which sees what an environment would show it (`environment`): observations, not beliefs."""

    draws_at_random = True  # it may

    def __init__(self, name: str, act: Callable[[int, np.random.Generator], Any]) -> None:
        self._name, self._act = name, act
        self._seen: int | None = None

    def act(self, belief: Belief, rng: np.random.Generator) -> Decision:
        """See Policy.act. Raises PluginError if the agent returns what is no action."""
        begin = time.perf_counter()
        actions, model = belief.model.actions, belief.model
        chosen = self._act(len(model.observations) if self._seen is None else self._seen, rng)
        number = action_number(chosen, actions)
        if number is None:
            raise PluginError(
                f"the agent {self._name} returned {shortened(chosen)}; expected {expected_action(actions)}."
            )
        unknown = np.full(len(actions), np.nan)
        return plain_decision(number, unknown, 0, time.perf_counter() - begin, f"chosen by {self._name}", belief)

    def observe(self, action: int, observation: int) -> None:
        """See Policy.observe."""
        self._seen = observation


class AgentSettings(PolicySettings):
    """An agent of a plug-in: a function (observation, rng) -> action, or a class of objects called like that."""

    kind: Literal["agent"] = Field(description="A function or class from outside that sees only observations.")
    agent: Annotated[str, AfterValidator(_module_and_name)] = Field(
        max_length=MAX_LENGTH,
        description="The agent as module:name, in a plug-in file (--plugin my_agents.py: my_agents:act) or a package "
        "with plug-ins. A class is made anew for every run.",
    )
    data: str | None = Field(
        default=None,
        min_length=1,
        max_length=1000,
        description="A file, such as trained weights, of at most 64 MB: its content (bytes) is what the class is made "
        "from. Default: the class is made from nothing.",
    )
    _content: bytes = PrivateAttr(default=b"")

    @model_validator(mode="after")
    def _read(self) -> "AgentSettings":
        if self.data is not None:
            path = Path(self.data)
            try:
                if not path.is_file() or path.stat().st_size > MAX_DATA_BYTES:
                    raise ValueError(f"data = {shortened(self.data)}: should be a file of at most 64 MB")
                self._content = path.read_bytes()
            except OSError as error:
                raise ValueError(f"data = {shortened(self.data)}: cannot be read ({error.strerror})") from error
        return self

    def faults(self) -> list[str]:
        """See PolicySettings.faults."""
        try:
            self._found()
        except PluginError as error:
            return [f"agent = {shortened(self.agent)}: {error}"]
        return []

    def sources(self) -> dict[str, str]:
        """See PolicySettings.sources: the plug-in's, and the data."""
        self._found()
        return source_of_plugin(self.agent.partition(":")[0]) | {"data": digest_of_bytes(self._content)}

    def build(self) -> Policy:
        """See PolicySettings.build. Raises PluginError if there is no such agent."""
        found = self._found()
        return AgentPolicy(self.agent, found(*self._made_from()) if isinstance(found, type) else found)

    def _made_from(self) -> tuple[bytes, ...]:
        """What a class is made from."""
        return () if self.data is None else (self._content,)

    def _found(self) -> Any:
        """The function or class. Raises PluginError."""
        module, _, name = self.agent.partition(":")
        found = named_in_plugin(module, name)
        if isinstance(found, type):
            _check_call(name, found, self._made_from(), "the content of data" if self.data else "nothing")
            if not any("__call__" in vars(kind) for kind in found.__mro__):
                raise PluginError(f"the class {name} has no __call__(self, observation, rng).")
            _check_call(f"{name}.__call__", found.__call__, (None, 0, None), "(self, observation, rng)")
        elif callable(found) and self.data is None:
            _check_call(name, found, (0, None), "(observation, rng)")
        else:
            wanted = "a function or a class" if self.data is None else "a class, which data need"
            raise PluginError(f"{name} is not {wanted}.")
        return found


def _check_call(name: str, function: Any, arguments: tuple[object, ...], what: str) -> None:
    """Raise PluginError if a function or class does not take these arguments."""
    try:
        signature = inspect.signature(function)
    except ValueError:  # of built-in functions
        return
    try:
        signature.bind(*arguments)
    except TypeError as error:
        raise PluginError(f"{name} must take {what}; it takes {signature}.") from error
