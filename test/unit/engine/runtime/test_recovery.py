"""A killed orchestrator is followed by one that goes on (semantics 9.1, 9.2)."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.clocks import SetClock
from fakes.commands import Abort, AnswerHold, ControlJob, Pause, Resume
from fakes.line import THREE, Line, with_section
from fakes.operator import ann
from fakes.reading import Reading
from fakes.world import World, begun, killed_at_work

from bt_orchestrator.base.errors import JournalFailed, JournalMismatch
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model import events as e
from bt_orchestrator.model.fault import parse_fault
from bt_orchestrator.model.goal import RESULT_TIMEOUT_S
from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.stop_reason import StopReason
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.store.sqlite.store import SqliteStore

TYPES = FakeActionTypes()
FLAGS = (
    with_section(2, '- {id: work, @a2}\n- parallel: [{id: x, @a2.TASK_B}, {id: y, @b2}]')
    + 'lateral_dependencies: [{flag: seen, upstream: work, downstream: pack}]\n'
    + 'initialization: [{id: home, task: HOME, action: /belt/do, once: true}]\n'
)


def work_of(world: World) -> list[tuple[str | None, str]]:
    """Return what was done in all, as (item, task), in no order."""
    done = [event for event in world.store.read() if isinstance(event, e.TaskSucceeded)]
    return sorted((event.item or '', event.task) for event in done)


def killed_after_each_settle(line: Line, text: str) -> Iterator[tuple[int, World, Orchestrator]]:
    """Run a line anew for each settle, kill it there, and let a successor end the work."""
    for settles in itertools.count(1):
        world = World(line.cell)
        first = begun(world, line.script(text))
        world.go(first, settles)
        if not first.state.jobs:
            break
        first.close()
        second = world.orchestrator()
        world.go(second)
        yield settles, world, second


@pytest.mark.parametrize('text', [THREE, FLAGS])
def test_9_2_kill_after_any_settle_changes_no_result(text: str) -> None:
    line = Line()
    whole = World(line.cell)
    whole.go(begun(whole, line.script(text)))
    expected, kills = work_of(whole), 0

    for settles, world, second in killed_after_each_settle(line, text):
        assert not second.state.jobs, f'killed after {settles} settles'
        assert second.state.ended['J'].progress.packed == 3
        assert work_of(world) == expected
        starts = [event.goal for event in world.events(e.TaskStarted)]  # type: ignore[attr-defined]
        assert len(starts) == len(set(starts)) == len(expected)
        assert world.clock.now() == whole.clock.now()
        second.close()
        kills += 1
    assert kills > 10


JUDGED = with_section(
    2,
    """
    - id: work
      task: TASK_A
      action: /a2/do
      retries: 1
      on_failure: continue
      fails_unless: {value: "${results.work.measurement}", at_most: 1.5}
    - {id: use, @b2, args: {special_argument_2: "${results.work.measurement}"}}
    """,
)


def story_of(world: World) -> list[tuple[object, ...]]:
    """Return how each attempt ended and what it gave, and what the next task was given."""
    story: list[tuple[object, ...]] = []
    for event in world.store.read():
        if isinstance(event, (e.TaskSucceeded, e.TaskFailed)):
            story.append((event.time, event.item, event.task, event.attempt, event.results))
        elif isinstance(event, e.TaskStarted):
            which = (event.round, event.attempt)
            story.append((event.time, event.item, event.task, *which, event.args))
        elif isinstance(event, e.RoundBegun):
            story.append((event.time, event.item, event.repeat, event.n))
    return story


def assert_killed_anywhere_it_ends_the_same(
    line: Line, text: str, story: list[tuple[object, ...]]
) -> None:
    """Kill the orchestrator after each settle, one run for each, and compare what became of it."""
    kills = 0
    for settles, world, second in killed_after_each_settle(line, text):
        assert story_of(world) == story, f'killed after {settles} settles'
        second.close()
        kills += 1
    assert kills > 10


CHANGED = with_section(
    2,
    """
    - {id: one, @a2, setup: {gripper: small}}
    - {id: to_large, @a2.TASK_C, args: {special_argument_1: large}, runs_for: all}
    - {id: two, @a2, setup: {gripper: large}}
    - {id: to_small, @a2.TASK_C, args: {special_argument_1: small}, runs_for: all}
    """,
)


def test_5_3_killed_after_any_settle_setups_are_the_same() -> None:
    setups = 'setups: {gripper: [small, large]}, '
    line = Line(
        keys={
            'a2': f'{setups}changes: {{gripper: {{task: TASK_C, argument: special_argument_1}}}}'
        }
    )
    whole = World(line.cell)
    whole.go(begun(whole, line.script(CHANGED)))
    story = story_of(whole)
    assert len([step for step in story if 'small' in str(step[-1])]) == 4
    assert_killed_anywhere_it_ends_the_same(line, CHANGED, story)


def test_2_8_kill_after_any_settle_changes_no_verdict() -> None:
    line = Line(faults={'a2': '#1=reads:2.5 #3=reads:3.5 #4=reads:4.5'})
    whole = World(line.cell)
    whole.go(begun(whole, line.script(JUDGED)))
    refused = [entry.results for entry in whole.events(e.TaskFailed)]  # type: ignore[attr-defined]
    assert [entry['measurement'] for entry in refused] == [2.5, 3.5, 4.5]
    assert_killed_anywhere_it_ends_the_same(line, JUDGED, story_of(whole))


REPEATED = with_section(
    2,
    """
    - repeat:
        - {id: glue, @b2}
        - id: work
          task: TASK_A
          action: /a2/do
          on_failure: continue
          fails_unless: {value: "${results.work.measurement}", at_most: 1.5}
      times: 2
    - {id: use, @b2.TASK_B, args: {special_argument_2: "${results.work.measurement}"}}
    """,
)


def test_3_9_kill_after_any_settle_changes_no_round() -> None:
    line = Line(faults={'a2': '#1=reads:2.5 #3=reads:3.5 #4=reads:4.5 #5=reads:5.5'})
    whole = World(line.cell)
    whole.go(begun(whole, line.script(REPEATED)))
    rounds = [(event.item, event.n) for event in whole.events(e.RoundBegun)]  # type: ignore[attr-defined]
    assert rounds == [('J/1', 1), ('J/2', 1), ('J/2', 2)]
    assert_killed_anywhere_it_ends_the_same(line, REPEATED, story_of(whole))


def test_6_8_killed_after_any_settle_every_serial_is_known() -> None:
    reading = Reading(faults='"#2=reads:1"')
    whole = World(reading.cell)
    ended = begun(whole, reading.script())
    whole.go(ended)
    assert [hold.reason for hold in ended.state.holds.values()] == ['duplicate_serial']
    expected, kills = story_of(whole), 0

    for settles in itertools.count(1):
        world = World(reading.cell)
        first = begun(world, reading.script())
        world.go(first, settles)
        if first.state.holds:
            break
        first.close()
        second = world.orchestrator()
        world.go(second)
        assert story_of(world) == expected, f'killed after {settles}'
        assert second.state.holds == ended.state.holds
        second.close()
        kills += 1
    assert kills == 10


def test_9_2_without_auto_resume_nothing_new_starts_until_resume() -> None:
    line = Line()
    world = World(line.cell)
    first = killed_at_work(world, line.script(THREE), 3)
    running = [key.task for key in first.state.running]
    second = world.orchestrator(auto_resume=False)
    world.go(second)

    assert running == ['work', 'place']
    assert [event.task for event in world.events(e.TaskAdopted)] == running  # type: ignore[attr-defined]
    assert second.state.packml is PackmlState.HELD
    assert not second.state.running
    (hold,) = second.state.holds.values()
    assert (hold.reason, hold.message) == ('restarted', 'unfinished jobs: 1, goals in flight: 2')

    answer = second.ask(AnswerHold(hold.id, 'retry', ann()))
    assert answer.message.startswith(f'hold 1 (restarted, {hold.message}) takes no answer; ')
    assert not second.ask(Resume(ann('back from lunch'))).accepted
    assert second.ask(Resume(ann('the line was looked at'), hold=hold.id)).accepted
    world.go(second)
    assert second.state.ended['J'].progress.packed == 3


def test_9_2_a_pause_does_not_hide_a_restart() -> None:
    line = Line()
    world = World(line.cell)
    first = begun(world, line.script(THREE), 3)
    assert first.ask(Pause(ann('a visitor'))).accepted
    first.close()
    second = world.orchestrator(auto_resume=False)
    assert [hold.reason for hold in second.state.holds.values()] == ['paused', 'restarted']
    assert second.ask(Resume(ann('the visitor left'))).accepted
    world.go(second)
    assert [hold.reason for hold in second.state.holds.values()] == ['restarted']
    assert len(world.events(e.TaskStarted)) == 1, 'nobody has looked at the line yet'
    second.close()

    third = world.orchestrator(auto_resume=False)
    assert [hold.reason for hold in third.state.holds.values()] == ['restarted'], 'one is enough'


@pytest.mark.parametrize(
    ('reason', 'left'), [('restarted', []), ('restored', ['1']), ('twin', ['1'])]
)
def test_9_2_auto_resume_ends_only_restart_hold(reason: str, left: list[str]) -> None:
    world = World(Line().cell)
    world.store.append([e.HoldRaised(seq=1, hold='1', reason=reason, answers=('resume',))])
    assert list(world.orchestrator(auto_resume=True).state.holds) == left


@pytest.mark.parametrize(('repeatable', 'ends'), [('true', True), ('false', False)])
def test_9_2_a_goal_that_its_server_does_not_know(repeatable: str, ends: bool) -> None:
    line = Line(faults={'a2': '#1=die:0.5'})
    world = World(line.cell)
    script = line.script(with_section(2, f'- {{id: work, @a2, repeatable: {repeatable}}}'))
    killed_at_work(world, script)
    world.clock.advance()  # the server dies
    world.clock.advance()  # and is back, knowing nothing
    second = world.orchestrator()
    world.go(second)

    assert (not second.state.jobs) is ends
    if ends:
        (resent,) = world.events(e.TaskResent)
        assert isinstance(resent, e.TaskResent)
        assert resent.goal in {event.goal for event in world.events(e.TaskStarted)}  # type: ignore[attr-defined]
    else:
        (hold,) = second.state.holds.values()
        assert (hold.task, hold.reason) == ('work', 'in_doubt')


def killed_before_sending(
    line: Line,
    wait_s: float = 0.0,
    meanwhile: Callable[[SetClock], None] = lambda clock: None,
) -> tuple[World, Orchestrator]:
    """Kill an orchestrator that has committed the start of `work`, and start another one.

    :param meanwhile: what happens to the machine's clocks between the two
    """
    world = World(line.cell)
    first = begun(world, line.script(with_section(2, '- {id: work, @a2.TASK_B}')), 1)
    world.gateway.unsent = 'TASK_B'
    world.go_until_starts(first, 'work')
    first.close()
    world.gateway.unsent = None
    world.clock.sleep(wait_s)
    meanwhile(world.clock)
    second = world.orchestrator()
    world.go(second)
    return world, second


def test_9_2_unreceived_goal_is_resent_with_same_uuid() -> None:
    world, second = killed_before_sending(Line())
    assert second.state.ended['J'].progress.packed == 1
    (resent,) = world.events(e.TaskResent)
    assert isinstance(resent, e.TaskResent)
    started = [x for x in world.events(e.TaskStarted) if isinstance(x, e.TaskStarted)]
    assert [x.goal for x in started if x.task == 'work'] == [resent.goal]
    assert not world.events(e.TaskFailed)
    assert not world.events(e.TaskAdopted), 'its server never knew it'


def test_9_2_goal_is_adopted_after_server_confirms_it() -> None:
    world = World(Line().cell)
    killed_at_work(world, Line().script(with_section(2, '- {id: work, @a2.TASK_B}')))
    unheard = world.orchestrator()
    unheard.settle()
    assert not world.events(e.TaskAdopted), 'no answer has come yet'
    unheard.close()

    third = world.orchestrator()
    third.settle()
    world.clock.advance()
    third.settle()
    (adopted,) = world.events(e.TaskAdopted)
    assert isinstance(adopted, e.TaskAdopted)
    assert (adopted.task, adopted.attempt) == ('work', 1)
    assert [key.task for key in third.state.running] == ['work'], 'it still runs'
    world.go(third)
    assert world.events(e.TaskAdopted) == [adopted]
    assert not third.state.jobs


def test_9_2_a_result_confirms_a_goal_too() -> None:
    world = World(Line().cell)
    killed_at_work(world, Line().script(with_section(2, '- {id: work, @a2.TASK_B}')))
    world.clock.sleep(RESULT_TIMEOUT_S / 2)  # it ends meanwhile
    world.go(world.orchestrator())
    kinds = [
        type(event).__name__
        for event in world.store.read()
        if isinstance(event, e.TaskEvent) and event.task == 'work'
    ]
    assert kinds == ['TaskStarted', 'TaskAdopted', 'TaskSucceeded']


def test_9_2_second_kill_before_answer_repeats_nothing() -> None:
    """The second orchestrator dies before it hears that the goal never arrived."""
    world = World(Line().cell)
    first = begun(world, Line().script(with_section(2, '- {id: work, @a2.TASK_B}')), 1)
    world.gateway.unsent = 'TASK_B'
    world.go_until_starts(first, 'work')
    first.close()
    world.gateway.unsent = None
    second = world.orchestrator()
    second.settle()
    second.close()
    world.go(world.orchestrator())
    assert not world.events(e.TaskAdopted)
    assert len(world.events(e.TaskResent)) == 1
    assert [item for item, task in work_of(world) if task == 'work'] == ['J/1']


def test_9_2_goal_listed_on_status_topic_has_arrived() -> None:
    """The server forgets sooner than the cell file says; then its denial is no proof."""
    line = Line()
    quick = replace(line.cell.components['a2'], result_timeout_s=1.0)
    world = World(replace(line.cell, components={**line.cell.components, 'a2': quick}))
    world.cell = line.cell
    killed_at_work(world, line.script(with_section(2, '- {id: work, @a2.TASK_B}')))
    world.clock.sleep(RESULT_TIMEOUT_S / 2)
    second = world.orchestrator()
    world.go(second)
    assert not world.events(e.TaskResent)
    assert not world.events(e.TaskAdopted), 'its server does not know it any more'
    (hold,) = second.state.holds.values()
    assert (hold.reason, hold.topic_says) == ('in_doubt', 'succeeded')


def cancelled_before_it_arrived(command: Asked, wait_s: float = 0.0) -> tuple[World, Orchestrator]:
    """Kill an orchestrator that has cancelled `place`, which never arrived, and start another."""
    line = Line()
    text = THREE.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    world = World(line.cell)
    world.gateway.unsent = 'TASK_A'
    first = begun(world, line.script(text), 1)
    world.go_until_starts(first, 'place')
    assert first.ask(command).accepted
    first.close()
    world.gateway.unsent = None
    world.clock.sleep(wait_s)
    second = world.orchestrator()
    world.go(second)
    return world, second


def test_9_2_unreceived_cancelled_goal_ends_without_hold() -> None:
    world, second = cancelled_before_it_arrived(ControlJob('abort', 'J', ann()))
    (failed,) = world.events(e.TaskFailed)
    assert isinstance(failed, e.TaskFailed)
    failure = (failed.reason, failed.message, failed.never_begun)
    assert failure == ('canceled', 'it never reached its server', True)
    assert not world.events(e.HoldRaised), 'no robot has placed the item'
    assert not world.events(e.TaskResent)
    assert not second.state.jobs


def test_9_2_possibly_received_cancelled_goal_is_in_doubt() -> None:
    _, second = cancelled_before_it_arrived(ControlJob('abort', 'J', ann()), RESULT_TIMEOUT_S)
    (hold,) = second.state.holds.values()
    assert hold.reason == 'in_doubt'


def test_9_2_hold_after_abort_says_goal_never_arrived() -> None:
    _, second = cancelled_before_it_arrived(Abort(ann('a hand in the cell')))
    (hold,) = second.state.holds.values()
    assert (hold.reason, hold.message) == ('in_doubt', 'it never reached its server')
    assert 'reject' in hold.answers, 'it is known that the item was not placed'


def test_9_2_server_may_have_forgotten_old_goals() -> None:
    world, second = killed_before_sending(Line(), wait_s=RESULT_TIMEOUT_S)
    assert [hold.reason for hold in second.state.holds.values()] == ['in_doubt']
    assert not world.events(e.TaskResent)


def test_9_2_a_status_topic_decides_nothing_but_is_told() -> None:
    """The goal succeeded while nobody was there, and its result is forgotten."""
    world = World(Line().cell)
    killed_at_work(world, Line().script(with_section(2, '- {id: work, @a2.TASK_B}')))
    world.clock.sleep(RESULT_TIMEOUT_S + 5.0)
    second = world.orchestrator()
    world.go(second)
    (hold,) = second.state.holds.values()
    assert (hold.reason, hold.topic_says) == ('in_doubt', 'succeeded')
    assert hold.answers[0] == 'mark_done'
    assert hold.message.startswith('after a restart of the orchestrator: ')
    assert 'the status topic says: succeeded' in hold_words(hold)


def test_9_2_cell_file_sets_server_memory_time() -> None:
    line = Line()
    short = replace(line.cell.components['a2'], result_timeout_s=1.0)
    line.cell = replace(line.cell, components={**line.cell.components, 'a2': short})
    _, second = killed_before_sending(line)
    assert [hold.reason for hold in second.state.holds.values()] == ['in_doubt']


def other_machine(clock: SetClock) -> None:
    """Go on at a machine whose wall clock is behind."""
    clock.boot, clock.ahead_s = 'second machine', -9.0


def twin_machine(clock: SetClock) -> None:
    """Go on at a machine that was booted at the same moment, and whose clock is right."""
    clock.boot = 'second machine'


def rebooted(clock: SetClock) -> None:
    """Start the machine anew."""
    clock.boot, clock.booted_s = 'first machine, later', clock.steady()


def set_back(clock: SetClock) -> None:
    """Set the wall clock back, by less than has passed since the goal was sent."""
    clock.ahead_s = -9.0


def set_forward(clock: SetClock) -> None:
    """Set the wall clock forward: a server of this machine may have forgotten by it."""
    clock.ahead_s = 3600.0


def untold(clock: SetClock) -> None:
    """Let the machine tell neither its boot nor its uptime."""
    clock.boot = None


@pytest.mark.parametrize(
    ('meanwhile', 'wait_s'),
    [
        (set_back, RESULT_TIMEOUT_S + 2.0),
        (other_machine, RESULT_TIMEOUT_S + 2.0),
        (other_machine, 0.0),
        (twin_machine, 0.0),
        (rebooted, 0.0),
        (set_forward, 0.0),
        (untold, 0.0),
    ],
)
def test_9_2_a_clock_that_was_set_proves_nothing(
    meanwhile: Callable[[SetClock], None], wait_s: float
) -> None:
    world, second = killed_before_sending(Line(), wait_s, meanwhile)
    assert [hold.reason for hold in second.state.holds.values()] == ['in_doubt']
    assert not world.events(e.TaskResent)


def test_9_2_a_journal_without_uptimes_proves_nothing() -> None:
    line = Line()
    world = World(line.cell)
    world.clock.boot = None
    first = begun(world, line.script(with_section(2, '- {id: work, @a2.TASK_B}')), 1)
    world.gateway.unsent = 'TASK_B'
    world.go_until_starts(first, 'work')
    first.close()
    world.gateway.unsent, world.clock.boot = None, 'first machine'
    second = world.orchestrator()
    world.go(second)
    assert [hold.reason for hold in second.state.holds.values()] == ['in_doubt']
    assert not world.events(e.TaskResent)


def test_9_2_another_instance_of_the_server_proves_nothing() -> None:
    line = Line(faults={'a2': '#1=die:0.5'})
    world = World(line.cell)
    killed_at_work(world, line.script(with_section(2, '- {id: work, @a2}')))
    world.clock.advance()  # the server dies
    world.clock.advance()  # and is back at once, knowing nothing
    second = world.orchestrator()
    world.go(second)
    sent = second.state.tasks[next(iter(second.state.holds.values())).key].sent  # type: ignore[index]
    assert world.clock.now() < sent + RESULT_TIMEOUT_S
    assert [hold.reason for hold in second.state.holds.values()] == ['in_doubt']


def test_9_2_a_cancelled_goal_stays_cancelled() -> None:
    line = Line(faults={'a2': '#1=hang'})
    world = World(line.cell)
    killed_at_work(world, line.script(with_section(2, '- {id: work, @a2, timeout: 5.0}')))
    second = world.orchestrator()
    world.go(second)
    failed = [event.reason for event in world.events(e.TaskFailed)]  # type: ignore[attr-defined]
    assert failed == ['timeout']


def test_2_6_external_cancel_during_downtime_is_in_doubt() -> None:
    line = Line(faults={'a2': '#1=cancel'})
    world = World(line.cell)
    options = 'retries: 2, repeatable: true, on_failure: continue'
    killed_at_work(world, line.script(with_section(2, f'- {{id: work, @a2, {options}}}')))
    world.clock.sleep(5.0)
    second = world.orchestrator()
    world.go(second)
    (hold,) = second.state.holds.values()
    assert (hold.task, hold.reason) == ('work', 'in_doubt')
    assert hold.message.startswith('cancelled by somebody else')
    assert not world.events(e.TaskRetrying)


def test_7_2_pause_lets_what_runs_end_and_starts_nothing() -> None:
    line = Line()
    world = World(line.cell)
    orchestrator = begun(world, line.script(FLAGS))
    world.go(orchestrator, 6)
    assert orchestrator.ask(Pause(ann('a visitor'))).accepted
    before = len(world.events(e.TaskStarted))
    world.go(orchestrator)
    assert len(world.events(e.TaskStarted)) == before
    assert orchestrator.state.packml is PackmlState.HELD
    assert orchestrator.ask(Resume(ann('gone'))).accepted
    world.go(orchestrator)
    assert orchestrator.state.ended['J'].progress.packed == 3
    refused = orchestrator.ask(Resume(ann('again')))
    assert refused.message == 'the cell is not paused; it is Complete'


def test_changed_cell_is_refused_during_unfinished_work() -> None:
    line = Line()
    world = World(line.cell)
    first = begun(world, line.script(THREE))
    world.go(first, 3)
    first.close()
    lamp = replace(line.cell.components['lamp'], faults=(parse_fault('#1=abort'),))
    world.cell = replace(line.cell, components={**line.cell.components, 'lamp': lamp})
    with pytest.raises(JournalMismatch, match=r'unfinished jobs \(J\) and the cell file has'):
        world.orchestrator()


class FullDisk(MemoryStore):
    """A journal that cannot be written from some event on."""

    def append(self, events):  # type: ignore[no-untyped-def]
        if events[-1].seq > 30:
            raise JournalFailed('the journal x.sqlite3 cannot be written: disk full')
        super().append(events)


def test_9_1_nothing_is_sent_that_is_not_durable() -> None:
    line = Line()
    world = World(line.cell, FullDisk())
    first = begun(world, line.script(THREE))
    world.go(first)
    assert first.broken is not None
    assert 'disk full' in first.broken
    assert (first.state.packml, first.state.stop_reason) == (
        PackmlState.HELD,
        StopReason.OWN_FAULT,
    )
    assert 'disk full' in first.state.stop_message
    assert not first.ask(Pause(ann())).accepted
    assert first.state.seq == len(list(world.store.read())) == 23
    first.close()

    durable = MemoryStore()
    durable.append(list(world.store.read()))
    world.store = durable  # the disk has room again
    second = world.orchestrator()
    world.go(second)
    assert second.state.ended['J'].progress.packed == 3
    assert work_of(world) == sorted(
        [(f'J/{n}', task) for n in (1, 2, 3) for task in ('place', 'work', 'pack')]
        + [('', 'index')] * (len(world.events(e.BeltIndexed)))
    )


def test_the_same_with_a_journal_in_a_file(tmp_path: Path) -> None:
    line = Line()
    path = tmp_path / 'journal.sqlite3'
    store = SqliteStore(path)
    world = World(line.cell, store)
    first = begun(world, line.script(FLAGS))
    world.go(first, 7)
    first.close()
    store.close()
    world.store = again = SqliteStore(path)
    second = world.orchestrator()
    world.go(second)
    again.close()
    assert second.state.ended['J'].progress.packed == 3
