"""The keys of a task that say how it is done, wherever they may be written."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.script import RunsFor
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.keys import Kind

_READS: Mapping[Kind, Callable[[Fields, str], Any]] = {
    Kind.SWITCH: Fields.switch,
    Kind.WHOLE: Fields.whole,
    Kind.SECONDS: Fields.seconds,
    Kind.TIMEOUT: lambda fields, key: fields.timeout(key, None),
    Kind.CHOICE: lambda fields, key: RunsFor(fields.choice(key)),
}
"""The reader of each kind of key that sets a field of the task."""


def written_options(fields: Fields) -> dict[str, Any]:
    """Return the fields of Task that a mapping sets; what was not written, or wrongly, is absent.

    Conditions and verdicts need to know the other tasks, and are read later.
    """
    options = {}
    for key in filter(lambda one: one.sets and fields.has(one.name), fields.keys):
        value = _READS[key.kind](fields, key.name)
        if fields.is_sure(key.name):
            options[key.sets] = value
    return options | _on_failure(fields)


def _on_failure(fields: Fields) -> dict[str, OnFailure]:
    given = [key for key in ('on_failure', 'continue_if_fail') if fields.has(key)]
    if not given:
        return {}
    word = fields.choice('on_failure')
    if given == ['continue_if_fail']:
        goes_on = fields.switch('continue_if_fail')
        return {'on_failure': OnFailure.CONTINUE if goes_on else OnFailure.HOLD}
    if len(given) > 1:
        what = '`continue_if_fail` and `on_failure` say the same thing twice'
        fields.report.add(fields.key_place('continue_if_fail'), what, 'keep `on_failure`')
        fields.doubt('on_failure')
    return {'on_failure': OnFailure(word)} if word else {}
