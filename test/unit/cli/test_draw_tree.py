"""Drawings of the behaviour tree, as DOT text."""

from __future__ import annotations

from fakes.dot_text import DotText
from fakes.line import THREE, Line, with_section
from py_trees.blackboard import Blackboard

from bt_orchestrator.cli.draw_tree import draw_tree


def drawn(text: str) -> DotText:
    line = Line()
    return DotText(draw_tree(line.script(text), line.cell).dot)


def test_tree_shows_every_behaviour_in_tick_order() -> None:
    dot = drawn(with_section(2, '- {id: work, @a2, retries: 1}'))
    assert dot.nodes['root']['shape'] == 'parallelogram'
    parts = [dot.nodes[f'root.{n}']['label'] for n in range(1, 6)]
    assert parts == ['initialization', 'section 3', 'section 2', 'section 1', 'belt']
    branch = [dot.nodes[f'root.3.1.2{deeper}']['label'] for deeper in ('', '.1', '.1.1', '.1.1.1')]
    assert branch == ['belt at rest', 'hold if it fails', 'retry up to 1 time', 'work (TASK_A)']
    assert dot.nodes['root.3.1.2.1.1.1']['tooltip'].startswith(
        'action: work (TASK_A) (ActionLeaf)'
    )
    assert set(dot.edges) == {f'{n.rpartition(".")[0]} -> {n}' for n in dot.nodes if '.' in n}


def test_a_repeat_and_a_verdict_are_seen() -> None:
    judged = 'fails_unless: {value: "${results.look.measurement}", at_least: 2}'
    repeat = f'- repeat: [{{id: glue, @b2}}, {{id: look, @a2, {judged}}}]\n  times: 2'
    dot = drawn(with_section(2, repeat))
    names = [dot.nodes[f'root.3.1.2{below}']['label'] for below in ('.1', '.1.1', '.1.1.2.1')]
    verdict = 'fails unless ${results.look.measurement} at least 2'
    assert names == ['up to 2 more rounds', 'in order', verdict]


def test_drawing_the_tree_leaves_nothing_on_the_blackboard() -> None:
    before = set(Blackboard.clients)
    drawn(f'{THREE}zones: {{z: [work, pack]}}')
    assert set(Blackboard.clients) == before


def test_equal_scripts_give_equal_trees_for_graphviz() -> None:
    line = Line()
    first, other = (draw_tree(line.script(THREE), line.cell) for _ in range(2))
    assert first == other
    assert b'<svg' in first.content('svg')
