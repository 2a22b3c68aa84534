"""The verb `job`: commands to one job."""

from __future__ import annotations

import argparse
from collections.abc import Mapping

from bt_orchestrator.cli.asked.derived import TYPED, actions_about, given, run_request
from bt_orchestrator.cli.command_parser import Action
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.model.requests import REQUESTS, About

DESCRIPTION = """\
Change, hold or end one job of a running tree node; `cell` is for the cell as a whole.
See docs/queue.md for the effect of each command in each state of a job."""

_UPDATE = REQUESTS['job.update']
_ALL = actions_about(About.JOB)


def _update(args: argparse.Namespace) -> int:
    if len(given(_UPDATE, args)) < 2:
        raise WrongUse(f'say what to change: {", ".join(_options())}')
    return run_request(_UPDATE, args)


def _options() -> list[str]:
    names = [parameter.name for parameter in _UPDATE.parameters if not parameter.is_required]
    return [TYPED[f'{_UPDATE.name}.{name}'][0] or f'--{name}' for name in names]


ACTIONS: Mapping[str, Action] = {**_ALL, _UPDATE.word: _ALL[_UPDATE.word]._replace(run=_update)}
