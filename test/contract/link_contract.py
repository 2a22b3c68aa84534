"""What every CellLink does, whatever is at its other end (see ports/door.py).

Subclass it and say how a bench is made.
"""

from __future__ import annotations

from typing import Any

import pytest
from contract.link_bench import LinkBench, Seen
from contract.link_doors import ANN, add, asked_of, happen, new_id, numbers, turn_until
from contract.link_following import FollowingContract
from patience import PATIENCE_S

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.order import Terms, WorkOrder
from bt_orchestrator.model.keeping.snapshot import state_from_plain
from bt_orchestrator.model.limits import EVENTS_PAGE, QUEUE_PAGE
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.status import ComponentStatus
from bt_orchestrator.ports import CellLink


def breaker(link: CellLink) -> ComponentStatus:
    """Return the newest word of a component."""
    return next(device for device in link.status().components if device.name == 'breaker')


class LinkContract(FollowingContract):
    """How the cell stands, pages of what there is, and requests; and what listeners are told."""

    # --- how it stands ----------------------------------------------------------------------

    def test_status_names_cell_and_its_state(self, link: CellLink) -> None:
        happen(link)
        status = link.status()
        assert link.name == '/bt_orchestrator'
        assert (status.cell, len(status.sections), len(status.components)) == ('link_cell', 2, 3)
        assert status.seq > 0
        assert status.history
        assert status.state in PackmlState

    def test_the_description_says_what_there_is(self, link: CellLink) -> None:
        cell = link.description()
        assert (cell.cell, cell.sections, cell.conveyor) == ('link_cell', 2, 'conveyor')
        named = {component.name: component for component in cell.components}
        assert set(named) == {'conveyor', 'feeder', 'breaker'}
        assert named['feeder'].durations_s == {'TASK_A': 0.2}
        assert named['breaker'].sections == (2,)

    def test_moment_provides_initial_state_of_virtual_run(
        self, bench: LinkBench, link: CellLink
    ) -> None:
        name = new_id()
        assert add(link, name).accepted
        moment = link.moment()
        assert moment.cell == bench.cell()
        assert name in moment.plain_state['state']['jobs']
        assert moment.now_s == pytest.approx(link.status().stamp, abs=PATIENCE_S)
        assert asked_of(link, 'job.cancel', job=name).accepted
        moment = link.moment()
        assert name in state_from_plain(moment.cell, moment.plain_state).order_ids

    # --- pages ------------------------------------------------------------------------------

    def test_a_page_of_events(self, link: CellLink) -> None:
        last = happen(link, 3)
        page = link.events_after(last - 3, 2)
        assert [event.seq for event in page.events] == [last - 2, last - 1]
        assert (page.history, page.last_seq) == (link.status().history, last)
        assert link.events_after(last).events == ()
        first = link.events_after(0).first_seq
        assert len(link.events_after(first - 1).events) <= EVENTS_PAGE

    def test_pages_of_a_long_queue(self, link: CellLink) -> None:
        for _ in range(3):
            assert add(link, *(new_id() for _ in range(200))).accepted
        names: list[str] = []
        while page := link.queue(names[-1] if names else '').jobs:
            assert len(page) <= QUEUE_PAGE
            names += [job.id for job in page]
        whole = link.queue(most=7)
        assert whole.queued == len(names) == len(set(names)) > QUEUE_PAGE
        assert [job.id for job in whole.jobs] == names[:7]
        assert [job.position for job in whole.jobs] == [1, 2, 3, 4, 5, 6, 7]
        with pytest.raises(CommandRefused, match='NOBODY is not in the queue'):
            link.queue('NOBODY')
        for name in names:
            assert asked_of(link, 'job.cancel', job=name).accepted

    def test_listed_jobs_with_what_they_were_ordered_with(
        self, bench: LinkBench, link: CellLink
    ) -> None:
        first, second = new_id(), new_id()
        terms = Terms(3, 1779084000.0, details={'customer': 'ACME'})
        order = WorkOrder('small', first, 2, {'speed': 0.5}, terms)
        assert asked_of(link, 'queue.add', orders=[order], held=True).accepted
        assert add(link, second).accepted
        job = link.job(first)
        assert (job.params, job.details, job.reason) == ({'speed': 0.5}, terms.details, '')
        status = job.status
        assert (status.quantity, status.priority, status.start) == (2, 3, terms.start)
        assert status.queued_at == pytest.approx(link.status().stamp, abs=PATIENCE_S)
        assert (status.started_at, status.ended_at) == (None, None)
        assert link.job(second).params == {'speed': 1.0}, 'the default'
        assert asked_of(link, 'job.abort', job=first).accepted

        job = link.job(first)
        assert (job.status.state, job.details) == (JobWord.ABORTED, terms.details)
        assert 'Ann' in job.reason
        assert 'because' in job.reason
        assert job.status.started_at is None
        assert job.status.ended_at is not None
        assert job.status.ended_at >= job.status.queued_at
        names: list[str] = []
        while page := link.jobs(names[-1] if names else '', most=3):
            assert len(page) <= 3
            names += [entry.status.id for entry in page]
        assert names.index(first) < names.index(second), 'those that ended come first'
        assert names == [entry.status.id for entry in link.jobs()]
        assert {job.id for job in link.status().jobs} <= set(names)

        assert asked_of(link, 'job.clear', job=first).accepted
        for ask_for in (link.job, link.jobs):
            with pytest.raises(CommandRefused, match=f'{first} is no longer listed'):
                ask_for(first)
        with pytest.raises(CommandRefused, match='there is no job NOBODY; jobs now: '):
            link.job('NOBODY')
        assert asked_of(link, 'job.cancel', job=second).accepted

    # --- asking -----------------------------------------------------------------------------

    def test_events_after_answer_show_the_request(self, link: CellLink) -> None:
        before, name = happen(link), new_id()
        seen = Seen()
        link.follow(seen)
        answer = add(link, name)
        assert answer.accepted
        assert [entry.job for entry in answer.orders] == [name]
        after = [event.event for event in link.events_after(before).events]
        assert 'job.queued' in after, 'it is on record when the answer comes'
        turn_until(link, lambda: seen.of('job.queued', job=name), 'event')
        assert seen.of('operator.decided', who='Ann', origin='contract', reason='because')
        assert asked_of(link, 'job.move', job=name, position=1).accepted
        changed = asked_of(link, 'job.update', job=name, quantity=3, priority=2)
        assert changed.accepted, changed
        turn_until(link, lambda: seen.of('job.updated', job=name), 'event')
        (job,) = (entry for entry in link.queue(most=1).jobs)
        assert (job.id, job.quantity, job.priority) == (name, 3, 2)
        assert asked_of(link, 'job.cancel', job=name).accepted

    @pytest.mark.parametrize(
        ('name', 'given', 'message'),
        [
            ('cell.clear', {}, 'either every slot, as in 1=WO-1/3 and 2=empty'),
            ('cell.clear', {'belt': ['1=O-1/1']}, 'clear'),
            ('cell.stop_after_never', {}, 'no stop was asked for'),
            ('hold.retry', {'hold': 'X'}, 'there is no hold X; holds now: '),
            ('hold.mark_done', {'hold': 'X', 'results': {'a': 1}}, 'about no task that can have'),
            ('item.remove_item', {'item': 'X/1'}, 'X/1 is not on the belt; on it: '),
            (
                'component.out_of_service',
                {'component': 'braker'},
                "there is no component 'braker'; did you mean `breaker`?",
            ),
            ('component.in_service', {'component': 'breaker'}, 'breaker is in service'),
            ('script.release_script', {'script': 'smal'}, "no job in the queue waits for 'smal'"),
            (
                'script.release_script',
                {'script': 'abcdef012345', 'cell_digest': '0'},
                'abcdef012345 was generated for another cell file (0)',
            ),
            ('job.pause', {'job': 'X'}, 'there is no job X; jobs now: '),
            ('job.move', {'job': 'X', 'position': 1}, 'X is not there; in the queue: '),
            ('job.update', {'job': 'X', 'quantity': 2}, 'X is not there; in the queue: '),
            ('job.update', {'job': 'X', 'start': 'soon'}, '`start` must be '),
            ('queue.add', {'orders': []}, 'name at least one order'),
        ],
    )
    def test_a_refusal_says_why_and_is_on_record(
        self, link: CellLink, name: str, given: dict[str, Any], message: str
    ) -> None:
        before = happen(link)
        answer = asked_of(link, name, **given)
        assert not answer.accepted
        assert message in answer.message
        if name != 'job.update' or 'start' not in given:
            (event,) = link.events_after(before).events
            assert event.event == 'operator.refused'
            assert vars(event)['message'] == answer.message

    def test_component_leaves_service_and_returns(self, link: CellLink) -> None:
        name = new_id()
        assert add(link, name).accepted
        # The answer names the first jobs, and tests before may have left some.
        assert asked_of(link, 'job.move', job=name, position=1).accepted
        out = asked_of(link, 'component.out_of_service', component='breaker')
        assert out.accepted, out.message
        assert name in out.message
        assert 'this is no lockout' in out.message
        turn_until(link, lambda: bool(breaker(link).out_of_service), 'word of the breaker')
        there = breaker(link)
        assert not there.ready
        assert there.out_of_service.endswith(str(ANN))  # a node that trusts no door says `claims`
        assert there.out_of_service_since == pytest.approx(link.status().stamp, abs=PATIENCE_S)
        job = link.job(name).status
        assert (job.state, job.held) == (JobWord.NOT_ALLOWED_TO_START, True)
        assert job.unavailable == ('breaker',)
        assert asked_of(link, 'component.in_service', component='breaker').accepted
        turn_until(link, lambda: not breaker(link).out_of_service, 'word of the breaker')
        assert breaker(link).out_of_service_since is None
        assert link.job(name).status.unavailable == ()
        assert asked_of(link, 'job.cancel', job=name).accepted

    def test_a_script_is_released_for_this_cell(self, link: CellLink) -> None:
        seen, script = Seen(), f'{next(numbers):012x}'
        link.follow(seen)
        answer = asked_of(link, 'script.release_script', script=script)
        assert answer.accepted, answer.message
        turn_until(link, lambda: seen.of('script.released', digest=script), 'event')
        (released,) = seen.of('script.released', digest=script)
        assert vars(released)['reason'].endswith(str(ANN))
        assert 'already' in asked_of(link, 'script.release_script', script=script).message

    def test_orders_with_mistakes(self, link: CellLink) -> None:
        before, good = happen(link), new_id()
        orders = [WorkOrder('small', good, 1), WorkOrder('smal', new_id(), 1)]
        answer = asked_of(link, 'queue.add', orders=orders)
        assert (answer.accepted, answer.message) == (False, 'refused with 1 finding')
        fits, wrong = answer.orders
        assert good in fits.message
        assert fits.findings == ()
        (finding,) = wrong.findings
        assert 'small' in finding, 'the nearest name is offered'
        events = link.events_after(before).events
        assert {event.event for event in events} == {'operator.refused'}, 'none is queued'

    def test_an_id_is_used_once(self, link: CellLink) -> None:
        name = new_id()
        assert add(link, name).accepted
        answer = add(link, name)
        assert not answer.accepted
        (order,) = answer.orders
        assert order.job == ''
        assert name in order.message

    def test_a_hold_is_answered(self, link: CellLink) -> None:
        seen = Seen()
        link.follow(seen)
        assert add(link, new_id(), held=False).accepted
        turn_until(link, lambda: seen.of('hold.raised', task='break'), 'hold')
        turn_until(link, lambda: seen.status and seen.status.holds, 'hold in the status')
        (hold,) = link.status().holds
        assert (hold.task, hold.component, hold.answers[0]) == ('break', 'breaker', 'retry')
        refused = asked_of(link, 'hold.mark_done', hold=hold.id, results={'measurement': 'much'})
        assert not refused.accepted
        assert 'measurement' in refused.message
        done = asked_of(link, 'hold.mark_done', hold=hold.id, results={'measurement': 3.5})
        assert done.accepted, done.message
        turn_until(link, lambda: seen.of('task.marked_done', task='break'), 'decision')
        (event,) = seen.of('task.marked_done', task='break')
        assert vars(event)['results'] == {'measurement': 3.5}
        turn_until(link, lambda: seen.of('job.completed'), 'end of the job')
