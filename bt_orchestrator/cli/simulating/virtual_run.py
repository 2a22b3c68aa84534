"""Results that `simulate` gives with `mark_done`: `TASK.FIELD=VALUE`, against the task's type."""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.check import as_json
from bt_orchestrator.cli.output import WrongUse, cannot_write
from bt_orchestrator.cli.pacing import Pacing
from bt_orchestrator.cli.simulating.cost_watch import CostWatch
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.model.script import Script, Task
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.wait import PartWait
from bt_orchestrator.ports import ActionTypes, EventSink
from bt_orchestrator.script.given_values import given_results, results_of, results_text
from bt_orchestrator.sim.faults import with_faults
from bt_orchestrator.sim.simulation import Outcome, Simulation, standstill
from bt_orchestrator.sim.standing_answers import StandingAnswers
from bt_orchestrator.store.trace import TraceFile
from bt_orchestrator.view.drawing.gantt import Gantt, GanttFold
from bt_orchestrator.view.drawing.gantt_page import gantt_svg
from bt_orchestrator.view.report.forecast import Forecast
from bt_orchestrator.view.report.forecast_fold import ForecastFold
from bt_orchestrator.view.report.forecast_text import detail_lines, job_lines, summary_lines
from bt_orchestrator.view.report.pace_text import ScriptPace
from bt_orchestrator.view.report.wait_log import WaitLog


def standing_results(
    words: Sequence[str], scripts: Iterable[Script], cell: Cell, types: ActionTypes
) -> Mapping[str, Mapping[str, Any]]:
    """Return the results of each task, by its id.

    :raises WrongUse: there is no such task, or they do not fit its action type
    """
    tasks = {name: task for script in scripts for name, task in script.tasks.items()}
    fields: dict[str, list[str]] = defaultdict(list)
    for word in words:
        name = _task_of(word, tasks)
        fields[name].append(word[len(name) + 1 :])
    return {name: _read(name, given, tasks[name], cell, types) for name, given in fields.items()}


def _task_of(word: str, tasks: Mapping[str, Task]) -> str:
    """Return the task that a word is about; an id may have dots, so the longest that fits."""
    fitting = [name for name in tasks if word.startswith(f'{name}.')]
    if not fitting:
        raise WrongUse(
            f'--result is TASK.FIELD=VALUE, with a task of the scripts: {", ".join(tasks)}; '
            f'found {word!r}'
        )
    return max(fitting, key=len)


def _read(
    name: str, given: Sequence[str], task: Task, cell: Cell, types: ActionTypes
) -> Mapping[str, Any]:
    try:
        return given_results(
            results_text(results_of(given)), types.action(cell.components[task.component].type)
        )
    except (CommandRefused, ValueError) as why:
        raise WrongUse(f'--result of {name}: {why}') from why


ROWS = ('sections', 'components')
"""The kinds of rows of a chart."""

WHO = 'simulate --on-hold'
"""The operator in the records of the run."""


@dataclass(frozen=True)
class RunOptions:
    """How a run goes, whatever the cell and the orders."""

    begin: float = 0.0
    """Time 0 of the run, seconds since the epoch."""
    faults: Sequence[str] = ()
    on_hold: Sequence[str] = ()
    answer_after_s: float = 0.0
    trace: Path | None = None
    gantt: Path | None = None
    results: Sequence[str] = ()
    rows: str = ROWS[0]
    """The kind of a row of the chart; one of ROWS."""
    journal: Path | None = None
    """A journal with rates for the expected pace."""


@dataclass(frozen=True)
class Run:
    """The outcome of a virtual run."""

    outcome: Outcome
    time_s: float
    forecast: Forecast
    waits: tuple[PartWait, ...]
    """The circle of waits at the end, if it is stuck."""
    holds: tuple[Hold, ...]
    complaints: tuple[str, ...]
    """Why holds were not answered although there was an answer to give."""
    paces: tuple[ScriptPace, ...]
    """The pace of the line with each script, whatever this run; in the order of the jobs."""


def run_jobs(
    cell: Cell, given: Sequence[bootstrap.Given], types: ActionTypes, options: RunOptions
) -> Run:
    """Run jobs on a cell, from time 0.

    :raises WrongFaults: a fault names what is not there
    :raises UnusableTrace: the trace cannot be written
    :raises WrongUse: the chart cannot be written
    :raises Refused: the cell does not take all jobs
    :raises TooCostly: the run would take too much memory
    :raises JournalUnusable: the journal cannot be read
    """
    scripts = [order.job.script for order in given]
    results = standing_results(options.results, scripts, cell, types)
    cell = with_faults(cell, options.faults, types)
    fold, gantt = ForecastFold(), GanttFold(by_component=options.rows == ROWS[1])
    with ExitStack() as stack:
        cost = CostWatch(sum(order.job.quantity for order in given))
        sinks: list[EventSink] = [fold, gantt, cost]
        if options.trace is not None:
            sinks.append(stack.enter_context(TraceFile(options.trace)))
        simulation = bootstrap.build_simulation(cell, types, sinks)
        stack.callback(simulation.close)
        bootstrap.queue(simulation, [_in_time_of_run(order, options.begin) for order in given])
        log = WaitLog()
        operator = StandingAnswers(
            simulation, options.on_hold, options.answer_after_s, WHO, results
        )
        answering = operator if options.on_hold else None
        outcome = simulation.run(_looks(simulation, log, answering, cost))
        waits, now_s = log.end(simulation.clock.now()), simulation.clock.now()
        if options.gantt is not None:
            sections, names = cell.conveyor.sections, list(cell.components)
            _draw(gantt.chart(cell.name, sections, waits, now_s, names), options.gantt)
        pacing = Pacing(cell, types, options.journal)
        paces = map(pacing.of, {script.name: script for script in scripts}.values())
        return _result(simulation, outcome, fold.forecast(cell, waits), operator, tuple(paces))


def _in_time_of_run(given: bootstrap.Given, begin: float) -> bootstrap.Given:
    """Return an order whose times count from the begin of the run, as all others of it do."""
    terms = given.job.terms
    start, due = (None if at is None else at - begin for at in (terms.start, terms.due))
    terms = dataclasses.replace(terms, start=start, due=due)
    return given._replace(job=dataclasses.replace(given.job, terms=terms))


def _looks(
    simulation: Simulation, log: WaitLog, operator: StandingAnswers | None, cost: CostWatch
) -> Callable[[], None]:
    def look() -> None:
        cost.look()
        log.look(simulation.state, simulation.waits(), simulation.clock.now())
        if operator is not None:
            operator.look()

    return look


def _draw(gantt: Gantt, path: Path) -> None:
    try:
        path.write_text(gantt_svg(gantt), encoding='utf-8')
    except OSError as error:
        raise WrongUse(cannot_write(f'the Gantt chart {path}', error)) from error


def _result(
    simulation: Simulation,
    outcome: Outcome,
    forecast: Forecast,
    operator: StandingAnswers,
    paces: tuple[ScriptPace, ...],
) -> Run:
    is_stuck = outcome is Outcome.STUCK
    waits = standstill(simulation.state, simulation.waits()) if is_stuck else []
    holds = tuple(simulation.state.holds.values())
    complaints = tuple(operator.complaints())
    now_s = simulation.clock.now()
    return Run(outcome, now_s, forecast, tuple(waits), holds, complaints, paces)


# --- as text ----------------------------------------------------------------------------------


def lines_of(done: Run, *, with_details: bool = False) -> Iterator[str]:
    """Yield what came of a run, for a person.

    :param with_details: also how busy sections and components were, and what they waited for
    """
    if done.outcome is Outcome.FINISHED:
        yield from summary_lines(done.forecast, done.paces)
        if with_details:
            yield from ('', *detail_lines(done.forecast))
        return
    yield f'{done.outcome.value} at {done.time_s:.1f} s:'
    for wait in done.waits:
        yield f'  {wait}'
    for hold in done.holds:
        yield from _hold_lines(hold)
    for complaint in done.complaints:
        yield f'  {complaint}'
    yield ''
    yield from job_lines(done.forecast)


def _hold_lines(hold: Hold) -> Iterator[str]:
    yield f'  hold {hold.id}: {hold_words(hold)}'
    yield f'    possible answers: {", ".join(hold.answers)}'


# --- as data ----------------------------------------------------------------------------------


def plain(done: Run) -> dict[str, Any]:
    """Return everything about a run as data that JSON can carry."""
    slowest = done.forecast.bottleneck
    return {
        **as_json(()),
        'ok': done.outcome is Outcome.FINISHED,
        'outcome': done.outcome.value,
        'time_s': done.time_s,
        'forecast': dataclasses.asdict(done.forecast),
        'bottleneck': None if slowest is None else dataclasses.asdict(slowest),
        'waits': [{'part': wait.part, **to_plain(wait.wait)} for wait in done.waits],
        'holds': [dataclasses.asdict(hold) for hold in done.holds],
        'complaints': list(done.complaints),
        'paces': [pace.plain() for pace in done.paces],
    }
