"""A line of twenty sections with everything in it that a drawing can show."""

from __future__ import annotations

from fakes.line import Line

_PREPARED = range(2, 8)
_GROUPS = (5, 12)
_RELEASING = 9
_EMPTY = (8, 14)


def long_line() -> Line:
    """Return the cell."""
    return Line(20, topics=('a3',), belt='retries: 1')


def _section(number: int) -> str:
    n = number
    if n in _EMPTY:
        return ''
    if n in _GROUPS:
        return f"""
  {n}:
    - parallel:
      - [{{id: turn{n}, @a{n}}}, {{id: weld{n}, @a{n}.TASK_B, timeout: none}}]
      - {{id: watch{n}, @b{n}, continue_if_fail: true, requires_conveyor: false}}
    - parallel: [{{@a{n}}}, {{@b{n}}}]"""
    if n == _RELEASING:
        return f"""
  {n}:
    release_conveyor: after_last_conveyor_task
    tasks:
      - {{id: grip, @a{n}}}
      - {{id: store, @b{n}, requires_conveyor: false, repeatable: true}}"""
    argument = '${params.lot} of ${order.id}, more text than a card has room for, ${item.number}'
    return f"""
  {n}:
    - {{id: work{n}, @a{n}, args: {{special_argument_1: "{argument}"}}}}
    - {{@b{n}.TASK_B}}"""


LONG = f"""
quantity: 12
params: {{lot: {{type: str, default: A7}}, force: {{type: float}}}}
initialization:
  - {{id: home, @lamp.PREPARE, once: true}}
{chr(10).join(f'  - {{id: prepare_{n}, @a{n}.PREPARE}}' for n in _PREPARED)}
initialization_dependencies:
{chr(10).join(f'  - {{upstream: home, downstream: prepare_{n}}}' for n in (2, 3, 4))}
sections:
  1:
    - {{id: pick, @b1, requires_conveyor: false, retries: 2, retry_delay: 1.5}}
    - {{id: place, @a1, qty_change: 1}}
{''.join(map(_section, range(2, 20)))}
  20: [{{id: pack, @a20, qty_change: -1, runs_for: all}}]
lateral_dependencies:
  - {{flag: near, upstream: work2, downstream: work3}}
  - {{flag: far, upstream: work4, downstream: work15, capacity: 12, initial: 2}}
  - {{flag: down, upstream: work6, downstream: work11, capacity: 5}}
  - {{flag: same, upstream: work16, downstream: "16.2"}}
zones:
  table: [work3, "2.2"]
  crane: [work10, work11, work17]
"""
