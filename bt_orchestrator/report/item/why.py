"""Why a task of an item could not begin yet, from what was so around it (semantics 7.4)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.report.causes import Cause, cause_of
from bt_orchestrator.report.item.history import Waited
from bt_orchestrator.report.item.scene import Film, Scene

LEAST_S = 0.02
"""A shorter wait is the time that the program and the disk need."""

Scripts = Callable[[str], Script | None]
"""Returns the script of a job; None: it is not known."""


class Next(NamedTuple):
    """The task that could not begin yet."""

    key: e.TaskKey
    component: str

    @classmethod
    def none(cls, job: str, item: str) -> Next:
        """Return what stands for no task: the item waits for the line to go on."""
        return cls(e.TaskKey(job, None, item, ''), '')


def waits(film: Film, start: float, end: float, task: Next, scripts: Scripts) -> list[Waited]:
    """Return what a task waited for, one thing after the other."""
    found: list[Waited] = []
    for since, until, scene in _stretches(film, start, end, task.key):
        cause = next(_obstacles(scene, task, scripts, since), None)
        kind, words = (cause.kind.value, cause.text) if cause else ('', '')
        last = found[-1] if found else None
        if last is not None and (last.kind, last.words) == (kind, words):
            found[-1] = replace(last, end=until)
        else:
            found.append(Waited(since, until, kind, words))
    return [one for one in found if one.seconds >= LEAST_S]


def _stretches(
    film: Film, start: float, end: float, key: e.TaskKey
) -> Iterator[tuple[float, float, Scene]]:
    """Yield the scenes of a stretch of time, parted where the delay of a retry is over."""
    for since, until, scene in film.between(start, end):
        over = min(max(scene.delayed.get(key, since), since), until)
        yield from ((a, b, scene) for a, b in ((since, over), (over, until)) if a < b)


def _obstacles(scene: Scene, task: Next, scripts: Scripts, since: float) -> Iterator[Cause]:
    """Yield what is in the way of a task, in the order in which the line looks.

    :param since: when this stretch of the scene begins
    """
    is_there = _is_in_hand(scene, task.key)
    yield from _of_cell(scene, task.key, is_there=is_there)
    if not is_there:
        yield from _of_belt(scene, task.key)
        return
    script = scripts(task.key.job or '')
    if script is not None and task.key.task in script.tasks:
        yield from _of_step(scene, task.key, script)
        yield from _of_flags(scene, task.key, script)
        yield from _of_zones(scene, task.key, script, scripts)
    if task.component in scene.unready:
        yield cause_of(Wait('', WaitKind.READINESS, task.component), ())
    if scene.delayed.get(task.key, since) > since:
        yield Cause(WaitKind.RETRY_DELAY, 'the delay before a retry')
    yield from _of_component(scene, task)


def _is_in_hand(scene: Scene, key: e.TaskKey) -> bool:
    cycle = scene.cycles.get(key.section or 0)
    return cycle is not None and cycle.item == key.item


def _of_cell(scene: Scene, key: e.TaskKey, *, is_there: bool) -> Iterator[Cause]:
    """Yield holds, pauses and states in which nothing starts, or no cycle begins."""
    for hold in scene.holds.values():
        if hold.task is None and hold.item is None:
            yield Cause(WaitKind.PAUSE, f'the cell to be resumed (hold {hold.hold})')
        elif not is_there or (hold.section, hold.job is None) == (key.section, False):
            yield Cause(WaitKind.HOLD, f'an answer to hold {hold.hold}')
    state = next((one for one in PackmlState if one.value == scene.state), None)
    if scene.is_ending:
        yield Cause(WaitKind.CELL_STATE, 'the orchestrator to be started again')
    elif state is not None and not (state.works if is_there else state.begins):
        yield cause_of(Wait('', WaitKind.CELL_STATE, scene.state), ())


def _of_belt(scene: Scene, key: e.TaskKey) -> Iterator[Cause]:
    """Yield why an item is not in its next section yet."""
    if scene.moves:
        yield cause_of(Wait('', WaitKind.BELT), ())
    there = scene.cycles.get(key.section or 0)
    if scene.slots.get(key.section or 0) == key.item and there is not None:
        where = (key.section,) if key.section is not None else ()
        yield cause_of(Wait('', WaitKind.JOB, there.item, where), ())
    yield _turns(scene)


def _of_component(scene: Scene, task: Next) -> Iterator[Cause]:
    if task.component in scene.out_of_service:
        yield cause_of(Wait('', WaitKind.OUT_OF_SERVICE, task.component), ())
    for key, component in scene.kept.items():
        if component == task.component and key != task.key:
            yield Cause(WaitKind.COMPONENT, f'{component}, busy with {key}')


def _of_step(scene: Scene, key: e.TaskKey, script: Script) -> Iterator[Cause]:
    cycle = scene.cycles.get(key.section or 0)
    if not script.step_of(key.task).requires_conveyor or cycle is None:
        return
    if scene.moves:
        yield cause_of(Wait('', WaitKind.BELT), ())
    elif scene.beat != cycle.beat:
        yield _turns(scene)


def _turns(scene: Scene) -> Cause:
    """Return what keeps the belt at rest."""
    beat = scene.beat or min((one.beat for one in scene.cycles.values()), default=0)
    owing = tuple(
        section
        for section, cycle in sorted(scene.cycles.items())
        if section not in scene.turned and cycle.beat <= beat
    )
    if not owing:
        return Cause(WaitKind.BELT, 'the belt')
    return cause_of(Wait('', WaitKind.TURN, sections=owing), ())


def _of_flags(scene: Scene, key: e.TaskKey, script: Script) -> Iterator[Cause]:
    for flag in script.downstream_of.get(key.task, ()):
        if scene.flags.get(flag.flag, flag.initial) <= 0:
            yield Cause(WaitKind.FLAG, f'{flag.upstream} to set flag {flag.flag}')
    for flag in script.upstream_of.get(key.task, ()):
        if scene.flags.get(flag.flag, flag.initial) >= flag.capacity:
            yield Cause(WaitKind.FLAG, f'{flag.downstream} to take flag {flag.flag}')


def _of_zones(scene: Scene, key: e.TaskKey, script: Script, scripts: Scripts) -> Iterator[Cause]:
    own = set(script.zones_of.get(key.task, ()))
    for other in scene.kept if own else ():
        theirs = scripts(other.job or '')
        shared = own.intersection(theirs.zones_of.get(other.task, ())) if theirs else ()
        if shared and other != key:
            yield Cause(WaitKind.ZONE, f'zone {min(shared)}, taken by {other}')
