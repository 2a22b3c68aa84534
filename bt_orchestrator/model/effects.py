"""The effects of a task's end: flags, items, the belt (semantics 3.2, 4.1, 4.2).

Every function returns the events that follow, in order; nothing is changed here.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from bt_orchestrator.model import events as e
from bt_orchestrator.model.judging.results import lots_of, serial_in
from bt_orchestrator.model.script import Task
from bt_orchestrator.model.state import CellState, JobState, Phase
from bt_orchestrator.model.words import sentence


def of_success(state: CellState, key: e.TaskKey) -> Iterator[e.Event]:
    """Yield the effects of a task that succeeded, or that an operator marked done."""
    task = state.task(key)
    if task is None:
        yield from _of_index_move(state)
        return
    yield from _of_flags(state, key)
    if key.job is None or key.item is None or key.section is None:
        return
    yield from _identified(state, key.job, key.item, task)
    if task.qty_change == 1:
        lots = lots_of(state.jobs[key.job].job)
        yield e.ItemPlaced(job=key.job, item=key.item, section=key.section, lots=lots)
    elif task.qty_change == -1 and state.items[key.item].section == key.section:
        yield from _taken_out(state, key.job, key.item, key.section)


def _identified(state: CellState, job: str, item: str, task: Task) -> Iterator[e.Event]:
    """Give an item the serial that a task has read (semantics 6.8)."""
    known = state.items[item]
    serial = serial_in(task, known.results.get(task.id, {}))
    if serial and serial != known.serial:
        yield e.ItemIdentified(job=job, item=item, task=task.id, serial=serial)


def of_passing(state: CellState, key: e.TaskKey) -> Iterator[e.Event]:
    """Yield the effects of a task that was skipped, or failed and continued.

    As if it had run (semantics 4.2), but nothing was placed or taken out.
    """
    yield from _of_flags(state, key)
    task = state.task(key)
    if task is None or key.job is None or key.item is None or key.section is None:
        return
    item = state.items[key.item]
    if task.qty_change == 1:
        yield e.ItemMissing(job=key.job, item=key.item, section=key.section)
    elif task.qty_change == -1 and not item.present and item.section == key.section:
        yield from _ended_at_sink(state, key.job, key.item, key.section)


def of_abort(state: CellState, job: JobState, reason: str) -> Iterator[e.Event]:
    """Begin the abort of a job: its items are rejected, its goals cancelled (semantics 4.3)."""
    if job.aborting:
        return
    name = job.job.id
    yield e.JobAborting(job=name, reason=reason)
    for item in job.items.values():
        if item.present and not item.rejected and not item.gone:
            yield e.ItemRejected(job=name, item=item.id, reason=reason)
    running = [
        key for key, task in state.running.items() if key.job == name and task.cancel_cause is None
    ]
    yield from cancelled(state, running, 'abort_job')


def cancelled(
    state: CellState, keys: Iterable[e.TaskKey], cause: str
) -> Iterator[e.TaskCancelRequested]:
    """Cancel the goals of tasks that run."""
    for key in keys:
        goal = state.running[key].goal
        assert goal is not None
        yield e.TaskCancelRequested(**key._asdict(), goal=goal, cause=cause)


def cancelled_words(count: int) -> str:
    """Say how many goals are being cancelled."""
    return sentence('goal_cancelled' if count == 1 else 'goals_cancelled', count=count)


def why_skipped(state: CellState, key: e.TaskKey, task: Task) -> str | None:
    """Say why a task is not needed; None: it is.

    Conditions (6.5) are not asked here: they need the values of references.
    """
    if key.item is None:
        return _why_initialization_skipped(state, key)
    item = state.items[key.item]
    if not item.present:
        return 'empty position'
    if not task.runs_for.includes(item.rejected):
        return 'rejected item' if item.rejected else 'good item'
    if item.gone and task.qty_change == -1:
        return 'it was taken out before'  # as a good item, by the twin of this task
    return None


def _why_initialization_skipped(state: CellState, key: e.TaskKey) -> str | None:
    assert key.job is not None
    job = state.jobs[key.job]
    if job.aborting:
        return 'job aborted'
    # Items on the line may still need the initialization.
    return 'job stopped' if job.stopping and not job.items else None


def _of_flags(state: CellState, key: e.TaskKey) -> Iterator[e.Event]:
    if key.job is None:
        return
    script = state.script(key.job)
    for dependency in script.upstream_of.get(key.task, ()):
        count = state.flags[dependency.flag].count + 1
        yield e.FlagRaised(**key._asdict(), flag=dependency.flag, count=count)
    for dependency in script.downstream_of.get(key.task, ()):
        count = state.flags[dependency.flag].count - 1
        yield e.FlagLowered(**key._asdict(), flag=dependency.flag, count=count)


def _taken_out(state: CellState, job: str, item: str, section: int) -> Iterator[e.Event]:
    if not state.items[item].present:
        yield from _ended_at_sink(state, job, item, section)
        return
    how = 'rejected' if state.items[item].rejected else 'packed'
    yield e.ItemRemoved(job=job, item=item, section=section, how=how)


def _ended_at_sink(state: CellState, job: str, item: str, section: int) -> Iterator[e.Event]:
    """End an empty position, unless a later section has a `-1` too and is the sink."""
    if section == state.script(job).sink:
        yield e.PositionEnded(job=job, item=item, section=section)


def _of_index_move(state: CellState) -> Iterator[e.Event]:
    """Move every item, the last first: no slot ever holds two.

    Only an empty position can be in the last slot (semantics 3.6).
    """
    last = state.slot(state.cell.conveyor.sections)
    if last is not None:
        yield e.PositionEnded(job=last.job, item=last.id, section=last.section)
    standing = [n for n, section in state.sections.items() if section.slot is not None]
    for number in sorted(standing, reverse=True):
        item = state.slot(number)
        if item is not None and number < state.cell.conveyor.sections:
            yield e.ItemMoved(job=item.job, item=item.id, section=number + 1)
    yield e.BeltIndexed(beat=state.beat + 1)


def is_startable(state: CellState, key: e.TaskKey) -> bool:
    """Tell whether a task waits for its first or its next attempt."""
    return state.phase(key) in (None, Phase.RETRYING)
