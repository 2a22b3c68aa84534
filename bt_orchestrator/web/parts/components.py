"""Components as parts, and what the cell file says of them."""

from __future__ import annotations

from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.status import (
    CellDescription,
    ComponentDescription,
    ComponentStatus,
)
from bt_orchestrator.model.status_words import component_trouble
from bt_orchestrator.web.offers import component_offers


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
        'contested_words': to_plain(component.contested_words, whole=True),
        'out_of_service': component.out_of_service,
        'out_of_service_since': component.out_of_service_since,
        'state': component.state,
        'task': component.task,
        'feedback': component.feedback,
        'trouble': component_trouble(component),
        'offers': component_offers(component),
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
