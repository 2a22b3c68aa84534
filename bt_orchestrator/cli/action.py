"""The arguments and the work of a verb, or of an action of a group of verbs."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import NamedTuple


class Action(NamedTuple):
    """One thing that can be typed, as `status`, or `pause` of `cell`."""

    add_arguments: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], int]
    """Carries it out; returns the exit status."""
    effect: str = ''
    """One line of help."""
