"""Semantics 7.5: queued jobs by recipe are made anew when a component goes out of service."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from fakes.commands import SetService
from fakes.operator import ann
from fakes.recipe_bench import BOX, Bench
from fakes.script_texts import LINE, script

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.base.replies import begin
from bt_orchestrator.engine.asking.recipes import QueueAnew
from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job, MadeAnew
from bt_orchestrator.model.requests import ask
from bt_orchestrator.model.state import JobState
from bt_orchestrator.ports import MadeScript

ORIGIN = 'made_from: {recipe: BOX-7, version: 1, recipe_digest: aa11}'


def at(component: str) -> MadeScript:
    """Return the script in which a component glues."""
    glue = f'  3: [{{id: glue, task: TASK_A, action: /{component}/task}}]'
    return MadeScript('BOX-7', f'{LINE}{glue}\n{ORIGIN}\n')


def slow(component: str) -> MadeScript:
    """Return the same, with a section in which two tasks follow each other."""
    made = at(component)
    looks = (f'{{id: {name}, task: RUN, action: /camera/task}}' for name in ('look', 'again'))
    more = f'  2: [{", ".join(looks)}]\n'
    return made._replace(text=made.text.replace('made_from', f'{more}made_from'))


NOT_MADE = Refused([Finding('recipe BOX-7', 1, 1, 'glue: only press could')])


class Node:
    """A node whose scripts are generated when the test says so."""

    def __init__(self, folder: Path) -> None:
        self.bench = Bench(folder)
        self._calls: list[Callable[[], object]] = []
        engine = self.bench.engine
        engine.add_sink(QueueAnew(self.bench.handler, engine.state, self._calls.append))

    def job(self, name: str) -> JobState:
        return self.bench.engine.state.jobs[name]

    def order(self, *names: str) -> None:
        """Queue jobs by recipe."""
        answer = self.bench.order(*names)
        self.bench.give(at('press'))
        assert answer.value.accepted, answer.value.message

    def service(self, component: str, *, out: bool) -> str:
        answer = begin(self.bench.engine.carry_out(SetService(component, not out, ann())))
        assert answer.value.accepted, answer.value.message
        self.settle()
        return answer.value.message

    def settle(self) -> None:
        """Do what is to be done later."""
        while self._calls:
            self._calls.pop(0)()

    @property
    def asked(self) -> list[frozenset[str]]:
        """What was left out, of each script that was asked for."""
        return [without for _, without in self.bench.asked]

    def all(self, kind: type[e.Event]) -> list[e.Event]:
        return [event for event in self.bench.store.read() if isinstance(event, kind)]


@pytest.fixture
def node(tmp_path: Path) -> Iterator[Node]:
    node = Node(tmp_path)
    yield node
    node.bench.sim.close()


def test_7_5_queued_recipe_jobs_are_remade_without_component(node: Node) -> None:
    node.order('A', 'B')
    message = node.service('press', out=True)
    assert 'by recipe, and made anew without it where that can be: A, B' in message
    assert node.job('A').unavailable == ('press',), 'until another script is there'
    node.bench.give(at('table'))
    node.bench.give(at('table'))
    assert node.asked[1:] == [frozenset({'press'})] * 2
    for name in 'AB':
        job = node.job(name)
        assert job.job.script.tasks['glue'].component == 'table'
        assert job.unavailable == ()
        assert job.awaits_release, 'an engineer has to see what was generated'
        assert job.held, 'as it was'
    decided = [event for event in node.all(e.OperatorDecided) if vars(event)['answer'] == 'update']
    assert [vars(event)['job'] for event in decided] == ['A', 'B']
    assert {vars(event)['origin'] for event in decided} == {'the node, by itself'}
    assert {vars(event)['reason'] for event in decided} == {
        'press is out of service; made anew: 2.0 s per item'
    }


def test_7_5_job_shows_missing_components_and_new_pace(node: Node) -> None:
    node.order('A')
    node.service('press', out=True)
    node.bench.give(slow('table'))
    assert node.job('A').anew == MadeAnew(('press',), (), 3.0, 2.0)
    node.service('camera', out=True)
    node.bench.give(at('table'))
    assert node.job('A').anew == MadeAnew(('press', 'camera'), (), 2.0, 2.0)
    node.service('press', out=False)
    node.bench.give(at('press'))
    assert node.job('A').anew == MadeAnew(('camera',), (), 2.0, 2.0), 'against all in service'
    node.service('camera', out=False)
    node.bench.give(slow('press'))
    assert node.job('A').anew == MadeAnew((), ('camera',), 3.0, 2.0)
    begin(node.bench.handler.carry_out(ask('job.update', ann(), job='A', priority=3)))
    assert node.job('A').anew is not None, 'it has the same script'
    begin(node.bench.handler.carry_out(ask('job.update', ann(), job='A', script='test')))
    assert node.job('A').anew is None


def test_7_5_component_lost_during_order_is_left_out(
    node: Node,
) -> None:
    node.service('press', out=True)
    engine, made_before = node.bench.engine, script(at('press').text)
    assert begin(engine.carry_out(AddJobs((Job('A', made_before, 1, recipe=BOX),)))).value.accepted
    node.settle()
    node.bench.give(at('table'))
    assert node.job('A').unavailable == ()


def test_7_5_unmakeable_job_stays_unavailable_with_reason(node: Node) -> None:
    node.order('A')
    node.service('press', out=True)
    node.bench.give(NOT_MADE)
    assert node.job('A').unavailable == ('press',)
    (refused,) = node.all(e.OperatorRefused)
    assert (vars(refused)['command'], vars(refused)['job']) == ('update', 'A')
    assert 'glue: only press could' in vars(refused)['message']


def test_7_5_return_to_service_remakes_only_changed_jobs(node: Node) -> None:
    node.order('A')
    node.service('press', out=True)
    node.bench.give(at('table'))
    node.service('press', out=False)
    node.bench.give(at('press'))
    assert node.job('A').job.script.tasks['glue'].component == 'press'
    updates = len(node.all(e.JobUpdated))
    node.service('lamp', out=True)
    assert len(node.asked) == 3, 'A does not need it'
    node.service('lamp', out=False)
    node.bench.give(at('press'))
    assert len(node.all(e.JobUpdated)) == updates == 2


def test_7_5_job_with_named_script_stays_unchanged(node: Node) -> None:
    assert node.bench.order('A', recipe=None).value.accepted
    message = node.service('packer', out=True)
    assert 'by recipe' not in message
    assert node.job('A').unavailable == ('packer',)
    node.service('packer', out=False)
    assert node.asked == []


def test_7_5_cancelled_job_is_not_remade(node: Node) -> None:
    node.order('A', 'B')
    node.service('press', out=True)
    begin(node.bench.handler.carry_out(ask('job.cancel', ann(), job='B')))
    node.bench.give(at('table'))
    assert len(node.asked) == 2
    assert node.job('A').unavailable == ()


def test_7_5_defect_in_one_job_stops_no_other(
    node: Node, caplog: pytest.LogCaptureFixture
) -> None:
    node.order('A', 'B')
    node.service('press', out=True)
    node.bench.break_down()
    assert 'A could not be made anew' in caplog.text
    node.bench.give(at('table'))
    assert node.job('B').unavailable == (), 'nor one after it'
    node.service('press', out=False)
    node.bench.give(at('press'))
    node.bench.give(at('press'))
    assert node.job('A').unavailable == node.job('B').unavailable == ()


def test_7_5_next_node_remakes_jobs_lacking_a_component(tmp_path: Path) -> None:
    node = Node(tmp_path)
    node.order('A')
    node.service('press', out=True)  # killed before it was made anew
    later: list[Callable[[], object]] = []
    anew = QueueAnew(node.bench.handler, node.bench.engine.state, later.append)
    anew.publish([e.OrchestratorStarted(cell='test_cell', digest='0')])
    assert len(later) == 1
    anew.publish([e.OrchestratorStopping()])
    assert len(later) == 1
    node.bench.sim.close()
