"""Cells and what fails in them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fakes.drawn.plan import Draw, Row, Traits, chance, devices
from hypothesis import strategies as st

TYPE = 'bt_orchestrator_interfaces/action/Component'
SECONDS = (1.0, 0.5, 2.5, 7.0, 0.0)
FAULTS = (
    'abort',
    'false',
    'reject',
    'cancel',
    'late:3.3',
    'reads:2.5',
    'reads',
    'hang',
    'die:1',
    'mute',
    'ignore_cancel',
)


def draw_cell(draw: Draw, size: int, traits: Traits) -> Row:
    """Draw a cell: two components for every section, and perhaps shared ones."""
    places: Row = {f'{letter}{n}': n for n in range(1, size + 1) for letter in 'ab'}
    if traits.shared and size > 1 and draw(st.booleans()):
        places['arm'] = sorted(draw(st.sets(st.integers(1, size), min_size=2, max_size=3)))
    if traits.shared:
        places['lamp'] = []
    components = {
        name: _component(draw, name, place, number, traits)
        for number, (name, place) in enumerate(places.items())
    }
    if chance(draw, 60):
        components['reader'] = _reader(draw, draw(st.integers(1, size)), traits)
    conveyor = {
        'sections': size,
        'action': '/belt/do',
        'type': 'bt_orchestrator_interfaces/action/Conveyor',
        'task': 'MOVE_ONE_INDEX',
        'duration': draw(st.sampled_from((2.0, 0.5, 10.0))) + (0.0 if traits.tied else 0.0137),
        'timeout': 60.01,
        'retries': draw(st.integers(0, 1)),
        'on_failure': draw(st.sampled_from(('hold', 'abort_job'))),
        'faults': _faults(draw, 6) if traits.faults else [],
    }
    cell = {'cell': 'random_cell', 'conveyor': conveyor, 'components': components}
    if traits.pieces and chance(draw, 10):
        cell['first_piece'] = 'automatic'
    if traits.rejects and not chance(draw, 20):
        cell['hold_after'] = draw_limit(draw)
    return {**cell, 'release': 'automatic'} if chance(draw, 25) else cell


def draw_limit(draw: Draw) -> Row:
    """Draw a limit of rejects."""
    rejects = draw(st.integers(1, 3))
    return {'rejects': rejects, 'of': rejects + draw(st.integers(0, 3))}


def lasting(cell: Row, seconds: Sequence[float]) -> list[float]:
    """Return durations, none 0 where a server dies, and let no nominal one be 0 there.

    Whether a goal that is cancelled as it starts is cancelled, or dies with its server in that
    moment, is open.
    """
    dying = [
        entry for entry in devices(cell) if any('die' in text for text in entry.get('faults', []))
    ]
    for device in dying:
        for task, nominal in device.get('durations', {}).items():
            device['durations'][task] = nominal or 1.0
    return [entry or 1.0 if dying else entry for entry in seconds]


def _component(draw: Draw, name: str, place: Any, number: int, traits: Traits) -> Row:
    row: Row = {'action': f'/{name}/do', 'type': TYPE}
    if place != []:
        row['section'] = place
    seconds = draw(st.sampled_from(SECONDS))
    if not traits.tied:
        seconds = 0.2 + seconds / 10 + number * 0.0171
    row['durations'] = dict.fromkeys(('PREPARE', 'TASK_A', 'TASK_B', 'TASK_C'), seconds)
    if chance(draw, 20):
        row['results'] = {'TASK_A': {'item_present': False, 'measurement': 2.5}}
    if traits.faults and (faults := _faults(draw, 70 if traits.rejects else 15)):
        row['faults'] = faults
    dies = any('die' in text for text in row.get('faults', []))
    if traits.setups and not dies and not chance(draw, 40):
        row['setups'] = {'tool': ['x', 'y']}
        row['changes'] = {'tool': {'task': 'TASK_C', 'argument': 'special_argument_1'}}
        # Where a controller takes no goal any more, no change is ever told, whatever is answered.
        is_deaf = any('ignore_cancel' in text for text in row.get('faults', []))
        if not is_deaf and chance(draw, 40):
            row['changes']['tool']['reads'] = 'value'
            row['state'] = {
                'topic': f'/{name}/state',
                'type': 'diagnostic_msgs/msg/KeyValue',
                'field': 'key',
                'ready': ['READY'],
            }
    return row


def _reader(draw: Draw, section: int, traits: Traits) -> Row:
    return {
        'section': section,
        'action': '/reader/do',
        'type': 'bt_orchestrator_interfaces/action/Reader',
        'durations': {'READ': draw(st.sampled_from(SECONDS)) if traits.tied else 0.4391},
        'results': {'READ': {'serial': draw(st.sampled_from(('S', 'S-{n}', '')))}},
        'faults': _faults(draw, 40) if traits.faults else [],
    }


def _faults(draw: Draw, percent: int) -> list[str]:
    if not chance(draw, percent):
        return []
    numbers = sorted(draw(st.sets(st.integers(1, 7), min_size=1, max_size=2)))
    return [f'#{n}={draw(st.sampled_from(FAULTS))}' for n in numbers]
