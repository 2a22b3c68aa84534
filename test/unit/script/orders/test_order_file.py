"""Work orders, and binding them to scripts."""

from __future__ import annotations

from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.mistake_tables import table
from fakes.script_texts import LINE, cell, line, mistakes, script

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.model.jobs.order import Job, WorkOrder
from bt_orchestrator.model.script import Parameter
from bt_orchestrator.script.orders.order_file import (
    OrderPlaces,
    bind_order,
    param_from_text,
    params_from_text,
    parse_order,
    read_order,
)
from bt_orchestrator.script.orders.parameter_uses import action_types
from bt_orchestrator.script.report import Place

ROOT = Path(__file__).parents[4]

SCRIPT = script(
    LINE + 'params: {lot: {type: str}, n: {type: int, default: 3}, '
    'x: {type: float, default: 1}, b: {type: bool, default: false}}\n'
)


@pytest.mark.parametrize(('text', 'expected'), table('orders'))
def test_orders(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: parse_order(text, 'order.yaml')) == expected


@pytest.mark.parametrize(('text', 'expected'), table('bindings'))
def test_bindings(text: str, expected: list[str]) -> None:
    order = parse_order(f'script: test\n{text}', 'order.yaml')
    assert mistakes(lambda: bind_order(order.order, SCRIPT, 'J1', order.places)) == expected


def test_the_shipped_order_is_read() -> None:
    read = read_order(ROOT / 'config' / 'orders' / 'wo_1001.yaml')
    assert read.order == WorkOrder('reference_process', 'WO-1001', 3, {'label': 'A7'})
    assert read.places.place('params', 'label') == Place(5, 17)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match='the file does not exist'):
        read_order(tmp_path / 'a.yaml')


def test_parameters_get_defaults_and_declared_types() -> None:
    job = bind_order(WorkOrder('test', None, 2, {'lot': 'A', 'x': 2}), SCRIPT, 'J1')
    assert job == Job('J1', SCRIPT, 2, {'lot': 'A', 'n': 3, 'x': 2.0, 'b': False})
    assert isinstance(job.params['x'], float)


def test_order_quantity_overrides_script_quantity() -> None:
    with_default = line('quantity: 7\n')
    assert bind_order(WorkOrder('test'), with_default, 'J1').quantity == 7
    assert bind_order(WorkOrder('test', quantity=2), with_default, 'J1').quantity == 2


def test_findings_without_a_file_cite_the_order() -> None:
    order = WorkOrder('test', 'WO/1', 0, {'lot': 3, 'zz': 1})
    with pytest.raises(Refused) as caught:
        bind_order(order, SCRIPT, 'J1')
    assert [str(finding) for finding in caught.value.findings] == [
        (
            'order WO/1, order:1:1: `WO/1` cannot be an order id: a slash separates the order '
            'from the number of the item; write for instance `WO-1`'
        ),
        (
            'order WO/1, params.lot:1:1: the parameter `lot` must be text (str), not the number '
            '3; put it in quotes'
        ),
        (
            'order WO/1, params.zz:1:1: the script `test` has no parameter `zz`; '
            'its parameters are `lot`, `n`, `x`, `b`'
        ),
        (
            'order WO/1, quantity:1:1: `quantity` must be from 1 to 2147483647, not the number 0; '
            'order at least one item'
        ),
    ]


def test_findings_without_an_order_id_cite_the_job() -> None:
    with pytest.raises(Refused, match=r'^order J7, quantity:1:1: the order names no quantity'):
        bind_order(WorkOrder('test', params={'lot': 'A'}), SCRIPT, 'J7')


def test_order_above_item_limit_of_cell_is_refused() -> None:
    order = WorkOrder('test', quantity=13, params={'lot': 'A'})
    expected = (
        r'`quantity` is 13, and an order of this cell has at most 12 items; order less at a time, '
        r'or raise `most_items` in the cell file'
    )
    with pytest.raises(Refused, match=expected):
        bind_order(order, SCRIPT, 'J1', most_items=12)
    assert bind_order(order, SCRIPT, 'J1', most_items=13).quantity == 13


@pytest.mark.parametrize('quantity', [-1, 2**31, True, 1.5, '3'])
def test_quantities_that_a_program_may_send(quantity: int) -> None:
    with pytest.raises(Refused, match='`quantity` must be from 1'):
        bind_order(WorkOrder('test', quantity=quantity, params={'lot': 'A'}), SCRIPT, 'J1')


def test_places_fall_back_to_what_is_around() -> None:
    places = OrderPlaces('o.yaml', {(): Place(1, 1), ('params',): Place(3, 9)})
    assert places.place('params', 'lot') == Place(3, 9)
    assert places.place('quantity') == Place(1, 1)


@pytest.mark.parametrize(
    ('text', 'type_', 'value'),
    [
        ('A7', 'str', 'A7'),
        ('7', 'str', '7'),
        ('"7"', 'str', '7'),
        ("'a b'", 'str', 'a b'),
        ('"', 'str', '"'),
        ('', 'str', ''),
        ('true', 'str', 'true'),
        ('5', 'int', 5),
        (' 5 ', 'int', 5),
        ('5', 'float', 5),
        ('1e3', 'float', 1000.0),
        ('TRUE', 'bool', True),
        ('false', 'bool', False),
        ('5x', 'int', '5x'),
        ('', 'int', ''),
        ('yes', 'bool', 'yes'),
    ],
)
def test_values_that_come_as_text(text: str, type_: str, value: object) -> None:
    read = param_from_text(text, Parameter('p', type_))
    assert (read, type(read)) == (value, type(value))


def test_unknown_parameters_stay_text_and_are_refused() -> None:
    params = params_from_text({'lot': '7', 'n': 'x', 'q': '1'}, SCRIPT)
    assert params == {'lot': '7', 'n': 'x', 'q': '1'}
    with pytest.raises(Refused) as caught:
        bind_order(WorkOrder('test', None, 1, params), SCRIPT, 'J1')
    assert ['`n`' in err.what or '`q`' in err.what for err in caught.value.findings] == [True] * 2


def test_order_values_must_fit_goal_fields() -> None:
    used = line(
        '  2: [{id: look, task: RUN, action: /camera/task, args: {code: "${params.code}",\n'
        '    small: "${order.quantity}", names: [x, "${order.id}"],\n'
        '    pose: {frame: "${params.code}"}, name: "lot ${params.code}"}}]\n'
        'params: {code: {type: str}}\n'
    )
    types = action_types(cell(), FakeActionTypes())
    order = parse_order(
        'script: test\norder: WO-1\nquantity: 300\nparams: {code: long}\n', 'order.yaml'
    )
    assert mistakes(lambda: bind_order(order.order, used, 'WO-1', order.places)) == []
    quantity, code = mistakes(lambda: bind_order(order.order, used, 'WO-1', order.places, types))
    assert quantity == (
        '3:11: `order.quantity` must be a whole number from 0 to 255 (uint8) '
        'for `small` of the task `look`, not the number 300; choose a number in that range'
    )
    assert code == (
        '4:16: `params.code` must be text of at most 3 characters (string<=3) '
        'for `code` of the task `look`, not the text `long`; shorten it'
    )


def test_values_that_fit_are_bound() -> None:
    used = line(
        '  2: [{id: look, task: RUN, action: /camera/task, args: {code: "${params.code}"}}]\n'
        'params: {code: {type: str}}\n'
    )
    types = action_types(cell(), FakeActionTypes())
    job = bind_order(WorkOrder('test', None, 1, {'code': 'abc'}), used, 'J1', types=types)
    assert job.params == {'code': 'abc'}
