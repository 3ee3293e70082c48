"""Run the slow tests; one that fails is run once more, alone, as a busy machine can disturb it.

Only a second failure fails the run. A first one is a fault all the same and is shown last, to be mended or explained.
Arguments are handed to pytest.
"""

import subprocess
import sys

import pytest

# More failures than these are not chance.
MAX_REPEATED = 5


class Failures:
    """A plugin of pytest: what the tests that failed said, by their names."""

    def __init__(self) -> None:
        self.said: dict[str, str] = {}

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.said[report.nodeid] = f"{self.said.get(report.nodeid, '')}{report.longreprtext}\n"


def main(arguments: list[str]) -> int:
    """The exit code: 0, or 1 if a test failed twice, or pytest's own where it could not run them."""
    first = Failures()
    code = int(pytest.main(["-m", "slow", "--durations", "20", *arguments], plugins=[first]))
    if not first.said or code != pytest.ExitCode.TESTS_FAILED or len(first.said) > MAX_REPEATED:
        return code
    failed_again = []
    for test in first.said:
        print(f"\nonce more, alone: {test}", flush=True)
        command = [sys.executable, "-m", "pytest", "-m", "", *arguments, "--numprocesses", "0", test]
        if subprocess.run(command, check=False).returncode:
            failed_again.append(test)
    for test, said in first.said.items():
        print(f"\n{said}\nFAULT: {test} failed {'twice' if test in failed_again else 'at first, and passed alone'}")
    print(f"slow tests: {len(first.said)} failed at first, {len(failed_again)} of them again", flush=True)
    return int(bool(failed_again))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
