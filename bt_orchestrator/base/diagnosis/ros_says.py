"""Why ROS 2 cannot be used, in a sentence."""

from __future__ import annotations

from collections.abc import Mapping

from bt_orchestrator.base.diagnosis.check import Verdict
from bt_orchestrator.base.diagnosis.domain import domain, reach
from bt_orchestrator.base.diagnosis.security import secured, security


def ros_says(error: Exception, environment: Mapping[str, str]) -> str:
    """Say what is wrong with the environment, else what ROS 2 says in its own words."""
    for look in (domain, reach, security):
        found = look(environment)
        if found.verdict is Verdict.FAIL:
            return f'{found.name}: {found.found}; {found.remedy}'
    # It ends with the place in the sources of rcl.
    words = str(error).splitlines()[0].partition(', at /')[0] if str(error) else repr(error)
    return f'ROS 2 says: {words}{secured(environment)}'
