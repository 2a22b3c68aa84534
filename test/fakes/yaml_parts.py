"""A script of which an example shows only a part."""

from __future__ import annotations

import re


def laid_over(script: str, part: str) -> str:
    """Return a script with the keys of a part, and the sections of a part, in place of its own."""
    keys = {**_entries(script, ''), **_entries(part, '')}
    if 'sections' in _entries(part, ''):
        both = (_entries(text, '')['sections'] for text in (script, part))
        sections = {number: text for each in both for number, text in _entries(each, '  ').items()}
        keys['sections'] = 'sections:\n' + ''.join(sections.values())
    return ''.join(keys.values())


def _entries(text: str, indent: str) -> dict[str, str]:
    """Return the lines of each key that stands at an indent."""
    matches = re.finditer(rf'^{indent}(\w+):.*\n(?:(?!{indent}\w).*\n)*', text, re.MULTILINE)
    return {entry[1]: entry[0] for entry in matches}
