"""The tree as a whole: it never ends, holds no progress, and is a function of the scripts."""

from __future__ import annotations

import pytest
from fakes.line import THREE, Line
from fakes.tree_waits import waits_of
from py_trees.blackboard import ActivityType, Blackboard
from py_trees.common import Status

from bt_orchestrator.engine.tree.compile import CellTree

GUARDED = """
lateral_dependencies: [{flag: clear, upstream: place, downstream: work}]
zones: {table: [work, pack]}
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: work, @a2}]
  3: [{id: pack, @a3, qty_change: -1}]
"""


def names(tree: CellTree) -> list[str]:
    """Return every behaviour's name, from the root down."""
    return [behaviour.name for behaviour in tree.root.iterate()]


@pytest.mark.parametrize('moment', [0.0, 1.0, 3.0, 6.0, 100.0])
def test_the_root_never_ends(moment: float) -> None:
    run = Line().begin(quantity=2).go(until=moment)
    tree = run.sim.orchestrator.tree
    assert tree.root.status is Status.RUNNING
    for section in tree.sections.values():
        assert section.status is Status.RUNNING


def test_initialization_and_downstream_sections_win_ties() -> None:
    tree = Line().begin().sim.orchestrator.tree
    assert [child.name for child in tree.root.children] == [
        'initialization',
        'section 3',
        'section 2',
        'section 1',
        'belt',
    ]


def test_job_has_branches_until_it_ends() -> None:
    line = Line()
    run = line.begin()
    tree = run.sim.orchestrator.tree
    empty = names(Line().begin().sim.orchestrator.tree)
    assert tree.has('J')
    run.submit('K', line.script(THREE))
    assert tree.has('K')
    assert len(names(tree)) > len(empty)
    run.go()
    assert not tree.has('J')
    assert not tree.has('K')
    assert [child.name for child in tree.sections[2].children] == ['next cycle']


def test_tree_rebuilt_during_job_is_the_same() -> None:
    run = Line().begin(quantity=3).go(until=4.0)
    orchestrator = run.sim.orchestrator
    before = names(orchestrator.tree)
    again = CellTree(orchestrator._ledger, orchestrator._projection.space)
    assert names(again) == before
    again.close()


def test_closed_engine_removes_its_blackboard_keys() -> None:
    keys, clients = set(Blackboard.storage), set(Blackboard.clients)
    run = Line().run()  # meanwhile what earlier tests left may be collected
    its_keys, its_clients = Blackboard.storage.keys() - keys, Blackboard.clients.keys() - clients
    assert its_keys
    assert its_clients
    run.sim.close()
    assert not its_keys & Blackboard.storage.keys()
    assert not its_clients & Blackboard.clients.keys()


def test_no_behaviour_reads_the_blackboard() -> None:
    Blackboard.enable_activity_stream(maximum_size=100_000)
    try:
        run = Line(topics=('a2',)).begin(GUARDED, quantity=2)
        run.go()
        assert Blackboard.activity_stream is not None
        done = {item.activity_type for item in Blackboard.activity_stream.data}
    finally:
        Blackboard.disable_activity_stream()
    assert run.ended
    assert ActivityType.WRITE.value in done
    assert not done & {ActivityType.READ.value, ActivityType.ACCESSED.value}


def test_guards_declare_blackboard_keys_they_depend_on() -> None:
    run = Line(topics=('a2',)).begin(GUARDED)
    space = run.sim.orchestrator._projection.space
    read = {
        key.removeprefix(f'{space}/')
        for behaviour in run.sim.orchestrator.tree.root.iterate()
        for client in behaviour.blackboards
        for key in client.read
    }
    assert read == {'belt', 'beat', 'flags/clear', 'zones/table', 'ready/a2'}


def test_cells_of_one_name_have_separate_blackboards() -> None:
    first, second = Line().begin(), Line().begin()
    spaces = {run.sim.orchestrator._projection.space for run in (first, second)}
    assert len(spaces) == 2


def test_a_part_that_works_waits_for_nothing() -> None:
    run = Line().begin().go(until=0.0)
    tree = run.sim.orchestrator.tree
    assert waits_of(tree.sections[1]) == ()
    assert [wait.reason for wait in waits_of(tree.sections[2])] == ['waiting for an item']
