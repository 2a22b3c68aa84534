"""What killed processes leave in shared memory disturbs nobody.

A folder of shared memory of its own is made for this, with a port whose lock cannot be taken.
"""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.every_distro

WITH_LEFTOVERS = """
set -e
mount -t tmpfs none /dev/shm
FASTDDS_BUILTIN_TRANSPORTS=DEFAULT "$0" -c '
import os, rclpy
rclpy.init()
node = rclpy.create_node("killed")
os.kill(os.getpid(), 9)' || true
for port in /dev/shm/fast*_port*[0-9]; do
    [ -e "$port" ] || { echo 'the killed process left no port'; exit 1; }
    rm -f "${port}_el" "${port}_sl"
    mkdir "${port}_el" "${port}_sl"
done
"$0" -c '
from bt_orchestrator.ros.diagnosis.participant import exchange
print(exchange({}))'
"""


def run_with_leftovers(**environment: str) -> subprocess.CompletedProcess[str]:
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(('FASTDDS_', 'FASTRTPS_'))
    }
    return subprocess.run(
        ['unshare', '--mount', 'sh', '-c', WITH_LEFTOVERS, sys.executable],
        env={**kept, **environment},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.mark.skipif(os.geteuid() != 0, reason='needs root, for a shared memory of its own')
def test_processes_communicate_despite_ports_of_killed_processes() -> None:
    run = run_with_leftovers()
    assert run.returncode == 0, run.stdout + run.stderr
    assert 'RTPS_TRANSPORT_SHM' not in run.stderr
    assert 'answered=None' not in run.stdout
    assert 'answered=' in run.stdout
