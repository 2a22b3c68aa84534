"""Where programs keep what is of the user who runs them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from bt_orchestrator.base.errors import OrchestratorError

PROJECT = 'bt_orchestrator'


class NoHome(OrchestratorError):
    """The home folder of this user is not known, as in a container."""


def own_folder(environment: Mapping[str, str], variable: str, below: str) -> Path:
    """Return a folder of the user for files of this project, as the XDG base directories say.

    :param variable: which names the folder for files of all programs
    :param below: where that is in the home folder if the variable is not set
    :raises NoHome: it is not set, and there is no home folder
    """
    if environment.get(variable):
        return Path(environment[variable], PROJECT)
    try:
        return Path.home() / below / PROJECT
    except RuntimeError:
        raise NoHome(
            f'there is no home folder for user id {os.getuid()}, in which {below}/{PROJECT} would '
            f'be; set HOME or {variable}, or name the path with an option'
        ) from None
