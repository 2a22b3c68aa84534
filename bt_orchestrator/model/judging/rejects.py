"""Runs of rejects: too many rejects among items that were begun one after the other (7.7)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import HoldAfter
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.judging.results import with_bounds
from bt_orchestrator.model.limits import listed
from bt_orchestrator.model.packml import VERBS, Cause
from bt_orchestrator.model.state import CellState, ItemState, Reject, RejectCount
from bt_orchestrator.model.stop_reason import TOO_MANY_REJECTS
from bt_orchestrator.model.words import AND, sentence

_OF_CELL = ''
"""Name of the count of all scripts without a limit of their own."""


def count_item(state: CellState, item: ItemState) -> None:
    """Give an item that begins its number among those that are counted with it."""
    limit = _limit(state, item.job)
    if limit is not None:
        count = state.reject_counts.setdefault(_name(state, item.job), RejectCount())
        count.begun += 1
        item.counted = count.begun


def count_reject(state: CellState, key: e.TaskKey) -> None:
    """Count the item that a task has just rejected, once; not one that its job's abort rejects."""
    assert key.job is not None
    assert key.item is not None
    item, limit = state.items[key.item], _limit(state, key.job)
    if not item.counted or limit is None or state.jobs[key.job].aborting:
        return
    count = state.reject_counts[_name(state, key.job)]
    reach = limit.of + 2 * state.cell.conveyor.sections  # no item on the line is further back
    kept = [reject for reject in count.rejects if reject.number > count.begun - reach]
    count.rejects = [*kept, Reject(item.counted, item.id, dict(_facts(state, key)))]
    item.counted = 0


def note_hold(state: CellState, job: str, hold: str) -> None:
    """Note that the count of a job's items has raised a hold."""
    state.reject_counts[_name(state, job)].hold = hold


def forget_rejects(state: CellState, hold: str) -> None:
    """Begin a count anew: its hold was released."""
    for count in state.reject_counts.values():
        if count.hold == hold:
            count.hold, count.rejects = None, []


def hold_of_run(state: CellState, key: e.TaskKey) -> Iterator[e.HoldRaised]:
    """Hold the line if the reject of a task has completed a run."""
    assert key.job is not None
    limit, count = _limit(state, key.job), state.reject_counts.get(_name(state, key.job))
    if limit is None or count is None or count.hold is not None:
        return
    run = _run(count.rejects, limit)
    if run:
        yield e.HoldRaised(
            hold=state.next_hold,
            job=key.job,
            reason=TOO_MANY_REJECTS,
            message=_message(run, limit),
            answers=(VERBS[Cause.UNHOLD],),
            items=tuple(reject.item for reject in run),
        )


def _limit(state: CellState, job: str) -> HoldAfter | None:
    return state.script(job).hold_after or state.cell.hold_after


def _name(state: CellState, job: str) -> str:
    script = state.script(job)
    return _OF_CELL if script.hold_after is None else script.name


def _run(rejects: Sequence[Reject], limit: HoldAfter) -> Sequence[Reject]:
    """Return the first run of rejects, in the order of the line; empty: there is none."""
    ordered = sorted(rejects, key=lambda reject: reject.number)
    for place, first in enumerate(ordered):
        run = [reject for reject in ordered[place:] if reject.number < first.number + limit.of]
        if len(run) >= limit.rejects:
            return run
    return ()


# What the rejects of a run have in common.

_FACTS = ('task', 'component', 'reason', 'product', 'job')
_LOT = 'lot '


def _facts(state: CellState, key: e.TaskKey) -> Iterator[tuple[str, str]]:
    task, failed = state.task(key), state.tasks[key]
    assert task is not None
    assert key.job is not None
    assert key.item is not None
    yield 'task', task.id
    yield 'component', task.component
    if failed.reason is not None:
        yield 'reason', failed.reason.value
    if failed.reason is Reason.RESULT_REFUSED and task.fails_unless is not None:
        yield 'verdict', with_bounds(task.fails_unless, state.scope(key)).words
    yield 'product', state.script(key.job).name
    yield 'job', key.job
    for name, lot in state.items[key.item].lots.items():
        yield f'{_LOT}{name}', lot


def _message(run: Sequence[Reject], limit: HoldAfter) -> str:
    items = listed([reject.item for reject in run], '')
    words = [sentence('rejects', count=len(run), of=limit.of, items=items)]
    return AND.join([*words, *_in_common([reject.facts for reject in run])])


def _in_common(facts: Sequence[Mapping[str, str]]) -> Iterator[str]:
    first = facts[0]
    common = {name for name in first if all(reject.get(name) == first[name] for reject in facts)}
    if 'task' not in common:
        tasks = listed(list(dict.fromkeys(reject['task'] for reject in facts)), '')
        yield sentence('rejects_tasks', tasks=tasks)
    for name in (name for name in _FACTS if name in common):
        yield sentence(f'rejects_{name}', **{name: first[name]})
    for name in (name for name in first if name in common and name.startswith(_LOT)):
        yield sentence('rejects_lot', name=name.removeprefix(_LOT), lot=first[name])
    if 'verdict' in common:
        yield sentence('rejects_verdict', wanted=first['verdict'])
