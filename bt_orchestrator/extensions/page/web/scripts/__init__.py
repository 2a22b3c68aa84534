"""Scripts on the page: by name for new orders, by digest with their lists, and as a drawing."""

from bt_orchestrator.extensions.page.web.scripts.endpoints import endpoints
from bt_orchestrator.extensions.page.web.scripts.shelf import Shelf

__all__ = ['Shelf', 'endpoints']
