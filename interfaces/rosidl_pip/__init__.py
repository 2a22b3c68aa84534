"""Build a ROS 2 interface package with pip alone, where there is no colcon and no CMake.

An interface package is ``package.xml``, definitions, and a ``CMakeLists.txt`` for colcon.
``python -m rosidl_pip PACKAGE WHEELS`` drives the same code generators as colcon (from the ROS 2
wheels of the environment it runs in), compiles what Python needs, and makes a wheel:

    definitions.py   what the package contains: package.xml, msg/, srv/, action/
    generate.py      definitions -> IDL, type hashes, C, C++ and Python sources
    compile.py       sources -> three shared objects
    command.py       the setuptools command that does both and lays out the wheel

It has to run in the environment that will load the result. There is no C++ type support and no
exported header, so only Python nodes can use such an installation, and one package built this way
cannot use the types of another.
"""

from rosidl_pip.command import setup_interfaces

__all__ = ['setup_interfaces']
