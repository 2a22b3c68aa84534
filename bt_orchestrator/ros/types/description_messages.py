"""What exists in a cell as a message (CellDescription), and back."""

from __future__ import annotations

from bt_orchestrator_interfaces import msg

from bt_orchestrator.model.status import CellDescription, ComponentDescription


def description_message(description: CellDescription) -> msg.CellDescription:
    """Return the message with all that a description says."""
    return msg.CellDescription(
        cell=description.cell,
        sections=description.sections,
        conveyor=description.conveyor,
        components=[_component_message(component) for component in description.components],
    )


def cell_description(message: msg.CellDescription) -> CellDescription:
    """Return all that a message says."""
    return CellDescription(
        cell=message.cell,
        sections=message.sections,
        conveyor=message.conveyor,
        components=tuple(map(_component, message.components)),
    )


def _component_message(component: ComponentDescription) -> msg.ComponentDescription:
    return msg.ComponentDescription(
        name=component.name,
        action=component.action,
        type=component.type,
        sections=component.sections,
        durations=[
            msg.TaskDuration(task=task, seconds=seconds)
            for task, seconds in component.durations_s.items()
        ],
        default_duration_s=component.default_duration_s,
    )


def _component(message: msg.ComponentDescription) -> ComponentDescription:
    return ComponentDescription(
        name=message.name,
        action=message.action,
        type=message.type,
        sections=tuple(map(int, message.sections)),
        durations_s={one.task: one.seconds for one in message.durations},
        default_duration_s=message.default_duration_s,
    )
