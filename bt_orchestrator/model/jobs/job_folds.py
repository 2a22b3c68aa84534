"""How the events of jobs and of the queue change the state; part of `model.fold`."""

from __future__ import annotations

from collections.abc import Callable

from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.initialization import Preparation
from bt_orchestrator.model.jobs.order import Job, Terms
from bt_orchestrator.model.limits import ENDED_KEPT, RELEASED_KEPT
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState, FlagState, JobState, Phase
from bt_orchestrator.model.stop_reason import STOP_AFTER, Wish


def script_loaded(event: e.ScriptLoaded, state: CellState) -> None:
    """Keep the script as long as a live job names it."""
    state.scripts[event.digest] = event.definition
    state.preparations[event.digest] = Preparation(event.definition, state.cell)


# --- the queue ------------------------------------------------------------------------------


def job_queued(event: e.JobQueued, state: CellState) -> None:
    """Put a new job into the queue."""
    script = state.scripts[event.digest]
    job = _job_of(event, script)
    _begin_flags(state, script)
    queued = JobState(
        job,
        event.digest,
        recipe=event.recipe,
        recipe_version=event.recipe_version,
        rest_of=event.rest_of,
        anew=event.anew,
        queued_at=event.time,
        held=event.held,
        awaits_start=event.awaits_start,
        awaits_release=event.awaits_release,
        unavailable=event.unavailable,
        ranked=event.ranked,
        wants_piece=event.first_piece or script.first_piece,
    )
    state.jobs.add(queued, event.position)
    state.order_ids.add(event.job)
    _note_recipe(event, state)
    _keep_released(state, queued)
    note_work(state, queued)


def job_moved(event: e.JobMoved, state: CellState) -> None:
    """Put a queued job at another place, where no other one overtakes it (semantics 6.7)."""
    state.jobs.move(event.job, event.position)


def queue_arranged(event: e.QueueArranged, state: CellState) -> None:
    """Put the first jobs of the queue into another order; how they are compared stays."""
    state.jobs.arrange(event.jobs)


def job_updated(event: e.JobUpdated, state: CellState) -> None:
    """Replace a queued job, as if it had been queued that way."""
    script, live = state.scripts[event.digest], state.jobs.queued(event.job)
    before = live.digest
    _forget_initialization(state, live)
    with state.jobs.changing(event.job) as changed:
        _begin_flags(state, script)
        changed.job = _job_of(event, script)
        changed.digest = event.digest
        changed.recipe, changed.recipe_version = event.recipe, event.recipe_version
        changed.anew = event.anew
        changed.wants_piece = event.first_piece or script.first_piece
        changed.awaits_start = event.awaits_start
        changed.awaits_release = event.awaits_release
        changed.unavailable = event.unavailable
    if event.position is not None:
        state.jobs.move(event.job, event.position, ranked=True)
    _forget_unused(state, before)
    _note_recipe(event, state)
    changed = state.jobs.queued(event.job)
    _keep_released(state, changed)
    note_work(state, changed)


def job_held(event: e.JobHeld, state: CellState) -> None:
    """Let later jobs pass."""
    state.jobs.hold(event.job, held=True)


def job_released(event: e.JobReleased, state: CellState) -> None:
    """Let it start in its turn; for the cell this is like a new order."""
    state.jobs.hold(event.job, held=False)
    note_work(state, state.jobs.queued(event.job))


def job_may_start(event: e.JobMayStart, state: CellState) -> None:
    """Let it start in its turn, unless it is held."""
    state.jobs.allow_start(event.job)
    note_work(state, state.jobs.queued(event.job))


def script_released(event: e.ScriptReleased, state: CellState) -> None:
    """Let the jobs of a script start; for the cell they are like new orders."""
    cells = state.released.get(event.digest, ())
    if event.cell_digest not in cells:
        state.released[event.digest] = (*cells, event.cell_digest)
    for job in state.queue:
        if job.unreleased == event.digest:
            state.jobs.release_script(job.job.id)
            _keep_released(state, job)
            note_work(state, state.jobs.queued(job.job.id))


def job_removed(event: e.JobRemoved, state: CellState) -> None:
    """Forget a job that has not started, except its id."""
    removed = state.jobs.queued(event.job)
    state.jobs.remove(event.job)
    _forget_initialization(state, removed)
    _forget_unused(state, removed.digest)


def queue_stop_requested(event: e.QueueStopRequested, state: CellState) -> None:
    """Let the line run empty."""
    state.stop_after = event.after


def queue_stop_cancelled(_: e.QueueStopCancelled, state: CellState) -> None:
    """Let the line go on."""
    state.stop_after = state.stop_after_by = None


def queue_stop_reached(event: e.QueueStopReached, state: CellState) -> None:
    """Let the line go on when an operator starts the cell again."""
    wish = state.stop_after_by or Wish(STOP_AFTER + event.after)
    state.stopped_by = state.stopped_by or wish
    state.stop_after = state.stop_after_by = None


# --- jobs on the line -----------------------------------------------------------------------


def job_started(event: e.JobStarted, state: CellState) -> None:
    """Take a job out of the queue, behind those on the line; held ones in front stay queued."""
    state.jobs.start(event.job, event.time)


def job_paused(event: e.JobPaused, state: CellState) -> None:
    """Let it begin no more items."""
    job = state.jobs[event.job]
    job.paused = True
    if event.item is not None:
        job.wants_piece, job.piece, job.piece_left = False, event.item, ''


def job_resumed(event: e.JobResumed, state: CellState) -> None:
    """Let it begin items again."""
    job = state.jobs[event.job]
    if event.item is not None and not event.another:
        job.approved = event.item
    job.paused, job.piece, job.wants_piece = False, '', event.another or job.wants_piece


def job_stopping(event: e.JobStopping, state: CellState) -> None:
    """Let it end with the items that it has begun."""
    job = state.jobs[event.job]
    job.stopping, job.paused, job.piece, job.end_reason = True, False, '', event.reason


def job_aborting(event: e.JobAborting, state: CellState) -> None:
    """Let it end; what is on the line drains."""
    state.jobs.abort(event.job, event.reason)


# --- ended jobs -----------------------------------------------------------------------------


def job_ended(event: e.JobCompleted | e.JobAborted, state: CellState) -> None:
    """Keep the job among the last that ended."""
    ended = state.jobs.remove(event.job)
    ended.ended_at = event.time
    _forget_initialization(state, ended)
    state.ended[event.job] = ended
    if len(state.ended) > ENDED_KEPT:
        # Only in older journals, which have no `job.cleared` for it.
        del state.ended[next(iter(state.ended))]
    _forget_unused(state, ended.digest)


def job_cleared(event: e.JobCleared, state: CellState) -> None:
    """Remove an ended job from the list; its id stays used."""
    del state.ended[event.job]


def note_work(state: CellState, job: JobState) -> None:
    """Let the cell know that it has work, if a job may start."""
    if job.may_start:
        state.had_work = True


def terms_of(event: e.OrderEvent) -> Terms:
    """Return the scheduling data of an order in an event."""
    return Terms(event.priority, event.start, event.due, event.details, event.first_piece)


def _job_of(event: e.OrderEvent, script: Script) -> Job:
    return Job(event.job, script, event.quantity, event.params, terms_of(event), event.choice)


def recipe_key(recipe: str, version: int | None) -> str:
    """Return what a version of a recipe is known by; a name has no spaces."""
    return f'{recipe} {version}'


def _note_recipe(event: e.OrderEvent, state: CellState) -> None:
    if event.recipe_digest:
        key = recipe_key(event.recipe, event.recipe_version)
        state.recipe_digests.setdefault(key, event.recipe_digest)


def _keep_released(state: CellState, job: JobState) -> None:
    """Keep a released script of an order by recipe, beyond the end of its job (semantics 6.11)."""
    if job.job.recipe is None or job.digest not in state.released:
        return
    kept = state.released_scripts
    kept.pop(job.digest, None)
    kept[job.digest] = job.job.script
    if len(kept) > RELEASED_KEPT:
        del kept[next(iter(kept))]


def _begin_flags(state: CellState, script: Script) -> None:
    """Set the flags that no other live job names to what a script begins with.

    They are back at their initial count (semantics 4.2), so a script with other initial counts
    than the previous one may set its own.
    """
    for dependency in script.dependencies:
        if not state.jobs.names_flag(dependency.flag):
            state.flags[dependency.flag] = FlagState(dependency.initial, dependency.capacity)


def _forget_initialization(state: CellState, job: JobState) -> None:
    for task in job.job.script.initialization:
        state.tasks.pop(e.TaskKey(job.job.id, None, None, task.id), None)


def forget_skips(state: CellState, may_forget: Callable[[JobState], bool]) -> None:
    """Re-evaluate initialization tasks that were skipped as already done (5.1)."""
    for key, progress in list(state.tasks.items()):
        if key.job is None or key.section is not None or not may_forget(state.jobs[key.job]):
            continue
        if progress.phase is Phase.DONE and not progress.attempt:
            del state.tasks[key]


def _forget_unused(state: CellState, digest: str) -> None:
    if not state.jobs.users(digest):
        del state.scripts[digest], state.preparations[digest]
