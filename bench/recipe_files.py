"""A cell that can do something, and recipes for it."""

from __future__ import annotations

from pathlib import Path
from random import Random

from bench.line_files import SECTIONS, cell_text

OPERATIONS = 60
"""Of each recipe, with the one that places the item and the one that takes it out."""


def able_cell_text() -> str:
    """Write the cell of the stand; two components can do each operation of the recipes."""
    able: dict[str, list[str]] = {f'{c}{n}': [] for n in range(1, SECTIONS + 1) for c in 'ab'}
    able['a1'].append('put: {task: TASK_A, qty_change: 1}')
    able[f'b{SECTIONS}'].append('take: {task: TASK_A, qty_change: -1}')
    for number in range(OPERATIONS - 2):
        section = 1 + number * (SECTIONS - 1) // (OPERATIONS - 2)
        for component in (f'b{section}', f'a{section + 1}'):
            able[component].append(f'work_{number}: {{task: TASK_A}}')
    text = cell_text(SECTIONS)
    for component, capabilities in able.items():
        start = f'  {component}: {{'
        listed = ', '.join(capabilities)
        text = text.replace(start, f'{start}capabilities: {{{listed}}}, ')
    return text


def write_recipe(folder: Path, seed: int) -> str:
    """Write a recipe and return its name; what its operations wait for is drawn."""
    random = Random(seed)
    lines = [f'recipe: R-{seed}', 'version: 1', f'script: made_{seed}', 'operations:']
    lines.append('  - {id: place, do: put}')
    for number in range(OPERATIONS - 2):
        before = f'o{max(0, number - random.randint(1, 10))}' if number else 'place'
        lines.append(f'  - {{id: o{number}, do: work_{number}, after: {before}}}')
    lines.append('  - {id: box, do: take}')
    (folder / f'recipe_{seed}.yaml').write_text('\n'.join(lines) + '\n')
    return f'R-{seed}'
