"""All requests to a cell, a job, an item or a hold: one table.

Verbs, services, help, documentation and permissions come from it. The states in which a request is
possible are not repeated here: `packml`, `job_control` and `failures` decide that.
"""

from bt_orchestrator.model.requests.asking import Asked, BadArguments, about_of, ask
from bt_orchestrator.model.requests.permission import refusal
from bt_orchestrator.model.requests.possible import (
    Addressed,
    answering,
    of_cell,
    of_hold,
    of_job,
    possible_answers,
)
from bt_orchestrator.model.requests.request import About, Kind, Parameter, Request, Why
from bt_orchestrator.model.requests.table import (
    ACKNOWLEDGE,
    ADD,
    ANSWERS,
    ARRANGE,
    CELL,
    COMMENT,
    IN_SERVICE,
    MOVE,
    NEXT,
    OUT_OF_SERVICE,
    RELEASE_SCRIPT,
    REMOVE_ITEM,
    REQUESTS,
    REQUEUE,
    STOP_AFTERS,
    TABLE,
    UPDATE,
    is_remark,
    of_name,
    of_word,
    requests_about,
    words_about,
)

__all__ = [
    'About',
    'Kind',
    'Parameter',
    'Request',
    'Why',
    'ACKNOWLEDGE',
    'ADD',
    'ANSWERS',
    'ARRANGE',
    'CELL',
    'COMMENT',
    'IN_SERVICE',
    'MOVE',
    'NEXT',
    'OUT_OF_SERVICE',
    'RELEASE_SCRIPT',
    'REMOVE_ITEM',
    'REQUESTS',
    'REQUEUE',
    'STOP_AFTERS',
    'TABLE',
    'UPDATE',
    'of_name',
    'is_remark',
    'of_word',
    'requests_about',
    'words_about',
    'Addressed',
    'answering',
    'possible_answers',
    'of_cell',
    'of_hold',
    'of_job',
    'refusal',
    'Asked',
    'BadArguments',
    'about_of',
    'ask',
]
