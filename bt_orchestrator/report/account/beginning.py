"""Where an account of a period begins: at the state of the cell that the events before it left."""

from __future__ import annotations

from bt_orchestrator.model.records import Wanted
from bt_orchestrator.report.account.fold import FOLLOWED, AccountFold
from bt_orchestrator.report.account.period import Period
from bt_orchestrator.report.account.planned import US, us_of
from bt_orchestrator.report.reading import Reading


def fold_at(reading: Reading, period: Period) -> tuple[AccountFold, Wanted]:
    """Return a fold that has taken in all before a period, and what it has to read from there.

    Where the clock was set back, events of before the period may be among those.
    """
    end = period.end_us + 0.5  # a time that is rounded to the end is in it
    wanted = Wanted(events=FOLLOWED, until=end / US)
    is_whole = reading.records.extent().first_seq == 1
    fold = AccountFold(period.planned, is_whole=is_whole)
    for event in reading.events(wanted):
        if us_of(event.time) >= period.begin_us:
            break
        fold.follow(event)
        wanted = wanted.past(event.seq)
    return fold, wanted
