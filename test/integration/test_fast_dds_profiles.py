"""Fast DDS takes the profiles that it is given: one with a name that it does not know it drops."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable, MutableMapping
from pathlib import Path

import pytest
from ros_domain import discover_fast

from bt_orchestrator.ros.fast_dds import OLD_PROFILES, PROFILES, keep_off_shared_memory

pytestmark = pytest.mark.every_distro

MAKE_NODE = """
import rclpy
rclpy.init()
rclpy.create_node('reads_its_profile').destroy_node()
rclpy.shutdown()
"""


@pytest.mark.parametrize('give', [keep_off_shared_memory, discover_fast])
def test_a_lost_message_is_told_again_soon(
    give: Callable[[MutableMapping[str, str]], None],
) -> None:
    environ = {n: v for n, v in os.environ.items() if not n.startswith(('FASTDDS_', 'FASTRTPS_'))}
    give(environ)
    profile = Path(environ.get(PROFILES) or environ[OLD_PROFILES]).read_text()
    period = r'heartbeat_?period>\s*<sec>0</sec>\s*<nanosec>50000000</nanosec>'
    assert re.search(period, profile, re.IGNORECASE)
    made = subprocess.run(
        [sys.executable, '-c', MAKE_NODE], env=environ, capture_output=True, text=True, check=False
    )
    assert (made.returncode, made.stdout, made.stderr) == (0, '', '')
