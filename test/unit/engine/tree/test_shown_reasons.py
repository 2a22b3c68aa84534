"""Conditions, verdicts, rounds and ends in the messages that tree viewers show."""

from __future__ import annotations

import pydot
from fakes.line import Line
from fakes.virtual_run import BY, VirtualRun
from py_trees.display import dot_tree

from bt_orchestrator.model.jobs.job_commands import UpdateJob
from bt_orchestrator.model.jobs.order import Job

CONDITIONAL = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2:
    - {id: weigh, @a2}
    - {id: seal, @b2, when: {value: "${results.weigh.measurement}", at_least: "${params.least}"}}
  3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
params: {least: {type: float, default: 2.5}}
"""
JUDGED = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2:
    - repeat:
        - {id: glue, @b2}
        - {id: weigh, @a2, fails_unless: {value: "${results.weigh.measurement}",
                                          at_least: "${params.least}"}}
      times: 1
  3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
params: {least: {type: float, default: 2.5}}
"""


def shown(run: VirtualRun) -> dict[str, str]:
    """Return the message of each behaviour of the tree by its name."""
    root = run.sim.orchestrator.tree.root
    return {behaviour.name: behaviour.feedback_message for behaviour in root.iterate()}


def until(script: str, time: float, **faults: str) -> dict[str, str]:
    line = Line(faults=faults)
    return shown(line.begin(script).go(until=time))


def test_skipped_task_names_condition_and_value() -> None:
    messages = until(CONDITIONAL, 4.2, a2='#1=reads:1.5')
    assert messages['seal (TASK_A)'].startswith('skipped: when ${results.weigh.measurement}')
    assert messages['when ${results.weigh.measurement} at least 2.5'] == 'found 1.5'


def test_started_task_shows_its_condition_value() -> None:
    messages = until(CONDITIONAL, 4.2, a2='#1=reads:3.5')
    assert messages['seal (TASK_A)'].startswith('running at ')
    assert messages['when ${results.weigh.measurement} at least 2.5'] == 'found 3.5'


def test_a_round_tells_why_it_began() -> None:
    messages = until(JUDGED, 5.2, a2='#1=reads:1.5')
    why = 'expected ${results.weigh.measurement} at least 2.5; found 1.5'
    assert messages['up to 1 more round'] == f'round 2: weigh: {why}'


def test_verdict_shows_bound_of_own_job() -> None:
    line = Line()
    run = line.begin(JUDGED, least=7.0)
    assert 'fails unless ${results.weigh.measurement} at least 7.0' in shown(run)


def test_changed_job_parameters_update_shown_bound() -> None:
    line = Line()
    run = line.begin(JUDGED)
    script = line.script(JUDGED)
    run.submit('K', script, least=7.0)
    verdict = 'fails unless ${results.weigh.measurement} at least'
    assert f'{verdict} 7.0' in shown(run)
    run.ask(UpdateJob(Job('K', script, 1, {'least': 9.0}), BY))
    run.go(until=0.5)
    assert f'{verdict} 9.0' in shown(run)
    assert f'{verdict} 7.0' not in shown(run)


def test_a_job_that_is_being_aborted_says_so() -> None:
    run = Line().begin(CONDITIONAL).go(until=3.5)
    run.control('abort', 'J')
    section = run.sim.orchestrator.tree.sections[2]
    assert 'J/1, the job is being aborted' in [node.feedback_message for node in section.iterate()]


def test_dot_graph_merges_no_behaviours() -> None:
    """Pydot reads `a: b` as port b of node a."""
    run = Line().begin(CONDITIONAL).go(until=3.5)
    root = run.sim.orchestrator.tree.root
    drawn = dot_tree(root)
    assert isinstance(drawn, pydot.Dot)
    assert len(drawn.get_nodes()) - _DEFAULTS == len(list(root.iterate()))


_DEFAULTS = 3
"""Nodes of pydot that stand for the defaults of graph, nodes and edges."""
