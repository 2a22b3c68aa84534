"""The last feedback of a goal as text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.limits import rough_size, shortened


def feedback_text(feedback: Mapping[str, Any] | None, most: int) -> str:
    """Return feedback as one JSON object of about `most` bytes; empty: there is none.

    Of a longer one, long fields are shortened, with a mark.
    """
    if feedback is None:
        return ''
    if rough_size(feedback) > most:
        share = most // max(1, len(feedback))
        feedback = {name: shortened(value, share) for name, value in feedback.items()}
    return json_of(feedback)
