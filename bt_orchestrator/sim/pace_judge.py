"""How fast a script is by the engine itself: with good items only, and with what is likely."""

from __future__ import annotations

import random
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Approval, Cell
from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.goal import GoalEnd, GoalRequest, GoalStatus
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.reference import Reference, Template
from bt_orchestrator.model.script import RunsFor, Script, SectionList, Step, Task
from bt_orchestrator.ports import ActionTypes, EventSink, EventStore, Told
from bt_orchestrator.sim.gateway import VirtualGateway
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.sim.standing_answers import StandingAnswers
from bt_orchestrator.sim.virtual_client import VirtualGoal
from bt_orchestrator.view.report.pace_text import Expected
from bt_orchestrator.view.report.rates import FAILS, RUNS, Rate

ITEMS = 24
"""Beside those that fill the line: a line with shared spaces need not repeat itself at once."""

MOST_DRAWN = 1000
"""Items of a run in which it is drawn what happens to each."""

MOST_TASKS = 20_000
"""Tasks of such a run; a long script has fewer items."""

BATCHES = 20
"""Parts of such a run whose means are compared, to know how sure the mean of all is."""

T_OF_BATCHES = 2.093
"""Student's t for 95 % and one degree of freedom less than there are batches."""

_DRAWN = 'drawn'
"""Goal field and result field of such a run; no field of a message is asked for there."""


class PaceJudge:
    """Runs scripts in virtual time. Implements `planning.Judge`."""

    def __init__(
        self, cell: Cell, types: ActionTypes, new_store: Callable[[], EventStore]
    ) -> None:
        """Judge scripts of a cell.

        :param new_store: makes an empty store, for each run
        """
        components = {
            name: replace(component, faults=()) for name, component in cell.components.items()
        }
        conveyor = replace(cell.conveyor, component=components[cell.conveyor.component.name])
        self._cell = replace(
            cell,
            conveyor=conveyor,
            components=components,
            hold_after=None,
            first_piece=Approval.AUTOMATIC,
        )
        self._types = types
        self._new_store = new_store

    def pace_s(self, script: Script) -> float | None:
        """Return the seconds between good items; None: the line does not get so far."""
        fill = script.sink - script.source + 1
        left = _Left()
        simulation = self._simulation(left)
        simulation.submit([Job('J', _with_tasks(script, _good), fill + ITEMS, {})])
        outcome = simulation.run()
        simulation.close()
        if outcome is not Outcome.FINISHED:
            return None
        times_s = left.times_s[: ITEMS + 1]  # no more items come when the others leave
        half = len(times_s) // 2
        return (times_s[-1] - times_s[half]) / (len(times_s) - 1 - half)

    def expected(self, script: Script, rates: Sequence[Rate]) -> Expected | None:
        """Return the pace with what is likely, the same in every run.

        Each task that may be skipped or fail is drawn by itself, but tasks with one condition are
        drawn together. What has no rate is as with `pace_s`.

        :return: None: the line does not get so far, or the script is too long for a sure figure
        """
        fill = script.sink - script.source + 1
        items = min(MOST_DRAWN, MOST_TASKS // len(script.tasks))
        runs = {rate.task: rate.share for rate in rates if rate.what == RUNS}
        fails = {rate.task: rate.share for rate in rates if rate.what == FAILS}
        drawn = _DrawnTasks(script, runs, fails, items + 2 * fill)
        left = _Left()
        simulation = self._simulation(left, robots=partial(_DrawnRobots, fails))
        operator = StandingAnswers(simulation, ('mark_done', 'skip'), 0.0, 'expected pace')
        simulation.submit([Job('J', _with_tasks(script, drawn), items + 2 * fill, {})])
        outcome = simulation.run(operator.look)
        simulation.close()
        times_s = left.times_s[fill - 1 : -fill]
        size = (len(times_s) - 1) // BATCHES
        if outcome is not Outcome.FINISHED or not size:
            return None
        ends_s = times_s[: size * BATCHES + 1 : size]
        means_s = [(end - begin) / size for begin, end in pairwise(ends_s)]
        return Expected(
            per_item_s=statistics.fmean(means_s),
            sure_s=T_OF_BATCHES * statistics.stdev(means_s) / BATCHES**0.5,
            items=size * BATCHES,
            good=left.good / len(left.times_s),
            holds=left.holds,
            rates=tuple(rates),
            always=tuple(drawn.always),
        )

    def _simulation(self, sink: EventSink, **more: Any) -> Simulation:
        return Simulation(self._cell, self._types, self._new_store(), [sink], **more)


class _Left:
    """When items left, and how many of them were good. Implements `ports.EventSink`."""

    def __init__(self) -> None:
        self.times_s: list[float] = []
        self.good = 0
        self.holds = 0
        self._nonconforming: set[str | None] = set()

    def publish(self, events: Sequence[e.Event]) -> None:
        """Note it."""
        for event in events:
            if isinstance(event, e.ItemRemoved):
                self.times_s.append(event.time)
                self.good += event.how == 'packed' and event.item not in self._nonconforming
            elif isinstance(event, e.TaskContinued):
                self._nonconforming.add(event.nonconforming)
            elif isinstance(event, e.ItemNonconforming):
                self._nonconforming.add(event.item)
            elif isinstance(event, e.HoldRaised):
                self.holds += 1


class _DrawnRobots(VirtualGateway):
    """Robots whose tasks fail as often as is likely, each by numbers of its own."""

    def __init__(self, fails: Mapping[str, float], *args: Any, **more: Any) -> None:
        super().__init__(*args, **more)
        self._fails = fails
        self._numbers = {name: random.Random(name) for name in fails}

    def drain(self) -> Sequence[Told]:
        """Return what is new; what ended well may have failed."""
        news = super().drain()
        for entry in news:
            if isinstance(entry, VirtualGoal) and entry.end is not None:
                entry.end = self._drawn(entry.request, entry.end)
        return news

    def _drawn(self, request: GoalRequest, end: GoalEnd) -> GoalEnd:
        task, is_judged = request.args.get(_DRAWN, ('', False))
        if task not in self._fails:
            return end
        is_good = self._numbers[task].random() >= self._fails[task]
        if is_judged:
            return replace(end, result={_DRAWN: is_good})
        return end if is_good else replace(end, status=GoalStatus.ABORTED)


class _DrawnTasks:
    """Makes each task of a script one that runs and fails as often as is likely."""

    def __init__(
        self, script: Script, runs: Mapping[str, float], fails: Mapping[str, float], items: int
    ) -> None:
        self._fails = fails
        self._items = items
        self._met: dict[Condition, Condition] = {}
        """A condition on the number of the item, for each that has a rate."""
        self.always: list[str] = []
        """Tasks with a condition that has none."""
        for name, share in runs.items():
            condition = script.tasks[name].condition
            assert condition is not None
            met = 1.0 - share if condition.negated else share
            self._met.setdefault(_unsigned(condition), self._draw(name, met))

    def __call__(self, task: Task) -> Task:
        """Return the task for the drawn run."""
        is_judged = task.fails_unless is not None and task.id in self._fails
        seen = Condition(Template((Reference('results', task.id, (_DRAWN,)),)))
        return replace(
            task,
            args={_DRAWN: (task.id, is_judged)},
            condition=None if task.condition is None else self._condition(task.id, task.condition),
            fails_unless=seen if is_judged else None,
            identifies=(),
        )

    def _condition(self, task: str, condition: Condition) -> Condition | None:
        drawn = self._met.get(_unsigned(condition))
        if drawn is None:
            self.always.append(task)
            return None
        return replace(drawn, negated=condition.negated)

    def _draw(self, name: str, share: float) -> Condition:
        numbers = random.Random(f'{name} runs')
        met = [number for number in range(1, self._items + 1) if numbers.random() < share]
        # No item has number 0, and a condition needs one at least.
        return Condition(Template((Reference('item', 'number'),)), one_of=(0, *met))


def _unsigned(condition: Condition) -> Condition:
    """Return what `when` and `unless` have in common."""
    return replace(condition, negated=False)


def _good(task: Task) -> Task:
    """Return a task that runs for every good item, and succeeds."""
    # Nobody rejects an item here; a task for rejected ones is skipped.
    runs_for = RunsFor.REJECTED if task.runs_for is RunsFor.REJECTED else RunsFor.GOOD
    return replace(
        task, args={}, condition=None, fails_unless=None, identifies=(), runs_for=runs_for
    )


def _with_tasks(script: Script, change: Callable[[Task], Task]) -> Script:
    """Return a script with changed tasks: no initialization, setups, values of orders, limits."""
    return replace(
        script,
        sections={
            number: _section(section, change) for number, section in script.sections.items()
        },
        initialization=(),
        initialization_dependencies=(),
        params={},
        lots={},
        hold_after=None,
    )


def _section(section: SectionList, change: Callable[[Task], Task]) -> SectionList:
    def changed(task: Task) -> Task:
        return replace(change(task), setup={}, change=None)

    steps = (
        Step(tuple(tuple(map(changed, track)) for track in step.tracks)) for step in section.steps
    )
    return replace(section, steps=tuple(steps))
