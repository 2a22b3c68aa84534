"""Sentences of the node: facts become words, and are read out of them again."""

from __future__ import annotations

import inspect
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bt_orchestrator.model import words
from bt_orchestrator.model.words import AND, OR, SENTENCES, Words, facts_of, sentence
from bt_orchestrator.model.words.answers import REFUSALS

PLACES = {'answers': f'a{OR}b', 'held': 'hold 1 (mark: aborted)'}
"""Places in which not anything can stand."""


@pytest.mark.parametrize('kind', sorted(SENTENCES.keys() - {'said'}))
def test_facts_are_read_out_of_their_sentence(kind: str) -> None:
    names = set(re.findall(r'\{(\w+)\}', SENTENCES[kind]))
    values = {name: PLACES.get(name, f'/x {name} 1') for name in names}
    words = Words(kind, values)
    assert facts_of(words.text()) == (words,)


@given(st.sampled_from(sorted(SENTENCES.keys() - {'said'})), st.text(min_size=1))
def test_sentence_is_read_back_with_any_content(kind: str, thing: str) -> None:
    names = set(re.findall(r'\{(\w+)\}', SENTENCES[kind]))
    message = Words(kind, {name: PLACES.get(name, thing) for name in names}).text()
    facts = facts_of(message)
    assert AND.join(fact.text() for fact in facts) in ('', message)


def test_refusal_kinds_differ_from_other_sentences() -> None:
    source = inspect.getsource(words)
    keys = re.findall(r"(?m)^    '?([A-Za-z_]+)'?: ", source)
    assert not REFUSALS.keys() & {key.lower() for key in keys}


@pytest.mark.parametrize(
    ('name', 'kind'),
    [
        ('hold 1 (mark: aborted)', 'hold_of'),
        ('hold 3 (paused, Ann: a; b (c))', 'hold_why'),
        ('hold 3 (paused)', 'hold_bare'),
    ],
)
def test_hold_name_is_recognised_in_sentence(name: str, kind: str) -> None:
    (fact,) = facts_of(f'{name} is open')
    assert fact == Words('hold_open', {'held': name})
    assert [inner.kind for inner in facts_of(name)] == [kind]
    assert facts_of('the door is open') == ()


def test_consecutive_pauses_are_read_separately() -> None:
    facts = facts_of('no pause is yours; hold 3 (paused, Ann: x); hold 4 (paused, Bob: y; z)')
    assert [fact.kind for fact in facts] == ['no_pause_yours', 'hold_why', 'hold_why']
    assert facts[-1].values['message'] == 'Bob: y; z'


def test_repeated_placeholder_must_have_same_value() -> None:
    template = 'hold 1 (a: b) takes no answer; take {} off the belt and say so with remove-item {}'
    assert facts_of(template.format('J/1', 'J/1'))[0].kind == 'takes_removal'
    assert facts_of(template.format('J/1', 'J/2'))[0].kind == 'takes_none'


def test_message_of_several_sentences_has_all_facts() -> None:
    lost = sentence('after_restart', words=sentence('not_known'))
    question = Words('taken_out', {'item': 'J/1', 'section': '2', 'answers': f'skip{OR}reject'})
    message = f'{lost}; no vacuum; {question.text()}'
    assert [part.kind for part in facts_of(message)] == [
        'after_restart',
    ]
    german = {'not_known': 'unbekannt', 'after_restart': 'danach: {words}', 'said': '{words}'}
    german['taken_out'] = '{item} aus {section}? {answers}'
    (fact,) = facts_of(message)
    expected = 'danach: unbekannt; no vacuum; J/1 aus 2? skip oder reject'
    assert fact.text(german, 'oder') == expected


@pytest.mark.parametrize(
    'message',
    [
        '',
        'no vacuum',
        'a; b; c',
        'waits for',
        ' waits for ',
        '; '.join('x' * 200),
        f'there is no request {"x" * 10_000}; one of job.move',
    ],
)
def test_foreign_text_is_no_node_sentence(message: str) -> None:
    assert facts_of(message) == ()
