"""The setuptools command that builds an interface package, and the layout of its wheel."""

from __future__ import annotations

import shutil
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

from rosidl_pip.compile import compile_package
from rosidl_pip.definitions import InterfacePackage, read_package
from rosidl_pip.generate import generate

INDEX = 'share/ament_index/resource_index'


def setup_interfaces(root: Path) -> None:
    """Do what ``setup()`` does, for the interface package in `root`."""
    package = read_package(root)

    class BuildInterfaces(build_py):
        """Put generated modules and shared objects where setuptools expects copied sources."""

        def run(self) -> None:
            scratch = Path(self.get_finalized_command('build').build_temp).absolute()
            shutil.rmtree(scratch, ignore_errors=True)
            build_package(package, scratch, Path(self.build_lib, package.name))
            self.distribution.data_files = _data_files(package, scratch)

    setup(
        name=package.name,
        version=package.version,
        description=package.description,
        license=package.licence,
        packages=[package.name],
        package_dir={package.name: '.'},  # has to exist, though nothing is copied from it
        cmdclass={'build_py': BuildInterfaces},
        distclass=_BinaryDistribution,
        zip_safe=False,
    )


def build_package(package: InterfacePackage, scratch: Path, out: Path) -> None:
    """Generate and compile in `scratch`; leave an importable package in `out`."""
    generated = scratch / 'generated'
    generate(package, generated)
    modules = generated / 'rosidl_generator_py' / package.name
    shutil.copytree(
        modules, out, ignore=shutil.ignore_patterns('*.c', '*.json'), dirs_exist_ok=True
    )
    (out / '__init__.py').touch()
    compile_package(package, generated, out)


class _BinaryDistribution(Distribution):
    """Makes the wheel specific to this Python and platform."""

    def has_ext_modules(self) -> bool:
        return True


def _data_files(package: InterfacePackage, scratch: Path) -> list[tuple[str, list[str]]]:
    """What ``share/`` holds after a colcon build too; ament_index_python reads the index."""
    share = f'share/{package.name}'
    generated = scratch / 'generated'
    files = [(share, ['package.xml'])]
    listed = []
    for path in package.files:
        idl, description = path.with_suffix('.idl'), path.with_suffix('.json')
        sources = [str(path), str(generated / 'idl' / idl), str(generated / 'hash' / description)]
        files.append((f'{share}/{path.parent}', sources))
        listed += [str(idl), str(path)]
    for resource, text in (('packages', ''), ('rosidl_interfaces', '\n'.join(sorted(listed)))):
        marker = scratch / resource / package.name
        marker.parent.mkdir(parents=True, exist_ok=True)
        marker.write_text(text)
        files.append((f'{INDEX}/{resource}', [str(marker)]))
    return files
