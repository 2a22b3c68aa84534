"""Why a stream is not opened."""

from __future__ import annotations

from bt_orchestrator.base.errors import OrchestratorError


class StreamRefused(OrchestratorError):
    """A stream cannot be opened as requested."""
