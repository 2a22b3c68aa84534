"""``python -m rosidl_pip PACKAGE WHEELS``: the wheel of an interface package, put into a folder.

PACKAGE needs no file but its package.xml and its definitions; a ``build`` folder is left in it.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from rosidl_pip.command import setup_interfaces


def main() -> None:
    parser = argparse.ArgumentParser(prog='rosidl_pip', description=__doc__)
    parser.add_argument('package', type=Path, help='folder with package.xml, msg/, srv/, action/')
    parser.add_argument('wheels', type=Path, help='folder to put the wheel into')
    options = parser.parse_args()
    wheels = options.wheels.absolute()
    os.chdir(options.package)
    # What setuptools is told by whoever builds a wheel.
    sys.argv = ['setup.py', '--quiet', 'bdist_wheel', '--dist-dir', str(wheels)]
    setup_interfaces(Path.cwd())


if __name__ == '__main__':
    main()
