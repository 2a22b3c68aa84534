"""The strings that stand below attributes, which Python does not keep."""

from __future__ import annotations

import ast
import inspect
from enum import Enum


def of_members(kind: type[Enum]) -> dict[str, str]:
    """Return the strings that stand below the members of an enumeration, by their values."""
    source = ast.parse(inspect.getsource(kind)).body[0]
    assert isinstance(source, ast.ClassDef)
    return {
        str(member.value.value): _string(below) or ''
        for member, below in zip(source.body, source.body[1:], strict=False)
        if isinstance(member, ast.Assign) and isinstance(member.value, ast.Constant)
    }


def of_fields(kind: type) -> dict[str, str]:
    """Return the strings that stand below the fields of a class, by their names."""
    source = ast.parse(inspect.getsource(kind)).body[0]
    assert isinstance(source, ast.ClassDef)
    found = {}
    for field, below in zip(source.body, source.body[1:], strict=False):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
            text = _string(below)
            if text is not None:
                found[field.target.id] = text
    return found


def _string(node: ast.stmt) -> str | None:
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        return inspect.cleandoc(str(node.value.value)).rstrip('.')
    return None
