"""Do the tests pass with the lowest and the newest versions that pyproject.toml allows, on every Python promised?

    python tests/versions.py [--python python3.12 ...] [--only lowest|newest] [-- PYTEST OPTIONS]

Each combination gets an environment of its own in a temporary folder; it needs the package index. The Pythons are those
of the classifiers in pyproject.toml, as commands on the path; one that is not there counts as failed. The lowest
versions are tried on the oldest Python only: newer Pythons have no wheels of them.
"""

import argparse
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PYTHONS = re.findall(r"Python :: (3\.\d+)$", "\n".join(PROJECT["classifiers"]), flags=re.M)


def lowest(requirements: list[str]) -> list[str]:
    """Every requirement `name>=version` as `name==version`; others as they are."""
    return [re.sub(r"^([\w.-]+)>=([\w.]+)$", r"\1==\2", requirement) for requirement in requirements]


def run(python: str, versions: str, options: list[str]) -> bool:
    """Whether the tests pass in a fresh environment; what fails is printed."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            subprocess.run([python, "-m", "venv", folder], check=True)
        except (OSError, subprocess.CalledProcessError) as error:
            print(f"{python}: no environment can be made with it ({error}).")
            return False
        inside = Path(folder) / "bin" / "python"
        pins = []
        if versions == "lowest":
            extras = PROJECT["optional-dependencies"]
            named = [one for name in ("dask", "docs", "gymnasium", "live", "recordings") for one in extras[name]]
            pins = lowest([*PROJECT["dependencies"], *named])
        install = [inside, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        commands = [[*install, "--editable", f"{ROOT}[dev]", *pins], [inside, "-m", "pytest", "-q", *options]]
        for command in commands:
            done = subprocess.run(list(map(str, command)), cwd=ROOT, capture_output=True, text=True, check=False)
            if done.returncode:
                print(done.stdout[-6000:], done.stderr[-3000:], sep="\n")
                return False
        print(done.stdout.strip().splitlines()[-1])
    return True


def main() -> int:
    """Run all combinations and print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", action="append", help="a Python to try (repeatable)")
    parser.add_argument("--only", choices=["lowest", "newest"])
    parser.add_argument("options", nargs="*", help="options of pytest")
    arguments = parser.parse_args()
    pythons = arguments.python or [f"python{number}" for number in PYTHONS]
    cases = [(pythons[0], "lowest"), *((python, "newest") for python in pythons)]
    failed = 0
    for python, versions in cases:
        if arguments.only in (None, versions):
            passed = run(python, versions, arguments.options)
            print(f"{python}, {versions} versions: {'passed' if passed else 'FAILED'}", flush=True)
            failed += not passed
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
