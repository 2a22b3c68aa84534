"""Everything that can be asked: word, roles, reason, confirmation, and when."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.model.by import Role
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.jobs.job_control import JobFacts
from bt_orchestrator.model.packml import MANUAL_FROM, PackmlState, UnitMode
from bt_orchestrator.model.requests import (
    CONTROLS,
    TABLE,
    UNIT_MODES,
    About,
    Request,
    Why,
    of_cell,
    of_job,
)
from tables import docstrings
from tables.markdown import cell, table

_REASON = {Why.FIRST: 'needed', Why.AFTERWARDS: 'may be empty', Why.NEVER: 'if given'}
_ANY = 'any'


def everything_that_can_be_asked() -> Iterator[str]:
    """Yield the table of requests."""
    titles = ('word', 'about', 'does', 'roles', 'reason', 'confirmed', 'moves', 'possible')
    yield from table(titles, map(_row, TABLE))


def roles() -> Iterator[str]:
    """Yield what each role is there for."""
    meanings = docstrings.of_members(Role)
    yield from table(
        ('role', 'is for'), ((f'`{role.value}`', cell(meanings[role.value])) for role in Role)
    )


def _row(request: Request) -> tuple[str, ...]:
    words = ', '.join(f'`{word}`' for word in (request.word, *request.also))
    return (
        words,
        request.about.value,
        cell(f'{request.effect}{_arguments(request)}'),
        _named(request.roles),
        _REASON[request.why],
        'yes' if request.is_confirmed else '',
        'yes' if request.moves else '',
        _possible(request),
    )


def _arguments(request: Request) -> str:
    of_its_own = request.parameters[1 if request.subject else 0 :]
    told = (
        f'`{one.name}`{"" if one.roles is None else f" (for {_named(one.roles)})"}'
        for one in of_its_own
    )
    arguments = ', '.join(told)
    return f'; takes {arguments}' if arguments else ''


def _named(roles: frozenset[Role]) -> str:
    return ', '.join(role.value for role in Role if role in roles)


def _possible(request: Request) -> str:
    match request.about:
        case About.CELL if request in CONTROLS.values():
            return ' or '.join(f'in {one.value}' for one in CONTROLS if CONTROLS[one] != request)
        case About.CELL if request is UNIT_MODES[UnitMode.MANUAL]:
            from_states = ' or '.join(state.value for state in MANUAL_FROM)
            return f'at a panel in local, in {from_states}'
        case _ if request.is_manual:
            return 'in manual mode' + (', at a panel in local' if request.needs_local else '')
        case About.CELL:
            states = [state.value for state in PackmlState if request in of_cell(state)]
            return _short(states, len(PackmlState))
        case About.JOB:
            words = [word.value for word in JobWord if request in of_job(JobFacts(word))]
            return _short(words, len(JobWord))
        case About.HOLD:
            return 'where the hold offers it'
        case About.ITEM:
            return 'while it is on the belt'
    return _ANY


def _short(states: list[str], of_all: int) -> str:
    return _ANY if len(states) == of_all else ', '.join(states)
