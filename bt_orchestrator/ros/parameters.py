"""Parameters of the tree node, declared with what a user needs to know about them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

DEFAULT_TICK_RATE_HZ = 10.0


@dataclass(frozen=True)
class NodeParameters:
    """The values that the node started with."""

    cell: Path
    trees: tuple[Path, ...]
    tick_rate_hz: float
    executor: str
    auto_start: bool
    auto_resume: bool
    journal: Path | None
    """None: events are kept in memory, and gone with the process."""
    journal_synchronous: str
    journal_keep_jobs: int
    """How many ended jobs keep their events; -1: all."""
    server_timeout_s: float
    expected_end: bool = True
    """Forecasts of the ends of jobs are made, in a process of their own."""


def declare(node: Node, defaults: NodeParameters) -> NodeParameters:
    """Declare every parameter; what ROS was told otherwise wins over the defaults."""

    def value(name: str, default: Any, text: str, **limits: Any) -> Any:
        descriptor = ParameterDescriptor(description=text, read_only=True, **limits)
        return node.declare_parameter(name, default, descriptor).value

    trees = value(
        'trees',
        [str(folder) for folder in defaults.trees],
        'Folders in which scripts are looked up by name, in order.',
    )
    journal = value(
        'journal',
        str(defaults.journal or ''),
        'File of the durable journal (SQLite); empty: in memory, gone with the process.',
    )
    return NodeParameters(
        cell=Path(value('cell', str(defaults.cell), 'Cell file (YAML): what exists.')),
        trees=tuple(map(Path, trees or ())),
        tick_rate_hz=value(
            'tick_rate_hz',
            defaults.tick_rate_hz,
            'Heartbeat of the tree in Hz. News wake it at once, whatever the rate.',
            floating_point_range=[FloatingPointRange(from_value=0.1, to_value=1000.0)],
        ),
        executor=value(
            'executor',
            defaults.executor,
            'rclpy executor: single, or events where rclpy has it.',
            additional_constraints='single or events',
        ),
        auto_start=value(
            'auto_start',
            defaults.auto_start,
            'The cell resets and starts by itself when an order arrives.',
        ),
        auto_resume=value(
            'auto_resume',
            defaults.auto_resume,
            'After a restart with unfinished work, go on without waiting for resume.',
        ),
        journal=Path(journal) if journal else None,
        journal_synchronous=value(
            'journal_synchronous',
            defaults.journal_synchronous,
            'FULL: a power cut loses nothing. NORMAL: quicker; a power cut may lose the last '
            'events, a crash of the program loses nothing.',
            additional_constraints='FULL or NORMAL',
        ),
        journal_keep_jobs=value(
            'journal_keep_jobs',
            defaults.journal_keep_jobs,
            'How many ended jobs keep their events in the journal; of older ones a summary '
            'stays. -1: all.',
            integer_range=[IntegerRange(from_value=-1, to_value=2**31 - 1)],
        ),
        expected_end=value(
            'expected_end',
            defaults.expected_end,
            'Forecast the ends of jobs, in a process of low priority.',
        ),
        server_timeout_s=value(
            'server_timeout',
            defaults.server_timeout_s,
            'Seconds that a goal waits for its action server before it fails with '
            'server_unavailable.',
            floating_point_range=[FloatingPointRange(from_value=0.0, to_value=3600.0)],
        ),
    )
