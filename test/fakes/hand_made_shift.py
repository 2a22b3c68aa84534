"""One shift with every loss, written by hand: what is lost is told in its test."""

from __future__ import annotations

from typing import Any

from fakes.day import Day, at
from fakes.line import Line, with_initialization

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import digest

SHIFTS = """
shifts:
  early: {from: 06:00, to: 14:00, breaks: [{from: 09:00, to: 09:30}]}
zone: UTC
"""
LINE = Line(seconds={'a2': 28.0})
SCRIPT = LINE.script(with_initialization('[{id: warm, @lamp}]'))


def task(kind: type[e.TaskEvent], task: str, item: str | None = 'J/1', **more: Any) -> e.Event:
    """Return an event of a task of section 2, or of initialization."""
    section = 2 if item else None
    return kind(job='J', section=section, item=item, task=task, **more)


def started(id_: str, component: str, attempt: int = 1, item: str | None = 'J/1') -> e.Event:
    more = {'name': 'TASK_A', 'action': f'/{component}/do', 'component': component}
    return task(e.TaskStarted, id_, item, attempt=attempt, goal='g', **more)


def succeeded(name: str, item: str | None = 'J/1', attempt: int = 1) -> e.Event:
    return task(e.TaskSucceeded, name, item, attempt=attempt, goal='g')


def to(state: str) -> e.Event:
    return e.CellStateChanged(state=state, previous='?')


def stopped(reason: str, words: str = '') -> e.Event:
    return e.StopReasonChanged(stop_reason=reason, reason=words)


def decided(answer: str, hold: str | None = None, reason: str = '') -> e.Event:
    return e.OperatorDecided(answer=answer, who='ann', reason=reason, hold=hold)


def out(number: int, how: str = 'packed') -> e.Event:
    return e.ItemRemoved(job='J', item=f'J/{number}', section=3, how=how)


def held_raised() -> e.Event:
    return e.HoldRaised(
        hold='1', job='J', section=2, item='J/1', task='work', name='TASK_A', component='a2',
        action='/a2/do', attempt=1, attempts=1, reason='aborted', message='jam',
    )  # fmt: skip


def the_day() -> Day:
    day = Day()
    day.note('05:50', e.OrchestratorStarted(cell='test_line', digest=digest(LINE.cell)))
    loaded = e.ScriptLoaded(script='test', digest=digest(SCRIPT), definition=SCRIPT)
    queued = e.JobQueued(job='J', script='test', digest=digest(SCRIPT), quantity=2000)
    day.note('06:10', loaded, queued, to('Resetting'), to('Idle'))
    day.note('06:15', to('Starting'), to('Execute'), e.JobStarted(job='J'))
    day.note('06:15', started('warm', 'lamp', item=None))
    day.note('06:20', succeeded('warm', None), started('work', 'a2'))
    # an item is out every 6 s from here to 07:00, all good; and so on below
    for number in range(1, 401):
        day.note(at('06:20') + 6 * number, out(number))
    failed = task(e.TaskFailed, 'work', attempt=1, goal='g', reason='aborted', message='jam')
    held = held_raised()
    day.note('07:00', failed, held, stopped('own_fault'), to('Holding'), to('Held'))
    day.note('07:10', decided('comment', '1', 'called the fitter'))
    day.note('07:20', decided('retry', '1', 'cleared the jam'), e.HoldReleased(hold='1'))
    day.note('07:20', stopped(''), to('Unholding'), to('Execute'), started('work', 'a2', 2))
    day.note('07:25', succeeded('work', attempt=2), started('more', 'a2'))
    paused = e.HoldRaised(hold='2', reason='paused', message='ann: lunch', owner='ann')
    day.note('08:00', decided('pause'), paused, stopped('operator'), to('Holding'))
    day.note('08:10', decided('resume', reason='back'), e.HoldReleased(hold='2'))
    day.note('08:10', stopped(''), to('Unholding'), to('Execute'))
    for number in range(401, 421):  # in the break: outside planned time
        day.note('09:10', out(number))
    for number in range(421, 427):
        day.note(
            '09:40', e.ItemNonconforming(job='J', item=f'J/{number}', task='work', reason='x')
        )
        day.note('09:40', out(number))
    for number in range(427, 437):
        day.note('09:50', e.ItemRejected(job='J', item=f'J/{number}', reason='x'))
        day.note('09:50', out(number, 'rejected'))
    unready = e.ComponentStateChanged(component='a1', ready=False, value='EMPTY')
    day.note('10:00', unready, succeeded('more'))
    day.note('10:00:01', stopped('starved', 'place of J/1 waits for /a1/state'), to('Suspended'))
    ready = e.ComponentStateChanged(component='a1', ready=True, value='READY')
    day.note('10:10:01', ready, stopped(''), to('Execute'), started('more', 'a2'))
    full = e.ComponentStateChanged(component='a3', ready=False, value='FULL')
    day.note('11:00', full, succeeded('more'))
    day.note('11:00:01', stopped('blocked', 'pack of J/1 waits for /a3/state'), to('Suspended'))
    empty = e.ComponentStateChanged(component='a3', ready=True, value='READY')
    day.note('11:05:01', empty, stopped(''), to('Execute'), started('more', 'a2'))
    day.note('11:10', out(437, 'by_hand'), out(438, 'by_hand'))
    for number in range(439, 539):
        day.note('11:20', out(number))
    day.note('12:00', decided('abort'), stopped('emergency', 'ann'), to('Aborting'))
    doubt = e.HoldRaised(
        hold='9', job='J', section=2, item='J/1', task='more', name='TASK_A', component='a2',
        attempt=1, attempts=1, reason='in_doubt', answers=('retry',),
    )  # fmt: skip
    aborted = task(e.TaskFailed, 'more', attempt=1, goal='g', reason='in_doubt')
    day.note('12:00', aborted, doubt, to('Aborted'))
    day.note('12:10', decided('clear'), e.HoldReleased(hold='9'))
    day.note('12:10', stopped('operator', 'the cell was stopped'), to('Clearing'), to('Stopped'))
    day.note('12:15', stopped(''), to('Resetting'), to('Idle'), to('Starting'), to('Execute'))
    day.note('12:15', started('more', 'a2'))
    day.note('13:00', e.JobHeld(job='Z'))
    day.note('13:10', e.OrchestratorStarted(cell='test_line', digest=digest(LINE.cell)))
    look = e.HoldRaised(hold='3', reason='restarted', message='1 job')
    day.note('13:10', look, stopped('own_fault', 'hold 3'), to('Holding'))
    day.note('13:12', decided('resume', '3', 'looked at it'), e.HoldReleased(hold='3'))
    day.note('13:12', stopped(''), to('Unholding'), to('Execute'))
    day.note('14:05', succeeded('more'), out(600))
    return day
