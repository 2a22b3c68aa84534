"""Texts that people give for the record: others must read what stands there, and all of it."""

from __future__ import annotations

import unicodedata

from bt_orchestrator.model.words import sentence

_WANTED = '\t\n\r\N{ZERO WIDTH NON-JOINER}\N{ZERO WIDTH JOINER}'
"""Breaks of lines, and what some scripts and pictures are written with."""

_UNSEEN = ('Cc', 'Cf', 'Cs', 'Zl', 'Zp')
"""Unicode categories: controls, also of the direction of text; half characters; separators."""


def text_fault(text: str) -> str | None:
    """Say which character a text must not have; None: it has none.

    Characters that turn the direction of text, U+202E first of all, let a reader see other words
    than there are.
    """
    char = next(filter(_is_unseen, text), None) if not text.isprintable() else None
    if char is None:
        return None
    name = unicodedata.name(char, 'a control character')
    return sentence('unseen', char=f'U+{ord(char):04X}', name=name)


def readable(text: str) -> str:
    """Return a text with a mark in place of each character that it must not have."""
    if text.isprintable():
        return text
    return ''.join('\N{REPLACEMENT CHARACTER}' if _is_unseen(char) else char for char in text)


def _is_unseen(char: str) -> bool:
    return char not in _WANTED and unicodedata.category(char) in _UNSEEN


# Foreign text, such as the words of a controller, for one line of a terminal or a report.


def one_line(text: str) -> str:
    """Return a text without line ends, and without characters that a terminal obeys."""
    return ''.join(c if c.isprintable() else '\ufffd' for c in ' '.join(text.split()))
