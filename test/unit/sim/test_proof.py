"""The deadlock proof, against what really happens on the line (semantics 8.2)."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from fakes.action_types import FakeActionTypes
from fakes.line import Line

from bt_orchestrator.model.goal import GoalRequest
from bt_orchestrator.model.order import Job
from bt_orchestrator.model.script import Script
from bt_orchestrator.sim.proof import DeadlockProof
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()
LINES = 40
"""Random lines a run: enough to meet every kind of circle, in seconds."""


def proof(line: Line) -> DeadlockProof:
    return DeadlockProof(line.cell, TYPES, MemoryStore)


def ends(line: Line, script: Script, quantity: int, seed: int | None = None) -> bool:
    """Tell whether a run of the whole script ends; with a seed, with random durations."""
    drawn = random.Random(seed)

    def duration(_: GoalRequest) -> float:
        return 1.0 if seed is None else drawn.choice([0.0, 0.5, 1.0, 7.0, 40.0])

    simulation = Simulation(line.cell, TYPES, MemoryStore(), duration=duration)
    simulation.submit([Job('J', script, quantity)])
    outcome = simulation.run()
    simulation.close()
    assert outcome is not Outcome.HELD
    return outcome is Outcome.FINISHED


def flagged(upstream: int, downstream: int, **dependency: int) -> str:
    """Return a script for five sections whose flag couples two of the inner ones."""
    listed = ''.join(f', {key}: {value}' for key, value in dependency.items())
    return f"""
sections:
  1: [{{id: place, @a1, qty_change: 1}}]
  2: [{{id: t2, @a2}}]
  3: [{{id: t3, @a3}}]
  4: [{{id: t4, @a4}}]
  5: [{{id: pack, @a5, qty_change: -1}}]
lateral_dependencies:
  - {{flag: coupled, upstream: t{upstream}, downstream: t{downstream}{listed}}}
"""


def test_neighbours_need_no_more_than_capacity_one() -> None:
    line = Line(5)
    assert proof(line).deadlock(line.script(flagged(2, 3))) is None


@pytest.mark.parametrize(
    ('text', 'remedy'),
    [
        (flagged(2, 4), 'capacity 2 of flag coupled frees it'),
        (flagged(3, 2), 'initial count 1 of flag coupled frees it'),
        (flagged(4, 2), 'initial count 2 with capacity 2 of flag coupled frees it'),
    ],
)
def test_the_smallest_remedy_is_named_and_works(text: str, remedy: str) -> None:
    line = Line(5)
    found = proof(line).deadlock(line.script(text))
    assert found is not None
    assert found.remedy == remedy
    assert found.flags == ('coupled',)

    numbers = [int(word) for word in remedy.split() if word.isdigit()]
    initial = numbers[0] if 'initial' in remedy else 0
    cured = text.replace('}\n', f', initial: {initial}, capacity: {numbers[-1]}}}\n')
    assert proof(line).deadlock(line.script(cured)) is None


def test_a_circle_of_two_flags_that_no_count_of_one_can_free() -> None:
    line = Line(3)
    text = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: late, @a2}, {id: early, @b2}]
  3: [{id: first, @a3}, {id: second, @b3}, {id: pack, @a3, qty_change: -1}]
lateral_dependencies:
  - {flag: one, upstream: second, downstream: late, initial: 0}
  - {flag: two, upstream: first, downstream: early, initial: 0}
"""
    found = proof(line).deadlock(line.script(text))
    assert found is not None
    assert found.remedy == ''
    objection = proof(line).objection(line.script(text))
    assert objection is not None
    assert objection.hint == 'no larger capacity or initial count of one flag frees it'


def test_failing_controllers_and_silent_topics_are_no_deadlock() -> None:
    line = Line(5, faults={'a2': '#*=abort', 'a3': '=silent'}, topics=('a3',))
    assert proof(line).deadlock(line.script(flagged(2, 3))) is None


def _random_script(drawn: random.Random, sections: int) -> str:
    lists: dict[int, list[str]] = {1: [], sections: []}
    for number in range(1, sections + 1):
        for which in range(drawn.randint(0 if 1 < number < sections else 1, 3)):
            conveyor = drawn.choice(['', '', ', requires_conveyor: false'])
            device = drawn.choice('ab')
            lists.setdefault(number, []).append(
                f'{{id: t{number}_{which}, @{device}{number}{conveyor}}}'
            )
    ids = [task.split(',')[0][5:] for tasks in lists.values() for task in tasks]
    lists[1].insert(drawn.randint(0, len(lists[1])), '{id: place, @a1, qty_change: 1}')
    lists[sections].append(f'{{id: pack, @a{sections}, qty_change: -1}}')
    text = 'sections:\n' + ''.join(_section(drawn, n, lists[n]) for n in sorted(lists))
    flags = drawn.sample(range(9), drawn.randint(1, 3))
    text += 'lateral_dependencies:\n'
    for flag in flags:
        upstream, downstream = drawn.sample(ids, 2)
        capacity = drawn.randint(1, 3)
        initial = drawn.randint(0, capacity)
        text += (
            f'  - {{flag: f{flag}, upstream: {upstream}, downstream: {downstream}, '
            f'capacity: {capacity}, initial: {initial}}}\n'
        )
    return text


def _section(drawn: random.Random, number: int, tasks: list[str]) -> str:
    early = drawn.random() < 0.3 and any('false' not in task for task in tasks)
    release = 'after_last_conveyor_task' if early else 'end_of_cycle'
    return f'  {number}: {{release_conveyor: {release}, tasks: [{", ".join(tasks)}]}}\n'


def test_the_proof_agrees_with_whole_runs_of_random_lines() -> None:
    drawn = random.Random(20)
    verdicts = []
    for _ in range(LINES):
        sections = drawn.randint(2, 5)
        line = Line(sections)
        text = _random_script(drawn, sections)
        script = line.script(text)
        fine = proof(line).deadlock(script) is None
        verdicts.append(fine)
        assert ends(line, script, 3 * sections) == fine, text
        for seed in range(2):
            assert ends(line, script, 3 * sections, seed) == fine, text
    assert 0.1 < verdicts.count(True) / len(verdicts) < 0.9


def test_a_script_is_proven_once(monkeypatch: pytest.MonkeyPatch) -> None:
    line = Line(5)
    one = proof(line)
    first = one.deadlock(line.script(flagged(2, 4)))
    monkeypatch.setattr('bt_orchestrator.sim.proof.Simulation', None)
    assert one.deadlock(line.script(flagged(2, 4))) is first
    assert one.deadlock(replace(line.script(flagged(2, 4)), dependencies=())) is None
