"""Help of a request, from its declaration."""

from __future__ import annotations

from bt_orchestrator.model.requests import Request, Why
from bt_orchestrator.model.roles import Role


def in_one_line(request: Request) -> str:
    """Return what a request does, and who may ask for it."""
    return f'{request.effect} ({allowed(request)})'


def allowed(request: Request) -> str:
    """Return who may ask for a request, in words."""
    return ', '.join(role.value for role in Role if role in request.roles)


def what_to_know(request: Request) -> str:
    """Return what a user should know before the request."""
    reason = {
        Why.FIRST: 'It needs a reason.',
        Why.AFTERWARDS: 'It does not wait for a reason; without one it is on record as empty.',
        Why.NEVER: '',
    }[request.why]
    final = 'It cannot be taken back.' if request.is_confirmed else ''
    effect = f'{request.effect[0].upper()}{request.effect[1:]}.'
    sentences = (effect, f'For: {allowed(request)}.', reason, final)
    return ' '.join(filter(None, sentences))
