"""The keys of a condition (semantics 6.5), and of how often it holds (8.4)."""

from __future__ import annotations

from bt_orchestrator.script.keys import Key, Kind, Table

COMPARISONS = ('equals', 'not_equals', 'at_least', 'at_most', 'between', 'one_of')
"""Keys that compare a value: one of them stands beside `value`."""

PARTS = ('all', 'any')
"""Keys that make one condition of several; they stand alone."""

_VALUE = '"${results.inspect.size}"'
_MEMBERS = '["${results.a.item_present}", "${results.b.item_present}"]'

CONDITION = Table(
    'a condition',
    (
        Key('value', Kind.REFERENCE, 'what is compared', _VALUE, rule='6.5'),
        Key('equals', Kind.VALUE, 'the value has to be this; not of floats', '3', rule='6.5'),
        Key(
            'not_equals',
            Kind.VALUE,
            'the value has to be another one; not of floats',
            '0',
            rule='6.5',
        ),
        Key('at_least', Kind.BOUND, 'the value has to be this or more', '4.5', rule='6.5'),
        Key('at_most', Kind.BOUND, 'the value has to be this or less', '5.5', rule='6.5'),
        Key(
            'between',
            Kind.LIST,
            'the value has to be the first, the second, or between them',
            '[4.5, "${params.heaviest}"]',
            members=Kind.BOUND,
            fewest=2,
            most=2,
            rule='6.5',
        ),
        Key(
            'one_of',
            Kind.LIST,
            'the value has to be one of these; not of floats',
            '[red, green]',
            members=Kind.VALUE,
            fewest=1,
            rule='6.5',
        ),
        Key(
            'all',
            Kind.LIST,
            'conditions that all have to hold',
            _MEMBERS,
            members=Kind.CONDITION,
            fewest=1,
            rule='6.5',
        ),
        Key(
            'any',
            Kind.LIST,
            'conditions; at least one has to hold',
            _MEMBERS,
            members=Kind.CONDITION,
            fewest=1,
            rule='6.5',
        ),
    ),
    forms=(*(('value', comparison) for comparison in COMPARISONS), *((part,) for part in PARTS)),
)


def _share(name: str, meaning: str, example: str, kind: Kind = Kind.SHARE, *of: Table) -> Key:
    return Key(name, kind, meaning, example, minimum=0, maximum=1, of=of, rule='8.4')


LIKELY = Table(
    'an expectation',
    (
        _share('runs', 'share of the good items for which its condition lets it run', '0.3'),
        _share('fails', 'share of its attempts that fail, or that its verdict refuses', '0.05'),
    ),
    one_of=('runs', 'fails'),
    short='runs',
)

LIKELY_KEY = _share(
    'likely',
    'for the expected pace alone: how often it runs, with `when` or `unless`; otherwise how '
    'often it fails',
    '0.05',
    Kind.SHARES,
    LIKELY,
)
