"""A name for a scenario, of a name that somebody else has given."""

from __future__ import annotations

import re
import unicodedata


def plain_name(text: str) -> str:
    """What letters, digits and ``_`` there are in it, a letter first; empty where there is none.

    Accents are taken off; whatever else there is becomes ``_``.
    """
    bare = "".join(c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c))
    return re.sub(r"[^A-Za-z0-9_]", "_", bare).lstrip("_0123456789")
