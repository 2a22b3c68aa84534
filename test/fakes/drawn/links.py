"""What connects the tasks of a script: initialization, flags and zones."""

from __future__ import annotations

from collections.abc import Sequence

from fakes.drawn.plan import Draw, Row, chance
from hypothesis import strategies as st

OFTEN_PREPARED = ('a1', 'a2', 'arm', 'lamp')
"""Components that several scripts prepare, so that they meet there."""

SETUP = '${params.setup}'
"""An argument that differs from order to order."""

Placed = tuple[int, Row]
"""A task with its section."""


def draw_initialization(draw: Draw, cell: Row) -> Row:
    """Draw the initialization of a script, and its order."""
    if draw(st.booleans()):
        return {}
    tasks: list[Row] = [{'id': 'home', 'task': 'HOME', 'action': '/belt/do', 'once': True}]
    tasks = tasks if draw(st.booleans()) else []
    names = sorted(cell['components'].keys() - {'reader'})
    often = [name for name in OFTEN_PREPARED if name in names]
    chosen = draw(st.lists(st.sampled_from([*names, *often, *often]), max_size=4))
    for number, name in enumerate(chosen):
        what = draw(st.sampled_from(('PREPARE', 'PREPARE', 'TASK_A')))
        task: Row = {'id': f'p{number}', 'task': what, 'action': f'/{name}/do'}
        task['on_failure'] = draw(st.sampled_from(('hold', 'continue', 'abort_job')))
        task['timeout'] = 8.03
        if chance(draw, 30):
            task['retries'] = 1
        if chance(draw, 50):
            task['once'] = True
        if chance(draw, 40):
            task['args'] = {'special_argument_2': draw(st.sampled_from((0.0, 1.0)))}
        tasks.append(task)
    ids = [task['id'] for task in tasks]
    pairs = [(ids[n - 1], ids[n]) for n in range(1, len(ids)) if chance(draw, 40)]
    order = [{'upstream': up, 'downstream': down} for up, down in pairs]
    return {'initialization': tasks, 'initialization_dependencies': order}


def add_setup(draw: Draw, script: Row) -> None:
    """Let the last section prepare for each order what the order says, unless it did so before."""
    action = f'/{draw(st.sampled_from("ab"))}{max(script["sections"])}/do'
    task: Row = {'id': 'load', 'task': 'PREPARE', 'action': action, 'once': True}
    task['args'] = {'special_argument_2': SETUP}
    script['params'] = {'setup': {'type': 'float', 'default': 0.0}}
    script.setdefault('initialization', []).append(task)


def draw_flags(draw: Draw, name: str, tasks: Sequence[Placed]) -> list[Row]:
    """Draw the flags of a script, between tasks so near that a capacity of 3 can be enough."""
    pairs = [(u, d) for u in tasks for d in tasks if u is not d and abs(u[0] - d[0]) <= 3]
    count = draw(st.integers(0, 3)) if pairs else 0
    flags = []
    for number in range(count):
        (first, upstream), (second, downstream) = draw(st.sampled_from(pairs))
        capacity = draw(st.integers(1, 3))
        initial = draw(st.integers(0, capacity))
        if chance(draw, 75):
            capacity, initial = _fitting(draw, second - first, capacity)
        ids = {'upstream': upstream['id'], 'downstream': downstream['id']}
        flags.append(
            {'flag': f'{name}_f{number}', **ids, 'capacity': capacity, 'initial': initial}
        )
    return flags


def _fitting(draw: Draw, distance: int, capacity: int) -> tuple[int, int]:
    """Return counts with which a flag so many sections down cannot close a circle alone."""
    if distance > 0:
        return max(distance, capacity), draw(st.integers(0, max(0, capacity - distance)))
    least = max(1, -distance)
    return max(capacity, least), least


def draw_zones(draw: Draw, tasks: Sequence[Placed], initialization: Sequence[Row]) -> Row:
    """Draw the zones of a script."""
    ids = [task['id'] for _, task in tasks] + [task['id'] for task in initialization]
    if len(ids) < 2 or not chance(draw, 40):
        return {}
    names = ('table', 'door')[: draw(st.integers(1, 2))]
    members = st.sets(st.sampled_from(ids), min_size=2, max_size=3)
    return {name: sorted(draw(members)) for name in names}
