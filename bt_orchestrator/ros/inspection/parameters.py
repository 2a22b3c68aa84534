"""Parameters of the inspection server that can be changed while the node runs."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.node import Node

from bt_orchestrator.base.errors import OrchestratorError

ON_CHANGE_S = sys.float_info.max
"""The period that stands for: only when something has changed."""


@dataclass(frozen=True)
class DefaultStream:
    """The snapshot stream that is there without being asked for."""

    is_open: bool = False
    period_s: float = ON_CHANGE_S
    blackboard_data: bool = True
    blackboard_activity: bool = False


_FIELDS = {
    'default_snapshot_stream': ('is_open', 'Publish snapshots of the tree on ~/snapshots.'),
    'default_snapshot_period': (
        'period_s',
        f'Longest time between snapshots of the default stream, s; {ON_CHANGE_S}: on change only.',
    ),
    'default_snapshot_blackboard_data': (
        'blackboard_data',
        'The default stream shows the blackboard variables of the visited path.',
    ),
    'default_snapshot_blackboard_activity': (
        'blackboard_activity',
        'The default stream shows what is done on the blackboard.',
    ),
}


def declare_default_stream(node: Node, apply: Callable[[DefaultStream], object]) -> None:
    """Declare the parameters of the default stream and apply them, now and when they change."""
    current = DefaultStream()
    for name, (field, text) in _FIELDS.items():
        default = getattr(current, field)
        value = node.declare_parameter(name, default, ParameterDescriptor(description=text)).value
        current = replace(current, **{field: value})
    apply(current)

    def on_set(parameters: Iterable[Any]) -> SetParametersResult:
        nonlocal current
        news = {_FIELDS[p.name][0]: p.value for p in parameters if p.name in _FIELDS}
        if not news:
            return SetParametersResult(successful=True)
        try:
            wanted = replace(current, **news)
            apply(wanted)
        except OrchestratorError as refused:
            return SetParametersResult(successful=False, reason=str(refused))
        current = wanted
        return SetParametersResult(successful=True)

    node.add_on_set_parameters_callback(on_set)
