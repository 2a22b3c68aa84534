"""From text to nodes: places, limits, and what YAML forbids."""

from __future__ import annotations

import pytest
import yaml
from fakes.mistake_tables import table
from fakes.script_texts import mistakes

from bt_orchestrator.script import composing
from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.report import Place, Report
from bt_orchestrator.script.yaml_nodes import ListNode, MapNode, Node, as_data


def composed(text: str) -> Node:
    report = Report('file.yaml')
    node = compose(text, report)
    report.refuse()
    assert node is not None
    return node


@pytest.mark.parametrize(('text', 'expected'), table('yaml'))
def test_what_is_not_allowed(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: composed(text)) == expected


@pytest.mark.parametrize(('text', 'expected'), table('yaml'))
def test_findings_do_not_depend_on_pyyaml_build(
    text: str, expected: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(composing, '_fast_loader', lambda: yaml.SafeLoader)
    assert mistakes(lambda: composed(text)) == expected


@pytest.mark.parametrize(
    ('text', 'data'),
    [
        ('a: 1', {'a': 1}),
        ('\ufeffa: 1', {'a': 1}),
        ('1: a\n2.50: b\nnull: c', {'1': 'a', '2.50': 'b', 'null': 'c'}),
        ('a: [x, {b: 1.5}]', {'a': ['x', {'b': 1.5}]}),
        ('a: "1"\nb: !!str 2\nc: ! 3\nd: !!int 4', {'a': '1', 'b': '2', 'c': '3', 'd': 4}),
        ('a: !!binary aGk=\nb: 2024-01-01', {'a': 'aGk=', 'b': '2024-01-01'}),
        ('!!map {a: !!seq [1]}', {'a': [1]}),
        ('a: &x [1]\nb: *x', {'a': [1], 'b': [1]}),
        ('a: &x {c: 1, d: 2}\nb: {<<: *x, c: 3}', {'a': {'c': 1, 'd': 2}, 'b': {'c': 3, 'd': 2}}),
        ('a: {<<: [{b: 1}, {b: 2, c: 3}]}', {'a': {'b': 1, 'c': 3}}),
        ('a: {"<<": 1}', {'a': {'<<': 1}}),
        ('a: |\n  two\n  lines\n', {'a': 'two\nlines\n'}),
        ('a: 1\n...\n', {'a': 1}),
        ('- - a', [['a']]),
    ],
)
def test_what_a_text_says(text: str, data: object) -> None:
    assert as_data(composed(text)) == data


def test_places_count_from_one() -> None:
    root = composed('# comment\nä: {b: [x, y]}\n')
    assert isinstance(root, MapNode)
    inner = root.entries[0].value
    assert isinstance(inner, MapNode)
    items = inner.entries[0].value
    assert isinstance(items, ListNode)
    assert [root.place, root.entries[0].key.place, inner.place] == [
        Place(2, 1),
        Place(2, 1),
        Place(2, 4),
    ]
    assert [item.place for item in items.items] == [Place(2, 9), Place(2, 12)]


def test_first_of_two_values_is_kept_as_doubtful() -> None:
    report = Report('file.yaml')
    node = compose('a: 1\na: 2\nb: 3', report)
    assert isinstance(node, MapNode)
    assert as_data(node) == {'a': 1, 'b': 3}
    assert node.doubtful == {'a'}
    assert len(report.findings) == 1


@pytest.mark.parametrize(
    ('text', 'line', 'what'),
    [
        ('a\n: \x07b', 2, 'U+0007 is not allowed'),
        ('a: b\x00', 1, 'U+0000 is not allowed'),
        ('a: \ud800', 1, 'U+D800 is not allowed'),
        ('[' * 100_000, 1, 'nested deeper than 40'),
        ('{a: ' * 100_000, 1, 'nested deeper than 40'),
        ('- ' * 100_000, 1, 'nested deeper than 40'),
        ('[' + '1,' * 200_001 + ']', 1, 'more than 200000 keys and values'),
    ],
    ids=['bell', 'nul', 'surrogate', 'brackets', 'braces', 'dashes', 'many'],
)
def test_hostile_texts(text: str, line: int, what: str) -> None:
    (finding,) = mistakes(lambda: composed(text))
    assert finding.startswith(f'{line}:')
    assert what in finding


@pytest.mark.parametrize('loader', [yaml.SafeLoader, composing._fast_loader()])
def test_half_a_character_is_refused(
    loader: type[object], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(composing, '_fast_loader', lambda: loader)
    assert len(mistakes(lambda: composed(r'a: "\ud800"'))) == 1


def bomb(template: str) -> str:
    """Return a text in which each of 20 lines repeats the line above it nine times."""
    names = [f'n{number}' for number in range(20)]
    lines = [f'{names[0]}: &{names[0]} {{key: 1}}']
    for name, above in zip(names[1:], names, strict=False):
        lines.append(f'{name}: &{name} ' + template.format(', '.join([f'*{above}'] * 9)))
    return '\n'.join(lines)


@pytest.mark.parametrize('template', ['[{}]', '{{<<: [{}]}}'])
def test_aliases_do_not_explode(template: str) -> None:
    (finding,) = mistakes(lambda: composed(bomb(template)))
    assert 'more than 200000 keys and values, aliases counted' in finding


def test_aliases_do_not_nest_deeper_than_text() -> None:
    chain = 'a0: &a0 [x]\n' + ''.join(f'a{n}: &a{n} [*a{n - 1}]\n' for n in range(1, 1000))
    (finding,) = mistakes(lambda: composed(chain))
    assert 'nested deeper than 40' in finding
