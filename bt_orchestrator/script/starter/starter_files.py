"""The three files of a starter cell, with comments for beginners."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from bt_orchestrator.script.cell_file import CELL_FILE
from bt_orchestrator.script.names import LONGEST_NAME
from bt_orchestrator.script.starter.starter_plan import Device, FoundServer, Plan

SCRIPT = 'first_product'
QUANTITY = 3
SCRIPT_FILE, ORDER_FILE = f'trees/{SCRIPT}.yaml', 'order.yaml'
RECIPE_FILE = f'recipes/{SCRIPT}.yaml'

Able = Callable[[Device, Plan, str], Iterable[str]]

_DURATION_S = 1.0
_CELL = """\
# What exists: the belt, and one component for each device controller.
# Mistakes are named with their places by: bt-orchestrator check {script}
cell: {name}
# start: advisory  # without it no job begins before the `start` of its order
conveyor:
  sections: {sections}  # positions of the belt, counted in the direction of travel
"""
_SCRIPT = """\
# How one product is made: what each section does with every item, in order.
script: {script}
quantity: {quantity}  # items of an order that names no quantity
"""
_INITIALIZATION = """\
initialization:  # before the first item; side by side if nothing else is said
"""
_SECTIONS = """\
sections:  # when all of them are done with their items, the belt moves by one position
"""
_ORDER = """\
# What is wanted: bt-orchestrator submit {file}
order: WO-1  # leave it out, and an id is given
script: {script}
quantity: {quantity}
"""


def starter_files(name: str, plan: Plan, schemas: Mapping[str, str]) -> dict[str, str]:
    """Return the texts of a starter cell by their paths.

    :param name: of the cell
    :param schemas: where the schema of each file is, by the file's path; may lack some
    """
    texts = {
        CELL_FILE: cell_text(name, plan),
        SCRIPT_FILE: ''.join(_script(plan)),
        ORDER_FILE: order_text(),
    }
    return with_schemas(texts, schemas)


def with_schemas(texts: Mapping[str, str], schemas: Mapping[str, str]) -> dict[str, str]:
    """Return texts that name their schemas to editors."""
    return {file: _modeline(schemas.get(file)) + text for file, text in texts.items()}


def order_text() -> str:
    """Return the work order."""
    return _ORDER.format(file=ORDER_FILE, script=SCRIPT, quantity=QUANTITY)


def _modeline(schema: str | None) -> str:
    return f'# yaml-language-server: $schema={schema}\n' if schema else ''


# --- cell file ------------------------------------------------------------------------------


def cell_text(name: str, plan: Plan, able: Able = lambda *_: ()) -> str:
    """Return the cell file.

    :param able: yields the lines that say what a device can do
    """
    return ''.join(_cell(name, plan, able))


def _cell(name: str, plan: Plan, able: Able) -> Iterator[str]:
    yield _CELL.format(script=SCRIPT, name=name, sections=plan.sections)
    yield from _served(plan.conveyor, '  ')
    if plan.index_task:
        yield f'  task: {plan.index_task}  # moves the belt by one position\n'
    yield '  timeout: 30.0  # seconds a move may take\n'
    yield '  duration: 2.0  # nominal seconds, for the simulation\n'
    yield from able(plan.conveyor, plan, '  ')
    yield 'components:  # durations are nominal seconds of each task, for the simulation\n'
    for device in plan.components:
        yield f'  {device.name}:\n'
        guess = '  # a guess: write where it stands' if device.found else ''
        yield f'    section: {device.section}{guess}\n'
        yield from _served(device, '    ')
        yield '    timeout: 60.0\n'
        durations = ', '.join(f'{task}: {_DURATION_S}' for task in device.type.constants)
        if durations:
            yield f'    durations: {{{durations}}}\n'
        yield from able(device, plan, '    ')
    yield from _left_out(plan.unusable)


def _served(device: Device, indent: str) -> Iterator[str]:
    origin = f'served by {device.found.node}' if device.found else 'an example: put your own'
    yield f'{indent}action: {device.action}  # {origin}\n'
    yield f'{indent}type: {device.type.name}\n'
    for topic in device.found.state_topics if device.found else ():
        state = f'{{topic: {topic}, type: std_msgs/msg/String, field: data, ready: [READY]}}'
        yield f'{indent}# If this says when a goal may be sent, with its word for ready:\n'
        yield f'{indent}# state: {state}\n'


def _left_out(unusable: Sequence[FoundServer]) -> Iterator[str]:
    if unusable:
        yield '# Also served, but of types that are not installed here or that name no task:\n'
    for server in unusable:
        yield f'#   {server.action}: {server.type}\n'


# --- script ---------------------------------------------------------------------------------


def _script(plan: Plan) -> Iterator[str]:
    yield _SCRIPT.format(script=SCRIPT, quantity=QUANTITY)
    devices = [plan.conveyor, *plan.components]
    preparing = [(device, task) for device in devices for task in device.preparations]
    preparing = [(device, task) for device, task in preparing if task != plan.index_task]
    if preparing:
        yield _INITIALIZATION
    for device, task in preparing:
        once = ', once: true' if device is plan.conveyor else ''
        yield f'  - {_task(device, task, once)}\n'
    yield _SECTIONS
    for section in range(1, plan.sections + 1):
        lines = [*_steps(plan, section)]
        if lines:
            yield f'  {section}:\n'
            yield from (f'    {line}\n' for line in lines)


def _steps(plan: Plan, section: int) -> Iterator[str]:
    if section == plan.source.section:
        *ahead, placing = plan.placing
        if ahead:
            yield '# requires_conveyor: false lets it run while the belt still moves'
        for task in ahead:
            yield f'- {_task(plan.source, task, ", requires_conveyor: false")}'
        yield '# qty_change: 1 places the item on the belt'
        yield f'- {_task(plan.source, placing, ", qty_change: 1")}'
    for device in plan.stations:
        if device.section == section:
            yield f'- {_task(device, device.works[0])}'
            if len(device.works) > 1:
                yield f'# {device.name} can also do {", ".join(map(str, device.works[1:]))}'
    if section == plan.sink.section:
        yield '# qty_change: -1 takes it out; runs_for: all takes rejected items out as well'
        yield f'- {_task(plan.sink, plan.taking, ", qty_change: -1, runs_for: all")}'


def _task(device: Device, task: str | None, options: str = '') -> str:
    id_ = f'{device.name}_{task.lower()}' if task else device.name
    named = f'id: {id_}, ' if len(id_) <= LONGEST_NAME else ''
    constant = f'task: {task}, ' if task else ''
    return f'{{{named}{constant}action: {device.action}{options}}}'
