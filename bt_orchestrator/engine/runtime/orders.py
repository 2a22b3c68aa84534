"""Taking jobs into the queue, or refusing them with the reason; waiting for their start."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from bt_orchestrator.base.deadlines import has_come
from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime.ledger import CLOCK_STEP_S, Ledger
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell, Start
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.jobs.job_commands import Sharing
from bt_orchestrator.model.jobs.job_folds import recipe_key
from bt_orchestrator.model.jobs.needs import awaits_release, unavailable_to
from bt_orchestrator.model.jobs.order import Job, MadeAnew, Terms
from bt_orchestrator.model.proof.sharing import contradiction
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState, JobState
from bt_orchestrator.model.words import joined, sentence


def queue(
    state: CellState,
    jobs: Sequence[Job],
    now: float,
    *,
    position: int | None = None,
    held: bool = False,
    sharing: Sharing | None = None,
) -> list[list[e.Event]]:
    """Queue jobs, all or none; returns the events of each.

    :param now: time on the wall clock
    :param position: place of the first, from 1; None: each gets its place by its urgency
    :param sharing: known result of the check of their scripts against the live ones
    :raises CommandRefused: an id was used, flags contradict those of a live job, or a version of
        a recipe was another one before
    """
    _refuse_unless_all_fit(state, jobs, sharing)
    each: list[list[e.Event]] = []
    loaded = set(state.scripts)
    ranks = _Ranks(state)
    for number, job in enumerate(jobs):
        queued = e.JobQueued(
            **_ordered(job),
            position=ranks.place(job) if position is None else position + number,
            held=held,
            ranked=position is None,
            awaits_start=awaits_start(state.cell, job.terms, now),
            awaits_release=awaits_release(state, job.script),
            unavailable=unavailable_to(state, job.script),
        )
        each.append([*_loaded(job.script, loaded), queued])
    return each


def queue_rest(
    state: CellState,
    job: Job,
    of: str,
    anew: MadeAnew | None,
    sharing: Sharing | None = None,
) -> list[e.Event]:
    """Queue the rest of a job in front of all others; it does not wait for its start again.

    :raises CommandRefused: as of `queue`
    """
    _refuse_unless_all_fit(state, [job], sharing)
    queued = e.JobQueued(
        **_ordered(job),
        position=1,
        awaits_release=awaits_release(state, job.script),
        unavailable=unavailable_to(state, job.script),
        rest_of=of,
        anew=anew,
    )
    return [*_loaded(job.script, set(state.scripts)), queued]


def change(
    state: CellState,
    job: Job,
    now: float,
    sharing: Sharing | None = None,
    anew: MadeAnew | None = None,
    *,
    keeps_script: bool = False,
) -> list[e.Event]:
    """Replace the order of a queued job.

    :param now: time on the wall clock
    :param anew: why its script was generated again; None: it was not
    :param keeps_script: jobs of several versions may have one script in common, which does not
        tell then what this one was made from
    :raises CommandRefused: its flags contradict those of another live job, or the version of its
        recipe was another one before
    """
    live = state.jobs[job.id]
    is_shared = state.jobs.users(live.digest) > 1
    others = {n: script for n, script in state.scripts.items() if n != live.digest or is_shared}
    why = contradiction(job.script, others, sharing)
    if why is None and not keeps_script:
        why = _other_recipe(job, state.recipe_digests)
    if why is not None:
        raise CommandRefused(why)
    ordered = _ordered(job)
    if keeps_script:
        ordered |= {'recipe': live.recipe, 'recipe_version': live.recipe_version}
        key = recipe_key(live.recipe, live.recipe_version)
        ordered['recipe_digest'] = state.recipe_digests.get(key, '')
    updated = e.JobUpdated(
        **ordered,
        anew=live.anew if digest(job.script) == live.digest else anew,
        position=_new_place(state, live, job),
        awaits_start=_waits(state, live, job, now),
        awaits_release=_waits_for_release(state, live, job),
        unavailable=unavailable_to(state, job.script),
    )
    return [*_loaded(job.script, set(state.scripts)), updated]


class _Ranks:
    """The places of orders that are queued together, in their order (semantics 6.7)."""

    def __init__(self, state: CellState) -> None:
        self._jobs = state.jobs
        self._given: list[tuple[int, tuple[int, float]]] = []
        """Of those before, sorted: the place without the others, and the urgency."""

    def place(self, job: Job) -> int | None:
        """Return the place of the next one; None: the end of the queue."""
        urgency = job.terms.urgency
        without = self._jobs.place_for(urgency)
        before = bisect_right(self._given, (without, urgency))
        self._given.insert(before, (without, urgency))
        place = without + before
        return None if place == self._jobs.waiting + len(self._given) else place


def _new_place(state: CellState, live: JobState, job: Job) -> int | None:
    """Return the new place of a ranked job whose urgency changes; None: it keeps its place."""
    urgency = job.terms.urgency
    if not live.ranked or urgency == live.job.terms.urgency:
        return None
    return state.jobs.place_for(urgency, but=job.id)


def _waits(state: CellState, live: JobState, job: Job, now: float) -> bool:
    """Tell whether a changed job waits for its start: one that was released keeps that."""
    if job.terms.start == live.job.terms.start:
        return live.awaits_start
    return awaits_start(state.cell, job.terms, now)


def _waits_for_release(state: CellState, live: JobState, job: Job) -> bool:
    """Tell whether a changed job waits for a release; the state keeps one of equal scripts."""
    if digest(job.script) == live.digest:
        return live.awaits_release
    return awaits_release(state, job.script)


def _ordered(job: Job) -> dict[str, Any]:
    """Return the fields of an order in an event."""
    made_from = job.script.made_from
    return {
        'job': job.id,
        'script': job.script.name,
        'digest': digest(job.script),
        'quantity': job.quantity,
        'params': job.params,
        'recipe': made_from.recipe if made_from else '',
        'recipe_version': made_from.version if made_from else None,
        'recipe_digest': made_from.recipe_digest if made_from else '',
        'choice': job.recipe,
        **vars(job.terms),
    }


def _loaded(script: Script, known: set[str]) -> Iterator[e.ScriptLoaded]:
    name = digest(script)
    if name not in known:
        known.add(name)
        yield e.ScriptLoaded(script=script.name, digest=name, definition=script)


def _refuse_unless_all_fit(state: CellState, jobs: Sequence[Job], sharing: Sharing | None) -> None:
    reasons = list(_reasons(state, jobs, sharing))
    wrong = [reason for reason in reasons if reason is not None]
    if wrong:
        each = [
            sentence('fits', job=job.id) if reason is None else reason
            for job, reason in zip(jobs, reasons, strict=True)
        ]
        raise CommandRefused(joined(*wrong), each)


def _reasons(
    state: CellState, jobs: Sequence[Job], sharing: Sharing | None
) -> Iterator[str | None]:
    """Yield for each job why it does not fit the live jobs and the given jobs before it."""
    ids: set[str] = set()
    known = dict(state.scripts)
    recipes = dict(state.recipe_digests)
    why_not: dict[str, str | None] = {}
    for job in jobs:
        script = digest(job.script)
        if job.id in ids or job.id in state.order_ids:
            yield sentence('id_again', job=job.id)
        else:
            if script not in why_not:
                why_not[script] = contradiction(job.script, known, sharing)
            yield why_not[script] or _other_recipe(job, recipes)
        ids.add(job.id)
        _note_recipe(job, recipes)
        known[script] = job.script


def _other_recipe(job: Job, known: Mapping[str, str]) -> str | None:
    """Say that a version of a recipe was another one before (semantics 8.6); None: it was not."""
    made_from = job.script.made_from
    if made_from is None or not made_from.recipe_digest:
        return None
    now = made_from.recipe_digest
    before = known.get(recipe_key(made_from.recipe, made_from.version), now)
    if before == now:
        return None
    names = {'recipe': made_from.recipe, 'version': made_from.version}
    return sentence('other_recipe', **names, digest=now, before=before)


def _note_recipe(job: Job, known: dict[str, str]) -> None:
    made_from = job.script.made_from
    if made_from is not None and made_from.recipe_digest:
        key = recipe_key(made_from.recipe, made_from.version)
        known.setdefault(key, made_from.recipe_digest)


# Jobs that wait for the start of their order (semantics 6.7).


def awaits_start(cell: Cell, terms: Terms, now: float) -> bool:
    """Tell whether a job has to wait for the start of its order."""
    if terms.start is None or cell.start is Start.ADVISORY:
        return False
    return not has_come(terms.start, now)


class Starts:
    """Lets jobs start when their time has come, at every settle.

    A start is a time of the calendar, so the wall clock decides, also one that was set. The timer
    on the steady clock only causes a settle at that time.
    """

    def __init__(self, ledger: Ledger) -> None:
        self._ledger = ledger
        self._wakes_at = 0.0
        """On the steady clock."""

    def land(self) -> None:
        """Record the jobs that may start now, and be woken for the next one."""
        jobs = self._ledger.state.jobs
        if jobs.first_awaiting is not None:
            self._ledger.record(self._due())
        first = jobs.first_awaiting
        if first is None:
            return
        start, steady = first.job.terms.start, self._ledger.steady
        assert start is not None
        wake_at = steady + start - self._ledger.now
        if has_come(self._wakes_at, steady) or abs(wake_at - self._wakes_at) >= CLOCK_STEP_S:
            self._wakes_at = wake_at
            self._ledger.wake_at(wake_at)

    def _due(self) -> Iterator[e.JobMayStart]:
        state, now = self._ledger.state, self._ledger.now
        while (job := state.jobs.first_awaiting) is not None:
            if awaits_start(state.cell, job.job.terms, now):
                return
            yield e.JobMayStart(job=job.job.id)
