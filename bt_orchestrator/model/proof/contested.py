"""The single things: components and zones for which tasks may have to wait."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from bt_orchestrator.model.script import INDEX, RunsFor, Script, Task


class Place(NamedTuple):
    """Where a task stands; tasks of one place never run at the same time."""

    section: int
    """0 for the move of the belt."""
    step: int = 0
    track: int = 0


def contested(script: Script, move: Task) -> Mapping[str, Sequence[str]]:
    """Return the components and zones that tasks for good items may wait for, with these tasks.

    The tasks of one section follow each other, except in different tracks of a group.
    """
    users: dict[str, dict[str, Place]] = defaultdict(dict)
    users[move.component][INDEX] = Place(0)
    for task, place in _places(script):
        users[task.component][task.id] = place
        for zone in script.zones_of.get(task.id, ()):
            users[f'zone {zone}'][task.id] = place
    return {name: list(found) for name, found in users.items() if _may_meet({*found.values()})}


def _places(script: Script) -> Iterator[tuple[Task, Place]]:
    for section, tasks in script.sections.items():
        for number, step in enumerate(tasks.steps):
            for track, members in enumerate(step.tracks):
                for task in members:
                    if task.runs_for is not RunsFor.REJECTED:
                        yield task, Place(section, number, track)


def _may_meet(places: set[Place]) -> bool:
    """Tell whether tasks at some places may want to run at the same time."""
    sections = {place.section for place in places}
    steps = {(place.section, place.step) for place in places}
    return len(sections) > 1 or len(places) > len(steps)
