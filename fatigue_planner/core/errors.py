"""The mistakes a user can make, one type each, under one root; what messages show of values; exit codes."""

from collections.abc import Iterable
from enum import IntEnum

# A message shows at most so many characters of a value, and so many items of a list.
MAX_SHOWN_LENGTH = 60
MAX_LISTED = 50
# So many digits tell any two numbers apart that are not the same but for rounding.
MAX_DIGITS = 17


class ExitCode(IntEnum):
    """What the process returns to the shell."""

    OK = 0
    INTERNAL_ERROR = 1
    BAD_INPUT = 2
    FAILED_PARTS = 3
    DAMAGED_STORE = 4
    INTERRUPTED = 130
    TERMINATED = 143


class FatplanError(Exception):
    """Root of every error that is the input's or the machine's, not the program's.

    >>> try:
    ...     fp.policy("gredy")
    ... except fp.FatplanError as error:
    ...     print("gredy" in str(error), int(error.exit_code))
    True 2
    """

    exit_code = ExitCode.BAD_INPUT

    def __str__(self) -> str:
        """The message; what it quotes of files and their names cannot steer a terminal: such characters are escaped."""
        return "".join(
            character
            if character.isprintable() or character == "\n"
            else character.encode("unicode_escape").decode("ascii")
            for character in super().__str__()
        )


class ExperimentError(FatplanError):
    """An experiment file is missing, unreadable, or says something that is not allowed."""


class ClaimsError(FatplanError):
    """A file of claims is missing, unreadable, or says something that is not allowed."""


class DataFileError(FatplanError):
    """A file with data of the human body is missing, incomplete or inconsistent."""


class SelectionError(FatplanError):
    """An option of the command line selects something the experiment does not have."""


class MissingReactionsError(FatplanError):
    """The reactions an experiment needs have not been simulated."""


class ArchiveError(FatplanError):
    """A file is not an archive of reactions."""


class ReaderError(FatplanError):
    """The process that reads stored reactions cannot be started on this machine."""


class OtherVersionError(FatplanError):
    """A reaction was written by a version of fatplan with another file format."""


class OutputFolderError(FatplanError):
    """A file or folder cannot be written."""


class MissingTableError(FatplanError):
    """The table of trials a command reads has not been written."""


class FailedMotionError(FatplanError):
    """A motion could not be simulated, or not accurately enough to be used."""

    exit_code = ExitCode.FAILED_PARTS


class StaleTableError(FatplanError):
    """The table of trials was made with other settings than the experiment has now."""


class WorkerError(FatplanError):
    """A process that does the work cannot be started on this machine."""


class LostWorkError(FatplanError):
    """Some work kills the workers that do it."""

    exit_code = ExitCode.FAILED_PARTS


class ClusterError(FatplanError):
    """There is no cluster at an address, or its workers could give other results."""


class LostClusterError(FatplanError):
    """The connection to a cluster broke before all work was done."""

    exit_code = ExitCode.FAILED_PARTS


class PluginError(FatplanError):
    """A plug-in cannot be loaded, registers what cannot be registered, or its section of the report fails."""


class ProblemError(FatplanError):
    """A problem or a belief made in Python is none: its probabilities are negative or do not sum to 1."""


class MissingExtraError(FatplanError):
    """What was asked for needs libraries that are not installed by default."""


class CycleError(FatplanError):
    """What was said or asked is of a cycle that is not going on."""


class ContradictionError(FatplanError):
    """A cycle was observed in two ways."""


class EvidenceError(FatplanError):
    """What was said of a cycle or a pause is no observation."""


class FaceUnreachableError(FatplanError):
    """The program that decides beside a robot does not answer."""

    exit_code = ExitCode.FAILED_PARTS


class FaceRefusedError(FatplanError):
    """The program that decides beside a robot refuses what was said, with an HTTP status."""

    exit_code = ExitCode.FAILED_PARTS

    def __init__(self, code: int, reason: str) -> None:
        super().__init__(f"refused with {code}: {reason}")
        self.code = code


class OtherSituationError(FatplanError):
    """A journal's shift was begun with another task, policy or version."""


class JournalInUseError(FatplanError):
    """A journal is being written by another program."""


class DamagedJournalError(FatplanError):
    """A journal is not what was written."""

    exit_code = ExitCode.DAMAGED_STORE


class RecordingError(FatplanError):
    """A file is not a usable recording, or contradicts itself."""


class RecognitionError(FatplanError):
    """Labelled repetitions are too few, or a file is no recogniser that this version can use."""


class DamagedFileError(FatplanError):
    """A file of the cache or of the results is not what was written."""

    exit_code = ExitCode.DAMAGED_STORE


def shortened(value: object) -> str:
    """A value as a message shows it: as Python writes it, control characters escaped, its beginning if it is long."""
    if isinstance(value, str):
        value = value[: MAX_SHOWN_LENGTH + 1]
    elif isinstance(value, tuple | list):
        value = list(value[:MAX_SHOWN_LENGTH])
    elif isinstance(value, dict):
        value = dict(list(value.items())[:MAX_SHOWN_LENGTH])
    text = repr(value)
    return text if len(text) <= MAX_SHOWN_LENGTH else f"{text[:MAX_SHOWN_LENGTH]}…"


def told_apart(first: float, second: float, form: str) -> tuple[str, str]:
    """Two numbers as a message shows them in a form like ".1f", with more digits where they would look the same."""
    digits, kind = int(form[1:-1]), form[-1]
    while True:
        texts = f"{first:.{digits}{kind}}", f"{second:.{digits}{kind}}"
        if texts[0] != texts[1] or first == second or digits >= MAX_DIGITS:
            return texts
        digits += 1


def check_known(option: str, name: str, known: Iterable[str], where: str = "the experiment's benchmark") -> None:
    """Raise SelectionError if what an option names is not there."""
    if name not in (names := list(known)):
        raise SelectionError(f"--{option} {name}: not in {where}; available: {listed(names)}.")


def listed(items: Iterable[object]) -> str:
    """Items with commas between them; of many the first."""
    texts = [str(item) for item in items]
    shown = [text if len(text) <= MAX_SHOWN_LENGTH else f"{text[:MAX_SHOWN_LENGTH]}…" for text in texts[:MAX_LISTED]]
    return ", ".join(shown) + (f", … ({len(texts)} in all)" if len(texts) > MAX_LISTED else "")
