"""The parts that job orders and job responses are made of (OPC 10031-4, chapter 6.3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

Resource = Mapping[str, object]
"""Personnel, equipment, a physical asset or material: fields by the names of the standard, as
JSON. Nothing but the id of an equipment is read, so they are kept as they came."""


@dataclass(frozen=True)
class Text:
    """A text in a language; without one it is a name."""

    text: str
    locale: str = ''


@dataclass(frozen=True)
class Parameter:
    """A value with a name (ISA95ParameterDataType)."""

    id: str
    value: object = None
    """A boolean, a number, a text or `Text`, or several in a tuple; None: none was given."""
    description: tuple[Text, ...] = ()
    unit: str = ''
    parts: tuple[Parameter, ...] = ()
    """Sub-parameters."""


@dataclass(frozen=True)
class WorkMaster:
    """How a product is made: a script, with its parameters."""

    id: str
    description: str = ''
    parameters: tuple[Parameter, ...] = ()


def text_to_plain(text: Text) -> object:
    """Return a text as JSON: one without a language is a plain text."""
    return {'Text': text.text, 'Locale': text.locale} if text.locale else text.text


def text_from_plain(plain: object) -> Text:
    """Return the text of a JSON value; any other text is shown unchanged."""
    if isinstance(plain, Mapping):
        return Text(str(plain.get('Text', '')), str(plain.get('Locale', '')))
    return Text(str(plain))


def texts_from_plain(plain: object) -> tuple[Text, ...]:
    """Return the texts that JSON tells of: a list of them, one, or none."""
    if plain is None:
        return ()
    several = plain if isinstance(plain, (list, tuple)) else [plain]
    return tuple(text_from_plain(member) for member in several)
