"""Environment variables for every Python process of this environment.

scripts/bootstrap copies this file into site-packages, with a ``.pth`` file that calls `set_up`
whenever Python starts. So a node, a test or a subprocess has the variables however it was started
(``.venv/jazzy/bin/bt-orchestrator`` from anywhere, an editor, cron), and nothing has to be
sourced. Those set with `setdefault` are defaults, which the user's shell may override.
"""

import os
import sys

from _fast_dds import keep_off_shared_memory  # copied from bt_orchestrator/ros

RCLPY = os.path.join('share', 'ament_index', 'resource_index', 'packages', 'rclpy')


def set_up(distro: str) -> None:
    """Runs before ros_wheels_bootstrapper's ``.pth``, which starts Python anew for the linker."""
    environ = os.environ
    overlays = _overlays()
    environ['ROS_DISTRO'] = distro
    environ['AMENT_PREFIX_PATH'] = os.pathsep.join([sys.prefix, *overlays])
    # Nothing leaves this computer unless the user says so (then: SUBNET).
    environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    keep_off_shared_memory(environ)
    # Also where HOME is missing or read-only, as in containers and in CI.
    environ.setdefault('ROS_LOG_DIR', os.path.join(sys.prefix, 'log'))
    _forget_other_libraries(overlays)


def _overlays() -> list[str]:
    """Prefixes that were set, such as a workspace with interfaces; no other ROS 2 among them."""
    prefixes = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    others = [prefix for prefix in prefixes if prefix and prefix != sys.prefix]
    return [prefix for prefix in others if not os.path.exists(os.path.join(prefix, RCLPY))]


def _forget_other_libraries(overlays: list[str]) -> None:
    """Of a sourced distribution, or of another such environment whose process started this one."""
    libraries = os.environ.get('LD_LIBRARY_PATH', '').split(os.pathsep)
    if os.path.join(sys.prefix, 'lib') in libraries:
        return
    kept = [path for path in libraries if path.startswith(tuple(f'{one}/' for one in overlays))]
    if kept:
        os.environ['LD_LIBRARY_PATH'] = os.pathsep.join(kept)
    else:
        os.environ.pop('LD_LIBRARY_PATH', None)
    os.environ.pop('_ROS_WHEELS_BOOTSTRAP_COMPLETE', None)  # have it set anew
