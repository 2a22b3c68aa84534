"""Names that ROS 2 accepts; test/integration compares them with its own rules."""

from __future__ import annotations

import pytest

from bt_orchestrator.script.report import START, Report
from bt_orchestrator.script.ros_names import (
    LONGEST_ACTION,
    check_action_name,
    check_token,
    check_topic_name,
    check_type_name,
    legal_name,
)

LEGAL = ['/a', 'a', '/a/b_2', 'a/B', '/_hidden/__x', '/a' + '/b' * 100]
ILLEGAL = ['/1a', '/a/1', '1', 'a//b', '/a/', '/', 'a-b', '/a b', 'ä', '/a.b', '/a\n', '/²']


@pytest.mark.parametrize('name', LEGAL)
def test_legal_names(name: str) -> None:
    assert check_action_name(name, START, Report('a.yaml'))
    assert check_topic_name(name, START, Report('a.yaml'))


@pytest.mark.parametrize('name', ILLEGAL)
def test_illegal_names(name: str) -> None:
    report = Report('a.yaml')
    assert not check_action_name(name, START, report)
    assert not check_topic_name(name, START, report)
    assert len(report.findings) == 2


@pytest.mark.parametrize('name', ['~/a', '~', '/{node}/a', '{ns}/a'])
def test_names_of_own_node_are_refused_for_components(name: str) -> None:
    report = Report('a.yaml')
    assert not check_action_name(name, START, report)
    assert 'would mean this node' in report.findings[0].what


def test_an_action_name_leaves_room_for_its_topics() -> None:
    name = '/' + 'a' * (LONGEST_ACTION - 1)
    assert check_action_name(name, START, Report('a.yaml'))
    assert not check_action_name(name + 'a', START, Report('a.yaml'))
    assert check_topic_name(name + 'a', START, Report('a.yaml'))


@pytest.mark.parametrize(
    ('name', 'legal'),
    [
        ('/component_1a/1a_action', '/component_1a/action_1a'),
        ('1a', 'action_1a'),
        ('/1_2', '/action_1_2'),
        ('a//b/', 'a/b'),
        ('~/a', '/a'),
        ('/', '/my_action'),
        ('/a-b c', '/a_b_c'),
        ('/ä', '/action'),
    ],
)
def test_a_legal_spelling_is_offered(name: str, legal: str) -> None:
    assert legal_name(name, 'action') == legal
    assert check_action_name(legal, START, Report('a.yaml'))


@pytest.mark.parametrize(
    ('name', 'kind', 'hint'),
    [
        ('a_b/action/Name', 'action', None),
        ('std_msgs/msg/UInt8', 'msg', None),
        ('std_msgs/msg/UInt8', 'action', 'std_msgs/action/UInt8'),
        ('a/Name', 'action', 'a/action/Name'),
        ('a.action.name', 'action', 'a/action/Name'),
        ('a.action.my_name', 'action', 'a/action/MyName'),
        ('Name', 'msg', 'my_interfaces/msg/MyType'),
        ('1/2/3', 'msg', 'my_interfaces/msg/MyType'),
        ('', 'msg', 'my_interfaces/msg/MyType'),
    ],
)
def test_type_names(name: str, kind: str, hint: str | None) -> None:
    report = Report('a.yaml')
    assert check_type_name(name, kind, START, report) is (hint is None)
    assert [finding.hint for finding in report.findings] == (
        [f'write for instance `{hint}`'] if hint else []
    )


@pytest.mark.parametrize(('name', 'is_legal'), [('cell_1', True), ('1', False), ('a/b', False)])
def test_tokens(name: str, is_legal: bool) -> None:
    assert check_token(name, 'cell', START, Report('a.yaml')) is is_legal
