"""Sentences of the node as facts, from which each language can word them.

This is the catalogue of their English; `web/static/strings` has it in the languages of the page.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

OVERRUN, SLOT_OCCUPIED = 'overrun', 'slot_occupied'
"""Reasons of holds that say it all: also the kinds of their sentences."""

SENTENCES: Mapping[str, str] = {
    'said': '{words}',
    'several_servers': '{count} servers of {action}: {servers}; stop all but one',
    'foreign_goal': 'it runs goal {goals}, which no task here waits for',
    'foreign_goals': 'it runs goals {goals}, which no task here waits for',
    'placed': 'was {item} placed in section {section}? mark_done if it was, else {answers}',
    'taken_out': 'was {item} taken out of section {section}? mark_done if it was, else {answers}',
    'wanted': 'later tasks use its results: {fields}; mark_done may give them',
    OVERRUN: 'the belt would carry {item} out of section {section}',
    SLOT_OCCUPIED: '{there} stands where {item} would be placed',
    'hold': 'hold {hold}',
}
"""By kind. `said`: words of a device or a person, or others that are known in words only."""

OR = ' | '
"""Between possible answers."""


@dataclass(frozen=True)
class Words:
    """The facts of one sentence."""

    kind: str
    """Which sentence it is."""
    values: Mapping[str, str] = field(default_factory=dict)
    """What it names."""

    def text(self, sentences: Mapping[str, str] = SENTENCES, or_: str = 'or') -> str:
        """Return the sentence in a language.

        :param sentences: its catalogue
        :param or_: its word between alternatives
        """
        answers = self.values.get('answers', '').replace(OR, f' {or_} ')
        return sentences[self.kind].format(**{**self.values, 'answers': answers})
