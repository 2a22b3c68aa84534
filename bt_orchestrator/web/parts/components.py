"""Components as parts."""

from __future__ import annotations

from bt_orchestrator.model.codec import plain_but
from bt_orchestrator.model.status import ComponentDescription, ComponentStatus
from bt_orchestrator.model.status_words import component_trouble
from bt_orchestrator.web.offers import component_offers
from bt_orchestrator.web.wording import said_in_each


def component_part(
    component: ComponentStatus, described: ComponentDescription | None
) -> dict[str, object]:
    """Return a component; its trouble in words."""
    contest = component.contested_words
    return {
        **plain_but(component),
        'contested_said': said_in_each((contest,) if contest else (), component.contested),
        'sections': list(described.sections) if described else [],
        'trouble': component_trouble(component),
        'offers': component_offers(component),
    }
