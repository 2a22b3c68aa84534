"""Commands in plain texts, for clients that cannot build structures <-> requests of ours."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.jobs.order import RecipeChoice, WorkOrder, order_id_fault
from bt_orchestrator.model.requests import (
    About,
    Addressed,
    Request,
    answering,
    of_word,
    requests_about,
)
from bt_orchestrator.model.requests.offers import offer_words
from bt_orchestrator.model.state import Hold


class Unclear(OrchestratorError):
    """No request can be made of what was given."""

    def __init__(self, findings: Iterable[str]) -> None:
        self.findings = tuple(findings)
        super().__init__('; '.join(self.findings))


# --- orders -------------------------------------------------------------------------------------


def order_of(
    id_: str,
    script: str,
    quantity: int,
    parameters: Sequence[str],
    recipes: Collection[str] = (),
) -> WorkOrder:
    """Return a work order.

    :param script: name of a script, or of a recipe
    :param quantity: 0: the default of the script
    :param parameters: of the script, as in `speed=12`
    :param recipes: names that are those of recipes; every other is that of a script
    :raises Unclear: with every mistake
    """
    params: dict[str, str] = {}
    findings = list(_mistakes(id_, script, parameters, params))
    if findings:
        raise Unclear(findings)
    if script in recipes:
        recipe = RecipeChoice((script,))
        return WorkOrder('', id_, quantity or None, params, recipe=recipe)
    return WorkOrder(script, id_, quantity or None, params)


def _mistakes(
    id_: str, script: str, parameters: Sequence[str], params: dict[str, str]
) -> Iterator[str]:
    fault = order_id_fault(id_)
    if fault is not None:
        yield f'Id: {id_!r} cannot be one: {fault}'
    if not script:
        yield 'Script: it is empty; name a script, or a recipe'
    for text in parameters:
        name, equals, value = (part.strip() for part in text.partition('='))
        if not name or not equals:
            yield f'Parameters: expected name=value, found {text!r}'
        elif name in params:
            yield f'Parameters: {name} is given twice'
        else:
            params[name] = value


# --- commands -----------------------------------------------------------------------------------


def command_of(verb: str, job: str) -> Addressed:
    """Return the request that a verb stands for.

    :param job: its id; empty: the verb is for the cell
    :raises Unclear: says which verbs there are
    """
    if job:
        return Addressed(_request(About.JOB, verb, 'a job'), {'job': job})
    return Addressed(_request(About.CELL, verb, 'the cell'), {})


def component_command_of(verb: str, component: str) -> Addressed:
    """Return the request to a component that a verb stands for.

    :raises Unclear: says which verbs there are
    """
    return Addressed(_request(About.COMPONENT, verb, 'a component'), {'component': component})


def with_code(addressed: Addressed, code: str) -> Addressed:
    """Return a request with a reason of the plant for the stop of the line (semantics 7.10).

    :param code: of the reason; empty: none
    :raises Unclear: the request takes none
    """
    if not code:
        return addressed
    if not addressed.request.takes_code:
        raise Unclear(
            [f'Code: expected none, for {addressed.request.word} has no reason of the plant']
        )
    return addressed._replace(arguments={**addressed.arguments, 'code': code})


def classification_of(stop: str, code: str) -> Addressed:
    """Return the request that gives a stop its reason."""
    (classify,) = requests_about(About.STOP)
    return Addressed(classify, {'stop': stop, 'code': code})


def release_of(script: str) -> Addressed:
    """Return the request that releases a script."""
    (release,) = requests_about(About.SCRIPT)
    return Addressed(release, {'script': script})


def _request(about: About, verb: str, subject: str) -> Request:
    request = of_word(about, verb.strip().lower())
    if request is None or request not in verbs(about):
        words = ', '.join(choice.word for choice in verbs(about))
        raise Unclear([f'Verb: expected a command to {subject}: {words}; found {verb!r}'])
    return request


def verbs(about: About) -> tuple[Request, ...]:
    """Return the requests that a verb alone is enough for."""
    return tuple(
        request
        for request in requests_about(about)
        if not any(p.is_required for p in request.parameters if p is not request.subject)
    )


# --- holds --------------------------------------------------------------------------------------


def answer_of(
    hold: str, answer: str, holds: Sequence[Hold], role: Role | None = None
) -> Addressed:
    """Return the request that an answer to a hold, or a remark about it, stands for.

    :param holds: those there are
    :param role: of the caller; None: not known
    :raises Unclear: says what is expected
    """
    named_hold = next((candidate for candidate in holds if candidate.id == hold), None)
    if named_hold is None:
        waiting = ', '.join(candidate.id for candidate in holds) or 'none'
        raise Unclear([f'Hold: expected one that waits ({waiting}); found {hold!r}'])
    try:
        return answering(named_hold, answer.strip().lower())
    except KeyError:
        possible = offer_words(named_hold.answers, role) or 'none'
        expected = f'expected one that is possible now ({possible})'
        raise Unclear([f'Answer: {expected}; found {answer!r}']) from None
