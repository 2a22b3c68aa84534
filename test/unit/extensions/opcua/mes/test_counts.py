"""PackML's counters of items."""

from __future__ import annotations

from typing import Any

from fakes.statuses import job, status

from bt_orchestrator.extensions.opcua.mes.packml import Count, Counter
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.status import JobStatus


def of(name: str, packed: int, rejected: int = 0, **about: Any) -> JobStatus:
    plain: dict[str, Any] = {
        'started': packed + rejected,
        'packed': packed,
        'good': packed,
        'rejected': rejected,
    }
    return job(name, **{**plain, **about})


def test_each_job_on_the_line_has_a_count() -> None:
    counter = Counter()
    counter.show(status(jobs=[of('A', 8, 2), of('B', 0), of('C', 0, position=1)]))
    assert counter.counts == (Count('A', 10, 2), Count('B'))
    assert (counter.processed, counter.defective) == (10, 2)


def test_last_job_stays_on_idle_line() -> None:
    counter = Counter()
    ended = [of(name, 5, state=JobWord.ENDED) for name in ('A', 'B')]
    counter.show(status(jobs=[*ended]))
    assert counter.counts == (Count('B', 5),)


def test_without_any_job_there_is_one_empty_count() -> None:
    counter = Counter()
    counter.show(status(jobs=[]))
    assert counter.counts == (Count(''),)


def test_total_never_falls_when_jobs_leave() -> None:
    counter = Counter()
    counter.show(status(jobs=[of('A', 5, state=JobWord.ENDED), of('B', 2)]))
    counter.show(status(jobs=[of('B', 3, 1), of('C', 1)]))
    assert (counter.processed, counter.defective) == (5 + 4 + 1, 1)


def test_what_is_not_good_is_defective() -> None:
    counter = Counter()
    counter.show(status(jobs=[of('A', 8, 2, good=7, nonconforming=1, missing=3, by_hand=1)]))
    assert counter.counts == (Count('A', 11, 4),)
