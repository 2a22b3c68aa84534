"""Everything that can be asked of a cell, a job, an item or a hold: one table.

Verbs, services, help and documentation come from it, and so does who may ask what. In which state
something is possible is not restated here: `packml`, `job_control` and `failures` decide it.
"""

from bt_orchestrator.model.requests.asking import Asked, BadArguments, ask
from bt_orchestrator.model.requests.permission import refusal
from bt_orchestrator.model.requests.possible import of_cell, of_hold, of_job
from bt_orchestrator.model.requests.request import About, Kind, Parameter, Request, Why
from bt_orchestrator.model.requests.table import (
    ADD,
    ANSWERS,
    CELL,
    MOVE,
    NEXT,
    REMOVE_ITEM,
    REQUESTS,
    STOP_AFTERS,
    TABLE,
    UPDATE,
    of_word,
    words_about,
)

__all__ = [
    'About',
    'Kind',
    'Parameter',
    'Request',
    'Why',
    'ADD',
    'ANSWERS',
    'CELL',
    'MOVE',
    'NEXT',
    'REMOVE_ITEM',
    'REQUESTS',
    'STOP_AFTERS',
    'TABLE',
    'UPDATE',
    'of_word',
    'words_about',
    'of_cell',
    'of_hold',
    'of_job',
    'refusal',
    'Asked',
    'BadArguments',
    'ask',
]
