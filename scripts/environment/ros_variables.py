"""Environment variables for every Python process of this environment.

scripts/bootstrap copies this file into site-packages, with a ``.pth`` file that calls `set_up`
whenever Python starts. So a node, a test or a subprocess has the variables however it was started
(``.venv/kilted/bin/bt-orchestrator`` from anywhere, an editor, cron), and nothing has to be
sourced. Those set with `setdefault` are defaults, which the user's shell may override.
"""

import os
import sys


def set_up(distro: str) -> None:
    """Runs before ros_wheels_bootstrapper's ``.pth``, which starts Python anew for the linker."""
    environ = os.environ
    environ['ROS_DISTRO'] = distro
    environ['AMENT_PREFIX_PATH'] = sys.prefix
    # Nothing leaves this computer unless the user says so (then: SUBNET).
    environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    # Shared memory segments outlive a killed process and then disturb the next one. It says
    # nothing to Fast DDS while the range above is LOCALHOST, but it does with SUBNET.
    environ.setdefault('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')
    # Also where HOME is missing or read-only, as in containers and in CI.
    environ.setdefault('ROS_LOG_DIR', os.path.join(sys.prefix, 'log'))
    _forget_other_libraries()


def _forget_other_libraries() -> None:
    """Of a sourced distribution, or of another such environment whose process started this one."""
    libraries = os.environ.get('LD_LIBRARY_PATH', '').split(os.pathsep)
    if os.path.join(sys.prefix, 'lib') not in libraries:
        os.environ.pop('LD_LIBRARY_PATH', None)
        os.environ.pop('_ROS_WHEELS_BOOTSTRAP_COMPLETE', None)  # have it set anew
