"""The inspection server inside one process: messages of trees, and how it starts."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any
from uuid import UUID

import pytest
from action_caller import ActionCaller
from py_trees.behaviour import Behaviour
from py_trees.behaviours import Failure, Running, Success
from py_trees.common import Access, BlackBoxLevel, ParallelPolicy
from py_trees.composites import Composite, Parallel, Selector, Sequence
from py_trees.decorators import Inverter
from py_trees_ros_interfaces.msg import BehaviourTree
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from watching_client import LATCHED, Snapshot

from bt_orchestrator.ros.inspection import server, start
from bt_orchestrator.ros.inspection.snapshot_source import TickStatistics
from bt_orchestrator.ros.inspection.start import NoLibrary
from bt_orchestrator.ros.inspection.tree_messages import TreeMessages

pytestmark = pytest.mark.every_distro

# --- trees ------------------------------------------------------------------------------------


def sample_tree() -> tuple[Composite, Selector]:
    """Return a tree with something of each kind, and a branch of it to change."""
    branch = Selector('branch', memory=False, children=[Failure('no'), Running('busy')])
    reader = Success('reader')
    reader.attach_blackboard_client(name='reader').register_key(key='k', access=Access.READ)
    line = Sequence('line', memory=True, children=[reader, Inverter('not', Failure('fails'))])
    line.blackbox_level = BlackBoxLevel.COMPONENT
    all_of = ParallelPolicy.SuccessOnAll(synchronise=False)
    return Parallel('root', all_of, [line, branch, Sequence('empty', memory=False)]), branch


def snapshot_of(messages: TreeMessages) -> Snapshot:
    return Snapshot(BehaviourTree(behaviours=messages.messages))


def tips(snapshot: Snapshot) -> dict[str, UUID]:
    return {b.name: UUID(bytes=bytes(b.tip_id.uuid)) for b in snapshot.message.behaviours}


def tip_of(behaviour: Behaviour) -> UUID:
    """Say what py_trees says, as it is written in messages."""
    tip = behaviour.tip()
    return UUID(int=0) if tip is None or tip is behaviour else tip.id


def test_every_kind_of_behaviour_has_its_words() -> None:
    root, _ = sample_tree()
    root.tick_once()
    messages = TreeMessages()
    messages.refresh(root)

    actual = {
        b.name: (b.type, b.additional_detail, b.status, b.blackbox_level)
        for b in snapshot_of(messages).message.behaviours
    }
    assert actual == {
        'root': (4, 'OnAll', 2, 4),
        'line': (2, 'WithMemory', 3, 2),
        'reader': (1, '', 3, 4),
        'not': (6, '', 3, 4),
        'fails': (1, '', 4, 4),
        'branch': (3, '', 2, 4),
        'no': (1, '', 4, 4),
        'busy': (1, '', 2, 4),
        'empty': (2, '', 3, 4),
    }
    reader = snapshot_of(messages).by_name['reader']
    assert [(pair.key, pair.value) for pair in reader.blackboard_access] == [('/k', 'r')]
    assert reader.class_name == 'py_trees.behaviours.Success'
    assert messages.visited_keys == {'/k'}


def test_tips_are_those_of_py_trees() -> None:
    root, branch = sample_tree()
    messages = TreeMessages()
    for step in range(4):
        if step == 2:
            branch.stop()
        elif step:
            root.tick_once()
        messages.refresh(root)
        assert tips(snapshot_of(messages)) == {b.name: tip_of(b) for b in root.iterate()}


def test_status_or_tree_change_makes_new_version() -> None:
    root, branch = sample_tree()
    messages = TreeMessages()
    versions = []
    new = Running('new')
    for change in (
        lambda: None,
        root.tick_once,
        lambda: None,
        lambda: branch.add_child(new),
        lambda: branch.remove_child(new),
        lambda: setattr(branch, 'feedback_message', 'words'),
    ):
        change()
        messages.refresh(root)
        versions.append(messages.version)
    assert versions == [1, 2, 2, 3, 4, 4]
    assert snapshot_of(messages).text('branch') == 'words'
    assert 'new' not in snapshot_of(messages).by_name


def test_a_branch_that_is_not_ticked_says_nothing() -> None:
    root, branch = sample_tree()
    root.tick_once()
    branch.feedback_message = 'old words'
    root.stop()
    messages = TreeMessages()
    messages.refresh(root)

    snapshot = snapshot_of(messages)
    assert {b.message for b in snapshot.message.behaviours} == {''}
    assert not any(b.is_active for b in snapshot.message.behaviours)
    assert messages.visited_keys == set()


# --- start ------------------------------------------------------------------------------------


def start_on_node(context: Context, kind: str = 'builtin') -> list[str]:
    """Start on a node without a cell, and return the names of its services."""
    node = Node('bare', context=context)
    try:
        engine: Any = SimpleNamespace(tree=SimpleNamespace(root=sample_tree()[0]))
        start.start_inspection(node, engine, TickStatistics(), kind)
        return [name for name, _ in node.get_service_names_and_types_by_node('bare', '/')]
    finally:
        node.destroy_node()


def test_node_without_message_types_runs_and_warns_once(
    context: Context, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(start, 'INTERFACES', 'no_such_interfaces')
    names = start_on_node(context)

    assert not [name for name in names if 'streams' in name]
    warnings = [line for line in capfd.readouterr().err.splitlines() if 'tree watcher' in line]
    (warning,) = warnings
    assert 'the package no_such_interfaces is not installed' in warning


def test_missing_library_is_named_with_install_hint(
    context: Context, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(start, 'LIBRARY', 'no_such_library')
    with pytest.raises(NoLibrary) as refused:
        start_on_node(context, 'py_trees_ros')
    assert 'no_such_library was asked for, and it is not installed; ' in str(refused.value)
    assert 'apt: ros-$ROS_DISTRO-py-trees-ros' in str(refused.value)


def test_a_library_that_lacks_something_says_what(
    context: Context, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / 'half_library').mkdir()
    (tmp_path / 'half_library' / '__init__.py').write_text('')
    (tmp_path / 'half_library' / 'trees.py').write_text('import tf2_that_is_missing')
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(start, 'LIBRARY', 'half_library')
    with pytest.raises(NoLibrary, match='cannot be loaded: No module named'):
        start_on_node(context, 'py_trees_ros')


def test_the_services_are_those_of_the_contract(context: Context) -> None:
    names = {name for name in start_on_node(context) if 'streams' in name}
    assert names == {
        '/bare/snapshot_streams/open',
        '/bare/snapshot_streams/close',
        '/bare/snapshot_streams/reconfigure',
        '/bare/blackboard_streams/get_variables',
        '/bare/blackboard_streams/open',
        '/bare/blackboard_streams/close',
    }


# --- turns ------------------------------------------------------------------------------------


class SlowWords:
    """Words that take an hour by the clock: others have the processor meanwhile."""

    def __init__(self) -> None:
        self.now = 0.0

    def __str__(self) -> str:
        self.now += 3600.0
        return 'words'


def test_change_after_delayed_turn_is_published(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    words, beats = SlowWords(), iter(range(1_000_000))
    clock = SimpleNamespace(monotonic=lambda: words.now + next(beats))
    monkeypatch.setattr(server, 'time', clock)
    leaf = Running('busy')
    leaf.tick_once()
    leaf.feedback_message = words  # type: ignore[assignment] # whatever can be written as text
    engine: Any = SimpleNamespace(tree=SimpleNamespace(root=leaf), state=SimpleNamespace(seq=1))
    seen: list[Any] = []
    caller = ActionCaller()
    try:
        start.start_inspection(caller.node, engine, TickStatistics(), 'builtin')
        caller.node.set_parameters([Parameter('default_snapshot_stream', value=True)])
        topic = 'action_caller/snapshots'
        caller.node.create_subscription(BehaviourTree, topic, seen.append, LATCHED)
        caller.spin_until(lambda: seen, 'the first snapshot')
        assert words.now > 0

        engine.state.seq, before = 2, len(seen)
        caller.spin_until(lambda: len(seen) > before, 'the snapshot of the change')
    finally:
        caller.close()
