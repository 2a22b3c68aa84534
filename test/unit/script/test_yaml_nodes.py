"""What a scalar means, and how messages name values."""

from __future__ import annotations

import math

import pytest

from bt_orchestrator.script.report import START
from bt_orchestrator.script.yaml_nodes import (
    Entry,
    ListNode,
    MapNode,
    Scalar,
    found,
    found_value,
    plain_value,
    quoted,
)


@pytest.mark.parametrize(
    ('text', 'value'),
    [
        ('', None),
        ('~', None),
        ('null', None),
        ('true', True),
        ('False', False),
        ('1', 1),
        ('-12', -12),
        ('+1', 1),
        ('0x1F', 31),
        ('0o17', 15),
        ('1.5', 1.5),
        ('1.', 1.0),
        ('.5', 0.5),
        ('1e3', 1000.0),
        ('-1.5e-3', -0.0015),
        ('.inf', math.inf),
        ('-.inf', -math.inf),
        ('1e400', math.inf),
    ],
)
def test_plain_values(text: str, value: object) -> None:
    read = plain_value(text)
    assert (read, type(read)) == (value, type(value))


@pytest.mark.parametrize(
    'text',
    [
        'yes',
        'no',
        'on',
        'off',
        '010',
        '0b1',
        '1_000',
        '1:30',
        '2024-01-01',
        '=',
        '1.2.3',
        '1e',
    ],
)
def test_what_yaml_parsers_disagree_about_is_text(text: str) -> None:
    assert plain_value(text) == text


def test_number_too_long_for_python_stays_text() -> None:
    assert plain_value('9' * 400) == 10**400 - 1
    assert plain_value('9' * 5000) == '9' * 5000


def test_not_a_number_is_a_number() -> None:
    assert math.isnan(plain_value('.nan'))  # type: ignore[arg-type]


def test_a_quoted_number_is_text() -> None:
    assert Scalar(START, '1', is_text=True).value == '1'


@pytest.mark.parametrize(
    ('value', 'words'),
    [
        (None, 'nothing'),
        (True, 'true'),
        (3, 'the number 3'),
        (1.5, 'the number 1.5'),
        ('abc', 'the text `abc`'),
        ('', 'empty text'),
        ({}, 'a mapping'),
        ([], 'a list'),
    ],
)
def test_values_in_words(value: object, words: str) -> None:
    assert found_value(value) == words


def test_nodes_in_words() -> None:
    key = Scalar(START, 'a', is_text=False)
    assert found(ListNode(START, ())) == 'a list'
    assert found(MapNode(START, (Entry(key, key),))) == 'a mapping'
    assert found(key) == 'the text `a`'


@pytest.mark.parametrize(
    ('text', 'shown'),
    [
        ('a\nb\x07', r'`a\nb\x07`'),
        ('\ud800', r'`\ud800`'),
        ('x' * 61, '`' + 'x' * 57 + '...`'),
        ('\n' * 61, '`' + r'\n' * 28 + r'\...`'),
        ('x' * 60, '`' + 'x' * 60 + '`'),
        ('größe', '`größe`'),
    ],
)
def test_a_users_text_stays_one_short_line(text: str, shown: str) -> None:
    assert quoted(text) == shown


def test_a_mapping_finds_its_entries() -> None:
    key = Scalar(START, 'a', is_text=False)
    mapping = MapNode(START, (Entry(key, key),), frozenset({'b'}))
    assert mapping.find('a') == Entry(key, key)
    assert mapping.find('b') is None
    assert not mapping.is_complete
