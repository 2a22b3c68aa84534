"""Build a ROS 2 interface package with pip alone, where there is no colcon and no CMake.

An interface package keeps its ordinary ``package.xml`` and ``CMakeLists.txt`` for colcon. Beside
them a three-line ``setup.py`` calls `setup_interfaces`, which drives the same code generators
(from the ROS 2 wheels of the environment it runs in) and compiles what Python needs:

    definitions.py   what the package contains: package.xml, msg/, srv/, action/
    generate.py      definitions -> IDL, type hashes, C, C++ and Python sources
    compile.py       sources -> three shared objects
    command.py       the setuptools command that does both and lays out the wheel

Install with ``pip install --no-build-isolation``: the generators must be those of the ROS 2 that
will load the result. There is no C++ type support and no exported header, so only Python nodes
can use such an installation, and one package built this way cannot use the types of another.
"""

from rosidl_pip.command import setup_interfaces

__all__ = ['setup_interfaces']
