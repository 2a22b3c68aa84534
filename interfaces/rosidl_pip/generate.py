"""Run the ROS 2 code generators of this environment on one interface package.

Calls what their CMake macros call, with the same JSON argument files, because that is the one
entrance that Jazzy and Kilted have in common.
"""

from __future__ import annotations

import functools
import json
import multiprocessing
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rosidl_pip.definitions import InterfacePackage

# Fast DDS needs the first one; rcl_action complains at run time when the second one is missing.
TYPESUPPORTS = ('rosidl_typesupport_fastrtps_c', 'rosidl_typesupport_introspection_c')
GENERATORS = (
    'rosidl_generator_c',
    'rosidl_generator_py',
    'rosidl_typesupport_c',
    *TYPESUPPORTS,
)


def generate(package: InterfacePackage, out: Path) -> None:
    """Write IDL to ``out/idl``, type descriptions to ``out/hash``, code to ``out/<generator>``.

    Every generator gets an output folder of its own, as file names repeat between them.
    """
    _find_dependencies_in(Path(sys.prefix))
    _parse_each_idl_file_once()
    idl_files = _translate_to_idl(package, out / 'idl')
    arguments = _common_arguments(package, out, idl_files)
    _describe_types(arguments, out / 'hash')
    # Forked here, each generator inherits the parsed files, which are most of the work.
    with multiprocessing.get_context('fork').Pool(os.cpu_count()) as pool:
        jobs = [(name, arguments, out / name) for name in GENERATORS]
        for done, name in enumerate(pool.imap_unordered(_run_generator, jobs), start=1):
            print(f'{name}, generator {done} of {len(jobs)}', flush=True)


def referenced_packages(package: InterfacePackage, out: Path) -> list[str]:
    """Names of all packages whose types are used, directly or not."""
    names = {
        entry['type_name'].split('/')[0]
        for path in (out / 'hash').glob('*/*.json')
        for entry in json.loads(path.read_text())['type_hashes']
    }
    if any(path.suffix == '.action' for path in package.files):
        names.add('action_msgs')  # cancelling: in no type description, but in the type support
    return sorted(names - {package.name})


def _find_dependencies_in(prefix: Path) -> None:
    os.environ['AMENT_PREFIX_PATH'] = str(prefix)


def _parse_each_idl_file_once() -> None:
    """Memoise the IDL parser, which every generator calls again for every file."""
    import rosidl_generator_py.generate_py_impl
    import rosidl_generator_type_description
    import rosidl_parser.parser
    import rosidl_pycommon

    parsed: dict[Path, Any] = {}
    parse = rosidl_parser.parser.parse_idl_file

    @functools.wraps(parse)
    def parse_once(locator: Any) -> Any:
        path = locator.get_absolute_path()
        if path not in parsed:
            parsed[path] = parse(locator)
        return parsed[path]

    for module in (
        rosidl_generator_py.generate_py_impl,
        rosidl_generator_type_description,
        rosidl_pycommon,
    ):
        module.parse_idl_file = parse_once


def _translate_to_idl(package: InterfacePackage, out: Path) -> list[Path]:
    from rosidl_adapter import convert_to_idl

    return [
        Path(convert_to_idl(package.root, package.name, path, out)).relative_to(out)
        for path in package.files
    ]


def _common_arguments(
    package: InterfacePackage, out: Path, idl_files: list[Path]
) -> dict[str, Any]:
    share = Path(sys.prefix, 'share')
    return {
        'package_name': package.name,
        'idl_tuples': [f'{out / "idl"}:{path}' for path in idl_files],
        'type_description_tuples': [
            f'{path}:{out / "hash" / path.with_suffix(".json")}' for path in idl_files
        ],
        'ros_interface_files': [str(package.root / path) for path in package.files],
        'ros_interface_dependencies': [],
        'target_dependencies': [str(package.root / path) for path in package.files],
        'include_paths': [f'{path.name}:{path}' for path in share.iterdir() if path.is_dir()],
    }


def _describe_types(arguments: dict[str, Any], out: Path) -> None:
    from rosidl_generator_type_description import generate_type_hash

    generate_type_hash(_write_arguments(arguments, out))


def _run_generator(job: tuple[str, dict[str, Any], Path]) -> str:
    name, arguments, out = job
    templates = Path(sys.prefix, 'share', name, 'resource')
    folder = out / arguments['package_name']
    _generator_function(name)(
        _write_arguments({**arguments, 'template_dir': str(templates)}, folder)
    )
    _write_visibility_headers(templates, folder)
    return name


def _generator_function(name: str) -> Callable[[str], Any]:
    if name == 'rosidl_generator_c':
        from rosidl_generator_c import generate_c

        return generate_c
    if name == 'rosidl_generator_py':
        from rosidl_generator_py import generate_py

        return functools.partial(generate_py, typesupport_impls=['rosidl_typesupport_c'])
    if name == 'rosidl_typesupport_c':
        from rosidl_typesupport_c import generate_c

        return functools.partial(generate_c, type_supports=list(TYPESUPPORTS))
    if name == 'rosidl_typesupport_fastrtps_c':
        from rosidl_typesupport_fastrtps_c import generate_typesupport_fastrtps_c

        return generate_typesupport_fastrtps_c
    from rosidl_typesupport_introspection_c import generate_c

    return generate_c


def _write_arguments(arguments: dict[str, Any], out: Path) -> str:
    out.mkdir(parents=True, exist_ok=True)
    path = out.with_name(f'{out.name}__arguments.json')
    path.write_text(json.dumps({**arguments, 'output_dir': str(out)}))
    return str(path)


def _write_visibility_headers(templates: Path, folder: Path) -> None:
    """Do what CMake's ``configure_file`` does for the export macros."""
    for template in templates.glob('*__visibility_control.h.in'):
        text = template.read_text()
        text = text.replace('@PROJECT_NAME_UPPER@', folder.name.upper())
        header = folder / 'msg' / template.stem
        header.parent.mkdir(parents=True, exist_ok=True)
        header.write_text(text.replace('@PROJECT_NAME@', folder.name))
