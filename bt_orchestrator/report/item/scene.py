"""The facts of a cell at a moment that tasks wait for: a fold from any event on.

The state of the cell (`model.state`) knows more, but needs the cell file and every event before.
What is not known yet here blocks nothing.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.frozen import changed


@dataclass(frozen=True)
class Scene:
    """One moment."""

    state: str = ''
    """PackML state of the cell; empty: not known."""
    is_ending: bool = False
    """The node ends, or ended: nothing starts."""
    moves: bool = False
    """The belt."""
    beat: int = 0
    slots: Mapping[int, str] = field(default_factory=dict)
    """Items, and empty positions, by section."""
    cycles: Mapping[int, e.CycleStarted] = field(default_factory=dict)
    """In hand, by section."""
    turned: frozenset[int] = frozenset()
    """Sections whose cycle in hand has released the belt."""
    holds: Mapping[str, e.HoldRaised] = field(default_factory=dict)
    running: Mapping[e.TaskKey, e.TaskStarted] = field(default_factory=dict)
    kept: Mapping[e.TaskKey, str] = field(default_factory=dict)
    """Components of tasks that run, or are held."""
    delayed: Mapping[e.TaskKey, float] = field(default_factory=dict)
    """Until when tasks that are to be tried again are delayed."""
    flags: Mapping[str, int] = field(default_factory=dict)
    unready: frozenset[str] = frozenset()
    out_of_service: frozenset[str] = frozenset()


class Shot(NamedTuple):
    """A scene, and from when on it was so."""

    time: float
    scene: Scene


class Film:
    """The scenes since the first event, in order."""

    def __init__(self) -> None:
        self._times: list[float] = []
        self._scenes: list[Scene] = []
        self.now = Scene()

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        fold = _FOLDS.get(type(event))
        after = self.now if fold is None else fold(self.now, event)
        if after is not self.now:
            self._keep(event.time, after)

    def _keep(self, time: float, scene: Scene) -> None:
        self.now = scene
        if self._times and self._times[-1] >= time:
            self._scenes[-1] = scene  # of one moment, or the clock was set back
            return
        self._times.append(time)
        self._scenes.append(scene)

    def between(self, start: float, end: float) -> Iterator[tuple[float, float, Scene]]:
        """Yield the scenes of a stretch of time: from when to when each was so."""
        place = max(0, bisect_right(self._times, start) - 1)
        while place < len(self._times) and self._times[place] < end:
            until = self._times[place + 1] if place + 1 < len(self._times) else end
            begin, until = max(start, self._times[place]), min(until, end)
            if begin < until:
                yield begin, until, self._scenes[place]
            place += 1


def _without(known: Mapping[Any, Any], *keys: object) -> dict[Any, Any]:
    return {key: value for key, value in known.items() if key not in keys}


# --- the line -----------------------------------------------------------------------------------


def _cycle_started(scene: Scene, event: e.CycleStarted) -> Scene:
    cycles = {**scene.cycles, event.section: event}
    return changed(scene, cycles=cycles, turned=scene.turned - {event.section})


def _cycle_completed(scene: Scene, event: e.CycleCompleted) -> Scene:
    return changed(scene, cycles=_without(scene.cycles, event.section))


def _turned(scene: Scene, event: e.TurnCompleted) -> Scene:
    return changed(scene, turned=scene.turned | {event.section})


def _index_started(scene: Scene, _: e.BeltIndexStarted) -> Scene:
    return changed(scene, moves=True)


def _beat(scene: Scene, event: e.BeltIndexed | e.BeatStarted) -> Scene:
    return changed(scene, moves=False, beat=event.beat)


def _flag(scene: Scene, event: e.FlagRaised | e.FlagLowered) -> Scene:
    return changed(scene, flags={**scene.flags, event.flag: event.count})


def _stands(scene: Scene, event: e.ItemPlaced | e.ItemMissing | e.ItemMoved) -> Scene:
    elsewhere = {section: item for section, item in scene.slots.items() if item != event.item}
    slots = dict(sorted({**elsewhere, event.section: event.item}.items()))
    return changed(scene, slots=slots)


def _gone(scene: Scene, event: e.ItemRemoved | e.PositionEnded) -> Scene:
    return changed(scene, slots={s: i for s, i in scene.slots.items() if i != event.item})


# --- tasks --------------------------------------------------------------------------------------


def _task_started(scene: Scene, event: e.TaskStarted) -> Scene:
    return changed(
        scene,
        running={**scene.running, event.key: event},
        kept={**scene.kept, event.key: event.component},
        delayed=_without(scene.delayed, event.key),
    )


def _task_ended(scene: Scene, event: e.TaskEvent) -> Scene:
    return changed(
        scene,
        running=_without(scene.running, event.key),
        kept=_without(scene.kept, event.key),
        delayed=_without(scene.delayed, event.key),
    )


def _task_retrying(scene: Scene, event: e.TaskRetrying) -> Scene:
    return changed(scene, delayed={**scene.delayed, event.key: event.not_before})


def _round_begun(scene: Scene, event: e.RoundBegun) -> Scene:
    again = [e.TaskKey(event.job, event.section, event.item, task) for task in event.tasks]
    return changed(scene, kept=_without(scene.kept, *again))


def _held(scene: Scene, event: e.HoldRaised) -> Scene:
    kept = scene.kept
    if event.task is not None and event.attempt:  # the robot stays where it stopped
        key = e.TaskKey(event.job, event.section, event.item, event.task)
        kept = {**kept, key: event.component}
    return changed(scene, holds={**scene.holds, event.hold: event}, kept=kept)


def _released(scene: Scene, event: e.HoldReleased) -> Scene:
    return changed(scene, holds=_without(scene.holds, event.hold))


# --- the cell -----------------------------------------------------------------------------------


def _readiness(scene: Scene, event: e.ComponentStateChanged) -> Scene:
    others = scene.unready - {event.component}
    return changed(scene, unready=others if event.ready else others | {event.component})


def _out(scene: Scene, event: e.ComponentOutOfService) -> Scene:
    return changed(scene, out_of_service=scene.out_of_service | {event.component})


def _in(scene: Scene, event: e.ComponentInService) -> Scene:
    return changed(scene, out_of_service=scene.out_of_service - {event.component})


def _state(scene: Scene, event: e.CellStateChanged) -> Scene:
    return changed(scene, state=event.state)


def _stopping(scene: Scene, _: e.OrchestratorStopping) -> Scene:
    return changed(scene, is_ending=True)


def _started(scene: Scene, _: e.OrchestratorStarted) -> Scene:
    return changed(scene, is_ending=False)


_FOLDS: Mapping[type[e.Event], Callable[[Scene, Any], Scene]] = {
    e.CycleStarted: _cycle_started,
    e.CycleCompleted: _cycle_completed,
    e.TurnCompleted: _turned,
    e.BeltIndexStarted: _index_started,
    e.BeltIndexed: _beat,
    e.BeatStarted: _beat,
    e.FlagRaised: _flag,
    e.FlagLowered: _flag,
    e.ItemPlaced: _stands,
    e.ItemMissing: _stands,
    e.ItemMoved: _stands,
    e.ItemRemoved: _gone,
    e.PositionEnded: _gone,
    e.TaskStarted: _task_started,
    e.TaskSucceeded: _task_ended,
    e.TaskFailed: _task_ended,
    e.TaskMarkedDone: _task_ended,
    e.TaskSkipped: _task_ended,
    e.TaskContinued: _task_ended,
    e.TaskRetrying: _task_retrying,
    e.RoundBegun: _round_begun,
    e.HoldRaised: _held,
    e.HoldReleased: _released,
    e.ComponentStateChanged: _readiness,
    e.ComponentOutOfService: _out,
    e.ComponentInService: _in,
    e.CellStateChanged: _state,
    e.OrchestratorStopping: _stopping,
    e.OrchestratorStarted: _started,
}
