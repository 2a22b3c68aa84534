from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from contract.gateway_bench import component
from fakes.action_types import FakeActionTypes

from bt_orchestrator.model.cell import StateTopic
from bt_orchestrator.sim.results import as_failed, not_ready_value, ready_value, simulated_result

RICH = FakeActionTypes().action('test_interfaces/action/Rich')
PLAIN = FakeActionTypes().action('plain_interfaces/action/Index')


def test_what_the_cell_file_does_not_say() -> None:
    assert simulated_result(component('any'), RICH, 'RUN') == {
        'task_result': True,
        'ok': True,
        'code': '',
        'count': 0,
        'value': 0.0,
        'pose': {'frame': '', 'position': {'x': 0.0, 'y': 0.0, 'z': 0.0}},
        'triple': [0.0, 0.0, 0.0],
        'pair': [0.0, 0.0],
    }


def test_cell_file_results_reach_into_nested_messages() -> None:
    given = {'RUN': {'ok': False, 'pose': {'position': {'x': 2.5}}}}
    result = simulated_result(replace(component('any'), results=given), RICH, 'RUN')
    assert result['ok'] is False
    assert result['pose'] == {'frame': '', 'position': {'x': 2.5, 'y': 0.0, 'z': 0.0}}
    assert result['count'] == 0


def test_results_belong_to_their_task() -> None:
    given = {'STOP': {'count': 4}}
    assert simulated_result(replace(component('any'), results=given), RICH, 'RUN')['count'] == 0


def test_not_done_where_the_type_can_say_it() -> None:
    assert as_failed({'task_result': True, 'count': 3}) == {'task_result': False, 'count': 3}
    assert as_failed(simulated_result(component('any'), PLAIN, '')) == {}


@pytest.mark.parametrize(
    'ready',
    [('READY',), ('NOT_READY', 'x'), (True,), (False,), (0,), (1, 0), (3, 1, 0), (0.5, 1.0)],
)
def test_not_ready_value_has_the_same_type(ready: tuple[Any, ...]) -> None:
    state = StateTopic('/arm/state', 'std_msgs/msg/String', 'data', ready)
    value = not_ready_value(state)
    assert ready_value(state) == ready[0]
    assert value not in ready
    assert isinstance(value, bool) == isinstance(ready[0], bool)
    assert isinstance(value, str) == isinstance(ready[0], str)
