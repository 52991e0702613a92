"""What XML 1.0 (section 2.2) can carry of a text."""

from __future__ import annotations

import re

_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def xml_text(text: str) -> str:
    """The text with the replacement character for each character that cannot stand in XML."""
    return _NOT_XML.sub("\N{REPLACEMENT CHARACTER}", text)
