"""What the shipped schemas say about a text, by an implementation that is not ours."""

from __future__ import annotations

import json
from functools import cache

from fakes.shipped import ROOT
from jsonschema import Draft7Validator

from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.yaml_nodes import as_data

SCHEMAS = ROOT / 'schemas'


@cache
def validator(file: str) -> Draft7Validator:
    """Return a validator of one of the shipped schemas."""
    schema = json.loads((SCHEMAS / file).read_text(encoding='utf-8'))
    Draft7Validator.check_schema(schema)
    return Draft7Validator(schema)


def refusals(file: str, text: str) -> list[str]:
    """Return what a schema has against a text; nothing where YAML itself has."""
    node = compose(text, Report('file.yaml'))
    errors = validator(file).iter_errors(as_data(node)) if node else ()
    return [f'{error.json_path}: {error.message}' for error in errors]
