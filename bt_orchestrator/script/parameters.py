"""The parameters that a script declares."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from bt_orchestrator.model.script import Parameter
from bt_orchestrator.script.drafts import ScriptDraft
from bt_orchestrator.script.field_types import PARAMETER_TYPES, misfit
from bt_orchestrator.script.fields import Fields, fields_of
from bt_orchestrator.script.names import check_name
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.script_keys import PARAMETER
from bt_orchestrator.script.yaml_nodes import Entry, Scalar, found, words


def read_parameters(draft: ScriptDraft, report: Report) -> None:
    """Read `params` into the draft."""
    node = draft.fields.mapping('params')
    if node is None:
        draft.unread_params.update(draft.fields.unread_words('params'))
        return
    for entry in node.entries:
        name = entry.key.text
        check_name(name, 'parameter name', entry.key.place, report)
        parameter = _parameter(entry, report)
        is_sure = name not in node.doubtful
        draft.params[name] = parameter if is_sure else replace(parameter, type='', default=None)
    for entry in node.repeated:
        _parameter(entry, report)
    for value in node.lost:
        draft.unread_params.update(words(value))


def _parameter(entry: Entry, report: Report) -> Parameter:
    fields = fields_of(entry.value, PARAMETER, report)
    if fields is None:
        return Parameter(entry.key.text, type='')
    type_name = fields.choice('type')
    default = _default(fields, type_name or '', report)
    return Parameter(entry.key.text, type_name or '', default, not fields.has('default'))


def _default(fields: Fields, type_name: str, report: Report) -> Any:
    node = fields.value('default')
    if node is None or type_name not in PARAMETER_TYPES:
        return None
    value: Any = node.value if isinstance(node, Scalar) else node
    problem = misfit(value, PARAMETER_TYPES[type_name])
    if problem is not None:
        what = f'`default` must be {problem.needed}, not {found(node)}'
        report.add(node.place, what, problem.hint)
        return None
    return float(value) if type_name == 'float' else value
