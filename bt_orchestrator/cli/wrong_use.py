"""The one error of the command line itself."""

from __future__ import annotations

from bt_orchestrator.base.errors import OrchestratorError


class WrongUse(OrchestratorError):
    """Options that cannot be carried out; the program ends with 2, as for those argparse finds."""
