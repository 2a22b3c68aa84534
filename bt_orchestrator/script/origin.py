"""The key `made_from`: where a generated script comes from."""

from __future__ import annotations

from bt_orchestrator.model.script import MadeFrom
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.keys import Kind
from bt_orchestrator.script.script_keys import MADE_FROM

_TEXTS = tuple(key.name for key in MADE_FROM.keys if key.kind is Kind.TEXT)


def read_origin(script: Fields) -> MadeFrom | None:
    """Return what a script was made from; None: it was written by hand."""
    fields = script.table('made_from')
    if fields is None:
        return None
    texts = {name: fields.text(name) or '' for name in _TEXTS}
    without = tuple(name.text for name in fields.names('without'))
    return MadeFrom(version=fields.optional_whole('version') or 0, without=without, **texts)
