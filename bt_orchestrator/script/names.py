"""Names that users choose: ids, parameters, flags; and names that ROS 2 prescribes."""

from __future__ import annotations

import re

from bt_orchestrator.model.jobs.order import order_id_fault
from bt_orchestrator.model.words import sentence
from bt_orchestrator.script.report import Place, Report
from bt_orchestrator.script.yaml_nodes import quoted

LONGEST_NAME = 64

ID_FORM = r'[^\s/${}]+'
NAME_WITHOUT_DOTS = r'[^\s/${}.]+'
"""Patterns for editors. They know fewer letters than Python does, so these take a little more."""

_ID = re.compile(r'[\w-]+(?:\.[\w-]+)*')
_NAME = re.compile(r'[\w-]+')


def check_id(text: str, kind: str, place: Place, report: Report) -> bool:
    """Report a task id or script name that cannot be one.

    Ids are letters, digits, `_` and `-`, with dots between: they stand in references, in item ids
    and in the paths of the tree.
    """
    return _check(
        _ID, text, kind, 'letters, digits, `_`, `-` and dots between them', place, report
    )


def check_name(text: str, kind: str, place: Place, report: Report) -> bool:
    """Report a name that cannot be one; as an id, but without dots.

    A dot in a blackboard key means an attribute, and in a reference the next name.
    """
    return _check(_NAME, text, kind, 'letters, digits, `_` and `-`', place, report)


def _check(
    rule: re.Pattern[str], text: str, kind: str, allowed: str, place: Place, report: Report
) -> bool:
    if len(text) > LONGEST_NAME:
        what = f'the {kind} {quoted(text)} has {len(text)} characters'
        report.add(place, what, f'use at most {LONGEST_NAME}')
        return False
    if not rule.fullmatch(text):
        legal = re.sub(r'[^\w-]+', '_', text).strip('_') or 'a_name'
        what = f'{quoted(text)} cannot be a {kind}: only {allowed} are allowed'
        report.add(place, what, f'write for instance {quoted(legal)}')
        return False
    return True


def wrong_order_id(text: str) -> tuple[str, str] | None:
    """Say what is wrong with an order id, and what to do; it begins the item ids `<order>/<n>`."""
    fault = order_id_fault(text)
    if fault is None:
        return None
    legal = re.sub(r'[^\w .-]+', '-', text).strip(' -')[:LONGEST_NAME] or 'WO-1001'
    return sentence('order_id', id=quoted(text), words=fault), sentence('id_instead', id=legal)
