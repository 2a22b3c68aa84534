"""How the keys of the users' files are described: one table a kind of mapping.

The tables are data: the reader takes ranges, defaults and suggestions from them, and whatever
documents the formats is generated from them. Start at `cell_keys.CELL`, `script_keys.SCRIPT` and
`script_keys.ORDER`; a key's `of` leads on.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import Any

from bt_orchestrator.script.ros_names import ACTION_TYPE_FORM, NAME_FORM

LARGEST_WHOLE = 2**31 - 1
"""Counts travel as 32 bit numbers in messages."""

LONGEST_SECONDS = 1e9
"""About 30 years; beyond it a clock may overflow."""


class Kind(Enum):
    """The kinds of values."""

    TEXT = 'text'
    """The text as written, whatever YAML would make of it."""
    WHOLE = 'a whole number'
    SECONDS = 'a number of seconds'
    TIMEOUT = 'a number of seconds or none'
    SHARE = 'a number from 0 to 1'
    SHARES = 'a number from 0 to 1, or a mapping'
    """A mapping of a few of them, or one whose meaning follows from the other keys."""
    SWITCH = 'true or false'
    CHOICE = 'one of a few words'
    SECTIONS = 'a section number or a list of them'
    NAMES = 'a name or a list of names'
    VALUE = 'a value'
    """One plain value, of a type that something else declares."""
    INSTANT = 'a date and time with its time zone'
    """A text; the zone must be written."""
    REFERENCE = 'a reference'
    BOUND = 'a number or a parameter'
    CONDITION = 'a reference or a condition'
    TABLE = 'a mapping'
    MAPPING = 'a mapping of names'
    LIST = 'a list'
    JSON = 'anything'
    """As a member: whatever JSON can say."""

    @property
    def in_words(self) -> str:
        """How messages name it."""
        return 'a mapping' if self is Kind.MAPPING else self.value


@dataclass(frozen=True)
class Key:
    """One key."""

    name: str
    kind: Kind
    meaning: str
    example: str
    """A value as a user would write it."""
    required: bool = False
    default: Any = None
    """The value when the key is absent; None: see the meaning."""
    minimum: float | None = None
    maximum: float | None = None
    choices: tuple[str, ...] = ()
    of: tuple[Table, ...] = ()
    """Tables of the members (LIST, MAPPING), or of the mapping itself (TABLE, CONDITION)."""
    members: Kind | None = None
    """The type of members without a table; None: any value of a message field."""
    fewest: int = 0
    """Members that a list or mapping has at least."""
    most: int | None = None
    """Members that a list has at most."""
    is_nested: bool = False
    """Whether a member of the list may be a list of such members."""
    form: str = ''
    """Pattern of a text, as far as an editor can know what the reader takes."""
    name_form: str = ''
    """Pattern of the names in a MAPPING."""
    sets: str = ''
    """Field of the task that it sets, if nothing more than its kind has to be known."""
    rule: str = ''
    """Rule or chapter of docs/semantics.md that says what it does."""

    @property
    def hint(self) -> str:
        """How to write it."""
        none = ', or `none` for no limit' if self.kind is Kind.TIMEOUT else ''
        return f'write for instance `{self.name}: {self.example}`{none}'


@dataclass(frozen=True)
class Table:
    """All keys of one kind of mapping."""

    name: str
    """As messages put it: a component."""
    keys: tuple[Key, ...]
    misplaced: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    """Keys that belong elsewhere: why they are wrong here, and what to do."""
    rivals: tuple[tuple[str, str], ...] = ()
    """Pairs of keys that say the same thing; one of each pair may be given."""
    one_of: tuple[str, ...] = ()
    """Keys that cannot all be absent; empty: there is no such demand."""
    forms: tuple[tuple[str, ...], ...] = ()
    """Sets of keys: exactly one of them is given, whole, and no other key; none: any set is."""
    short: str = ''
    """A key whose value may stand in place of the whole mapping."""

    @cached_property
    def by_name(self) -> Mapping[str, Key]:
        """Keys by name."""
        return {key.name: key for key in self.keys}

    @property
    def hint(self) -> str:
        """How to write such a mapping: with the keys that it needs, else with those there are."""
        if self.one_of:
            any_of = ' or '.join(f'`{name}`' for name in self.one_of)
            return f'write a mapping with the key {any_of}'
        needed = [key.name for key in self.keys if key.required]
        names = [f'`{name}`' for name in needed or list(self.by_name)[:3]]
        return f'write a mapping with the key{"s" if len(names) > 1 else ""} {", ".join(names)}'

    def tree(self) -> Iterator[Table]:
        """Yield this table and all that its keys lead to, each as often as it is met."""
        yield self
        for key in self.keys:
            for table in key.of:
                yield from table.tree()


def words(enum: type[Enum], *leave_out: Enum) -> tuple[str, ...]:
    """Return an enum's words, as choices of a key."""
    return tuple(str(member.value) for member in enum if member not in leave_out)


def whole(
    name: str, meaning: str, example: str, minimum: int, default: int | None = None, rule: str = ''
) -> Key:
    """Return the key of a count."""
    return Key(
        name,
        Kind.WHOLE,
        meaning,
        example,
        default=default,
        minimum=minimum,
        maximum=LARGEST_WHOLE,
        rule=rule,
    )


def action() -> Key:
    """Return the key of an action name."""
    return Key(
        'action',
        Kind.TEXT,
        'ROS 2 action name',
        '/unpacking/unpacking_action',
        required=True,
        form=NAME_FORM,
        rule='2.1',
    )


def action_type() -> Key:
    """Return the key of an action type."""
    return Key(
        'type',
        Kind.TEXT,
        'ROS 2 action type',
        'my_interfaces/action/PackingArm',
        required=True,
        form=ACTION_TYPE_FORM,
        rule='2.1',
    )
