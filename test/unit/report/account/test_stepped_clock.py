"""A clock that was set: periods reach over both times, and the report names the step."""

from __future__ import annotations

import pytest
from fakes.day import Day, at
from fakes.hand_made_shift import LINE, SCRIPT, to

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import digest
from bt_orchestrator.report.account.account import account, of_job, whole
from bt_orchestrator.report.account.period import Period
from bt_orchestrator.report.account.planned import us_of
from bt_orchestrator.report.reading import Reading

NODE = e.OrchestratorStarted(cell='test_line', digest=digest(LINE.cell))
LOADED = e.ScriptLoaded(script='test', digest=digest(SCRIPT), definition=SCRIPT)
QUEUED = e.JobQueued(job='J', script='test', digest=digest(SCRIPT), quantity=9)
DONE = e.JobCompleted(job='J')


def set_back() -> Reading:
    """Return a journal whose clock was set back by an hour while a job ran."""
    day = Day()
    day.note('18:03', NODE, LOADED, QUEUED, to('Execute'), e.JobStarted(job='J'))
    day.note('17:10', e.ClockStepped(seconds=-3600.0))
    day.note('17:14', DONE)
    return Reading(day.records())


@pytest.mark.parametrize('of', [lambda r: whole(r, 'j'), lambda r: of_job(r, 'J', 'j')])
def test_a_period_reaches_over_the_times_before_and_after_a_step(of: object) -> None:
    assert callable(of)
    period = of(set_back())
    assert isinstance(period, Period)
    assert (period.begin_us, period.end_us) == (us_of(at('17:10')), us_of(at('18:10')))


def test_a_report_names_the_step_and_does_not_blame_the_cell_file() -> None:
    reading = set_back()
    notes = account(reading, whole(reading, 'j'), LINE.cell).notes()
    (named,) = (
        note for note in notes if note.startswith('the clock was set back by 3600 s, from')
    )
    assert named.endswith('that time counts once, so the figures lack it')
    assert not any('cell file are too long' in note for note in notes)
