"""Components as parts, and what the cell file says of them."""

from __future__ import annotations

from bt_orchestrator.model.status import (
    CellDescription,
    ComponentDescription,
    ComponentStatus,
)
from bt_orchestrator.model.status_words import component_trouble


def component_part(
    component: ComponentStatus, described: ComponentDescription | None
) -> dict[str, object]:
    """Return a component; its trouble in words."""
    return {
        'name': component.name,
        'action': component.action,
        'sections': list(described.sections) if described else [],
        'available': component.available,
        'ready': component.ready,
        'contested': component.contested,
        'state': component.state,
        'task': component.task,
        'feedback': component.feedback,
        'trouble': component_trouble(component),
    }


def line_part(description: CellDescription) -> dict[str, object]:
    """Return what exists in the cell."""
    return {
        'cell': description.cell,
        'sections': description.sections,
        'conveyor': description.conveyor,
        'components': list(map(_described, description.components)),
    }


def _described(component: ComponentDescription) -> dict[str, object]:
    return {
        'name': component.name,
        'action': component.action,
        'type': component.type,
        'sections': list(component.sections),
        'durations_s': dict(component.durations_s),
        'default_duration_s': component.default_duration_s,
    }
