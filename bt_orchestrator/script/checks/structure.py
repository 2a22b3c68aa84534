"""The structure of a script: groups, releases, repeats, dependencies, zones (semantics 3 to 5)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise

from bt_orchestrator.model.script import Dependency, InitializationDependency, Release, Zone
from bt_orchestrator.script.drafts import ScriptDraft, SectionDraft, TaskDraft
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.names import check_name
from bt_orchestrator.script.report import Place, Report, did_you_mean, listing
from bt_orchestrator.script.yaml_nodes import Entry, ListNode, Scalar, found, quoted


def circles(edges: Iterable[tuple[str, str]]) -> list[list[str]]:
    """Return circles, each as its nodes in order with the first repeated at the end.

    There is at least one if the graph has any; of circles that share nodes only one is returned,
    which is enough to say what is wrong there.
    """
    following: dict[str, list[str]] = {}
    for upstream, downstream in edges:
        following.setdefault(upstream, []).append(downstream)
    all_circles: list[list[str]] = []
    closed: set[str] = set()
    for start in following:
        circle = _circle(start, following, closed)
        if circle is not None:
            all_circles.append(circle)
    return all_circles


def _circle(start: str, following: dict[str, list[str]], closed: set[str]) -> list[str] | None:
    """Walk depth first without recursion; `closed` nodes were left for good."""
    path: list[str] = []
    branches: list[list[str]] = [[start]]
    while branches:
        if not branches[-1]:
            branches.pop()
            if path:
                closed.add(path.pop())
            continue
        node = branches[-1].pop(0)
        if node in path:
            closed.update(path)
            return [*path[path.index(node) :], node]
        if node not in closed:
            path.append(node)
            branches.append(list(following.get(node, ())))
    return None


class DependencyReader:
    """Reads what relates tasks to each other."""

    def __init__(self, script: ScriptDraft, report: Report) -> None:
        self._script = script
        self._report = report

    # --- lateral dependencies -------------------------------------------------------------

    def lateral(self) -> Iterator[Dependency]:
        """Yield the lateral dependencies (4.1)."""
        lines: dict[str, int] = {}
        for fields in self._script.fields.tables('lateral_dependencies'):
            flag = self._flag(fields, lines)
            ends = [self._end(fields, key) for key in ('upstream', 'downstream')]
            if None not in ends and ends[0] == ends[1]:
                what = f'`{ends[0]}` cannot wait for itself'
                self._report.add(fields.place('downstream'), what, 'name two different tasks')
            capacity, initial = fields.whole('capacity'), fields.whole('initial')
            if initial > capacity and fields.is_sure('capacity', 'initial'):
                what = f'`initial` is {initial}, but the capacity is {capacity}'
                hint = f'write `initial: {capacity}` at most, or raise the capacity'
                self._report.add(fields.place('initial'), what, hint)
            yield Dependency(flag, ends[0] or '', ends[1] or '', capacity, initial)

    def _flag(self, fields: Fields, lines: dict[str, int]) -> str:
        flag = fields.text('flag')
        if flag is None:
            return ''
        check_name(flag, 'flag name', fields.place('flag'), self._report)
        if flag in lines:
            what = f'the flag `{flag}` is used twice'
            hint = f'use another name; the first is in line {lines[flag]}'
            self._report.add(fields.place('flag'), what, hint)
        lines.setdefault(flag, fields.place('flag').line)
        return flag

    def _end(self, fields: Fields, key: str) -> str | None:
        """Return the id of a task of a section's list."""
        name = fields.text(key)
        task = self._known(name, fields.place(key)) if name is not None else None
        if task is not None and task.section is None:
            what = f'`{task.id}` is an initialization task, which belongs to no cycle'
            hint = 'name a task of a section'
            self._report.add(fields.place(key), what, hint)
        elif task is not None and self._script.is_repeated(task):
            what = f'`{task.id}` is in a repeat, and would change the flag once a round'
            hint = 'name a task before or behind the repeat'
            self._report.add(fields.place(key), what, hint)
        return name

    # --- zones ----------------------------------------------------------------------------

    def zones(self) -> Iterator[Zone]:
        """Yield the zones; initialization tasks may be in them (4.4)."""
        node = self._script.fields.mapping('zones')
        for entry in node.entries if node else ():
            check_name(entry.key.text, 'zone name', entry.key.place, self._report)
            if isinstance(entry.value, ListNode):
                yield Zone(entry.key.text, tuple(self._members(entry, entry.value)))
            else:
                what = f'a zone must be a list of tasks, not {found(entry.value)}'
                hint = f'write for instance `{entry.key.text}: [inspect, assemble]`'
                self._report.add(entry.value.place, what, hint)

    def _members(self, zone: Entry, members: ListNode) -> Iterator[str]:
        seen: set[str] = set()
        for item in members.items:
            if not isinstance(item, Scalar) or not item.text:
                what = f'a zone lists ids of tasks, not {found(item)}'
                self._report.add(item.place, what, 'write the id of a task')
                continue
            if item.text in seen:
                what = f'{quoted(item.text)} is in the zone twice'
                self._report.add(item.place, what, 'remove one')
            else:
                self._known(item.text, item.place)
            seen.add(item.text)
            yield item.text
        if len(members.items) < 2:
            what = f'the zone {quoted(zone.key.text)} has fewer than two tasks'
            self._report.add(zone.key.place, what, 'list the tasks that must not overlap')

    # --- initialization -------------------------------------------------------------------

    def initialization(self) -> tuple[InitializationDependency, ...]:
        """Return the order among initialization tasks; a circle is reported once (5.1)."""
        found_pairs = []
        for fields in self._script.fields.tables('initialization_dependencies'):
            first = self._initialization_task(fields, 'upstream')
            second = self._initialization_task(fields, 'downstream')
            if first is not None and first == second:
                what = f'`{first}` cannot wait for itself'
                self._report.add(fields.place('downstream'), what, 'name two different tasks')
            elif first is not None and second is not None:
                pair = InitializationDependency(first, second)
                found_pairs.append((pair, fields.place('upstream')))
        self._check_circles(dict(found_pairs))
        return tuple(pair for pair, _ in found_pairs)

    def _check_circles(self, pairs: dict[InitializationDependency, Place]) -> None:
        for circle in circles((pair.upstream, pair.downstream) for pair in pairs):
            steps = set(pairwise(circle))
            places = [
                at
                for dependency, at in pairs.items()
                if (dependency.upstream, dependency.downstream) in steps
            ]
            way = ' -> '.join(circle)
            what = f'these initialization tasks wait for each other in a circle: {way}'
            self._report.add(min(places), what, 'remove one of these dependencies')

    def _initialization_task(self, fields: Fields, key: str) -> str | None:
        name = fields.text(key)
        known = [task.id for task in self._script.initialization]
        if name is None or name in known or self._script.may_have(name):
            return name
        if name in self._script.by_id:
            what = f'`{name}` is not an initialization task'
            hint = 'order tasks of sections by `lateral_dependencies`'
        else:
            what = f'there is no initialization task {quoted(name)}'
            offer = (
                f'there is {listing(known)}' if known else 'give the script one, or remove this'
            )
            hint = did_you_mean(name, known, offer)
        self._report.add(fields.place(key), what, hint)
        return None

    def _known(self, name: str, place: Place) -> TaskDraft | None:
        task = self._script.by_id.get(name)
        if task is None and not self._script.may_have(name):
            hint = did_you_mean(name, self._script.by_id, 'name the id of a task of this script')
            self._report.add(place, f'there is no task {quoted(name)}', hint)
        return task


# Parallel groups and the release of the conveyor (semantics 3.1, 3.8).


def check_sections(script: ScriptDraft, report: Report) -> None:
    """Report groups that would wait for themselves, and turns that would never be complete."""
    for section in script.lists:
        for step in section.steps:
            _check_group(step, report)
        _check_release(section, report)


def _check_group(step: tuple[tuple[TaskDraft, ...], ...], report: Report) -> None:
    """A component runs one task at a time, so its tasks belong into one track (2.5)."""
    owners: dict[str, tuple[int, TaskDraft]] = {}
    for number, track in enumerate(step):
        for task in track:
            if task.component is None:
                continue
            owner, first = owners.setdefault(task.component.name, (number, task))
            if owner != number:
                what = f'`{task.component.name}` cannot run two tasks at a time'
                hint = f'put it into one list with `{first.id}`, or behind the group'
                report.add(task.place('action'), what, hint)


def _check_release(section: SectionDraft, report: Report) -> None:
    if section.release is Release.END_OF_CYCLE:
        return
    tasks = list(section.tasks)
    if tasks and not any(task.task.requires_conveyor for task in tasks):
        what = f'section {section.name} has no task that requires the conveyor'
        hint = 'remove `release_conveyor`, or let a task require the conveyor'
        report.add(section.release_place, what, hint)
    for task in section.trailing:
        if task.may_reject and task.fields.is_sure('on_failure'):
            what = f'`{task.id}` cannot reject: it runs after the conveyor is released'
            hint = 'let it hold, continue or abort_job'
            report.add(task.place('on_failure'), what, hint)


# Repeats: what must not be done twice, and what could never be (semantics 3.9).


def check_repeats(script: ScriptDraft, report: Report) -> None:
    """Report repeats that would move an item twice, or that never begin a round."""
    for repeat in script.repeats:
        for task in repeat.tasks:
            if task.task.qty_change and task.fields.is_sure('qty_change'):
                what = f'`{task.id}` moves the item, and cannot be repeated'
                report.add(task.place('qty_change'), what, 'put it before or behind the repeat')
        if repeat.tasks and not any(map(_is_judged, repeat.tasks)):
            what = (
                f'no {script.step} of this repeat has a verdict, so nothing would ever repeat it'
            )
            hint = 'give one of them `fails_unless`; for failed attempts there is `retries`'
            report.add(repeat.place, what, hint)


def _is_judged(task: TaskDraft) -> bool:
    return task.fields.has('fails_unless') or not task.fields.is_sure('fails_unless')
