"""Each answer is made of sentences that every language of the page has."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.model.words import AND, Words, facts_of

OWN_WORDS = (
    'refused_because',
    'no_goal',
    'not_released',
    'unavailable',
    'answers_are_also',
    'answers_of_others',
    'no_such_reason',
    'no_such_task',
    'no_rest_id',
    'not_recorded',
    'still_paused',
)
"""Kinds whose words are sentences themselves; those of others may be of a person or a device."""


def check_answer(message: str) -> None:
    """Check that all of an answer can be read, line by line."""
    for line in message.splitlines():
        facts = facts_of(line)
        assert facts, f'no sentence of the catalogue: {line}'
        assert AND.join(fact.text() for fact in facts) == line
        assert list(unread(facts)) == [], f'partly no sentence of the catalogue: {line}'


def unread(facts: tuple[Words, ...]) -> Iterator[str]:
    """Yield what is no sentence where one belongs."""
    for fact in facts:
        if fact.kind == 'said':
            yield fact.values['words']
        for name, value in fact.values.items():
            if name == 'held' or (name == 'words' and fact.kind in OWN_WORDS):
                inner = facts_of(value)
                yield from unread(inner) if inner else [value]
