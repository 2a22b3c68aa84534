"""Flags, zones and the order of initialization (semantics 4 and 5.1)."""

from __future__ import annotations

import pytest
from fakes.mistake_tables import table
from fakes.mistake_texts import RELATED
from fakes.script_texts import line, mistakes

from bt_orchestrator.model.script import Dependency, InitializationDependency, Zone


@pytest.mark.parametrize(('text', 'expected'), table('dependencies'))
def test_dependencies(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(RELATED + text)) == expected


def test_relations_are_read() -> None:
    read = line(
        RELATED + 'lateral_dependencies:\n'
        '  - {flag: f, upstream: look, downstream: press, capacity: 3, initial: 1}\n'
        '  - {flag: g, upstream: place, downstream: pack}\n'
        'zones: {t: [look, press]}\n'
        'initialization_dependencies: [{upstream: home, downstream: ready}]\n'
    )
    assert read.dependencies == (
        Dependency('f', 'look', 'press', 3, 1),
        Dependency('g', 'place', 'pack', 1, 0),
    )
    assert read.zones == (Zone('t', ('look', 'press')),)
    assert read.initialization_dependencies == (InitializationDependency('home', 'ready'),)


def test_unreadable_id_has_no_consequences() -> None:
    findings = mistakes(
        lambda: line(
            '  2: [{id: [x], task: RUN, action: /camera/task}]\n'
            'lateral_dependencies: [{flag: f, upstream: x, downstream: place}]\n'
            'zones: {t: [x, place]}\n'
        )
    )
    assert findings == ['5:12: `id` must be text, not a list; write for instance `id: inspect`']


def test_without_initialization_there_is_nothing_to_order() -> None:
    text = 'initialization_dependencies: [{upstream: a, downstream: place}]\n'
    assert mistakes(lambda: line(text)) == [
        '5:42: there is no initialization task `a`; give the script one, or remove this',
        (
            '5:57: `place` is not an initialization task; '
            'order tasks of sections by `lateral_dependencies`'
        ),
    ]
