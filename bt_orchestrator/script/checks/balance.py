"""Every item is placed once and taken out once (semantics 3.2)."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.script import RunsFor
from bt_orchestrator.script.drafts import ScriptDraft, TaskDraft
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.report import Report, listing

GOOD, REJECTED = False, True
"""States of an item, as `RunsFor.includes` takes them."""


def check_balance(script: ScriptDraft, report: Report) -> None:
    """Report whatever would leave an item unplaced, on the belt, or taken out twice.

    A good item passes every task from the source to the sink and meets exactly one `-1`. Behind a
    task that may reject it, it must meet exactly one `-1` that runs for rejected items. A `-1`
    that may reject has then failed to take the item out, so it needs another one behind it. A task
    that rejects before or at the `+1` leaves an empty position and needs none; nor does one that
    runs for rejected items only, or that no item on the belt can reach. A `-1` in parallel to a
    task that may reject is refused: their order is undefined.
    """
    lists = [task_list for task_list in script.lists if not task_list.is_repeated]
    changing = [task for task_list in lists for task in task_list.tasks if _changes(task)]
    placing = [task for task in changing if task.task.qty_change > 0]
    taking = [task for task in changing if task.task.qty_change < 0]
    for task in placing:
        check_placing(task, report)
    for task in taking:
        check_taking(task, report)
    for task in placing[1:]:
        what = f'items are placed twice, by `{placing[0].id}` and by `{task.id}`'
        report.add(task.place('qty_change'), what, 'keep one `qty_change: 1`')
    if not _is_readable(script):
        return
    strays = [
        task for section in script.strays.values() for task in section.tasks if _changes(task)
    ]
    placing = [*placing, *(task for task in strays if task.task.qty_change > 0)]
    taking = [*taking, *(task for task in strays if task.task.qty_change < 0)]
    if _check_presence(script, placing, taking, report) and not strays:
        _Balance(script, placing[0], taking, report).check()


class _Balance:
    """The line from its one source on."""

    def __init__(
        self, script: ScriptDraft, source: TaskDraft, taking: list[TaskDraft], report: Report
    ) -> None:
        self._script = script
        self._source = source
        self._taking = taking
        self._report = report

    def check(self) -> None:
        """Check sections outside the line, then good items, then rejected ones."""
        self._check_ends()
        early = [task for task in self._taking if not self._source.precedes(task)]
        for task in early:
            if task.section == self._source.section:
                what = f'`{task.id}` does not wait until `{self._source.id}` has placed the item'
                self._report.add(task.place('qty_change'), what, 'put it behind that task')
        if early or not all(task.fields.is_sure('runs_for') for task in self._taking):
            return
        self._check_good()
        self._check_rejects()

    def _check_rejects(self) -> None:
        """Follow the possible states of an item, step by step, and check rejecting tasks."""
        states = frozenset((GOOD, REJECTED))
        for number in sorted(self._script.sections):
            for step in self._script.sections[number].steps:
                left = [self._follow(track, states) for track in step]
                states = frozenset.intersection(*left) if left else states

    def _follow(self, track: tuple[TaskDraft, ...], states: frozenset[bool]) -> frozenset[bool]:
        """Return the states in which an item can be on the belt behind a track.

        It starts with both, because an operator may reject any item.
        """
        for task in track:
            if not self._source.precedes(task) and not self._source.is_beside(task):
                continue
            here = {state for state in states if task.task.runs_for.includes(state)}
            is_taking = task.task.qty_change < 0
            if self._rejects(task) and (GOOD in here or (here and is_taking)):
                self._check_rejected(task)
            if is_taking:
                states -= here
            if GOOD in states or (task.may_reject and here):
                states |= {REJECTED}
        return states

    def _check_ends(self) -> None:
        first = self._source.section or 0
        last = max(task.section or 0 for task in self._taking)
        for number, section in self._script.sections.items():
            if number < first:
                what = f'no item gets to section {number}: items are placed in section {first}'
            elif number > max(first, last):
                what = f'no item gets to section {number}: the last is taken out in section {last}'
            else:
                continue
            self._report.add(section.place, what, 'move its tasks, or remove the section')

    def _check_good(self) -> None:
        takers = [task for task in self._taking if task.task.runs_for.includes(rejected=False)]
        if not takers:
            what = f'only rejected items are taken out, by {listing(t.id for t in self._taking)}'
            hint = 'one task with `qty_change: -1` must run for good items'
            self._report.add(self._taking[0].place('runs_for'), what, hint)
        for task in takers[1:]:
            what = f'a good item is taken out twice, by `{takers[0].id}` and by `{task.id}`'
            hint = 'keep one, or set `runs_for: rejected` on the other'
            self._report.add(task.place('qty_change'), what, hint)

    def _rejects(self, task: TaskDraft) -> bool:
        """Tell whether a task may reject; a trailing one may not, which is reported elsewhere."""
        is_sure = task.fields.is_sure('on_failure') and not self._script.trailing(task)
        return task.may_reject and is_sure

    def _check_rejected(self, task: TaskDraft) -> None:
        takers = [taker for taker in self._taking if taker.task.runs_for.includes(rejected=True)]
        beside = [taker for taker in self._taking if taker.is_beside(task)]
        behind = [taker for taker in takers if task.precedes(taker)]
        if beside:
            what = f'`{task.id}` may reject the item while `{beside[0].id}` takes it out'
            hint = 'run them one after the other'
        elif not behind:
            what = f'an item that `{task.id}` rejects is never taken out'
            hint = self._missing_taker_hint(task, takers)
        elif len(behind) > 1:
            what = f'an item that `{task.id}` rejects is taken out twice'
            hint = f'keep one of {listing(taker.id for taker in behind)} for rejected items'
        else:
            return
        self._report.add(task.place('on_failure'), what, hint)

    def _missing_taker_hint(self, task: TaskDraft, takers: list[TaskDraft]) -> str:
        early = [taker for taker in takers if taker is not task]
        if early:
            return f'move `{early[-1].id}` behind it'
        later = [taker for taker in self._taking if task.precedes(taker)]
        if later:
            return f'set `runs_for: all` on `{later[0].id}`'
        return 'add a task with `qty_change: -1` and `runs_for: rejected` behind it'


def _is_readable(script: ScriptDraft) -> bool:
    return script.tasks_are_complete and all(
        task.fields.is_sure('qty_change') for task_list in script.lists for task in task_list.tasks
    )


def _changes(task: TaskDraft) -> bool:
    return task.task.qty_change != 0 and task.fields.is_sure('qty_change')


def _check_presence(
    script: ScriptDraft, placing: list[TaskDraft], taking: list[TaskDraft], report: Report
) -> bool:
    place = script.fields.key_place('sections')
    if not placing and script.sections:
        what = 'no task places items'
        report.add(place, what, 'give exactly one task `qty_change: 1`')
    if not taking and script.sections:
        what = 'no task takes items out'
        report.add(place, what, 'give a task of the last section `qty_change: -1`')
    return len(placing) == 1 and bool(taking)


def check_placing(task: TaskDraft, report: Report) -> None:
    """Report what a task that places the item cannot have."""
    for key in _conditions(task):
        what = f'a task that places the item cannot have `{key}`'
        report.add(task.fields.key_place(key), what, f'remove `{key}`')
    check_unjudged(task.fields, 'places the item', report)
    if task.task.runs_for is not RunsFor.GOOD:
        what = 'an item that is rejected before it is placed leaves an empty position'
        report.add(task.place('runs_for'), what, 'remove `runs_for` from this task')


def check_taking(task: TaskDraft, report: Report) -> None:
    """Report what a task that takes the item out cannot have."""
    for key in _conditions(task):
        what = f'a task that takes the item out cannot have `{key}`: the item would stay'
        report.add(task.fields.key_place(key), what, f'remove `{key}`, or use `runs_for`')
    check_unjudged(task.fields, 'takes the item out', report)
    if task.task.on_failure is OnFailure.CONTINUE and task.fields.is_sure('on_failure'):
        key = 'continue_if_fail' if task.fields.has('continue_if_fail') else 'on_failure'
        what = 'a task that takes the item out cannot continue after a failure'
        report.add(task.place(key), what, 'use `hold`, `reject` or `abort_job`')


def check_unjudged(fields: Fields, does: str, report: Report) -> None:
    """Report a verdict, or a serial: the item has moved before either could refuse (2.8, 6.8)."""
    for key, verb in (('fails_unless', 'judge'), ('identifies', 'identify')):
        if fields.has(key):
            what = f'a task that {does} cannot have `{key}`: the item has moved by then'
            hint = f'{verb} it by a task of its own, or by the task before'
            report.add(fields.key_place(key), what, hint)


def _conditions(task: TaskDraft) -> Iterator[str]:
    return (key for key in ('when', 'unless') if task.fields.has(key))
