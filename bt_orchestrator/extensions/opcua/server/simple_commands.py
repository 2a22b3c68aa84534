"""The methods of the flat part: plain texts and numbers in, a plain answer out."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial

from asyncua import ua

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.extensions.opcua.mes.plain_commands import (
    Unclear,
    answer_of,
    classification_of,
    command_of,
    component_command_of,
    order_of,
    release_of,
    verbs,
    with_code,
)
from bt_orchestrator.extensions.opcua.server import calls
from bt_orchestrator.extensions.opcua.server.bridge import Bridge
from bt_orchestrator.extensions.opcua.server.calls import CALLER, Argument, reason_of
from bt_orchestrator.extensions.opcua.server.space import Space
from bt_orchestrator.model.requests import (
    About,
    Addressed,
    BadArguments,
    Request,
    ask,
    requests_about,
)
from bt_orchestrator.ports.doors.tickets import Outcome
from bt_orchestrator.script.given_values import arguments_of

TEXT, COUNT = ua.VariantType.String, ua.VariantType.UInt32

ACCEPTED = Argument('Accepted', ua.VariantType.Boolean, 'the cell does it')
MESSAGE = Argument('Message', TEXT, 'what was done, or why nothing was')
FINDINGS = Argument('Findings', TEXT, 'every mistake of the order', is_list=True)
REASON = Argument('Reason', TEXT, 'why, for the record')
_STOP, _CODE = requests_about(About.STOP)[0].parameters
CODE_GIVEN = Argument('Code', TEXT, f'{_CODE.meaning}, one of Reasons/Codes; empty: none')


def _words(requests: Iterable[Request]) -> str:
    return ', '.join(request.word for request in requests)


SUBMIT_ORDER = (
    Argument('Id', TEXT, 'of the order, given once; its job has the same id'),
    Argument('Script', TEXT, 'name of the script that it runs, or of the recipe'),
    Argument('Quantity', COUNT, 'items to make; 0: the default of the script'),
    Argument('Parameters', TEXT, 'of the script, each as in speed=12', is_list=True),
)
COMMAND = (
    Argument(
        'Verb',
        TEXT,
        f'to the cell: {_words(verbs(About.CELL))}; to a job: {_words(verbs(About.JOB))}',
    ),
    Argument('Job', TEXT, 'id of the job; empty: the cell'),
    REASON,
)
REQUEST = (
    Argument('Name', TEXT, 'of the request: its subject and its word, as in job.move'),
    Argument('Arguments', TEXT, 'by name, as JSON or YAML: {"job": "WO-7", "position": 1}'),
    REASON,
)
ANSWER_HOLD = (
    Argument('Hold', TEXT, 'id of the hold, as in OldestHold/ID'),
    Argument('Answer', TEXT, 'one of OldestHold/Answers, or acknowledge or comment'),
    REASON,
)
COMPONENT_COMMAND = (
    Argument('Verb', TEXT, _words(verbs(About.COMPONENT))),
    Argument('Component', TEXT, 'its name in the cell file'),
    REASON,
)
RELEASE_SCRIPT = (
    Argument('Script', TEXT, requests_about(About.SCRIPT)[0].parameters[0].meaning),
    REASON,
)
CLASSIFY_STOP = (
    Argument('Stop', TEXT, _STOP.meaning),
    Argument('Code', TEXT, f'{_CODE.meaning}, one of Reasons/Codes'),
    REASON,
)
WITH_CODE = 'WithCode'
"""End of the name of a method that also takes a reason of the plant."""


class SimpleCommands:
    """Carries out the methods, for the caller of each."""

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge

    async def build(self, space: Space, top: str) -> None:
        """Make the methods."""
        await space.method(
            f'{top}/SubmitOrder', self._submit, SUBMIT_ORDER, (ACCEPTED, MESSAGE, FINDINGS),
            'queues an order; its job starts when its turn comes',
        )  # fmt: skip
        for name, read, arguments, does, about in (
            (
                'Command', command_of, COMMAND, 'a command to the cell, or to a job',
                (About.CELL, About.JOB),
            ),
            (
                'ComponentCommand', component_command_of, COMPONENT_COMMAND,
                'whether a component may get goals; this is no lockout', (About.COMPONENT,),
            ),
            (
                'ReleaseScript', release_of, RELEASE_SCRIPT,
                'lets jobs of a generated script start', (About.SCRIPT,),
            ),
            (
                'AnswerHold', self._answer, ANSWER_HOLD,
                'decides what becomes of something that is held', (About.HOLD,),
            ),
            (
                'ClassifyStop', classification_of, CLASSIFY_STOP,
                "says the plant's reason for a stop of the line; the last one counts", (),
            ),
        ):  # fmt: skip
            call, method = partial(self._carry_out, name, read), (ACCEPTED, MESSAGE)
            await space.method(f'{top}/{name}', call, arguments, method, does)
            if any(request.takes_code for request in requests_about(*about)):
                path, call = f'{top}/{name}{WITH_CODE}', partial(self._with_code, name, read)
                more = f'{does}; with a reason of the plant for the stop of the line'
                await space.method(path, call, (*arguments, CODE_GIVEN), method, more)
        await space.method(
            f'{top}/Request', self._request, REQUEST, (ACCEPTED, MESSAGE, FINDINGS),
            'makes any request by its name; docs/requests.md lists them',
        )  # fmt: skip

    async def _request(self, name: str, arguments: str, reason: str) -> list[ua.Variant]:
        reason = reason_of(reason, 'Request')
        try:
            asked = ask(name, calls.by_caller(reason, ''), **arguments_of(arguments))
        except (BadArguments, CommandRefused) as error:
            return _told(Outcome(False, str(error)), findings=True)
        outcome = await self._bridge.calls.ask(asked.request, asked.arguments, reason)
        return _told(outcome, findings=True)

    async def _submit(
        self, id_: str, script: str, quantity: int, parameters: Sequence[str]
    ) -> list[ua.Variant]:
        try:
            recipes = await self._bridge.orderable.recipe_names(script)
            order = order_of(id_, script, quantity, parameters, recipes)
        except Unclear as error:
            return _told(Outcome(False, 'the order was not sent', error.findings), findings=True)
        outcome = await self._bridge.calls.ask('queue.add', {'orders': [order]}, '')
        return _told(outcome, findings=True)

    async def _carry_out(
        self, method: str, read: Callable[..., Addressed], *given: str
    ) -> list[ua.Variant]:
        """Make the request that the arguments of a method stand for; the last is the reason."""
        *words, reason = given
        try:
            request, arguments = read(*words)
        except Unclear as error:
            return _told(Outcome(False, str(error)))
        return _told(await self._bridge.calls.ask(request, arguments, reason_of(reason, method)))

    async def _with_code(
        self, method: str, read: Callable[..., Addressed], *given: str
    ) -> list[ua.Variant]:
        *words, code = given
        return await self._carry_out(
            f'{method}{WITH_CODE}', lambda *plain: with_code(read(*plain), code.strip()), *words
        )

    def _answer(self, hold: str, answer: str) -> Addressed:
        return answer_of(hold, answer, self._bridge.status.holds, CALLER.get().role)


def _told(outcome: Outcome, *, findings: bool = False) -> list[ua.Variant]:
    outputs = [
        ua.Variant(outcome.accepted, ua.VariantType.Boolean),
        ua.Variant(outcome.message, TEXT),
    ]
    return [*outputs, ua.Variant(list(outcome.findings), TEXT)] if findings else outputs
