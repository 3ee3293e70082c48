"""Code that the documentation shows."""

from conftest import ROOT


def block(page: str, heading: str, language: str) -> str:
    """The first block of code under a heading of a page of the docs."""
    text = (ROOT / "docs" / page).read_text()
    return text[text.index(heading) :].split(f"```{language}\n")[1].split("```")[0]
