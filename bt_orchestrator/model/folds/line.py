"""How events about the line change the state: cycles, flags, the belt and the items on it."""

from __future__ import annotations

from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.counting import NONCONFORMING, kind_of
from bt_orchestrator.model.judging.rejects import count_item
from bt_orchestrator.model.state import CellState, Cycle, Finished, ItemState, JobState
from bt_orchestrator.model.task_spans import passed_tasks

# --- cycles, flags, the belt ----------------------------------------------------------------


def cycle_started(event: e.CycleStarted, state: CellState) -> None:
    job = state.jobs[event.job]
    if event.item not in state.items:
        job.progress.started += 1
        item = ItemState(event.item, event.job, job.progress.started)
        state.items[event.item] = job.items[event.item] = item
        count_item(state, item)
    state.items[event.item].open_cycles += 1
    state.sections[event.section].cycle = Cycle(event.job, event.item, event.beat)


def turn_completed(event: e.TurnCompleted, state: CellState) -> None:
    section = state.sections[event.section]
    assert section.cycle is not None
    section.turn_beat = section.cycle.beat


def cycle_completed(event: e.CycleCompleted, state: CellState) -> None:
    section = state.sections[event.section]
    assert section.cycle is not None
    tasks = passed_tasks(state, event.section, section.cycle)
    section.finished = Finished(event.job, event.item, section.cycle.beat, *tasks)
    section.cycle = None
    script = state.script(event.job)
    for task in script.sections[event.section].tasks:
        del state.tasks[e.TaskKey(event.job, event.section, event.item, task.id)]
    item = state.items[event.item]
    if event.section == script.last_before_sink and item.present and not item.rejected:
        state.jobs[event.job].progress.processed += 1
    item.open_cycles -= 1
    _forget_if_gone(state, item)


def flag_changed(event: e.FlagRaised | e.FlagLowered, state: CellState) -> None:
    state.flags[event.flag].count = event.count


def beat_started(event: e.BeatStarted, state: CellState) -> None:
    state.beat = event.beat


def belt_index_started(_: e.BeltIndexStarted, state: CellState) -> None:
    state.indexing = True


def belt_indexed(event: e.BeltIndexed, state: CellState) -> None:
    state.indexing = False
    state.beat = event.beat
    del state.tasks[e.INDEX_KEY]
    for section in state.sections.values():
        if section.finished is not None and section.finished.beat < event.beat:
            section.finished = None


# --- items ----------------------------------------------------------------------------------


def item_placed(event: e.ItemPlaced, state: CellState) -> None:
    _stand(state, event.item, event.section)
    state.items[event.item].lots = event.lots
    state.jobs[event.job].progress.placed += 1


def item_missing(event: e.ItemMissing, state: CellState) -> None:
    _stand(state, event.item, event.section)
    state.items[event.item].present = False
    state.jobs[event.job].progress.missing += 1
    _piece_left(state.jobs[event.job], event.item, 'missing')


def item_identified(event: e.ItemIdentified, state: CellState) -> None:
    state.items[event.item].serial = event.serial
    state.serials.add(event.serial)


def item_moved(event: e.ItemMoved, state: CellState) -> None:
    state.sections[state.items[event.item].section].slot = None
    _stand(state, event.item, event.section)


def item_rejected(event: e.ItemRejected, state: CellState) -> None:
    state.items[event.item].rejected = True


def item_nonconforming(event: e.ItemNonconforming, state: CellState) -> None:
    mark_nonconforming(state, event.item, event.task)


def mark_nonconforming(state: CellState, name: str, task: str) -> None:
    """Note that an item passed a task that was not done well for it."""
    state.items[name].nonconforming.append(task)


def item_removed(event: e.ItemRemoved, state: CellState) -> None:
    item = state.items[event.item]
    progress = state.jobs[event.job].progress
    _piece_left(state.jobs[event.job], event.item, event.how)
    if event.how == 'by_hand':
        item.present = False
        progress.missing += 1
        progress.removed += 1
        return
    if event.how == 'rejected':
        progress.rejected += 1
    else:
        progress.packed += 1
    kind = kind_of(event.how, is_nonconforming=bool(item.nonconforming))
    progress.nonconforming += kind == NONCONFORMING
    if event.section == state.script(event.job).sink:
        _leave(state, item)
        return
    item.present = False
    progress.processed += event.how == 'packed'


def _piece_left(job: JobState, item: str, how: str) -> None:
    """Note how the first piece that a job waits for has left the line (semantics 6.12)."""
    if job.piece == item:
        job.piece_left = how


def position_ended(event: e.PositionEnded, state: CellState) -> None:
    _leave(state, state.items[event.item])


def _stand(state: CellState, item: str, section: int) -> None:
    assert state.sections[section].slot is None, f'two items in slot {section}'
    state.sections[section].slot = item
    state.items[item].section = section


def _leave(state: CellState, item: ItemState) -> None:
    state.sections[item.section].slot = None
    item.section = 0
    item.gone = True
    _forget_if_gone(state, item)


def _forget_if_gone(state: CellState, item: ItemState) -> None:
    if item.gone and item.open_cycles == 0:
        del state.items[item.id]
        del state.jobs[item.job].items[item.id]
