"""Text for XML, whatever a device or a person wrote into it."""

from __future__ import annotations

import re


def xml_text(text: str) -> str:
    """Return a text without characters that XML 1.0 cannot carry."""
    return _NOT_XML.sub('\N{REPLACEMENT CHARACTER}', text)


_NOT_XML = re.compile('[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]')
"""Characters outside production 2 of XML 1.0."""
