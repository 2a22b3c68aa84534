"""The fold from events to the items that leave the line, and to what went wrong with them.

The causes are those of docs/account.md: the first decision by which an item is not good, and the
failure that the decision was about.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from bt_orchestrator.base.errors import MissingResult
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.codec import from_plain, to_plain
from bt_orchestrator.model.condition import Condition, holds
from bt_orchestrator.model.failures import MARK_DONE, SKIP
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.jobs.counting import BY_HAND, GOOD, REJECTED, kind_of
from bt_orchestrator.model.judging.results import with_bounds
from bt_orchestrator.model.reference import Reference, Scope, references
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.task_spans import TaskSpan
from bt_orchestrator.view.report.account.causes.flaws import Bounds, Decision, Effect, Flaw
from bt_orchestrator.view.report.account.causes.made import Again, Happening, Left, Made, Measured

Results = Mapping[str, Any]


@dataclass
class _Failure:
    """The last failed attempt of a task for an item."""

    reason: str = ''
    component: str = ''
    bound: str = ''
    was_held: bool = False
    """A person was asked about it."""


@dataclass
class _Item:
    flaw: Flaw | None = None
    """Why it is rejected, or else its first mark."""
    is_nonconforming: bool = False
    is_rejected: bool = False
    is_first_pass: bool = True
    failures: dict[str, _Failure] = field(default_factory=dict)
    """By task, the newest last."""

    @property
    def has_reject(self) -> bool:
        """Tell whether the decision to reject it is known."""
        return self.flaw is not None and self.flaw.effect is Effect.REJECTED


@dataclass
class _Job:
    made: Made
    aborting: bool = False
    params: Mapping[str, Any] = field(default_factory=dict)
    items: dict[str, _Item] = field(default_factory=dict)


class ItemsAtWork:
    """Takes in one event after another; keeps what it needs of items that are at work."""

    def __init__(self) -> None:
        self._jobs: dict[str, _Job] = {}
        self._verdicts: dict[str, dict[str, Condition]] = {}
        """By the digest of a script and by task."""
        self._asked: dict[str, tuple[str, str]] = {}
        """Job and item of the holds that stand."""
        self._answer = ''
        """The last one of an operator."""

    def follow(self, event: e.Event, span: TaskSpan | None) -> Sequence[Happening]:
        """Take in the next event; returns what comes of it.

        :param span: the attempt that ended with it
        """
        take = self._FOLDS.get(type(event))
        return () if take is None else tuple(take(self, event, span))

    # --- jobs -------------------------------------------------------------------------------

    def _order(self, event: e.OrderEvent, _: object) -> Iterator[Happening]:
        job = self._of(event.job)
        job.made = Made(event.job, event.script, event.digest, event.recipe, event.recipe_version)
        verdicts = self._verdicts.get(event.digest, {}).values()
        named = {parameter.name for verdict in verdicts for parameter in _parameters(verdict)}
        job.params = {name: value for name, value in event.params.items() if name in named}
        yield from ()

    def _script(self, event: e.ScriptLoaded, _: object) -> Iterator[Happening]:
        self._verdicts[event.digest] = verdicts_of(event.definition)
        yield from ()

    def _ends(
        self, event: e.JobCompleted | e.JobAborted | e.JobRemoved, _: object
    ) -> Iterator[Happening]:
        self._jobs.pop(event.job, None)
        used = {job.made.digest for job in self._jobs.values()}
        self._verdicts = {
            digest: kept for digest, kept in self._verdicts.items() if digest in used
        }
        yield from ()

    def _aborting(self, event: e.JobAborting, _: object) -> Iterator[Happening]:
        self._of(event.job).aborting = True
        yield from ()

    def _of(self, job: str) -> _Job:
        known = self._jobs.get(job)
        if known is None:
            known = self._jobs[job] = _Job(Made(job))
        return known

    def _item(self, job: str, item: str) -> _Item:
        return self._of(job).items.setdefault(item, _Item())

    # --- tasks ------------------------------------------------------------------------------

    def _started(self, event: e.TaskStarted, _: object) -> Iterator[Happening]:
        if event.job is None or event.item is None or not (event.attempt > 1 or event.round):
            return
        item = self._item(event.job, event.item)
        item.is_first_pass = False
        if event.attempt > 1:
            failure = item.failures.get(event.task, _Failure(component=event.component))
            decision = Decision.RETRY if failure.was_held else Decision.RETRIES
            yield self._again(event.job, Effect.ATTEMPT, decision, event.task, failure)

    def _round(self, event: e.RoundBegun, _: object) -> Iterator[Happening]:
        item = self._item(event.job, event.item)
        item.is_first_pass = False
        failed = [
            (task, failure) for task, failure in item.failures.items() if task in event.tasks
        ]
        task, failure = failed[-1] if failed else ('', _Failure())
        for name, _failure in failed:
            del item.failures[name]
        decision = Decision.AGAIN if failure.was_held else Decision.REPEAT
        yield self._again(event.job, Effect.ROUND, decision, task, failure)

    def _again(
        self, job: str, effect: Effect, decision: Decision, task: str, failure: _Failure
    ) -> Again:
        made = self._of(job).made
        return Again(made, _flaw(effect, decision, made, task, failure))

    def _failed(self, event: e.TaskFailed, span: TaskSpan | None) -> Iterator[Happening]:
        if event.job is None or event.item is None:
            return
        component = '' if span is None else span.started.component
        bound = ''
        if event.reason == Reason.RESULT_REFUSED.value:
            bound = '; '.join(self._unmet(event.job, event.task, event.results))
            yield from self._measured(event, component)
        failures = self._item(event.job, event.item).failures
        failures.pop(event.task, None)
        failures[event.task] = _Failure(event.reason, component, bound)

    def _succeeded(self, event: e.TaskSucceeded, span: TaskSpan | None) -> Iterator[Happening]:
        if event.job is not None and event.item is not None and self._verdicts:
            yield from self._measured(event, '' if span is None else span.started.component)

    # --- verdicts ---------------------------------------------------------------------------

    def _comparisons(self, job: str, task: str) -> Iterator[Condition]:
        """Yield what the verdict of a task compares of its own result, with numbers as bounds."""
        of = self._of(job)
        verdict = self._verdicts.get(of.made.digest, {}).get(task)
        if verdict is None:
            return
        scope = Scope(of.params, {}, {}, {})
        for comparison in verdict.comparisons:
            if _own_value(comparison, task) is not None:
                try:
                    yield with_bounds(comparison, scope)
                except MissingResult:
                    continue

    def _unmet(self, job: str, task: str, results: Results) -> Iterator[str]:
        scope = Scope({}, {}, {}, {task: results})
        for comparison in self._comparisons(job, task):
            try:
                is_met = holds(comparison, scope)
            except MissingResult:
                is_met = False
            if not is_met:
                yield comparison.words

    def _measured(
        self, event: e.TaskSucceeded | e.TaskFailed, component: str
    ) -> Iterator[Measured]:
        assert event.job is not None
        for comparison in self._comparisons(event.job, event.task):
            low, high = comparison.at_least, comparison.at_most
            reference = _own_value(comparison, event.task)
            value = None if reference is None else _number(event.results, reference.fields)
            if value is None or reference is None or (low is None and high is None):
                continue
            product = self._of(event.job).made.product
            named = '.'.join(reference.fields)
            yield Measured(Bounds(product, event.task, component, named, low, high), value)

    # --- holds and their answers ------------------------------------------------------------

    def _held(self, event: e.HoldRaised, _: object) -> Iterator[Happening]:
        if event.job is not None and event.item is not None:
            self._asked[event.hold] = event.job, event.item
            failures = self._item(event.job, event.item).failures
            if event.task in failures:
                failures[event.task].was_held = True
        yield from ()

    def _released(self, event: e.HoldReleased, _: object) -> Iterator[Happening]:
        self._asked.pop(event.hold, None)
        yield from ()

    def _decided(self, event: e.OperatorDecided, _: object) -> Iterator[Happening]:
        self._answer = event.answer
        asked = self._asked.get(event.hold or '')
        if asked is not None and event.answer in (MARK_DONE, SKIP):
            self._item(*asked).is_first_pass = False
        yield from ()

    # --- items ------------------------------------------------------------------------------

    def _nonconforming(self, event: e.ItemNonconforming, _: object) -> Iterator[Happening]:
        decision = Decision.SKIP if self._answer == SKIP else Decision.MARK_DONE
        self._mark(event.job, event.item, event.task, decision)
        yield from ()

    def _continued(self, event: e.TaskContinued, _: object) -> Iterator[Happening]:
        if event.job is None or event.item is None:
            return
        item = self._item(event.job, event.item)
        if event.nonconforming is not None:
            self._mark(event.job, event.item, event.task, Decision.ON_FAILURE)
        elif event.policy == OnFailure.REJECT.value and item.is_rejected and not item.has_reject:
            failure = item.failures.get(event.task, _Failure())
            by = Decision.REJECT if failure.was_held else Decision.ON_FAILURE
            made = self._of(event.job).made
            item.flaw = _flaw(Effect.REJECTED, by, made, event.task, failure)
        yield from ()

    def _rejected(self, event: e.ItemRejected, _: object) -> Iterator[Happening]:
        job, item = self._of(event.job), self._item(event.job, event.item)
        item.is_rejected = True
        if job.aborting:
            item.flaw = Flaw(Effect.REJECTED, Decision.ABORT_JOB, job.made.product)
        yield from ()

    def _mark(self, job: str, item: str, task: str, decision: Decision) -> None:
        record, made = self._item(job, item), self._of(job).made
        if record.flaw is None:
            failure = record.failures.get(task, _Failure())
            record.flaw = _flaw(Effect.NONCONFORMING, decision, made, task, failure)
        record.is_nonconforming = True

    def _out(self, event: e.ItemRemoved, _: object) -> Iterator[Happening]:
        job = self._of(event.job)
        item = job.items.pop(event.item, None) or _Item()
        kind = kind_of(event.how, is_nonconforming=item.is_nonconforming)
        flaw = item.flaw
        if kind == GOOD:
            flaw = None
        elif kind == BY_HAND:
            flaw = Flaw(Effect.BY_HAND, Decision.TAKEN_OFF, job.made.product)
        elif kind == REJECTED and not item.has_reject:
            by = Decision.ABORT_JOB if job.aborting else Decision.ON_FAILURE
            flaw = Flaw(Effect.REJECTED, by, job.made.product)
        yield Left(job.made, kind, item.is_first_pass, flaw)

    _FOLDS: ClassVar[Mapping[type[e.Event], Callable[..., Iterator[Happening]]]] = {
        e.JobQueued: _order,
        e.JobUpdated: _order,
        e.ScriptLoaded: _script,
        e.JobCompleted: _ends,
        e.JobAborted: _ends,
        e.JobRemoved: _ends,
        e.JobAborting: _aborting,
        e.TaskStarted: _started,
        e.RoundBegun: _round,
        e.TaskFailed: _failed,
        e.TaskSucceeded: _succeeded,
        e.HoldRaised: _held,
        e.HoldReleased: _released,
        e.OperatorDecided: _decided,
        e.ItemNonconforming: _nonconforming,
        e.TaskContinued: _continued,
        e.ItemRejected: _rejected,
        e.ItemRemoved: _out,
    }

    # --- kept and gone on from --------------------------------------------------------------

    def plain(self) -> dict[str, Any]:
        """Return what it knows, as JSON carries it."""
        return {
            'jobs': [to_plain(job) for job in self._jobs.values()],
            'verdicts': to_plain(self._verdicts),
            'asked': self._asked,
            'answer': self._answer,
        }

    def go_on_from(self, plain: Mapping[str, Any]) -> None:
        """Know what another one knew; books of an older program know less."""
        if 'nonconforming' in plain:
            self._jobs = {job['job']: _Job(from_plain(Made, job)) for job in plain['jobs']}
            for item in plain['nonconforming']:
                self._mark(item.rpartition('/')[0], item, '', Decision.ON_FAILURE)
            return
        jobs = [_read_job(job) for job in plain['jobs']]
        self._jobs = {job.made.job: job for job in jobs}
        self._verdicts = {
            digest: {
                task: from_plain(Condition, condition) for task, condition in verdicts.items()
            }
            for digest, verdicts in plain['verdicts'].items()
        }
        self._asked = {hold: (job, item) for hold, (job, item) in plain['asked'].items()}
        self._answer = plain['answer']


def _read_job(plain: Mapping[str, Any]) -> _Job:
    job = from_plain(_Job, {**plain, 'items': None})
    job.items = {name: _read_item(item) for name, item in plain.get('items', {}).items()}
    return job


def _read_item(plain: Mapping[str, Any]) -> _Item:
    item = from_plain(_Item, {**plain, 'failures': None})
    failures = plain.get('failures', {})
    item.failures = {task: from_plain(_Failure, failure) for task, failure in failures.items()}
    return item


def _flaw(effect: Effect, decision: Decision, made: Made, task: str, failure: _Failure) -> Flaw:
    about = (failure.component, failure.reason, failure.bound)
    return Flaw(effect, decision, made.product, task, *about)


def verdicts_of(script: Script) -> dict[str, Condition]:
    """Return the verdicts of a script by task."""
    judged = ((task.id, task.fails_unless) for task in script.tasks.values())
    return {task: verdict for task, verdict in judged if verdict is not None}


def _parameters(verdict: Condition) -> Iterator[Reference]:
    """Yield the parameters that are bounds."""
    for comparison in verdict.comparisons:
        yield from references((comparison.at_least, comparison.at_most))


def _own_value(comparison: Condition, task: str) -> Reference | None:
    """Return the field of a task's own result that a comparison is about; None: it is not."""
    parts = comparison.value.parts
    part = parts[0] if len(parts) == 1 else None
    is_own = isinstance(part, Reference) and (part.source, part.name) == ('results', task)
    return part if is_own and isinstance(part, Reference) else None


def _number(results: Results, fields: Sequence[str]) -> float | None:
    """Return a finite number of a result; None: there is none."""
    value: Any = results
    for name in fields:
        value = value.get(name) if isinstance(value, Mapping) else None
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return value if math.isfinite(value) else None


FOLLOWED = (
    e.RoundBegun.event,
    e.ItemNonconforming.event,
    e.TaskContinued.event,
    e.ItemRejected.event,
    e.ItemRemoved.event,
)
