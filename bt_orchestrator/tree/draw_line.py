"""A script as its process: the line of sections, with what couples them.

The picture is read like a page: what comes before the line on top, then the belt from left to
right with each section's list below its slot, in several rows where the belt is long.
"""

from __future__ import annotations

import graphviz

from bt_orchestrator.tree.draw_band import add_band
from bt_orchestrator.tree.draw_card import Sheet
from bt_orchestrator.tree.draw_flags import add_flags
from bt_orchestrator.tree.draw_section import INVISIBLE, add_section, slot
from bt_orchestrator.tree.draw_text import FAINT, FONT, INK, PAPER, entry, font, table

LONGEST_ROW = 7
"""Sections side by side that are still readable on a screen and on paper."""

BELT = {'color': '#8a94a3', 'penwidth': '5', 'arrowsize': '0.6'}


def line(sheet: Sheet) -> graphviz.Digraph:
    """Draw a script as a process."""
    graph = graphviz.Digraph(sheet.script.name, graph_attr=_page(sheet))
    graph.attr('node', shape='plain', fontname=FONT)
    graph.attr('edge', fontname=FONT, color=INK, arrowsize='0.7')
    rows = in_rows(sheet.cell.conveyor.sections)
    above = add_band(graph, sheet)
    ends = {number: add_section(graph, sheet, number) for row in rows for number in row}
    for sections in rows:
        _belt(graph, sections, rows[-1][-1])
        for node in above:
            graph.edge(node, slot(sections[0]), **INVISIBLE)
        above = [node for section in sections for node in ends[section]]
    add_flags(graph, sheet)
    return graph


def in_rows(sections: int) -> list[list[int]]:
    """Break a long belt into rows of about equal length."""
    count = -(-sections // LONGEST_ROW)
    length = -(-sections // count)
    numbers = range(1, sections + 1)
    return [list(numbers[start : start + length]) for start in range(0, sections, length)]


def _page(sheet: Sheet) -> dict[str, str]:
    return {
        'label': title(sheet),
        'labelloc': 't',
        'labeljust': 'l',
        'fontname': FONT,
        'bgcolor': PAPER,
        'rankdir': 'TB',
        'newrank': 'true',
        'compound': 'true',
        'nodesep': '0.25',
        'ranksep': '0.3',
        'pad': '0.3',
        'tooltip': f'script {sheet.script.name}',
    }


def title(sheet: Sheet) -> str:
    """Return the label of a whole drawing: script, cell, and what an order may set."""
    script, conveyor = sheet.script, sheet.cell.conveyor
    rows = [
        [entry(font(script.name, size=22, bold=True))],
        [entry(font(f'for cell {sheet.cell.name}, {conveyor.sections} sections', size=12))],
    ]
    for parameter in script.params.values():
        default = 'required' if parameter.required else f'default {parameter.default}'
        text = f'parameter {parameter.name}: {parameter.type}, {default}'
        rows.append([entry(font(text, size=11, colour=FAINT))])
    if script.quantity is not None:
        rows.append([entry(font(f'quantity: default {script.quantity}', size=11, colour=FAINT))])
    return table(rows)


def _belt(graph: graphviz.Digraph, sections: list[int], last: int) -> None:
    """Draw the belt below one row of slots, with where it comes from and goes to."""
    first, final = sections[0], sections[-1]
    stations = [slot(number) for number in sections]
    if first > 1:
        stations.insert(0, f'from.{first}')
        graph.node(stations[0], _elsewhere(f'from {first - 1}'))
    if final < last:
        stations.append(f'to.{final}')
        graph.node(stations[-1], _elsewhere(f'to {final + 1}'))
    with graph.subgraph() as rank:
        rank.attr(rank='same')
        for station in stations:
            rank.node(station)
    for one, following in zip(stations, stations[1:]):
        graph.edge(one, following, edgetooltip='the belt', **BELT)


def _elsewhere(text: str) -> str:
    return table([[entry(font(text, size=10, colour=FAINT, italic=True))]])
