"""The parameters of the tree node, declared to ROS with what a user needs to know about them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.node import Node
from rclpy.parameter import Parameter

from bt_orchestrator.model.limits import NAME, cut
from bt_orchestrator.ros.node_parameters import NodeParameters, Words, described
from bt_orchestrator.script.report import did_you_mean

CLOCK = 'use_sim_time'

_TYPES = frozenset(kind.value for kind in Parameter.Type)


def declare(node: Node, defaults: NodeParameters) -> NodeParameters:
    """Declare every parameter; values that ROS was given win over the defaults.

    :raises BadParameter: a parameter is none of its choices
    """
    values = {}
    for name, words in described():
        default = getattr(defaults, name)
        descriptor = _descriptor(words, default)
        value = node.declare_parameter(name, _to_ros(default), descriptor).value
        values[name] = _from_ros(name, words, value)
    node.add_on_set_parameters_callback(_refuse_another_clock)
    _refuse_in_words(node)
    return NodeParameters(**values)


def _refuse_in_words(node: Node) -> None:
    """Refuse parameters that rclpy would refuse without a name: other types, unknown ones."""
    answers = {SetParameters: _set_each, SetParametersAtomically: _set_together}
    for service in node.services:
        answer = answers.get(service.srv_type)
        if answer is not None:
            service.callback = partial(answer, node, service.callback)


def _set_each(node: Node, inner: Callable[[Any, Any], Any], request: Any, response: Any) -> Any:
    for parameter in request.parameters:
        reason = _why_not(node, parameter)
        if reason is None:
            inner(SetParameters.Request(parameters=[parameter]), response)
        else:
            response.results.append(SetParametersResult(successful=False, reason=reason))
    return response


def _set_together(
    node: Node, inner: Callable[[Any, Any], Any], request: Any, response: Any
) -> Any:
    for parameter in request.parameters:
        reason = _why_not(node, parameter)
        if reason is not None:
            response.result = SetParametersResult(successful=False, reason=reason)
            return response
    return inner(request, response)


def _why_not(node: Node, parameter: Any) -> str | None:
    name = cut(parameter.name, NAME)
    if not node.has_parameter(parameter.name):
        known = sorted(node.list_parameters([], 0).names)
        hint = did_you_mean(name, known, f'the parameters are {", ".join(known)}')
        return f'there is no parameter {name!r}; {hint}'
    if parameter.value.type not in _TYPES:
        return (
            f'{name} has a value of type {parameter.value.type}; expected one of '
            f'rcl_interfaces/msg/ParameterType, {min(_TYPES)} to {max(_TYPES)}'
        )
    return None


def _refuse_another_clock(parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
    """Refuse to change `use_sim_time`, which rclpy declares for every node, while the node runs.

    With it any participant could stop the time of a cell, or have it jump. All other parameters
    are read-only.
    """
    if all(parameter.name != CLOCK for parameter in parameters):
        return SetParametersResult(successful=True)
    reason = (
        f'{CLOCK} is read when the node starts and cannot be changed while it runs; start it anew '
        f'with --ros-args -p {CLOCK}:=true, or without it'
    )
    return SetParametersResult(successful=False, reason=reason)


def _descriptor(words: Words, default: object) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(
        description=f'{words.meaning[0].upper()}{words.meaning[1:]}.',
        additional_constraints=' or '.join(words.choices),
        read_only=True,
    )
    limits: Any = {'from_value': words.low, 'to_value': words.high}
    if isinstance(default, float):
        descriptor.floating_point_range = [FloatingPointRange(**limits)]
    elif words.low is not None:
        descriptor.integer_range = [IntegerRange(**limits)]
    return descriptor


def _to_ros(value: Any) -> Any:
    """Return a value as ROS has it, which knows no paths, and no None."""
    if isinstance(value, tuple):
        return [str(path) for path in value]
    return str(value or '') if value is None or isinstance(value, Path) else value


def _from_ros(name: str, words: Words, value: Any) -> Any:
    match getattr(NodeParameters(), name):
        case tuple():
            return tuple(map(Path, value or ()))
        case None:
            return words.read(value) if value else None
    return value
