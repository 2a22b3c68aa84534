"""Sentences of the node: facts become words, and are read out of them again."""

from __future__ import annotations

import re

import pytest

from bt_orchestrator.model.words import OR, SENTENCES, Words, facts_of, sentence


@pytest.mark.parametrize('kind', sorted(SENTENCES.keys() - {'said'}))
def test_facts_are_read_out_of_their_sentence(kind: str) -> None:
    names = set(re.findall(r'\{(\w+)\}', SENTENCES[kind]))
    values = {name: f'a{OR}b' if name == 'answers' else f'/x {name} 1' for name in names}
    words = Words(kind, values)
    assert facts_of(words.text()) == (words,)


def test_a_message_of_several_sentences_has_the_facts_of_each() -> None:
    lost = sentence('after_restart', words=sentence('not_known'))
    question = Words('taken_out', {'item': 'J/1', 'section': '2', 'answers': f'skip{OR}reject'})
    message = f'{lost}; no vacuum; {question.text()}'
    assert [one.kind for one in facts_of(message)] == [
        'after_restart',
    ]
    german = {'not_known': 'unbekannt', 'after_restart': 'danach: {words}', 'said': '{words}'}
    german['taken_out'] = '{item} aus {section}? {answers}'
    (found,) = facts_of(message)
    expected = 'danach: unbekannt; no vacuum; J/1 aus 2? skip oder reject'
    assert found.text(german, 'oder') == expected


@pytest.mark.parametrize(
    'message', ['', 'no vacuum', 'a; b; c', 'waits for', ' waits for ', '; '.join('x' * 200)]
)
def test_words_of_others_are_no_sentences_of_the_node(message: str) -> None:
    assert facts_of(message) == ()
