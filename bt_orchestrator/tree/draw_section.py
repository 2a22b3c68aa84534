"""One section as a titled group: its slot on the belt, and its list from top to bottom."""

from __future__ import annotations

import graphviz

from bt_orchestrator.model.script import Release, SectionList, Step, Task
from bt_orchestrator.tree.draw_card import CARD_WIDTH, Sheet, belt_words, card, details
from bt_orchestrator.tree.draw_text import BAR, FAINT, INK, PAPER, RULE, entry, font, table, tooltip

INVISIBLE = {'style': 'invis', 'weight': '0'}
SECTION_FILL = '#f4f6f9'
SLOT_FILL = '#d5dae2'
GROUP_FILL = '#e6ebf2'


def slot(section: int) -> str:
    """Name the node of a section's slot."""
    return f'slot.{section}'


def node_of(task: Task) -> str:
    """Name the node of a task."""
    return f'task.{task.id}'


def add_section(graph: graphviz.Digraph, sheet: Sheet, number: int) -> list[str]:
    """Draw one section; returns its lowest nodes."""
    tasks = sheet.script.sections.get(number)
    with graph.subgraph(name=f'cluster.section.{number}') as cluster:
        cluster.attr(
            label=f'<{font(heading(sheet, number), size=13, bold=True)}>',
            labeljust='l',
            style='filled,rounded',
            fillcolor=SECTION_FILL,
            color=RULE,
            margin='10',
            tooltip=_about(sheet, number),
        )
        label = bar(f'slot {number}', INK, SLOT_FILL)
        cluster.node(slot(number), label, tooltip=f'position {number} of the belt')
        if tasks is None:
            return _nothing(cluster, number)
        return _steps(cluster, sheet, tasks)


def heading(sheet: Sheet, number: int) -> str:
    """Return the title of a section."""
    script = sheet.script
    roles = [('source', script.source), ('sink', script.sink)]
    named = [role for role, section in roles if section == number]
    return ' \u00b7 '.join([f'Section {number}', *named])


def _about(sheet: Sheet, number: int) -> str:
    components = sheet.cell.components.values()
    here = [one.name for one in components if number in one.sections]
    return tooltip([heading(sheet, number), f'components: {", ".join(here) or "none"}'])


def _nothing(cluster: graphviz.Digraph, number: int) -> list[str]:
    name = f'idle.{number}'
    text = font('no task: items pass', size=10, colour=FAINT, italic=True)
    cluster.node(name, table([[entry(text)]]), tooltip='this script has no list for this section')
    cluster.edge(slot(number), name, **INVISIBLE)
    return [name]


def _steps(cluster: graphviz.Digraph, sheet: Sheet, tasks: SectionList) -> list[str]:
    ends = [slot(tasks.section)]
    for number, step in enumerate(tasks.steps):
        if number == tasks.turn_steps:
            ends = _release(cluster, tasks.section, ends)
        ends = _step(cluster, sheet, tasks, step, ends)
    if tasks.release is not Release.END_OF_CYCLE and tasks.turn_steps == len(tasks.steps):
        ends = _release(cluster, tasks.section, ends)
    return ends


def _release(cluster: graphviz.Digraph, section: int, above: list[str]) -> list[str]:
    """Draw where the turn is complete before the list ends (semantics 3.8)."""
    name = f'release.{section}'
    hint = 'the belt may move from here on; what is below runs meanwhile'
    cluster.node(name, bar('belt released', PAPER, BAR), tooltip=hint)
    _join(cluster, above, [name], f'{section}.release')
    return [name]



def bar(text: str, colour: str, fill: str) -> str:
    """Return the label of a bar across a section."""
    words = font(text, size=10, bold=True, colour=colour)
    return table([[entry(words, align='CENTER', width=CARD_WIDTH)]], fill=fill)


def _step(
    cluster: graphviz.Digraph, sheet: Sheet, tasks: SectionList, step: Step, above: list[str]
) -> list[str]:
    """Draw a task or a group below what is there; returns its lowest nodes."""
    number = tasks.steps.index(step) + 1
    if step.is_group:
        with cluster.subgraph(name=f'cluster.group.{tasks.section}.{number}') as group:
            group.attr(
                label=f'<{font("in parallel", size=10, italic=True)}>',
                style='filled,rounded',
                fillcolor=GROUP_FILL,
                color=RULE,
                margin='8',
                tooltip='these start together; the group ends when all of them ended',
            )
            _tracks(group, sheet, tasks, step)
    else:
        _tracks(cluster, sheet, tasks, step)
    first = [node_of(track[0]) for track in step.tracks]
    _join(cluster, above, first, f'{tasks.section}.{number}')
    return [node_of(track[-1]) for track in step.tracks]


def _tracks(graph: graphviz.Digraph, sheet: Sheet, tasks: SectionList, step: Step) -> None:
    for track in step.tracks:
        for task in track:
            add_task(graph, sheet, task, belt_words(tasks, step, task))
        for one, following in zip(track, track[1:]):
            graph.edge(node_of(one), node_of(following))


def add_task(graph: graphviz.Digraph, sheet: Sheet, task: Task, belt: str = '') -> None:
    """Draw the card of a task."""
    name = node_of(task)
    graph.node(name, card(sheet, task, belt), id=name, tooltip=details(sheet, task, belt))


def _join(graph: graphviz.Digraph, above: list[str], below: list[str], name: str) -> None:
    """Draw the order of two steps; two groups meet in a point."""
    if len(above) > 1 and len(below) > 1:
        point = f'join.{name}'
        graph.node(point, '', shape='point', width='0.06', color=INK)
        for node in above:
            graph.edge(node, point, arrowhead='none')
        above = [point]
    for one in above:
        for other in below:
            graph.edge(one, other, weight='20')
