"""How a cell stands, in words: what `status` prints, `watch` shows, and an operator types.

Everything here reads a status or a part of it, and returns text of one line without control
characters, whatever a controller wrote into its messages.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from datetime import datetime

from bt_orchestrator.model.by import Control
from bt_orchestrator.model.hold_words import again_words, hold_words
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.jobs.needs import on_the_line_words
from bt_orchestrator.model.packml import UnitMode
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import (
    CellStatus,
    ComponentStatus,
    FlagStatus,
    ItemStatus,
    JobStatus,
    Leadership,
    SectionStatus,
    StandbyStatus,
    TaskStatus,
)
from bt_orchestrator.model.status_words import (
    component_trouble,
    job_count_words,
    script_words,
    wait_words,
)
from bt_orchestrator.model.texts import one_line
from bt_orchestrator.model.wait import StandCause, Wait
from bt_orchestrator.view.screen.advice import WHY, Shell, alike_lines, hold_advice, next_lines


def status_lines(status: CellStatus, shell: Shell | None) -> Iterator[str]:
    """Yield a whole status as text.

    :param shell: for what can be typed; None: nothing can, as it is long past
    """
    yield from _cell_lines(status)
    yield from _job_lines(status, shell)
    for reason in reasons(status.initialization):
        yield f'  initialization  {reason}'
    for section in status.sections:
        yield f'  section {section.number:<3} {slot(section.slot) or "-":<14} {_work(section)}'
    yield from (f'  {text}' for text in troubles(status))
    for flag in status.flags:
        yield f'  flag {flag_count(flag)}'
    for component in status.components:
        if component.setups:
            yield f'  setup of {component.name}: {setup_words(component)}'
    for hold in status.holds:
        yield f'  {hold_text(hold)}'
        yield from (f'    {text}' for text in advice(hold, status, shell))
    yield from (f'  alike: {text}' for text in (alike_lines(status, shell) if shell else ()))
    yield from (f'  next: {text}' for text in (next_lines(status, shell) if shell else ()))


def advice(hold: Hold, status: CellStatus, shell: Shell | None) -> list[str]:
    """Return what the reader of a status can type about a hold, and what others may answer."""
    return hold_advice(hold, shell, status.unauthenticated_role) if shell else []


def _cell_lines(status: CellStatus) -> Iterator[str]:
    """Yield how the cell stands, and what it waits for."""
    since = f'{status.state.value} for {duration(state_s(status))}'
    yield f'cell {one_line(status.cell)}: {since}, belt {belt(status)}, seq {status.seq}'
    if failure(status):
        yield f'  {failure(status)}'
    if status.leadership:
        yield from (f'  {text}' for text in leadership_words(status.leadership))
    if in_local(status):
        yield f'  {in_local(status)}'
    if status.unauthenticated_role and status.signed_commands != 'required':
        role = status.unauthenticated_role.value
        yield f'  commands over ROS are unauthenticated: everybody there has the role {role}'
    if status.safety not in ('', 'ready'):
        yield f'  safety input not ready: {one_line(status.safety)}'
    if status.stop_after:
        yield f'  the cell stops after the current {status.stop_after}'
    if status.wish:
        yield f'  {stopped(status)}'
    if status.stop_reason:
        yield f'  stands still: {status.stop_reason.value}, {one_line(status.stop_message)}'
    if stands(status):
        yield f'  {stands(status)}'


def _job_lines(status: CellStatus, shell: Shell | None) -> Iterator[str]:
    """Yield each job, and what it needs before it can go on."""
    for job in status.jobs:
        how_far = f'{job_count_words(job)}{job_terms(job)}{expected_finish(job, status)}'
        yield f'  {job_name(job)}: {job.state.state}{ending(job)}, {how_far}'
        if shell and job.awaits_release:
            release = shell.command(f'release-script {job.digest} {WHY}')
            yield f'    an engineer releases it: {release}'
        if shell and job.unavailable and job.started_at is not None:
            waits = on_the_line_words(
                job.id, job.unavailable, is_by_recipe=job.by_recipe, to_begin=job.to_begin
            )
            yield f'    {one_line(waits)}'
    if unlisted(status):
        where = f': {shell.command("queue")}' if shell else ''
        yield f'  {unlisted(status)} more jobs in the queue{where}'


def in_local(status: CellStatus) -> str:
    """Say that only panels move the line, or what runs there by hand; nothing in remote."""
    if status.unit_mode is UnitMode.MANUAL:
        goal = status.manual
        how = f': {goal.task} at {goal.component}, {goal.state}' if goal is not None else ''
        return f'in manual mode{one_line(how)}'
    is_local = status.control is Control.LOCAL
    return 'in local: only the panels of the line move it' if is_local else ''


def unlisted(status: CellStatus) -> int:
    """Return how many jobs of the queue a status does not list."""
    return status.queued - sum(1 for job in status.jobs if job.position)


def stopped(status: CellStatus) -> str:
    """Say who stopped the cell, and what lets it work again; nothing if it was not stopped."""
    wish = status.wish
    if wish is None:
        return ''
    at = f'{datetime.fromtimestamp(wish.time):%H:%M:%S}' if wish.time else ''
    text = one_line(wish.words(at))
    return f'{text}; orders wait for {status.waits_for or "a start after that"}'


def stands(status: CellStatus) -> str:
    """Say why nothing moves, where no hold, wish or failure of the same status says it."""
    standstill = status.stands
    if (
        standstill is None
        or standstill.cause in _SAID
        or (status.wish and standstill.cause is _COMMAND)
    ):
        return ''
    since = f'{datetime.fromtimestamp(standstill.since):%H:%M:%S}'
    return f'nothing moves since {since}: {one_line(standstill.reason)}'


_COMMAND = StandCause.COMMAND
_SAID = (StandCause.HOLD, StandCause.JOURNAL, StandCause.ORDER)
"""Causes that other lines tell, and the one that is no trouble."""


def failure(status: CellStatus) -> str:
    """Say that the cell does nothing, any more or for now, and why; nothing if all is well."""
    if status.journal_failure:
        return f'NOTHING IS DONE ANY MORE: {one_line(status.journal_failure)}'
    return f'WAITS FOR THE DISK: {one_line(status.disk_wait)}' if status.disk_wait else ''


def state_s(status: CellStatus) -> float:
    """Return for how many seconds the cell has been in its state."""
    return max(0.0, status.stamp - status.state_since)


def belt(status: CellStatus) -> str:
    """Say whether the belt moves."""
    return 'moving' if status.belt.moving else 'at rest'


def job_name(job: JobStatus) -> str:
    """Return a job with its script."""
    return f'{one_line(job.id)} ({one_line(script_words(job))})'


def ending(job: JobStatus) -> str:
    """Say that a job is stopping or aborting: it ends when its last item has left."""
    return f', {job.ending}' if job.ending else ''


def job_terms(job: JobStatus) -> str:
    """Say how urgent a job is and when it is wanted, in the reader's time zone, if that is set."""
    terms = [f', priority {job.priority}'] if job.priority else []
    if job.start is not None:
        terms.append(start_wait(job) or f', start {_moment(job.start)}')
    if job.due is not None:
        terms.append(f', due {_moment(job.due)}')
    return ''.join([*terms, of_its_making(job), lacks(job), piece_wait(job)])


def of_its_making(job: JobStatus) -> str:
    """Say whose rest a job is, and why and at what pace it was made anew, while it matters."""
    if job.state in OVER:
        return ''
    parts = [f', rest of {one_line(job.rest_of)}'] if job.rest_of else []
    if job.anew is not None:
        parts.append(f', {one_line(job.anew.words)}')
    return ''.join(parts)


def lacks(job: JobStatus) -> str:
    """Say that a script is not released, and which components out of service a job needs."""
    parts = [', its script is not released'] if job.awaits_release else []
    if job.unavailable:
        parts.append(f', needs {" and ".join(job.unavailable)}, out of service')
    return ''.join(parts)


def start_wait(job: JobStatus) -> str:
    """Say until when a job waits for its start (semantics 6.7); nothing if it does not."""
    if not job.awaits_start or job.start is None:
        return ''
    return f', waits for its start {_moment(job.start)}'


def piece_wait(job: JobStatus) -> str:
    """Say that a job waits for the approval of its first piece (semantics 6.12)."""
    if not job.awaited_piece or job.state in OVER:
        return ''
    left = job.first_piece_state or 'still on the line'
    return f', waits for the approval of {one_line(job.awaited_piece)} ({left})'


def _moment(seconds: float) -> str:
    return f'{datetime.fromtimestamp(seconds):%Y-%m-%d %H:%M}'


def expected_finish(job: JobStatus, status: CellStatus) -> str:
    """Say when a job is expected to end, in the reader's time zone, or why that is unknown."""
    if job.expected_end_s is None:
        return _unknown_end(job, status)
    end = datetime.fromtimestamp(status.stamp + job.expected_end_s)
    return f', expected finish {end:%H:%M:%S} ({_from_now(job.expected_end_s)})'


def _unknown_end(job: JobStatus, status: CellStatus) -> str:
    """Say that the end of a job on the line cannot be known; the reason if no line has it."""
    is_told = status.holds or status.wish or job.position
    if is_told or not job.end_unknown:
        return ''
    is_same = status.stands is not None and status.stands.reason == job.end_unknown
    return ', end unknown' if is_same else f', end unknown: {one_line(job.end_unknown)}'


def _from_now(seconds: float) -> str:
    if seconds < 1.0:
        return 'any moment'
    if seconds < 100.0:
        return f'in {seconds:.0f} s'
    minutes = round(seconds / 60)
    return f'in {minutes} min' if minutes < 100 else f'in {minutes / 60:.1f} h'


def fate(item: ItemStatus | None) -> str:
    """Say what is wrong with the item in a slot; nothing if it is good, or there is none."""
    if item is None:
        return ''
    words = ['rejected'] if item.rejected else []
    if item.nonconforming:
        tasks = ', '.join(map(one_line, item.nonconforming))
        words.append(f'nonconforming ({tasks})')
    return ', '.join(words)


def slot(item: ItemStatus | None) -> str:
    """Return what the belt carries at a section; the place of an absent item in brackets."""
    if item is None:
        return ''
    name = one_line(item.id)
    return name if item.present else f'({name})'


def task(running: TaskStatus) -> str:
    """Return a task that has a goal in flight."""
    named = one_line(running.id)
    if one_line(running.name) not in named:
        named = f'{named} {one_line(running.name)}'
    words = filter(None, (named, again_words(running.round, running.attempt)))
    return f'{", ".join(words)} at {one_line(running.action)}'


def _work(section: SectionStatus) -> str:
    parts = (fate(section.slot), *map(task, section.running), finished(section))
    return '; '.join(filter(None, (*parts, *reasons(section.waits))))


def finished(section: SectionStatus) -> str:
    """Say with which item a section is done in this beat, and which of its tasks failed."""
    if section.finished is None:
        return ''
    failed = ', '.join(map(one_line, section.finished.failed))
    return f'done with {one_line(section.finished.item)}{f" ({failed} failed)" if failed else ""}'


def reasons(waits: Iterable[Wait]) -> list[str]:
    """Return for what something waits, each sentence once."""
    return list(map(one_line, wait_words(waits)))


def flag_count(flag: FlagStatus) -> str:
    """Return where the counter of a flag stands."""
    return f'{one_line(flag.name)}: {flag.count} of {flag.capacity}'


def setup_words(component: ComponentStatus) -> str:
    """Name the setups of a component with their values."""
    named = (f'{name} {value or "not known"}' for name, value in component.setups.items())
    return ', '.join(named)


def troubles(status: CellStatus) -> list[str]:
    """Return every component that can be sent nothing, and every standby that is of no use."""
    texts = [text for text in map(trouble, status.components) if text]
    standbys = status.leadership.standbys if status.leadership else ()
    return texts + [standby_words(standby) for standby in standbys if standby.trouble]


def leadership_words(leadership: Leadership) -> Iterator[str]:
    """Yield the node that leads, and the standbys that could take over."""
    process = f'process {leadership.process}'
    yield one_line(f'led by {leadership.host}, {process}, epoch {leadership.epoch}')
    if not leadership.standbys:
        yield 'no standby was heard'
    yield from (standby_words(standby) for standby in leadership.standbys if not standby.trouble)


def standby_words(standby: StandbyStatus) -> str:
    """Say where a standby is, and whether it could take over."""
    could = f'cannot take over: {standby.trouble}' if standby.trouble else 'can take over'
    return one_line(f'standby {standby.host}, process {standby.process}: {could}')


def trouble(component: ComponentStatus) -> str:
    """Say why a component can be sent nothing; nothing if it can."""
    return one_line(component_trouble(component))


def hold_text(hold: Hold) -> str:
    """Say what is held, where, and why."""
    return one_line(f'hold {hold.id}: {hold_words(hold)}')


def duration(seconds: float) -> str:
    """Return how long something takes or took, in at most 8 characters up to 100 hours."""
    if seconds < 100:
        return f'{seconds:.1f} s'
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f'{hours}:{minutes:02}:{rest:02}' if hours else f'{minutes}:{rest:02}'


def silence(node: str, silent_s: float) -> str:
    """Say that nothing is heard of a node."""
    return f'no news from {node} for {duration(silent_s)}; showing what was last heard'
