"""Why nothing moves is told with its root cause, one second after everything came to rest."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from fakes.commands import Abort, Pause, Stop
from fakes.line import THREE, TYPES, Line, with_section
from fakes.virtual_run import BY, VirtualRun

from bt_orchestrator.engine.runtime.overview import Overview, description_of
from bt_orchestrator.extensions.opcua.server.simple import values as opcua_values
from bt_orchestrator.extensions.page.web.parts.parts import cell_part
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.goal import Contest
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job, Terms
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.model.wait import StandCause, Stands
from bt_orchestrator.view.report.wait_chains import causes, chains
from bt_orchestrator.view.screen import words

FAR = 2e6
"""Seconds after which no test looks any more."""

GENERATED = f'made_from: {{recipe: WM-100, version: 3}}\n{THREE}'


def settled(run: VirtualRun, after_s: float = 30.0) -> CellStatus:
    """Return the status a while after nothing more happens."""
    run.go()
    return Overview(run.sim.orchestrator).status(run.now + after_s)


def stands(run: VirtualRun) -> Stands:
    """Return why the cell stands then."""
    halt = settled(run).stands
    assert halt is not None
    return halt


def of_a2() -> VirtualRun:
    """Return a line whose second section cannot start its task for a service stop."""
    run = Line().begin(THREE, 3).go(until=0.5)
    run.service('a2', out=True)
    return run


def held() -> VirtualRun:
    return Line(faults={'a2': '#1=abort'}).begin(THREE, 3)


def paused() -> VirtualRun:
    run = Line().begin(THREE, 3).go(until=3.5)
    run.command(Pause)
    return run


def stopped() -> VirtualRun:
    run = Line().begin(THREE, 3).go(until=3.5)
    run.command(Stop)
    return run


def aborted() -> VirtualRun:
    run = Line().begin(THREE, 3).go(until=3.5)
    run.command(Abort)
    return run


def not_ready(component: str) -> VirtualRun:
    text = with_section(2, '- {id: work, @a2}')
    return Line(topics=(component,), faults={component: '#1=not_ready'}).begin(text, 3)


def job_paused() -> VirtualRun:
    run = Line().begin(THREE, 3).go(until=3.5)
    run.control('pause', 'J')
    return run


def unreleased() -> VirtualRun:
    line = Line()
    run = VirtualRun(line.cell, line.types)
    run.submit('K', line.script(GENERATED, 'made'), 2)
    return run


def held_in_queue() -> VirtualRun:
    line = Line()
    run = VirtualRun(line.cell, line.types, auto_start=False)
    run.submit('K', line.script(THREE), 2)
    run.control('hold', 'K')
    return run


def without_orders() -> VirtualRun:
    return Line().begin(THREE, 1)


def unavailable() -> VirtualRun:
    line = Line()
    run = VirtualRun(line.cell, line.types)
    run.service('a2', out=True)
    run.submit('K', line.script(THREE), 2)
    return run


def unreleased_and_held() -> VirtualRun:
    run = unreleased()
    run.control('hold', 'K')
    return run


def later() -> VirtualRun:
    """Return a cell whose only order starts after all that is looked at."""
    line = Line()
    run = VirtualRun(line.cell, line.types)
    job = Job('K', line.script(THREE), 2, terms=Terms(start=FAR))
    assert run.ask(AddJobs((job,), BY)).accepted
    return run


def belt_out() -> VirtualRun:
    run = Line().begin(THREE, 3).go(until=0.5)
    run.service('conveyor', out=True)
    return run


def belt_not_ready() -> VirtualRun:
    topic = '{topic: /belt/state, type: std_msgs/msg/String, field: data, ready: [READY]}'
    line = Line(faults={'conveyor': '#1=not_ready'}, belt=f'state: {topic}')
    return line.begin(THREE, 3)


STANDING: dict[str, tuple[Callable[[], VirtualRun], StandCause, str, str]] = {
    'component out of service': (of_a2, StandCause.OUT_OF_SERVICE, 'a2', 'section 2: waiting'),
    'hold': (held, StandCause.HOLD, '1', 'waiting for an answer to hold 1'),
    'pause': (paused, StandCause.PAUSE, '1', 'waiting for an answer to hold 1'),
    'stop': (stopped, StandCause.COMMAND, 'Stopped', 'the cell is Stopped (Ann'),
    'abort': (aborted, StandCause.COMMAND, 'Aborted', 'the cell is Aborted (Ann'),
    'source': (lambda: not_ready('a1'), StandCause.STARVED, 'a1', 'section 1: waiting for'),
    'sink': (lambda: not_ready('a3'), StandCause.BLOCKED, 'a3', 'section 3: waiting for'),
    'station': (lambda: not_ready('a2'), StandCause.NOT_READY, 'a2', 'section 2: waiting for'),
    'paused job': (job_paused, StandCause.PAUSE, 'J', 'section 1: waiting for J to be resumed'),
    'release': (unreleased, StandCause.RELEASE, 'K', 'K waits for the release of its script'),
    'release of a held job': (
        unreleased_and_held,
        StandCause.JOB_HELD,
        'K',
        'K is held in the queue; K waits for the release of its script',
    ),
    'start': (later, StandCause.JOB_START, 'K', 'K waits for the start of its order'),
    'belt out of service': (belt_out, StandCause.OUT_OF_SERVICE, 'conveyor', 'belt: waiting'),
    'belt not ready': (
        belt_not_ready,
        StandCause.NOT_READY,
        'conveyor',
        'belt: waiting for /belt/state = READY',
    ),
    'held job': (held_in_queue, StandCause.JOB_HELD, 'K', 'K is held in the queue'),
    'order that needs a component': (unavailable, StandCause.OUT_OF_SERVICE, 'K', 'K needs a2'),
    'no order': (without_orders, StandCause.ORDER, '', 'there is no job'),
}

NO_PART = (
    *(stopped, aborted, unreleased, unreleased_and_held, held_in_queue, later),
    *(unavailable, without_orders),
)
"""What stands for a command, or for an order: no part of the cell is the cause."""


@pytest.mark.parametrize('name', STANDING)
def test_7_4_standing_cell_reports_root_cause(name: str) -> None:
    begun, cause, about, reason = STANDING[name]
    halt = stands(begun())
    assert (halt.cause, halt.name) == (cause, about)
    assert halt.reason.startswith(reason)


def out_of_service_and_not_ready() -> VirtualRun:
    run = not_ready('a2').go(until=4.5)
    run.service('a3', out=True)
    return run


ON_THE_LINE = {
    'two causes': out_of_service_and_not_ready,
    **{name: begun for name, (begun, *_) in STANDING.items() if begun not in NO_PART},
}


@pytest.mark.parametrize('name', ON_THE_LINE)
def test_gravest_cause_on_page_is_root_cause(name: str) -> None:
    status = settled(ON_THE_LINE[name]())
    first, *_ = causes(chains(status), status.state)
    assert status.stands is not None
    assert first.root.part.partition('/')[2] == status.stands.name


@pytest.mark.parametrize('name', [name for name in STANDING if name not in ('no order', 'start')])
def test_7_4_job_end_is_unknown_while_cell_stands(name: str) -> None:
    job = settled(STANDING[name][0]()).jobs[0]
    assert job.expected_end_s is None
    assert job.end_unknown


def test_7_4_two_servers_of_action_are_root_cause() -> None:
    run = Line().begin(THREE, 3).go(until=2.5)
    run.sim.gateway._clients['a2'].contest = Contest(('/one', '/two'))
    halt = stands(run)
    assert (halt.cause, halt.name) == (StandCause.CONTESTED, 'a2')
    assert 'there are 2 servers of /a2/do' in halt.reason


def test_7_4_nothing_is_told_before_a_second_of_rest() -> None:
    run = of_a2().go()
    overview = Overview(run.sim.orchestrator)
    rest = run.state.time
    halts = [overview.status(rest + after_s).stands for after_s in (0.0, 0.5, 0.99, 1.0, 9.0)]
    assert [halt is not None for halt in halts] == [False, False, False, True, True]
    assert halts[-1] == halts[-2]
    assert halts[-1] is not None
    assert halts[-1].since == rest


def test_7_4_nothing_is_told_while_a_goal_runs() -> None:
    run = Line(seconds={'a2': 60.0}).begin(THREE, 3).go(until=20.0)
    assert run.state.running
    assert settled_now(run).stands is None


def settled_now(run: VirtualRun) -> CellStatus:
    return Overview(run.sim.orchestrator).status(run.now + 30.0)


def test_7_4_a_cell_that_works_again_stands_no_more() -> None:
    run = of_a2().go()
    overview = Overview(run.sim.orchestrator)
    assert overview.status(run.now + 5.0).stands is not None
    run.service('a2', out=False)
    assert overview.status(run.now + 10.0).stands is None
    assert stands(run).cause is StandCause.ORDER


def test_7_4_job_awaiting_start_has_known_end() -> None:
    assert settled(later()).jobs[0].end_unknown == ''


@pytest.mark.parametrize('name', STANDING)
def test_7_4_page_terminal_and_opc_ua_report_same_cause(name: str) -> None:
    status = settled(STANDING[name][0]())
    halt = status.stands
    assert halt is not None
    part = cell_part(status, description_of(Line().cell, TYPES), '/node')
    assert part['stands'] == {**to_plain(halt, whole=True), 'cause': halt.cause.value}
    shown = dict(opcua_values(status))
    assert (shown['StandsCause'], shown['StandsReason']) == (halt.cause.value, halt.reason)
    assert shown['StandsSince'] is not None
    lines = '\n'.join(words.status_lines(status, None))
    is_said_otherwise = halt.cause in (StandCause.HOLD, StandCause.ORDER) or status.wish
    assert halt.reason in lines or is_said_otherwise


def test_page_and_terminal_name_the_cause() -> None:
    status = settled(of_a2())
    assert (status.state, status.stop_reason) == (PackmlState.EXECUTE, None)
    halt = status.stands
    assert halt is not None
    part = cell_part(status, description_of(Line().cell, TYPES), '/node')
    assert part['stands'] == {**to_plain(halt, whole=True), 'cause': 'out_of_service'}
    assert part['state_kind'] == 'stopped'
    lines = list(words.status_lines(status, None))
    assert any('nothing moves since' in line and halt.reason in line for line in lines)
    assert any(line.endswith('end unknown') for line in lines)


def test_queued_job_awaiting_person_has_no_expected_end() -> None:
    line = Line()
    run = line.begin(THREE, 3)
    run.submit('K', line.script(THREE), 2)
    run.control('hold', 'K')
    run.go(until=3.5)
    first, second = run.sim.status().jobs
    assert (first.end_unknown, second.end_unknown) == ('', 'K is held in the queue')
