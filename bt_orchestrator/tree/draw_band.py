"""What stands above the line: initialization, the belt's own move, the legend."""

from __future__ import annotations

from collections.abc import Iterator

import graphviz

from bt_orchestrator.model.script import INDEX, Task
from bt_orchestrator.model.state import CellState
from bt_orchestrator.tree.belt import index_task
from bt_orchestrator.tree.draw_card import ITEM_FILL, OFF_BELT, ZONE_FILLS, Sheet, belt_words
from bt_orchestrator.tree.draw_flags import FLAG
from bt_orchestrator.tree.draw_section import INVISIBLE, SECTION_FILL, add_task
from bt_orchestrator.tree.draw_text import BAR, PAPER, RULE, entry, font, table

LEGEND = 'legend'
MOVE = f'task.{INDEX}'


def add_band(graph: graphviz.Digraph, sheet: Sheet) -> list[str]:
    """Draw what is above the line; returns the nodes below which the line begins."""
    lowest = [*_initialization(graph, sheet), *_belt(graph, sheet)]
    graph.node(LEGEND, legend(sheet), tooltip='legend')
    top = [f'task.{task.id}' for task in sheet.script.initialization if not _upstream(sheet, task)]
    with graph.subgraph() as rank:
        rank.attr(rank='same')
        for node in (*top, MOVE, LEGEND):
            rank.node(node)
    for one, following in zip((*top, MOVE), (*top[1:], MOVE, LEGEND)):
        graph.edge(one, following, **INVISIBLE)
    return [*lowest, LEGEND]


def _initialization(graph: graphviz.Digraph, sheet: Sheet) -> list[str]:
    script = sheet.script
    if not script.initialization:
        return []
    with graph.subgraph(name='cluster.initialization') as cluster:
        _title(cluster, 'Initialization, for every order', _INITIALIZATION)
        for task in script.initialization:
            add_task(cluster, sheet, task)
        for dependency in script.initialization_dependencies:
            cluster.edge(f'task.{dependency.upstream}', f'task.{dependency.downstream}')
    return [f'task.{task.id}' for task in script.initialization]


_INITIALIZATION = 'what no arrow orders runs at the same time; a section begins the first item '\
    'of an order when its own components are initialized'


def _upstream(sheet: Sheet, task: Task) -> bool:
    dependencies = sheet.script.initialization_dependencies
    return any(dependency.downstream == task.id for dependency in dependencies)


def _belt(graph: graphviz.Digraph, sheet: Sheet) -> list[str]:
    with graph.subgraph(name='cluster.belt') as cluster:
        _title(cluster, 'Belt, after every beat', 'moves every item by one slot')
        add_task(cluster, sheet, index_task(CellState(sheet.cell)))
    return [MOVE]


def _title(cluster: graphviz.Digraph, text: str, hint: str) -> None:
    cluster.attr(
        label=f'<{font(text, size=13, bold=True)}>',
        labeljust='l',
        style='filled,rounded',
        fillcolor=SECTION_FILL,
        color=RULE,
        margin='10',
        tooltip=hint,
    )


# --- legend -----------------------------------------------------------------------------------


def legend(sheet: Sheet) -> str:
    """Explain the marks that this drawing has."""
    rows = [[entry(font('Legend', size=11, bold=True), span=2)]]
    rows += [[sample, entry(font(meaning, size=9))] for sample, meaning in _entries(sheet)]
    return table(rows, border=1, fill=PAPER, spacing=2)


def _entries(sheet: Sheet) -> Iterator[tuple[str, str]]:
    script = sheet.script
    task = entry(font('id', size=10, bold=True))
    yield task, 'a task: id, task constant, action, arguments; hold if it fails'
    yield _sample('+1 item', ITEM_FILL), 'places an item on the belt, \u22121 takes it out'
    yield entry(font('\u2192', size=11)), 'one after the other; side by side: at the same time'
    if _off_belt(sheet):
        yield entry(font('dashed', size=9, italic=True)), f'{OFF_BELT}: need not wait for it to rest'
    if script.dependencies:
        flag = entry(font('- -\u25b6', size=10, colour=FLAG, bold=True))
        yield flag, '\u25b2 sets a flag (waits while it is full), \u25bc takes it (waits while it is 0)'
    if script.zones:
        zone = 'tasks of one zone never run at the same time'
        yield _sample('\u25a0 zone', ZONE_FILLS[0]), zone
    if any(tasks.turn_steps < len(tasks.steps) for tasks in script.sections.values()):
        bar = entry(font('belt released', size=9, bold=True, colour=PAPER), fill=BAR)
        yield bar, 'the belt may move; other sections release it at their end'
    else:
        yield entry(''), 'the belt moves when every section has come to its end'


def _sample(text: str, fill: str) -> str:
    return entry(font(text, size=9), fill=fill)


def _off_belt(sheet: Sheet) -> bool:
    return any(
        belt_words(tasks, step, task)
        for tasks in sheet.script.sections.values()
        for step in tasks.steps
        for task in step.tasks
    )
