"""The page for operators: one file, no request but to its own program, and no script but its own."""

import base64
import hashlib
import re
from pathlib import Path

from fatigue_planner.live.face.guard import HEADERS

PAGE = (Path(__file__).parent / "page.html").read_text(encoding="utf-8")


def _digests(element: str) -> str:
    """What a content security policy says of the page's own scripts or styles."""
    contents = re.findall(rf"<{element}>(.*?)</{element}>", PAGE, re.DOTALL)
    digests = (base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in contents)
    return " ".join(f"'sha256-{digest}'" for digest in digests)


PAGE_HEADERS = {
    **HEADERS,
    "content-security-policy": f"default-src 'none'; script-src {_digests('script')}; style-src {_digests('style')}; "
    "connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
}
