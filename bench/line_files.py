"""Cells and scripts of any size, as text: components `aN` and `bN` in section N."""

from __future__ import annotations

TYPE = 'bt_orchestrator_interfaces/action/Component'
BELT_TYPE = 'bt_orchestrator_interfaces/action/Conveyor'
BELT_S = 0.05
"""Half a period of a tree that is polled at 100 ms: the mean of all its phases."""
SECTIONS = 5
RESULT_TIMEOUT_S = 1.0
"""For how long a server remembers: each status message lists all the goals it still knows."""


def work_s(section: int, letter: str) -> float:
    """Return the seconds of a task: no two of one cycle end together.

    A tree that is polled starts a task at a tick, so how long an end waits for the next one is
    a matter of the length alone. The first tasks of five sections are spread over the period, of
    100 ms and of 10 ms: these waits are 6, 28, 50, 62 and 84 ms, or 0, 2, 4, 6 and 8 ms.
    """
    return 0.028 + 0.022 * section if letter == 'a' else 0.055


def cell_text(
    sections: int, letters: str = 'ab', *, result_timeout_s: float = RESULT_TIMEOUT_S
) -> str:
    """Write a cell."""
    head = (
        f'cell: bench\nconveyor: {{sections: {sections}, action: /bench/belt, type: {BELT_TYPE}, '
        f'task: MOVE_ONE_INDEX, duration: {BELT_S}, result_timeout: {result_timeout_s}}}\n'
        'components:\n'
    )
    return head + ''.join(
        f'  {letter}{n}: {{section: {n}, action: /bench/{letter}{n}, type: {TYPE}, '
        f'durations: {{TASK_A: {work_s(min(n, 5), letter):.3f}}}, '
        f'result_timeout: {result_timeout_s}}}\n'
        for n in range(1, sections + 1)
        for letter in letters
    )


def script_text(
    sections: int, tasks: int = 2, *, letters: str = 'ab', name: str = 'line', flags: bool = False
) -> str:
    """Write a script with so many tasks in every section.

    :param flags: from each section to the next; the deadlock proof has nothing to do without
    """
    lines = [f'script: {name}', 'sections:']
    for n in range(1, sections + 1):
        lines.append(f'  {n}:')
        for k in range(tasks):
            change = ', qty_change: 1' if (n, k) == (1, 0) else ''
            if (n, k) == (sections, tasks - 1):
                change = ', qty_change: -1'
            action = f'/bench/{letters[k % len(letters)]}{n}'
            lines.append(f'    - {{id: t{n}_{k}, task: TASK_A, action: {action}{change}}}')
    if flags:
        lines.append('lateral_dependencies:')
        lines += [
            f'  - {{flag: f{n}, upstream: t{n}_0, downstream: t{n + 1}_0}}'
            for n in range(1, sections)
        ]
    return '\n'.join(lines) + '\n'


def few_working_text(sections: int) -> str:
    """Write a script in which five sections work, the first and the last among them."""
    working = sorted({1, 2, 3, 4, sections})
    lines = ['script: few', 'sections:']
    for n in working:
        change = {1: ', qty_change: 1', sections: ', qty_change: -1'}.get(n, '')
        lines.append(f'  {n}: [{{id: t{n}, task: TASK_A, action: /bench/a{n}{change}}}]')
    return '\n'.join(lines) + '\n'
