"""The account of the shift that runs: as a part of the page, as a document, and as metrics."""

from bt_orchestrator.extensions.page.web.account.endpoints import endpoints
from bt_orchestrator.extensions.page.web.account.watch import ShiftWatch, reason_part

__all__ = ['ShiftWatch', 'endpoints', 'reason_part']
