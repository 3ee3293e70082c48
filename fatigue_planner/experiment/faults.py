"""What pydantic finds wrong, in the words of the files: one line per fault with source, key, value, what is allowed."""

import difflib
from collections.abc import Callable, Iterable, Iterator, Sequence

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from fatigue_planner.errors import LONGEST_SHOWN, shortened
from fatigue_planner.settings import Settings

Location = tuple[int | str, ...]

# pydantic's words for what a YAML file should have.
_SHAPES = {
    "dict_type": "should be a mapping of keys and values",
    "model_type": "should be a mapping of keys and values",
    "model_attributes_type": "should be a mapping of keys and values",
    "tuple_type": "should be a list",
}
_SIZES = {
    "too_short": "should have at least {min_length} of them, not {actual_length}",
    "too_long": "should have at most {max_length} of them, not {actual_length}",
}
# More faults than these help nobody, and to describe thousands takes long.
MOST_FAULTS = 50
_MOST_CONSIDERED = 4 * MOST_FAULTS
# Behind the name of an entry whose name itself is wrong.
_KEY = "[key]"


def fault_text(error: ValidationError, source: str, place: Callable[[Location], str] | None = None) -> str:
    """One message of all faults: source, key, value, what is allowed; `place`: how the path of a key is written."""
    return told_together(source, fault_lines(error, place or _place))


def fault_lines(error: ValidationError, place: Callable[[Location], str]) -> list[str]:
    """The faults, one each, without the source."""
    known = _known_keys()
    considered = error.errors(include_url=False)[: _MOST_CONSIDERED + 1]
    described = [_describe(fault, place, known) for fault in _telling(considered, known)]
    return [line for fault in described for line in fault.split("\n")]


def told_together(source: str, faults: Iterable[str]) -> str:
    """One message of all faults, each on a line that names the source; of very many the first."""
    lines = list(dict.fromkeys(faults))
    more = ["there are more faults; mend these first."] if len(lines) > MOST_FAULTS else []
    return "\n".join(f"{source}: {fault}" for fault in lines[:MOST_FAULTS] + more)


def dotted(parts: Iterable[int | str]) -> str:
    """The path of a key as a message writes it: dots between the names, names that are no names in quotes."""
    texts = [str(part) for part in parts]
    return ".".join(one if one.isprintable() and 0 < len(one) <= LONGEST_SHOWN else shortened(one) for one in texts)


def _telling(faults: list[ErrorDetails], known: Sequence[str]) -> list[ErrorDetails]:
    """The faults without those that only follow from others: a key missing because it is misspelt, a list too
    short because what is in it is wrong.
    """
    misspelt = {
        (*fault["loc"][:-1], close)
        for fault in faults
        if fault["type"] == "extra_forbidden"
        for close in difflib.get_close_matches(str(fault["loc"][-1]), known, n=1)
    }
    inside = {fault["loc"][:-1] for fault in faults}
    return [
        fault
        for fault in faults
        if not (fault["type"] == "missing" and fault["loc"] in misspelt)
        and not (fault["type"] == "too_short" and fault["loc"] in inside)
    ]


def _describe(fault: ErrorDetails, place_of: Callable[[Location], str], known: Sequence[str]) -> str:
    location = fault["loc"]
    place = place_of(location[:-1] if location[-1:] == (_KEY,) else location)
    if fault["type"] == "extra_forbidden":
        return f"{place}: unknown key{_did_you_mean(str(location[-1]), known)}"
    if fault["type"] == "missing":
        return f"{place}: is missing."
    if fault["type"] == "value_error":
        text = str(fault["ctx"]["error"])
        return f"{place}: {text}." if location else text.replace("\n", ".\n") + "."
    if fault["type"] == "union_tag_invalid":
        return f"{place}.kind = {shortened(fault['ctx']['tag'])}: should be one of {fault['ctx']['expected_tags']}."
    if fault["type"] == "union_tag_not_found":
        return f"{place}: needs a kind."
    message = _SHAPES.get(fault["type"], fault["msg"][0].lower() + fault["msg"][1:])
    if fault["type"] in _SIZES:
        message = _SIZES[fault["type"]].format(**fault["ctx"])
    return f"{place} = {shortened(fault['input'])}: {message}."


def _place(location: Location) -> str:
    """The path of a key; behind an entry with a `kind` pydantic adds the kind, which the file has not."""
    parts = list(location)
    if parts[:2] == ["benchmark", "policies"] or parts[:1] == ["hidden_workers"]:
        del parts[3:4]  # benchmark.policies.<name>.<kind>..., hidden_workers.<name>.<parameter>.<kind>...
    if parts[:1] == ["belief"]:
        del parts[1:2]
    # preferences.<name>.tasks.<number>.<kind>..., actions.<name>.loads.<number>.<kind>...
    if (parts[0:1], parts[2:3]) in ((["preferences"], ["tasks"]), (["actions"], ["loads"])):
        del parts[4:5]
    return dotted(parts) or "the file"


def _did_you_mean(key: str, known: Sequence[str]) -> str:
    if key in known:
        return f" here; {key!r} belongs elsewhere, see experiments/paper.yaml."
    close = difflib.get_close_matches(key, known, n=1)
    return f"; did you mean {close[0]!r}?" if close else "."


def _known_keys() -> list[str]:
    names = {field.alias or name for model in _all_settings(Settings) for name, field in model.model_fields.items()}
    return sorted(names)


def _all_settings(kind: type[Settings]) -> Iterator[type[Settings]]:
    for below in kind.__subclasses__():
        yield below
        yield from _all_settings(below)
