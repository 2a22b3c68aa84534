"""The past: events, jobs, items, and the last work of sections and components."""

from bt_orchestrator.extensions.page.web.archive.archive import Archive
from bt_orchestrator.extensions.page.web.archive.endpoints import endpoints

__all__ = ['Archive', 'endpoints']
