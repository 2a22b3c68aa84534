"""What the page offers can be done: each offer is a request that the cell does not refuse."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from fakes.commands import Abort, Clear, Reset, Start, Stop, StopAfter
from fakes.line import THREE, Line, with_section
from fakes.operator import engineer
from fakes.page_parts import offered, page_parts, status_of
from fakes.virtual_run import VirtualRun

from bt_orchestrator.extensions.page.web.offers import job_offers
from bt_orchestrator.extensions.page.web.parts.parts import NOT_KNOWN, job_part
from bt_orchestrator.extensions.page.web.parts.tasks import TaskParts
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job, MadeAnew, RecipeChoice
from bt_orchestrator.model.status import CellDescription


def words(run: VirtualRun) -> set[str]:
    """Return the words that can be asked of the cell."""
    return {offer['word'] for offer in page_parts(run)['cell']['offers']}


def offer(part: dict[str, Any], word: str) -> Any:
    (wanted,) = (candidate for candidate in part['offers'] if candidate['word'] == word)
    return wanted


def test_working_cell_offers_only_stops() -> None:
    run = Line(3).begin(quantity=3)
    run.go(until=2.0)
    assert words(run) == {
        *('pause', 'stop', 'abort', 'stop_after_item', 'stop_after_job'),
        'local',
    }


def test_pause_is_resumed_by_cell_or_hold() -> None:
    run = Line(3).begin()
    run.go(until=2.0)
    run.pause()
    parts = page_parts(run)
    assert 'resume' in words(run)
    assert [item['name'] for item in offer(parts['cell'], 'resume')['parameters']] == ['everyones']
    (hold,) = parts['cell']['holds']
    resume = offer(parts[f'hold/{hold}'], 'resume')
    assert (resume['path'], resume['body']) == ('/api/requests/cell.resume', {'hold': hold})
    assert [item['name'] for item in resume['parameters']] == ['code']


def test_hold_answers_carry_path_and_words() -> None:
    run = Line(3, faults={'a2': 'TASK_A=abort'}).begin()
    run.go()
    parts = page_parts(run)
    (hold,) = parts['cell']['holds']
    part = parts[f'hold/{hold}']
    assert offered(part)[0] == 'hold.retry'
    done = offer(part, 'mark_done')
    assert done['path'] == '/api/requests/hold.mark_done'
    assert done['body'] == {'hold': hold}
    assert [parameter['name'] for parameter in done['parameters']] == ['results', 'code']
    reject = offer(part, 'reject')
    assert (reject['is_confirmed'], reject['why']) == (True, 'first')
    assert reject['roles'] == ['operate', 'engineer']
    assert 'resume' not in words(run), 'a hold of a task is no pause'


def test_results_are_asked_only_for_item_tasks() -> None:
    text = 'initialization: [{id: warm, @a1.PREPARE}]\n' + with_section(2, '[{id: work, @a2}]')
    run = Line(3, faults={'a1': 'PREPARE=abort'}).begin(text)
    run.go()
    parts = page_parts(run)
    (hold,) = parts['cell']['holds']
    asked = offer(parts[f'hold/{hold}'], 'mark_done')['parameters']
    assert [parameter['name'] for parameter in asked] == ['code']


def test_again_is_offered_inside_repeat() -> None:
    judged = '{id: weigh, @a2, fails_unless: "${results.weigh.item_present}"}'
    run = Line(3, faults={'a2': '#1=abort'}).begin(with_section(2, f'- repeat: [{judged}]'))
    run.go()
    parts = page_parts(run)
    (hold,) = parts['cell']['holds']
    again = offer(parts[f'hold/{hold}'], 'again')
    assert (again['path'], again['body']) == ('/api/requests/hold.again', {'hold': hold})


def test_clear_says_which_status_was_looked_at() -> None:
    run = Line(3).begin()
    run.go(until=3.5)
    run.command(Abort)
    run.go()
    parts = page_parts(run)
    clear = offer(parts['cell'], 'clear')
    assert clear['body'] == {'as_shown': parts['now']['seq']}
    assert clear['roles'] == ['engineer']
    assert parts['cell']['state_kind'] == 'trouble'
    assert words(run) == {'pause', 'clear', 'local'}, 'the line stands already'
    run.command(Clear, belt=_as_it_is(run))
    assert 'reset' in words(run)
    run.command(Reset)
    assert 'start' in words(run)
    run.command(Start)
    assert not words(run) & {'reset', 'start', 'clear'}


def _as_it_is(run: VirtualRun) -> Any:
    from bt_orchestrator.model.judging.belt_statement import AsShown

    return AsShown(run.state.seq)


def test_clear_waits_until_belt_position_is_known() -> None:
    run = Line(3).begin()
    run.go(until=1.5)
    assert page_parts(run)['belt']['moving']
    run.command(Abort)
    run.go()
    assert 'clear' not in words(run)
    assert not run.command(Clear, belt=_as_it_is(run)).accepted
    run.answer('mark_done')
    assert 'clear' in words(run)


def test_complete_cell_offers_no_reset_or_start() -> None:
    run = Line(3).run()
    assert run.state.packml.value == 'Complete'
    assert words(run) == {'pause', 'stop', 'abort', 'local'}
    run.command(Stop)
    run.go()
    assert 'reset' in words(run)


def test_requested_stop_offers_only_its_withdrawal() -> None:

    run = Line(3).begin(quantity=3)
    run.go(until=2.0)
    run.ask(StopAfter('item', engineer('Ann')))
    choices = words(run)
    assert 'stop_after_never' in choices
    assert 'stop_after_item' not in choices
    assert offer(page_parts(run)['cell'], 'stop_after_never')['body'] == {}


def test_jobs_offer_what_their_state_allows() -> None:
    line = Line(3)
    run = VirtualRun(line.cell, line.types)
    for job in ('J', 'K', 'L'):
        run.submit(
            job,
            line.script(THREE),
            5,
        )
    run.go(until=1.0)
    parts = page_parts(run)
    assert offered(parts['job/J']) == ['job.pause', 'job.stop', 'job.abort']
    queued = {'job.move', 'job.update', 'job.hold', 'job.abort', 'job.cancel'}
    assert set(offered(parts['job/K'])) == queued, 'the first of the queue is next already'
    assert set(offered(parts['job/L'])) == queued | {'job.next'}
    assert offer(parts['job/L'], 'next')['body'] == {'job': 'L'}
    assert [arg['name'] for arg in offer(parts['job/L'], 'move')['parameters']] == ['position']
    update = {arg['name']: arg['roles'] for arg in offer(parts['job/L'], 'update')['parameters']}
    assert update['script'] == ['engineer']
    assert update['quantity'] == ['mes', 'engineer']
    run.control('pause', 'J')
    assert 'job.resume' in offered(page_parts(run)['job/J'])


def test_recipe_job_lacking_component_can_be_requeued() -> None:
    line, box = Line(3), RecipeChoice(('BOX',))
    run = VirtualRun(line.cell, line.types)
    script = line.script(THREE)
    assert run.ask(AddJobs((Job('J', script, 5, recipe=box), Job('K', script, 1)))).accepted
    run.go(until=1.0)
    assert 'job.requeue' not in offered(page_parts(run)['job/J']), 'nothing is out of service'
    assert run.service('a2', out=True).accepted
    part = page_parts(run)['job/J']
    assert offer(part, 'requeue')['body'] == {'job': 'J'}
    assert [parameter['name'] for parameter in offer(part, 'requeue')['parameters']] == ['order']
    assert offer(part, 'requeue')['foresee']['name'] == 'job.requeue'
    assert 'job.requeue' not in offered(page_parts(run)['job/K']), 'it has not started'
    run.control('stop', 'J')
    assert 'job.requeue' not in offered(page_parts(run)['job/J'])


def test_job_can_be_requeued_when_component_returns() -> None:
    line, box = Line(3), RecipeChoice(('BOX',))
    run = VirtualRun(line.cell, line.types)
    assert run.ask(AddJobs((Job('J', line.script(THREE), 5, recipe=box),))).accepted
    run.go(until=1.0)
    status = status_of(run)

    def names(anew: MadeAnew, *away: str) -> list[object]:
        components = tuple(
            replace(entry, out_of_service_since=1.0 if entry.name in away else None)
            for entry in status.components
        )
        job = replace(status.jobs[0], anew=anew)
        return [entry['name'] for entry in job_offers(job, replace(status, components=components))]

    def changed_by(anew: MadeAnew, *away: str) -> object:
        job = replace(status.jobs[0], anew=anew, unavailable=away)
        tasks = TaskParts(CellDescription('', 0, ''), ())
        return job_part(job, status, None, tasks, NOT_KNOWN)['changed_by']

    assert changed_by(MadeAnew(without=('a2',)), 'b2') == ['b2', 'a2']
    assert 'job.requeue' in names(MadeAnew(without=('a2',)))
    assert 'job.requeue' in names(MadeAnew(without=('a2', 'b2')), 'b2')
    assert 'job.requeue' not in names(MadeAnew(without=('a2',)), 'a2'), 'it would be the same'
    assert 'job.requeue' not in names(MadeAnew(without=('gone',))), 'the cell has it no more'
    assert 'job.requeue' not in names(MadeAnew(back=('a2',))), 'it has it already'


def test_job_cannot_resume_while_cell_is_paused() -> None:
    run = Line(3).begin(quantity=3)
    run.go(until=2.0)
    run.pause()
    assert page_parts(run)['job/J']['substate'] == 'Suspended'
    assert 'job.resume' not in offered(page_parts(run)['job/J'])
    assert not run.control('resume', 'J').accepted


def test_item_can_be_removed_only_once() -> None:
    run = Line(3, seconds={'a2': 20.0}).begin()
    run.go(until=5.0)
    (remove,) = page_parts(run)['section/2']['offers']
    assert (remove['name'], remove['path']) == (
        'item.remove_item',
        '/api/requests/item.remove_item',
    )
    run.pause()
    assert run.remove('J/1').accepted
    assert page_parts(run)['section/2']['offers'] == []


def test_journal_failure_leaves_only_abort() -> None:
    from dataclasses import replace

    from fakes.page_parts import status_of

    from bt_orchestrator.extensions.page.web.offers import cell_offers

    run = Line(3).begin()
    run.go(until=1.0)
    status = replace(status_of(run), commands=('abort',), journal_failure='the disk is full')
    assert [entry['word'] for entry in cell_offers(status)] == ['abort']


def test_offers_that_change_ends_can_be_foreseen() -> None:
    run = Line(3).begin(quantity=3)
    run.submit('later', Line(3).script(THREE), 2)
    run.go(until=2.0)
    parts = page_parts(run)
    foreseen = {item['name']: item['foresee'] for item in parts['job/later']['offers']}
    assert foreseen['job.hold'] == {'name': 'job.hold', 'arguments': {'job': 'later'}}
    assert None not in foreseen.values()
    add = parts['cell']['add']
    assert (add['path'], add['body']) == ('/api/requests/queue.add', {})
    assert add['foresee'] == {'name': 'queue.add', 'arguments': {}}
    assert offer(parts['cell'], 'abort')['foresee'] is None
    run.go()
    (ended,) = (item for item in page_parts(run)['job/later']['offers'] if item['word'] == 'clear')
    assert ended['foresee'] is None, 'it changes only the list'
