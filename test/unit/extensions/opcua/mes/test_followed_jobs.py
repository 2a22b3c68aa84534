"""The followed of jobs beside the engine: after every settle both say the same of every job."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from fakes import plan_runs
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan
from fakes.line import THREE, TYPES, Line, with_section
from fakes.plan_operator import operate
from fakes.plan_runs import ProductBench
from fakes.profiles import examples
from fakes.virtual_run import BY, VirtualRun
from hypothesis import given

from bt_orchestrator.extensions.opcua.mes.followed_jobs import FollowedJobs, News
from bt_orchestrator.model.events import ItemNonconforming, ItemRemoved
from bt_orchestrator.model.jobs.isa95 import JobWord, job_word
from bt_orchestrator.model.jobs.job_commands import AddJobs, UpdateJob
from bt_orchestrator.model.jobs.job_record import Counts
from bt_orchestrator.model.jobs.order import Job, Terms
from bt_orchestrator.model.status import JobStatus, ListedJob

RUN, HELD, SUSPENDED, ENDED = (
    JobWord.RUNNING,
    JobWord.HELD,
    JobWord.SUSPENDED,
    JobWord.ENDED,
)
QUEUED, NOT_ALLOWED = JobWord.ALLOWED_TO_START, JobWord.NOT_ALLOWED_TO_START
COUNTED = tuple(vars(Counts()))


class BookedRun(VirtualRun):
    """A run whose jobs are followed."""

    def __init__(self, *args: Any, **more: Any) -> None:
        self.followed = FollowedJobs()
        self.followed.begin()
        self.news: list[News] = []
        super().__init__(*args, **more)

    def _check(self) -> None:
        super()._check()
        for event in self.store.read(after=self.followed.seq):
            self.news += self.followed.follow(event)
        for job in (*self.state.jobs.values(), *self.state.ended.values()):
            booked = self.followed.get(job.job.id)
            assert booked is not None
            status = booked.status
            assert status.state is job_word(self.state, job)
            assert status.ending == (job.ending if job.ended_at is None else '')
            assert (status.started_at, status.ended_at) == (job.started_at, job.ended_at)
            assert booked.reason == job.end_reason
            if not job.started:
                assert status.awaits_start is job.awaits_start
                assert (status.held, status.unavailable) == (job.held, job.unavailable)
            of = (status.recipe, status.recipe_version)
            assert of == (job.recipe, job.recipe_version)
            counts = {name: getattr(status, name) for name in COUNTED}
            assert counts == {name: getattr(job.progress, name) for name in COUNTED}
        assert [listed.status.id for listed in self.followed.ended()] == list(self.state.ended)

    def told(self, job: str = 'J') -> list[JobWord]:
        """Return the states of a job that were told."""
        return [change.job.status.state for change in self.news if change.job.status.id == job]


def begin(line: Line, text: str = THREE, quantity: int = 2) -> BookedRun:
    run = BookedRun(line.cell, TYPES)
    run.submit('J', line.script(text), quantity)
    return run


def test_a_job_that_nothing_stops() -> None:
    run = begin(Line())
    run.go()
    assert run.told() == [QUEUED, RUN, ENDED]
    (last,) = run.news[-1:]
    assert (last.job.status.packed, last.job.status.started) == (2, 2)
    assert last.before is RUN


def test_a_job_that_was_cleared_unheard_is_forgotten() -> None:
    run = begin(Line())
    run.go()
    (ended,) = run.followed.ended()
    run.followed.take([ended])
    assert run.followed.ended() == [ended]
    run.followed.take([])
    assert run.followed.get('J') is None


def test_queued_jobs_are_held_released_changed_and_removed() -> None:
    line = Line()
    run = begin(line)
    run.add(('K', line.script(THREE)), held=True)
    for verb in ('release', 'hold', 'cancel'):
        run.control(verb, 'K')
    assert run.told('K') == [NOT_ALLOWED, QUEUED, NOT_ALLOWED]
    assert run.followed.get('K') is None
    run.go()


def test_order_change_is_reported_in_same_state() -> None:
    line = Line()
    run = begin(line)
    script = line.script(THREE)
    run.add(('K', script), held=True)
    assert run.ask(UpdateJob(Job('K', script, 7), BY)).accepted
    assert run.told('K') == [NOT_ALLOWED, NOT_ALLOWED]
    assert run.news[-1].job.status.quantity == 7
    run.go()


def paused_job(run: BookedRun) -> list[JobWord]:
    run.control('pause', 'J')
    run.go(until=run.now + 1)
    run.control('resume', 'J')
    return [SUSPENDED, RUN]


def paused_cell(run: BookedRun) -> list[JobWord]:
    run.pause()
    run.resume()
    return [SUSPENDED, RUN]


def paused_job_in_paused_cell(run: BookedRun) -> list[JobWord]:
    run.control('pause', 'J')
    run.pause()
    run.resume()
    run.control('resume', 'J')
    return [SUSPENDED, RUN]


def stopped_job(run: BookedRun) -> list[JobWord]:
    run.control('stop', 'J')
    return []


@pytest.mark.parametrize('what', [paused_job, paused_cell, paused_job_in_paused_cell, stopped_job])
def test_operator_commands_change_job_states(
    what: Callable[[BookedRun], list[JobWord]],
) -> None:
    run = begin(Line())
    run.go(until=0.5)
    between = what(run)
    run.go()
    assert run.told() == [QUEUED, RUN, *between, ENDED]


def test_failure_holds_job_and_answer_resumes_it() -> None:
    run = begin(Line(faults={'a2': '#1=abort'}))
    run.go()
    assert run.told() == [QUEUED, RUN, HELD]
    assert 'work' in run.news[-1].interrupted
    run.answer('retry')
    run.go()
    assert run.told() == [QUEUED, RUN, HELD, RUN, ENDED]
    assert run.news[-1].interrupted == ''


def test_items_that_fail_are_counted() -> None:
    text = with_section(2, '- {id: work, @a2, on_failure: continue}\n- {id: look, @b2}')
    run = begin(Line(faults={'a2': '#1=abort', 'b2': '#1=abort'}), text)
    run.go()
    run.answer('skip')
    run.go()
    job = run.followed.get('J')
    assert job is not None
    assert job.status.nonconforming == 1


def test_nonconforming_item_is_counted_once_on_removal() -> None:
    followed = FollowedJobs()
    followed.begin(listed=[ListedJob(JobStatus('J', 'small', JobWord.RUNNING, started_at=1.0))])
    for seq, task in enumerate(('weigh', 'look'), start=1):
        followed.follow(
            ItemNonconforming(seq=seq, job='J', item='J/1', task=task, reason='by eye it is good')
        )
    assert followed.get('J').status.nonconforming == 0  # type: ignore[union-attr]
    for seq, item in enumerate(('J/1', 'J/2'), start=3):
        followed.follow(ItemRemoved(seq=seq, job='J', item=item, section=3, how='packed'))
    job = followed.get('J')
    assert job is not None
    assert (job.status.packed, job.status.nonconforming, job.status.good) == (2, 1, 1)


def test_job_changes_update_booked_recipe() -> None:
    line = Line()
    run = begin(line, f'made_from: {{recipe: P-1, version: 1}}\n{THREE}')
    newer = line.script(f'made_from: {{recipe: P-1, version: 2}}\n{THREE}')
    assert run.release(newer).accepted
    run.add(('K', line.script(THREE)))
    assert run.ask(UpdateJob(Job('K', newer, 1), BY)).accepted
    booked = run.followed.get('K')
    assert booked is not None
    assert (booked.status.recipe, booked.status.recipe_version) == ('P-1', 2)
    run.go()


def test_an_aborted_job_drains() -> None:
    text = THREE.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    run = begin(Line(seconds={'a2': 5.0}), text)
    run.go(until=5.0)
    run.control('abort', 'J')
    run.go()
    assert run.told()[-1] is JobWord.ABORTED


def test_aborted_job_no_longer_awaits_start() -> None:
    line = Line()
    run = begin(line)
    early = Job('K', line.script(THREE), 1, {}, terms=Terms(start=1e5))
    assert run.ask(AddJobs((early,), BY)).accepted
    booked = run.followed.get('K')
    assert booked is not None
    assert booked.status.awaits_start
    assert run.control('abort', 'K').accepted
    booked = run.followed.get('K')
    assert booked is not None
    assert not booked.status.awaits_start
    run.go()


def test_a_book_that_begins_later_goes_on_alike() -> None:
    run = begin(Line(faults={'a2': '#2=abort'}), quantity=3)
    run.go(until=3.0)
    later = FollowedJobs()
    later.begin(run.sim.status())
    assert later.seq == run.followed.seq
    run.control('pause', 'J')
    run.control('resume', 'J')
    run.go()
    run.answer('retry')
    run.go()
    news = [change for event in run.store.read(after=0) for change in later.follow(event)]
    assert [change.job.status.state for change in news] == run.told()[-len(news) :]
    mine, theirs = later.get('J'), run.followed.get('J')
    assert mine is not None
    assert theirs is not None
    assert [getattr(mine.status, name) for name in COUNTED] == [
        getattr(theirs.status, name) for name in COUNTED
    ]


def test_what_was_heard_before_is_heard_once() -> None:
    run = begin(Line())
    run.go()
    assert not [change for event in run.store.read() for change in run.followed.follow(event)]


def test_followed_jobs_match_engine_on_generated_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plan_runs, 'VirtualRun', BookedRun)

    @examples(15, 1000)
    @given(lines())
    def holds(plan: Plan) -> None:
        operate(ProductBench(plan), plan.moments)

    holds()
