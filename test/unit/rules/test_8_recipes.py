"""Orders by recipe: generated first, queued together, and a version says one thing (8.6)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.commands import SetService
from fakes.operator import ann
from fakes.recipe_bench import BOX, LID, Bench, made

from bt_orchestrator.base.errors import Finding, NotRead, Refused
from bt_orchestrator.base.replies import begin
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.jobs.order import RecipeChoice, WorkOrder
from bt_orchestrator.model.requests import ask
from bt_orchestrator.ports import MadeScript

TYPES = FakeActionTypes()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    bench = Bench(tmp_path)
    yield bench
    bench.sim.close()


def test_8_6_script_orders_do_not_wait_for_recipe_orders(bench: Bench) -> None:
    first = bench.order('A')
    second = bench.order('B', recipe=None)
    assert second.value.accepted
    assert not first.is_there
    bench.give(made())
    assert first.value.accepted
    assert bench.queue == ['B', 'A']


def test_8_6_orders_of_a_request_are_queued_together(bench: Bench) -> None:
    orders = [WorkOrder('', 'A', 1, recipe=BOX), WorkOrder('test', 'B', 1)]
    orders += [WorkOrder('', 'C', 1, recipe=LID), WorkOrder('', 'D', 1, recipe=BOX)]
    answer = begin(bench.handler.carry_out(ask('queue.add', ann(), orders=orders, held=True)))
    assert bench.asked == [((BOX, LID), frozenset())]
    assert (bench.store.together, bench.queue) == ([], [])
    bench.give(made(), made(2, 'bb22'))
    assert answer.value.accepted, answer.value.message
    assert bench.store.together == [['A', 'B', 'C', 'D']]
    jobs = [job.job for job in bench.engine.state.jobs.values()]
    assert [job.recipe for job in jobs] == [BOX, None, LID, BOX]


@pytest.mark.parametrize('kind', ['one cannot be made', 'nothing is made', 'one does not fit'])
def test_8_6_request_with_one_bad_order_queues_nothing(bench: Bench, kind: str) -> None:
    answer = bench.order('A', 'B', recipe=BOX)
    if kind == 'one cannot be made':
        bench.give(Refused([Finding('recipe BOX-7', 1, 1, 'no component has `glue`')]))
    elif kind == 'nothing is made':
        bench.replies.pop(0).give(NotRead('generating took too long'))
    else:
        bench.give(MadeScript('BOX-7', 'script: test\n'))
    assert not answer.value.accepted
    assert bench.queue == []
    assert bench.store.together == []


def test_8_6_generation_omits_component_taken_out_of_service_meanwhile(bench: Bench) -> None:
    answer = bench.order('A')
    begin(bench.engine.carry_out(SetService('press', False, ann())))
    bench.give(made())
    assert [without for _, without in bench.asked] == [frozenset(), frozenset({'press'})]
    assert not answer.is_there
    bench.give(made())
    assert answer.value.accepted


def test_8_6_a_version_of_a_recipe_says_one_thing(bench: Bench) -> None:
    def give(name: str, script: MadeScript) -> Answer:
        answer = bench.order(name)
        bench.give(script)
        return answer.value

    assert give('A', made(1, 'aa11')).accepted
    assert give('B', made(1, 'aa11')).accepted
    why = (
        'recipe BOX-7 version 1 was another one before: it is bb22 now, and was aa11; '
        'give the recipe another version'
    )
    assert give('C', made(1, 'bb22')).message == why
    assert give('D', made(2, 'bb22')).accepted
    orders = [WorkOrder('', name, 1, recipe=choice) for name, choice in (('E', BOX), ('F', LID))]
    both = begin(bench.handler.carry_out(ask('queue.add', ann(), orders=orders, held=True)))
    bench.give(made(3, 'cc33'), made(3, 'dd44'))
    assert 'version 3 was another one before' in both.value.message
    assert bench.queue == ['A', 'B', 'D']


def test_8_6_change_to_altered_recipe_version_is_refused(bench: Bench) -> None:
    assert not bench.order('A').is_there
    bench.give(made(1, 'aa11'))
    answer = begin(bench.handler.carry_out(ask('job.update', ann(), job='A', recipe=['BOX-7'])))
    bench.give(made(1, 'bb22'))
    assert not answer.value.accepted
    assert 'version 1 was another one before' in answer.value.message


def test_8_6_recipe_version_of_ended_job_is_remembered(bench: Bench) -> None:
    answer = bench.order('A')
    bench.give(made(1, 'aa11'))
    assert answer.value.accepted
    begin(bench.handler.carry_out(ask('job.cancel', ann(), job='A')))
    assert bench.queue == []
    answer = bench.order('B')
    bench.give(made(1, 'bb22'))
    assert 'was aa11' in answer.value.message


def test_8_6_queued_job_is_regenerated_from_its_order(bench: Bench) -> None:
    answer = bench.order('A', recipe=LID)
    bench.give(made(1, 'aa11'))
    assert answer.value.accepted
    begin(bench.engine.carry_out(SetService('press', False, ann())))
    answer = begin(bench.handler.make_anew('A', ann()))
    assert bench.asked[-1] == ((LID,), frozenset({'press'}))
    other = MadeScript('BOX-7', made().text.replace('script: test', 'script: test_2'))
    bench.give(other)
    assert answer.value.accepted, answer.value.message
    job = bench.engine.state.jobs['A'].job
    assert (job.script.name, job.recipe, job.quantity) == ('test_2', LID, 1)


def test_8_6_job_update_sets_and_removes_recipe(bench: Bench) -> None:
    assert bench.order('A', recipe=None).value.accepted
    given = {'job': 'A', 'recipe': ['BOX-7'], 'version': 2}
    answer = begin(bench.handler.carry_out(ask('job.update', ann(), **given)))
    bench.give(made(2))
    assert answer.value.accepted, answer.value.message
    assert bench.engine.state.jobs['A'].job.recipe == RecipeChoice(('BOX-7',), 2)
    assert bench.engine.state.jobs['A'].recipe_version == 2
    update = ask('job.update', ann(), job='A', quantity=5)
    assert begin(bench.handler.carry_out(update)).value.accepted
    assert bench.engine.state.jobs['A'].job.recipe == RecipeChoice(('BOX-7',), 2)
    update = ask('job.update', ann(), job='A', script='test')
    assert begin(bench.handler.carry_out(update)).value.accepted
    assert bench.engine.state.jobs['A'].job.recipe is None


def test_8_6_jobs_with_equal_scripts_keep_their_versions(bench: Bench) -> None:
    for version, name in ((1, 'A'), (2, 'B')):
        answer = bench.order(name)
        bench.give(made(version, f'{version}{version}'))
        assert answer.value.accepted
    update = ask('job.update', ann(), job='B', quantity=5)
    assert begin(bench.handler.carry_out(update)).value.accepted
    jobs = bench.engine.state.jobs
    assert [jobs[name].recipe_version for name in 'AB'] == [1, 2]
    assert jobs['B'].job.quantity == 5


@pytest.mark.parametrize(
    ('change', 'wanted'),
    [
        ({'version': 3}, RecipeChoice(('LID-1',), 3, {'glue': 'robot_a'})),
        ({'bind': {'glue': 'press'}}, RecipeChoice(('LID-1',), 2, {'glue': 'press'})),
        (
            {'bind': {'pack': 'packer'}},
            RecipeChoice(('LID-1',), 2, {'glue': 'robot_a', 'pack': 'packer'}),
        ),
        ({'recipe': ['LID-1']}, RecipeChoice(('LID-1',))),
    ],
)
def test_8_6_version_or_binding_change_keeps_recipe(
    bench: Bench, change: dict[str, object], wanted: RecipeChoice
) -> None:
    bench.order('A', recipe=LID)
    bench.give(made(1, 'aa11'))
    answer = begin(bench.handler.carry_out(ask('job.update', ann(), job='A', **change)))
    assert bench.asked[-1] == ((wanted,), frozenset())
    bench.give(made(3, 'cc33'))
    assert answer.value.accepted, answer.value.message
    job = bench.engine.state.jobs['A']
    assert (job.job.recipe, job.recipe_version) == (wanted, 3)


@pytest.mark.parametrize('change', [{'version': 3}, {'bind': {'glue': 'press'}}])
def test_8_6_script_job_refuses_version_and_binding(
    bench: Bench, change: dict[str, object]
) -> None:
    assert bench.order('A', recipe=None).value.accepted
    update = ask('job.update', ann(), job='A', **change)
    (of_job,) = begin(bench.handler.carry_out(update)).value.orders
    (key,) = change
    (finding,) = of_job.findings
    assert finding.startswith(
        f'order A, {key}:1:1: `{key}` is about a recipe, and the order names none; '
    )


def test_8_6_update_applies_to_recipe_at_its_turn(bench: Bench) -> None:
    bench.order('A')
    bench.give(made(1, 'aa11'))
    update = ask('job.update', ann(), job='A', version=2)
    answer = begin(bench.handler.carry_out(update))
    other = begin(bench.handler.carry_out(ask('job.update', ann(), job='A', recipe=['LID-1'])))
    late = bench.replies.pop(0)
    bench.give(made(3, 'cc33'))
    assert other.value.accepted
    late.give((made(2, 'bb22'),))
    assert not answer.is_there, 'what was generated is of the other recipe'
    assert bench.asked[-1] == ((RecipeChoice(('LID-1',), 2),), frozenset())
    bench.give(made(4, 'dd44'))
    assert answer.value.accepted, answer.value.message
    job = bench.engine.state.jobs['A']
    assert (job.job.recipe, job.recipe_version) == (RecipeChoice(('LID-1',), 2), 4)


def test_8_6_regeneration_uses_recipe_that_changed_meanwhile(bench: Bench) -> None:
    bench.order('A')
    bench.give(made(1, 'aa11'))
    anew = begin(bench.handler.make_anew('A', ann()))
    other = begin(bench.handler.carry_out(ask('job.update', ann(), job='A', recipe=['LID-1'])))
    late = bench.replies.pop(0)
    bench.give(made(3, 'cc33'))
    assert other.value.accepted
    late.give((made(1, 'aa11'),))
    bench.give(made(3, 'cc33'))
    assert anew.value.accepted
    job = bench.engine.state.jobs['A']
    assert (job.job.recipe, job.recipe_version) == (RecipeChoice(('LID-1',)), 3)


def test_8_6_job_changed_to_script_is_not_regenerated(bench: Bench) -> None:
    bench.order('A')
    bench.give(made(1, 'aa11'))
    anew = begin(bench.handler.make_anew('A', ann()))
    assert begin(
        bench.handler.carry_out(ask('job.update', ann(), job='A', script='test'))
    ).value.accepted
    bench.give(made(1, 'aa11'))
    assert anew.value.message == 'A is no job by recipe'
    assert bench.engine.state.jobs['A'].job.recipe is None


def test_8_6_job_regenerated_from_equal_older_version_reports_it(bench: Bench) -> None:
    for version, name in ((1, 'A'), (2, 'B')):
        bench.order(name)
        bench.give(made(version, f'{version}{version}'))
    # Version 2 was taken back: the newest is 1 again.
    answer = begin(bench.handler.carry_out(ask('job.update', ann(), job='B', recipe=['BOX-7'])))
    bench.give(made(1, '11'))
    assert answer.value.accepted
    assert bench.engine.state.jobs['B'].recipe_version == 1
