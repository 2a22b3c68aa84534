"""The list of alarms for the page: the last ones, with their words in each language."""

from __future__ import annotations

from itertools import islice
from typing import Any, NamedTuple

from bt_orchestrator.extensions.page.web.archive.archive import Look, each, event_of
from bt_orchestrator.extensions.page.web.wording import said_in_each
from bt_orchestrator.model.records import Wanted
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.alarms import FOLLOWED, Alarm, AlarmFold, alarm_plain, often

MOST = 200
"""Most alarms of one answer."""

MOST_RECORDS = 20_000
"""Records that are looked through; a longer journal has older alarms."""


class Choice(NamedTuple):
    """The alarms that a reader wants; empty: all."""

    kind: str = ''
    component: str = ''
    is_open: bool = False

    def has(self, alarm: Alarm) -> bool:
        """Tell whether an alarm is wanted."""
        return (
            self.kind in ('', alarm.kind.value)
            and self.component in ('', alarm.component)
            and not (self.is_open and alarm.cleared_us is not None)
        )


def alarms_page(look: Look, choice: Choice) -> dict[str, Any]:
    """Return the last alarms, the last first, and which came most."""
    wanted = Wanted(events=FOLLOWED, newest_first=True)
    records = list(islice(each(look, wanted), MOST_RECORDS))
    fold = AlarmFold(SteadyTime())
    for record in reversed(records):
        event = event_of(record)
        if event is not None:
            fold.follow(event)
    found = [alarm for alarm in fold.alarms if choice.has(alarm)]
    return {
        'alarms': [_plain(one, fold.now_us) for one in reversed(found[-MOST:])],
        'counts': [
            {'kind': one.kind, 'about': one.about, 'reason': one.reason, 'times': one.times}
            for one in often(found, fold.now_us)
        ],
        'is_cut': len(found) > MOST or len(records) == MOST_RECORDS,
        'damage': look.damage,
        'has_beginning': len(records) == MOST_RECORDS,
    }


def _plain(alarm: Alarm, now_us: int) -> dict[str, Any]:
    held = alarm.held
    message = alarm.words if held is None else held.message
    return {
        **alarm_plain(alarm, now_us),
        'said': said_in_each(message),
        'controller_said': '' if held is None else held.controller_said,
    }
