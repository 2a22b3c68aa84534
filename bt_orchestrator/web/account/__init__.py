"""The account of the shift that runs: as a part of the page, as a document, and as metrics."""

from bt_orchestrator.web.account.endpoints import endpoints
from bt_orchestrator.web.account.watch import ShiftWatch

__all__ = ['ShiftWatch', 'endpoints']
