"""The verb `component`: whether a component may get goals."""

from __future__ import annotations

from bt_orchestrator.cli.asked.derived import actions_about
from bt_orchestrator.model.requests import About

DESCRIPTION = """\
Take a component out of service, or bring it back. Out of service is no lockout: it does not
protect people at the machine."""

ACTIONS = actions_about(About.COMPONENT)
