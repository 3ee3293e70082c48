"""The mistakes a user can make, one type each, under one root; and the exit codes of `fatplan`."""

from enum import IntEnum


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
    """Root of every error that is the input's or the machine's, not the program's."""

    exit_code = ExitCode.BAD_INPUT


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


class BundleError(FatplanError):
    """A file is not a bundle of reactions."""


class OtherVersionError(FatplanError):
    """A reaction was written by a version of fatplan with another file format."""


class OutputFolderError(FatplanError):
    """A file or folder cannot be written."""


class MissingTableError(FatplanError):
    """The table of trials a command reads has not been written."""


class UnknownContrastError(FatplanError):
    """Two policies are not compared by any family of the experiment's statistics."""


class FailedMotionError(FatplanError):
    """A motion could not be simulated, or not accurately enough to be used."""

    exit_code = ExitCode.FAILED_PARTS


class StaleTableError(FatplanError):
    """The table of trials was made with other settings than the experiment has now."""


class LostWorkError(FatplanError):
    """Some work kills the process that does it."""

    exit_code = ExitCode.FAILED_PARTS


class DamagedFileError(FatplanError):
    """A file of the cache or of the results is not what was written."""

    exit_code = ExitCode.DAMAGED_STORE
