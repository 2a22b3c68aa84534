"""Mistakes of a command line, and of files that were refused."""

from __future__ import annotations

import sys

from bt_orchestrator.base.errors import OrchestratorError, Refused, counted


class WrongUse(OrchestratorError):
    """Options that cannot be carried out; the program ends with 2, as for those argparse finds."""


# Printing the mistakes of a file that was refused.

MOST_ON_TERMINAL = 50
"""Mistakes that a person is shown at once; a file or a pipe gets all of them."""


def print_mistakes(refused: Refused) -> None:
    """Print mistakes on the standard error, in the order of the file."""
    findings = refused.findings
    most = MOST_ON_TERMINAL if sys.stderr.isatty() else len(findings)
    for finding in findings[:most]:
        print(finding, file=sys.stderr)
    if len(findings) > most:
        rest = counted(len(findings) - most, 'more mistake')
        print(f'... and {rest}; check --json has all of them', file=sys.stderr)
