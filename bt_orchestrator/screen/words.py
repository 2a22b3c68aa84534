"""How a cell stands, in words: what `status` prints, `watch` shows, and an operator types.

Everything here reads a status (bt_orchestrator_interfaces/msg/Status) or a part of it, and returns
text of one line without control characters, whatever a controller wrote into its messages.
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime
from typing import Any

from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.screen.advice import Shell, hold_advice, next_lines

BAD_COUNTS = ('rejected', 'missing', 'nonconforming')
"""Counts of a job that are shown only when there are any."""


def one_line(text: str) -> str:
    """Return a text without line ends and without what would steer a terminal."""
    return ''.join(c if c.isprintable() else '\ufffd' for c in ' '.join(text.split()))


def status_lines(status: Any, shell: Shell) -> Iterator[str]:
    """Yield a whole status as text."""
    since = f'{status.state} for {duration(state_s(status))}'
    yield f'cell {one_line(status.cell)}: {since}, belt {belt(status)}, seq {status.seq}'
    if failure(status):
        yield f'  {failure(status)}'
    if status.stop_after:
        yield f'  the cell stops after the current {status.stop_after}'
    if status.stopped_with:
        yield f'  {stopped(status)}'
    if status.stop_reason:
        yield f'  stands still: {status.stop_reason}, {one_line(status.stop_message)}'
    for job in status.jobs:
        told = f'{job.state}, {job_counts(job)}{job_terms(job)}{expected_finish(job, status)}'
        yield f'  {job_name(job)}: {told}'
    if unlisted(status):
        yield f'  {unlisted(status)} more jobs in the queue: {shell.command("queue")}'
    for reason in status.initialization_waiting:
        yield f'  initialization  {one_line(reason)}'
    for section in status.sections:
        yield f'  section {section.section:<3} {slot(section) or "-":<14} {_work(section)}'
    yield from (f'  {text}' for text in troubles(status))
    for flag in status.flags:
        yield f'  flag {flag_count(flag)}'
    for hold in status.holds:
        yield f'  {hold_text(hold)}'
        yield from (f'    {text}' for text in hold_advice(hold, shell))
    yield from (f'  next: {text}' for text in next_lines(status, shell))


def unlisted(status: Any) -> int:
    """Return how many jobs of the queue a status does not list."""
    return int(status.queued) - sum(1 for job in status.jobs if job.position)


def stopped(status: Any) -> str:
    """Say who wants the cell to stand, and what lets it work again; nothing if nobody does."""
    if not status.stopped_with:
        return ''
    who, why = one_line(status.stopped_by) or 'an operator', one_line(status.stopped_why)
    since = status.stopped_at.sec
    at = f' at {datetime.fromtimestamp(since):%H:%M:%S}' if since else ''
    said = f'{who} said {status.stopped_with.replace("_", " ")}{at}{f": {why}" if why else ""}'
    return f'{said}; orders wait for {status.waits_for or "a start after that"}'


def failure(status: Any) -> str:
    """Say that the cell does nothing, any more or for now, and why; nothing if all is well."""
    if status.journal_failure:
        return f'NOTHING IS DONE ANY MORE: {one_line(status.journal_failure)}'
    return f'WAITS FOR THE DISK: {one_line(status.disk_wait)}' if status.disk_wait else ''


def state_s(status: Any) -> float:
    """Return for how many seconds the cell has been in its state."""
    since, now = status.state_since, status.stamp
    passed: float = now.sec - since.sec + (now.nanosec - since.nanosec) * 1e-9
    return max(0.0, passed)


def belt(status: Any) -> str:
    """Say whether the belt moves."""
    return 'moving' if status.belt_moving else 'at rest'


def job_name(job: Any) -> str:
    """Return a job with its script."""
    return f'{one_line(job.id)} ({one_line(job.script)})'


def job_counts(job: Any) -> str:
    """Return how far a job is, good and bad."""
    bad = [f'{getattr(job, name)} {name}' for name in BAD_COUNTS if getattr(job, name)]
    return ', '.join([f'{job.packed} of {job.quantity} packed', *bad])


def job_terms(job: Any) -> str:
    """Say how urgent a job is and when it is wanted, in the reader's time zone, if that is set."""
    told = [f', priority {job.priority}'] if job.priority else []
    for name in ('start', 'due'):
        seconds = getattr(job, name).sec
        if seconds:
            told.append(f', {name} {datetime.fromtimestamp(seconds):%Y-%m-%d %H:%M}')
    return ''.join(told)


def expected_finish(job: Any, status: Any) -> str:
    """Say when a job is expected to end, in the reader's time zone; nothing if it is not known."""
    if job.expected_end_s < 0.0:
        return ''
    end = datetime.fromtimestamp(status.stamp.sec + job.expected_end_s)
    return f', expected finish {end:%H:%M:%S} ({_from_now(job.expected_end_s)})'


def _from_now(seconds: float) -> str:
    if seconds < 1.0:
        return 'any moment'
    if seconds < 100.0:
        return f'in {seconds:.0f} s'
    minutes = round(seconds / 60)
    return f'in {minutes} min' if minutes < 100 else f'in {minutes / 60:.1f} h'


def fate(section: Any) -> str:
    """Say what is wrong with the item in a slot; nothing if it is good, or there is none."""
    words = ['rejected'] if section.slot_rejected else []
    if section.slot_nonconforming:
        tasks = ', '.join(map(one_line, section.slot_nonconforming))
        words.append(f'nonconforming ({tasks})')
    return ', '.join(words)


def slot(section: Any) -> str:
    """Return what the belt carries at a section; the place of an absent item in brackets."""
    name = one_line(section.slot)
    return f'({name})' if section.slot_empty_position else name


def task(running: Any) -> str:
    """Return a task that has a goal in flight."""
    again = f', attempt {running.attempt}' if running.attempt > 1 else ''
    named = one_line(running.id)
    if one_line(running.name) not in named:
        named = f'{named} {one_line(running.name)}'
    return f'{named}{again} at {one_line(running.action)}'


def _work(section: Any) -> str:
    reasons = [one_line(reason) for reason in section.waiting]
    return '; '.join(filter(None, [fate(section), *map(task, section.running), *reasons]))


def flag_count(flag: Any) -> str:
    """Return where the counter of a flag stands."""
    return f'{one_line(flag.name)}: {flag.count} of {flag.capacity}'


def troubles(status: Any) -> list[str]:
    """Return every component that can be sent nothing."""
    return [text for text in map(trouble, status.components) if text]


def trouble(component: Any) -> str:
    """Say why a component can be sent nothing; nothing if it can."""
    name = one_line(component.name)
    if not component.available:
        return f'{name}: no action server at {one_line(component.action)}'
    if component.contested:
        return f'{name}: {one_line(component.contested)}'
    if not component.ready:
        state = f'its state is {one_line(component.state)}' if component.state else 'no state yet'
        return f'{name}: not ready, {state}'
    return ''


def hold_text(hold: Any) -> str:
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
