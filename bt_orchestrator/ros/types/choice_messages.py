"""What an order names in place of a script, as fields of messages, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from diagnostic_msgs.msg import KeyValue

from bt_orchestrator.model.jobs.order import RecipeChoice


def choice_fields(choice: RecipeChoice | None) -> dict[str, Any]:
    """Return the fields that name recipes; None: they stay empty."""
    if choice is None:
        return {}
    version, bind = choice.version or 0, key_values(choice.bind)
    return {'recipes': list(choice.recipes), 'version': version, 'bind': bind}


def choice_from(message: Any) -> RecipeChoice | None:
    """Return what a message names, a version or a binding without a recipe too; None: nothing."""
    bind = {one.key: one.value for one in message.bind}
    if not message.recipes and not message.version and not bind:
        return None
    return RecipeChoice(tuple(message.recipes), message.version or None, bind)


def key_values(texts: Mapping[str, str]) -> list[Any]:
    """Return texts with names."""
    return [KeyValue(key=key, value=value) for key, value in texts.items()]
