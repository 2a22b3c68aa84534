"""What an order names in place of a script, as fields of messages, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bt_orchestrator_interfaces.msg import WorkOrder
from diagnostic_msgs.msg import KeyValue

from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.ros.types.mapping import flat

CHOICE = flat(RecipeChoice, WorkOrder, {}, any_of=('recipes', 'version', 'bind'))
"""Of every message with these fields. A version or a binding without a recipe is read as well."""

choice_fields, choice_from = CHOICE.write, CHOICE.read


def key_values(texts: Mapping[str, str]) -> list[Any]:
    """Return texts with names."""
    return [KeyValue(key=key, value=value) for key, value in texts.items()]
