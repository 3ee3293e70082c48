"""Builds the package: what pyproject.toml cannot say.

The experiments at the top of the repository go into the wheel as `fatigue_planner/shipped`, so there is no second copy.

An index has no files beside the README, so relative pictures are left out and relative links become text. With the
address of the published repository's files in FATPLAN_FILES_URL (https://…/), both are kept and lead there.
"""

import os
import re
from pathlib import Path

from setuptools import find_packages, setup

SHIPPED = "fatigue_planner.shipped"


def long_description(readme: str, url: str) -> str:
    """The README as an index can show it."""
    readme = re.sub(r"^<!--.*-->\n", "", readme, flags=re.M)
    if url:
        return re.sub(r"\]\((?!https?:|#)", f"]({url.rstrip('/')}/", readme)
    without_pictures = re.sub(r"^!\[[^\]]*\]\((?!https?:)[^)]*\)\n\n", "", readme, flags=re.M)
    return re.sub(r"\[([^\]]*)\]\((?!https?:|#)[^)]*\)", r"\1", without_pictures)


setup(
    packages=[*find_packages(include=["fatigue_planner*"]), SHIPPED],
    package_dir={SHIPPED: "experiments"},
    long_description=long_description(
        (Path(__file__).parent / "README.md").read_text(encoding="utf-8"), os.environ.get("FATPLAN_FILES_URL", "")
    ),
    long_description_content_type="text/markdown",
)
