"""Settings of every test."""

import interrupts
import pytest
from fakes.profiles import PROFILE
from hypothesis import settings
from hypothesis.internal.conjecture import providers
from hypothesis.internal.constants_ast import Constants

from bt_orchestrator.ros.memory import collect_rarely

pytest_plugins = ['failed_cells', 'long_first', 'on_idle', 'ros_domain', 'skips']

# The same examples in every run: a red gate means that the change is wrong. No deadline, because
# a busy machine is no bug. In the night the examples are new, and a failure is printed with what
# is needed to see it again.
# Hypothesis draws numbers from the text of the tests as well. Then each change of any test would
# change what all others draw.
pytest.MonkeyPatch().setattr(providers, '_get_local_constants', Constants)
settings.register_profile('gate', derandomize=True, deadline=None)
settings.register_profile('nightly', deadline=None, print_blob=True)
settings.register_profile('shard', deadline=None, print_blob=True)
settings.load_profile(PROFILE)

interrupts.heed()


def pytest_collection_finish() -> None:
    """Look for garbage as rarely as a node does; a run of tests holds a million objects."""
    collect_rarely()
