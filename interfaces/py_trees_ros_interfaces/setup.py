"""Build with pip, without colcon: see ``../rosidl_pip``; a ROS 2 distribution has this package."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from rosidl_pip import setup_interfaces  # noqa: E402 - found through the line above

setup_interfaces(HERE)
