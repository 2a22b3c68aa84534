"""The requests that a reader may make, and the roles for the others (semantics 7.1)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bt_orchestrator.model.requests.possible import of_hold
from bt_orchestrator.model.requests.request import Request
from bt_orchestrator.model.roles import Role

_PEOPLE = {
    Role.VIEW: 'a viewer',
    Role.MES: 'an MES',
    Role.OPERATE: 'an operator',
    Role.ENGINEER: 'an engineer',
}


def may_make(request: Request, role: Role | None) -> bool:
    """Tell whether a role may make a request.

    :param role: of the reader; None: not known, so nothing is kept from the reader
    """
    return role is None or role in request.roles


def allowed(answers: Iterable[str], role: Role | None) -> list[str]:
    """Return the answers to a hold that a role may give."""
    return [one.word for one in of_hold(answers) if may_make(one, role)]


def roles_of(answers: Iterable[str]) -> dict[str, list[str]]:
    """Return the roles that may give each of the answers to a hold."""
    return {
        one.word: [role.value for role in Role if role in one.roles] for one in of_hold(answers)
    }


def role_words(answers: Sequence[str]) -> list[str]:
    """Return for each of the answers to a hold the roles that may give it, as one text."""
    roles = roles_of(answers)
    return [' or '.join(roles.get(answer, ())) for answer in answers]


def who_may(request: Request) -> str:
    """Name the people who may make a request, for instance an operator or an engineer."""
    return ' or '.join(_PEOPLE[role] for role in Role if role in request.roles)


def offer_words(answers: Sequence[str], role: Role | None) -> str:
    """Name the answers that a role may give, and who may give the others."""
    mine = ', '.join(allowed(answers, role))
    return '; '.join(filter(None, (mine, *answers_of_others(answers, role))))


def answers_of_others(answers: Sequence[str], role: Role | None) -> list[str]:
    """Say who may give the answers to a hold that a role may not give."""
    words: dict[str, list[str]] = {}
    for request in of_hold(answers):
        if not may_make(request, role):
            words.setdefault(who_may(request), []).append(request.word)
    also = 'may also' if allowed(answers, role) else 'may'
    return [f'{who} {also}: {", ".join(names)}' for who, names in words.items()]
