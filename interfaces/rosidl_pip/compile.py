"""Compile generated sources into the three shared objects that Python needs.

``<pkg>_s__rosidl_typesupport_c`` is the extension module: the C structures, their conversion from
and to Python, and the type support that dispatches to the other two. These, one for Fast DDS and
one for introspection, are opened by the dispatcher under the names they would have in a ROS 2
installation. The extension links to them, and they carry those names as SONAME: so they are mapped
already when the dispatcher asks, and the dynamic loader has nothing to search for.
"""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import sysconfig
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from rosidl_pip.definitions import InterfacePackage
from rosidl_pip.generate import GENERATORS, TYPESUPPORTS, referenced_packages

# Conversion is a small part of what a message costs, so build time is worth more than speed.
# Nobody here can mend a warning in generated code.
COMPILE_FLAGS = ('-O0', '-fPIC', '-w')
LINK_FLAGS = (
    '-shared',
    # The package's libraries lie beside its extension, those of the wheels in <prefix>/lib.
    '-Wl,-rpath,$ORIGIN:$ORIGIN/../../..',
    # The extension has to map the plugins, though none of its own symbols asks for them.
    '-Wl,--no-as-needed',
)


@dataclass(frozen=True)
class SharedObject:
    """What one library is made of."""

    file: str
    sources: tuple[str, ...]
    """Globs in the generated tree. What one glob finds becomes one translation unit."""
    suffixes: tuple[str, ...]
    """``lib<dependency>__<suffix>.so`` are linked, for every package whose types are used."""
    runtime: tuple[str, ...]
    """Libraries of ROS 2 itself that are linked."""


@dataclass(frozen=True)
class Unit:
    """What one call of the compiler reads and writes."""

    source: Path
    object_file: str
    size: int
    """Bytes of sources in it."""


def compile_package(package: InterfacePackage, generated: Path, out: Path) -> None:
    """Write the shared objects to `out`, from what `generate` left in `generated`."""
    out.mkdir(parents=True, exist_ok=True)
    dependencies = referenced_packages(package, generated)
    targets = _shared_objects(package.name)
    objects = {target.file: _units(target, generated) for target in targets}
    _compile([unit for units in objects.values() for unit in units], _include_flags(generated))
    *plugins, extension = targets
    for target in plugins:
        _link(target, objects[target.file], out, _libraries(target, dependencies))
    plugin_flags = [f'-L{out}', *(f'-l:{plugin.file}' for plugin in plugins)]
    libraries = [*plugin_flags, *_libraries(extension, dependencies)]
    _link(extension, objects[extension.file], out, libraries)


def _shared_objects(name: str) -> list[SharedObject]:
    """Plugins first: the extension links to them, and their open symbols are found in it."""
    fastrtps, introspection = TYPESUPPORTS
    return [
        SharedObject(
            file=f'lib{name}__{fastrtps}.so',
            sources=(f'{fastrtps}/*/*/detail/*.cpp',),
            suffixes=(fastrtps,),
            runtime=(fastrtps, 'fastcdr'),
        ),
        SharedObject(
            file=f'lib{name}__{introspection}.so',
            sources=(f'{introspection}/*/*/detail/*.c',),
            suffixes=(introspection,),
            runtime=(introspection,),
        ),
        SharedObject(
            file=f'{name}_s__rosidl_typesupport_c{sysconfig.get_config_var("EXT_SUFFIX")}',
            sources=(
                'rosidl_generator_c/*/*/detail/*__functions.c',
                'rosidl_generator_c/*/*/detail/*__type_support.c',
                'rosidl_generator_c/*/*/detail/*__description.c',
                'rosidl_generator_py/*/*/*_s.c',
                'rosidl_generator_py/*/*.ep.rosidl_typesupport_c.c',
                'rosidl_typesupport_c/*/*/*__type_support.cpp',
            ),
            suffixes=('rosidl_generator_c', 'rosidl_generator_py', 'rosidl_typesupport_c'),
            runtime=('rosidl_typesupport_c', 'rosidl_runtime_c', 'rcutils'),
        ),
    ]


def _compile(units: list[Unit], includes: list[str]) -> None:
    """Compile all, as many at a time as there are processors; the longest begin."""
    done = itertools.count(1)

    def compile_unit(unit: Unit) -> None:
        source = str(unit.source)
        output = ['-c', source, '-o', unit.object_file]
        _run(_compiler(unit.source.suffix), *COMPILE_FLAGS, *includes, *output)
        print(f'compiled {next(done)} of {len(units)}', flush=True)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        longest = sorted(units, key=lambda unit: -unit.size)
        list(pool.map(compile_unit, longest))  # a list, or errors would go unseen


def _link(target: SharedObject, units: list[Unit], out: Path, libraries: list[str]) -> None:
    flags = [*LINK_FLAGS, f'-Wl,-soname,{target.file}', '-o', str(out / target.file)]
    _run(_compiler('.cpp'), *flags, *(unit.object_file for unit in units), *libraries)


def _units(target: SharedObject, generated: Path) -> list[Unit]:
    folder = generated / 'objects' / target.file
    folder.mkdir(parents=True, exist_ok=True)
    return [unit for glob in target.sources for unit in _units_of(generated, glob, folder)]


def _units_of(generated: Path, glob: str, folder: Path) -> list[Unit]:
    """Include sources in one file: most of the time goes into the headers they share."""
    sources = sorted(generated.glob(glob))
    name = glob.replace('/', '.').replace('*', '')
    if glob.endswith('__description.c'):  # each defines the same static names
        return [
            Unit(source, str(folder / f'{number}{name}.o'), source.stat().st_size)
            for number, source in enumerate(sources)
        ]
    unit = folder / (name + sources[0].suffix)
    unit.write_text(''.join(f'#include "{source}"\n' for source in sources))
    return [Unit(unit, f'{unit}.o', sum(source.stat().st_size for source in sources))]


def _include_flags(generated: Path) -> list[str]:
    import numpy

    wheels = Path(sys.prefix, 'include')
    folders = [
        *(generated / generator for generator in GENERATORS),
        wheels,  # some wheels install to include/<pkg>/<pkg>, some to include/<pkg>
        *(path for path in sorted(wheels.iterdir()) if path.is_dir()),
        sysconfig.get_path('include'),
        numpy.get_include(),
    ]
    return [f'-I{folder}' for folder in folders]


def _libraries(target: SharedObject, dependencies: list[str]) -> list[str]:
    names = [f'{package}__{suffix}' for suffix in target.suffixes for package in dependencies]
    folder = Path(sys.prefix, 'lib')
    return [f'-L{folder}', *(f'-l{name}' for name in (*names, *target.runtime))]


def _compiler(suffix: str) -> str:
    return os.environ.get('CC', 'cc') if suffix == '.c' else os.environ.get('CXX', 'c++')


def _run(*command: str) -> None:
    try:
        subprocess.run(command, check=True)
    except FileNotFoundError:
        raise SystemExit(f'{command[0]}: not found; install a C and C++ compiler') from None
    except subprocess.CalledProcessError as error:
        raise SystemExit(f'failed with {error.returncode}: {" ".join(command)}') from None
