"""The syntax of references."""

from __future__ import annotations

import pytest

from bt_orchestrator.model.reference import Reference, Template
from bt_orchestrator.script.references import (
    Path,
    ReferenceFault,
    fixed_reference,
    has_reference,
    is_single,
    path,
    split,
)
from bt_orchestrator.script.report import START
from bt_orchestrator.script.yaml_nodes import Scalar


@pytest.mark.parametrize(
    ('text', 'parts'),
    [
        ('', []),
        ('plain', ['plain']),
        ('$ { } $x {x}', ['$ { } $x {x}']),
        ('${order.id}', [Path('order', 'id')]),
        ('a ${order.id} b', ['a ', Path('order', 'id'), ' b']),
        ('${params.a}${item.id}', [Path('params', 'a'), Path('item', 'id')]),
        ('${results.4.1.x}}', [Path('results', '4.1.x'), '}']),
    ],
)
def test_a_string_is_split_into_text_and_references(text: str, parts: list[str | Path]) -> None:
    assert list(split(text)) == parts


@pytest.mark.parametrize('text', ['${', '${a', 'x ${order.id} ${', '${}', '${order.}', '${.id}'])
def test_a_broken_reference_is_a_fault(text: str) -> None:
    assert isinstance(list(split(text))[-1], ReferenceFault)


def test_text_after_broken_reference_is_read_too() -> None:
    before, fault, between, behind = split('a ${x} b ${order.id}')
    assert (before, between, behind) == ('a ', ' b ', Path('order', 'id'))
    assert isinstance(fault, ReferenceFault)


def test_a_path_prints_as_it_was_written() -> None:
    assert str(path('results.4.1.x')) == '${results.4.1.x}'


@pytest.mark.parametrize(
    ('written', 'kind'),
    [
        (Path('order', 'id'), 'str'),
        (Path('order', 'quantity'), 'int'),
        (Path('item', 'number'), 'int'),
        (Path('item', 'id'), 'str'),
    ],
)
def test_order_and_item_have_fixed_values(written: Path, kind: str) -> None:
    reference, type_ = fixed_reference(written)
    assert (str(reference), type_.kind) == (f'{written.source}.{written.rest}', kind)


def test_an_order_has_no_other_values() -> None:
    with pytest.raises(ReferenceFault, match='does not exist'):
        fixed_reference(Path('order', 'ids'))


def test_only_text_contains_references() -> None:
    assert has_reference(Scalar(START, '${a.b}', is_text=False))
    assert not has_reference(Scalar(START, '12', is_text=False))


def test_a_single_reference_keeps_its_type() -> None:
    assert is_single(Template((Reference('order', 'id'),)))
    assert not is_single(Template(('a', Reference('order', 'id'))))
