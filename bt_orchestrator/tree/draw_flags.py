"""Flags as edges between the tasks that they couple (semantics 4.1)."""

from __future__ import annotations

import graphviz

from bt_orchestrator.model.script import Dependency
from bt_orchestrator.tree.draw_card import Sheet
from bt_orchestrator.tree.draw_text import entry, font, table, tooltip

FLAG = '#b45309'


def add_flags(graph: graphviz.Digraph, sheet: Sheet) -> None:
    """Draw every lateral dependency."""
    for dependency in sheet.script.dependencies:
        hint = _about(dependency)
        graph.edge(
            f'task.{dependency.upstream}',
            f'task.{dependency.downstream}',
            label=_label(dependency),
            id=f'flag.{dependency.flag}',
            edgetooltip=hint,
            labeltooltip=hint,
            color=FLAG,
            style='dashed',
            penwidth='1.6',
            constraint='false',
        )


def _label(dependency: Dependency) -> str:
    counts = f'capacity {dependency.capacity}, initial {dependency.initial}'
    name = font(f'flag {dependency.flag}', size=10, bold=True, colour=FLAG)
    return table([[entry(name)], [entry(font(counts, size=9, colour=FLAG))]])


def _about(dependency: Dependency) -> str:
    up, down, flag = dependency.upstream, dependency.downstream, dependency.flag
    return tooltip(
        [
            f'flag {flag}: capacity {dependency.capacity}, initial count {dependency.initial}',
            f'{up} starts while {flag} is below {dependency.capacity}, and adds one after it',
            f'{down} starts while {flag} is above 0, and takes one after it',
        ]
    )
