"""What pydantic finds wrong, in terms of the files: one line per fault with source, key, value, what is allowed."""

import difflib
from collections.abc import Iterable, Sequence

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from fatigue_planner.core.errors import MAX_SHOWN_LENGTH, listed, shortened
from fatigue_planner.core.settings import MAX_NAME_LENGTH, Settings
from fatigue_planner.core.yaml_reader import decimal_comma_hint
from fatigue_planner.experiment.error_location import kinds_of, locate

# More faults than these help nobody, and describing thousands takes long.
MAX_FAULTS = 50
_MAX_CONSIDERED = 4 * MAX_FAULTS
# What pydantic puts behind the name of an entry if the name itself is wrong.
_KEY = "[key]"
NAME_PATTERN = f"should begin with a letter and have no more than {MAX_NAME_LENGTH} letters (a to z), digits, _ . and -"
# Our wording for pydantic's types of errors, in terms of a YAML file.
_WORDING = {
    "dict_type": "should be a mapping of keys and values",
    "model_type": "should be a mapping of keys and values",
    "model_attributes_type": "should be a mapping of keys and values",
    "tuple_type": "should be a list",
    "string_pattern_mismatch": NAME_PATTERN,
    "too_short": "should have at least {min_length} of them",
    "too_long": "should have at most {max_length} of them",
}


def error_message(error: ValidationError, kind: type[Settings], source: str) -> str:
    """One message of all faults in settings of a kind: source, key, value, what is allowed."""
    return joined_errors(source, error_lines(error, kind))


def error_lines(error: ValidationError, kind: type[Settings], above: str = "") -> list[str]:
    """The faults in settings of a kind, one line each; `above`: the key of these settings in the file."""
    considered = [_Fault(fault, kind, above) for fault in error.errors(include_url=False)[: _MAX_CONSIDERED + 1]]
    misspelt = {(*fault.location[:-1], fault.meant()) for fault in considered if fault.type == "extra_forbidden"}
    inside = {fault.location[:end] for fault in considered for end in range(len(fault.location))}
    # Nothing new: a default that depends on what is wrong, a key that is missing because it is misspelt, a list that is
    # too short because its items are wrong.
    informative = [
        fault
        for fault in considered
        if fault.type != "default_factory_not_called"
        and not (fault.type == "missing" and fault.location in misspelt)
        and not (fault.type == "too_short" and fault.location in inside)
    ]
    return [line for fault in informative for line in fault.text().split("\n")]


def joined_errors(source: str, faults: Iterable[str]) -> str:
    """One message of all faults, each on a line that names the source; of very many the first."""
    lines = list(dict.fromkeys(faults))
    more = ["there are more faults; correct these first."] if len(lines) > MAX_FAULTS else []
    return "\n".join(f"{source}: {fault}" for fault in lines[:MAX_FAULTS] + more)


def dotted(parts: Iterable[int | str]) -> str:
    """The path of a key as a message writes it: dots between the names, and quotes around what cannot be a name."""
    names = [str(part) for part in parts]
    return ".".join(
        name if name.isprintable() and 0 < len(name) <= MAX_SHOWN_LENGTH else shortened(name) for name in names
    )


class _Fault:
    """One of pydantic's faults."""

    def __init__(self, details: ErrorDetails, kind: type[Settings], above: str) -> None:
        self.details, self.type, self.kind = details, details["type"], kind
        location = details["loc"]
        self.location = location[:-1] if location[-1:] == (_KEY,) else location
        parts, self.expected = locate(kind, self.location)
        self.key = ".".join(part for part in (above, dotted(parts)) if part)

    def meant(self) -> str | None:
        """Of an unknown key: the known key of the same group that is most like it, if any is."""
        close = difflib.get_close_matches(str(self.location[-1]), self._known(), n=1)
        return close[0] if close else None

    def text(self) -> str:
        """The fault in words; several lines where pydantic reports several faults as one."""
        value = self.details["input"]
        if self.type == "extra_forbidden":
            meant = self.meant()
            return f"{self.key}: unknown key; " + (
                f"did you mean {meant!r}?" if meant else f"allowed are {listed(self._known())}."
            )
        if self.type == "missing":
            return f"{self.key}: is missing."
        if self.type == "value_error":
            text = str(self.details["ctx"]["error"])
            return f"{self.key}: {text}." if self.key else text.replace("\n", ".\n") + "."
        if self.type == "union_tag_not_found":
            return f"{self.key}: needs a kind: one of {listed(kinds_of(self.expected))}."
        if self.type == "union_tag_invalid":
            kinds = listed(kinds_of(self.expected))
            return f"{self.key}.kind = {shortened(value['kind'])}: should be one of {kinds}."
        wording, default = _WORDING.get(self.type), self.details["msg"]
        message = wording.format(**self.details.get("ctx", {})) if wording else default[0].lower() + default[1:]
        hint = decimal_comma_hint(value) if self.type == "float_type" else ""
        return f"{self.key or 'the file'} = {shortened(value)}: {message}{hint}."

    def _known(self) -> Sequence[str]:
        _, owner = locate(self.kind, self.location[:-1])
        if not (isinstance(owner, type) and issubclass(owner, Settings)):
            return []
        return [field.alias or name for name, field in owner.model_fields.items()]
