"""The cursor over one mapping."""

from __future__ import annotations

import pytest

from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.keys import Key, Kind, Table
from bt_orchestrator.script.report import Place, Report
from bt_orchestrator.script.yaml_nodes import MapNode, Scalar

MEMBER = Table('a member', (Key('name', Kind.TEXT, 'its name', 'a', required=True),))
TABLE = Table(
    'a thing',
    (
        Key('name', Kind.TEXT, 'its name', 'a', required=True),
        Key('count', Kind.WHOLE, 'how many', '2', default=7, minimum=1, maximum=9),
        Key('delay', Kind.SECONDS, 'how long', '2.0', default=1.5, minimum=0, maximum=9),
        Key('limit', Kind.TIMEOUT, 'how long at most', '2.0', minimum=0, maximum=9),
        Key('ready', Kind.SWITCH, 'is it', 'true', default=True),
        Key('mode', Kind.CHOICE, 'how', 'slow', default='fast', choices=('fast', 'slow')),
        Key('members', Kind.LIST, 'parts', '[{name: a}]', of=(MEMBER,)),
        Key('inner', Kind.TABLE, 'one part', '{name: a}', of=(MEMBER,)),
    ),
    misplaced={'colour': ('things have no colour', 'remove it')},
)


def fields(text: str) -> tuple[Fields, Report]:
    report = Report('f')
    node = compose(text, report)
    assert isinstance(node, MapNode)
    return Fields(node, TABLE, report), report


def told(report: Report) -> list[str]:
    return [str(finding).removeprefix('f:') for finding in report.findings]


def test_absent_keys_have_their_defaults() -> None:
    read, report = fields('name: x')
    assert (read.whole('count'), read.seconds('delay'), read.switch('ready')) == (7, 1.5, True)
    assert (read.choice('mode'), read.timeout('limit', 3.0)) == ('fast', 3.0)
    assert (read.items('members'), read.mapping('inner'), read.table('inner')) == ((), None, None)
    assert list(read.tables('members')) == []
    assert read.is_sure('count', 'delay', 'members')
    assert told(report) == []


def test_long_name_list_is_checked_without_pairwise_comparison(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """An order of 100 kB with 50,000 recipes took minutes."""
    read, report = fields(f'name: x\nmembers: [{", ".join(["a"] * 500)}, [b], "", c]')
    compared = []

    def equals(first: Scalar, other: object) -> bool:
        compared.append(other)
        return first is other

    monkeypatch.setattr(Scalar, '__eq__', equals)
    assert [name.text for name in read.names('members')] == [*'a' * 500, 'c']
    assert len(compared) < 500
    assert len(told(report)) == 2


def test_values_are_read() -> None:
    read, report = fields(
        'name: x\ncount: 3\ndelay: 2\nlimit: none\nready: false\nmode: slow\n'
        'members: [{name: y}, {name: z}]\ninner: {name: w}'
    )
    inner = read.table('inner')
    assert inner is not None
    assert (read.whole('count'), read.seconds('delay'), read.switch('ready')) == (3, 2.0, False)
    assert (read.choice('mode'), read.timeout('limit', 3.0)) == ('slow', None)
    assert [member.text('name') for member in read.tables('members')] == ['y', 'z']
    assert inner.text('name') == 'w'
    assert told(report) == []


def test_unreadable_value_is_unsure_and_gets_default() -> None:
    read, report = fields('name: [x]\ncount: 0\nlimit: 0\nmode: medium\nmembers: [3]')
    assert (read.text('name'), read.whole('count'), read.choice('mode')) == (None, 7, 'fast')
    assert read.timeout('limit', 3.0) == 3.0
    assert list(read.tables('members')) == []
    for key in ('name', 'count', 'limit', 'mode', 'members'):
        assert not read.is_sure(key)
    assert [finding.split(':')[0] for finding in told(report)] == ['1', '2', '3', '4', '5']


def test_places_are_those_of_key_and_value() -> None:
    read, _ = fields('name: x\ncount:  3')
    assert (read.key_place('count'), read.place('count')) == (Place(2, 1), Place(2, 9))
    assert (read.key_place('mode'), read.place('mode')) == (Place(1, 1), Place(1, 1))


def test_a_missing_key_is_told_at_the_mapping() -> None:
    read, report = fields('count: 3')
    assert told(report) == ['1:1: a thing needs the key `name`; write for instance `name: a`']
    assert not read.is_sure('name')


def test_misspelt_key_is_read_as_known_key() -> None:
    read, report = fields('nam: x\ncuont: 3')
    assert (read.text('name'), read.whole('count')) == ('x', 3)
    assert told(report) == [
        '1:1: a thing has no key `nam`; did you mean `name`?',
        '2:1: a thing has no key `cuont`; did you mean `count`?',
    ]


def test_a_misspelt_key_yields_to_the_right_one() -> None:
    read, report = fields('nam: x\nname: y')
    assert read.text('name') == 'y'
    assert len(told(report)) == 1


def test_misspelt_key_of_another_kind_is_ignored() -> None:
    read, report = fields('nam: [x]\niner: 3')
    assert (read.text('name'), read.table('inner')) == (None, None)
    assert not read.is_sure('name')
    assert len(told(report)) == 2


def test_a_misplaced_key_says_why() -> None:
    _, report = fields('name: x\ncolour: red')
    assert told(report) == ['2:1: things have no colour; remove it']


def test_key_given_twice_is_not_sure() -> None:
    read, report = fields('name: x\ncount: 1\ncount: 2\nnaem: z')
    assert read.whole('count') == 1
    assert not read.is_sure('count')
    assert read.is_sure('delay', 'name')
    assert len(told(report)) == 2


def test_misspelt_key_given_twice_is_not_sure() -> None:
    read, _ = fields('name: x\ncuont: 1\ncuont: 2')
    assert not read.is_sure('count')
