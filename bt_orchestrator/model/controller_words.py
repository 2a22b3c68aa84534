"""The words of a controller about a failed attempt: the texts of its Result."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from bt_orchestrator.model.action_type import MessageType
from bt_orchestrator.model.limits import SAID, cut

MESSAGE = 'message'
"""Field of a Result that is meant for a person, by custom."""


def controller_words(result: Mapping[str, Any]) -> str:
    """Return `message` of a result; if that is empty, every text in it with its name."""
    message = result.get(MESSAGE)
    if isinstance(message, str) and message.strip():
        return cut(message.strip(), SAID)
    return cut('; '.join(f'{name}: {text}' for name, text in _texts(result, '')), SAID)


def words_field(result: MessageType) -> str:
    """Return the field of a Result in which a simulated controller says something; empty: none."""
    texts = [
        name for name, field in result.fields.items() if field.kind == 'str' and not field.is_array
    ]
    return MESSAGE if MESSAGE in texts else next(iter(texts), '')


def _texts(value: object, place: str) -> Iterator[tuple[str, str]]:
    """Yield every text that is not blank, with its place."""
    if isinstance(value, str):
        if value.strip():
            yield place, value.strip()
    elif isinstance(value, Mapping):
        for name, member in value.items():
            yield from _texts(member, f'{place}.{name}' if place else str(name))
    elif isinstance(value, (list, tuple)):
        for number, member in enumerate(value):
            if not isinstance(member, (bool, int, float)):
                yield from _texts(member, f'{place}[{number}]')
