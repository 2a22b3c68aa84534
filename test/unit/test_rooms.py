"""What import rules cannot say of the rooms of docs/architecture.md."""

from __future__ import annotations

import ast
import graphlib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / 'bt_orchestrator'
FILES = sorted(PACKAGE.rglob('*.py'))

MOST_LINES = 5000

TOP = {PACKAGE / '__init__.py'}

INSIDERS = ('ros/executor/lean_',)
"""The files that may use what rclpy does not promise to keep."""

UNASKED_CANCEL = ('sim/controllers/task_server.py', '_update_state')
"""A simulated server that cancels on its own account, for which rclpy has no public call."""

SURFACES = ('cli/', 'view/screen/', 'view/drawing/', 'extensions/')
"""What people see and type."""

DOOR = ('cli/door.py', 'bt_orchestrator.ros.link.ros_link')
"""The one place where the door of a real node is opened."""

USERS = ('bench', 'launch')
"""What uses the package, and is installed or measured with it."""

MOST_ENTRIES = 14
"""At the top of the package: folders, and files."""

BEFORE = {
    **{f'extensions/{name}/verb': 'cli' for name in ('page', 'opcua')},
    'extensions/opcua/mes': 'mes',
    'extensions/opcua': 'opcua',
    'extensions/page': 'web',
    'extensions/parquet': 'report',
    'extensions/postgres/sources': 'cli',
    'extensions/postgres/verb': 'cli',
    'extensions/postgres': 'store',
    'extensions/recipes/generating': 'cli',
    'extensions/recipes/planning': 'planning',
    'extensions/recipes/reading': 'script',
    'model/proof': 'proof',
    **{f'ports/{name}': name for name in ('doors', 'following', 'news', 'spare_log')},
    'ros/node_parameters': 'node_parameters',
    'script/users': 'users',
}
"""Rooms that were put together since: edges are counted over those of before, so it is no gain."""

MOST_EDGES = 145
"""Pairs of rooms of which one imports the other: only fewer."""

REQUESTS = ('.model.requests.', '.model.commands.', '.model.jobs.job_commands.')
NO_REQUESTS = ('TABLE', 'REQUESTS', 'Answer', 'OrderAnswer', 'Command', 'OnRecord', 'Sharing')
MOST_NAMING_REQUESTS = 18
"""Modules that name a single request, or a class of orders: only fewer."""


def rooms() -> list[Path]:
    return sorted({file.parent for file in FILES})


@pytest.mark.parametrize('room', rooms(), ids=lambda room: str(room.relative_to(ROOT)))
def test_no_room_exceeds_its_line_limit(room: Path) -> None:
    lines = sum(len(file.read_text().splitlines()) for file in room.glob('*.py'))
    assert lines <= MOST_LINES, f'{lines} lines; make a room in it for what belongs together'


def test_only_the_lean_way_uses_rclpy_internals() -> None:
    uses = {
        (name, inside)
        for name, file in ((file.relative_to(PACKAGE).as_posix(), file) for file in FILES)
        if not name.startswith(INSIDERS)
        for inside in used_of_the_inside(file.read_text())
    }
    assert uses == {UNASKED_CANCEL}, 'move it there, or use what rclpy documents'


def test_people_see_a_cell_through_its_door_alone() -> None:
    uses = {
        (name, outside)
        for name, file in ((file.relative_to(PACKAGE).as_posix(), file) for file in FILES)
        if name.startswith(SURFACES)
        for outside in behind_the_door(file.read_text())
    }
    assert uses == {DOOR}, 'ask and follow through ports.CellLink'


@pytest.mark.parametrize(
    ('text', 'outside'),
    [
        ('from bt_orchestrator_interfaces.msg import Status', 'bt_orchestrator_interfaces.msg'),
        ('def f():\n    import std_msgs.msg', 'std_msgs.msg'),
        ('from diagnostic_msgs.msg import KeyValue', 'diagnostic_msgs.msg'),
        ('from bt_orchestrator.ros.link import client', 'bt_orchestrator.ros.link'),
    ],
)
def test_what_is_behind_the_door_is_seen(text: str, outside: str) -> None:
    assert list(behind_the_door(text)) == [outside]


def behind_the_door(text: str) -> Iterator[str]:
    """Yield the modules of ROS messages that a module imports, and those of the link."""
    for node in ast.walk(ast.parse(text)):
        match node:
            case ast.Import(names):
                modules = [alias.name for alias in names]
            case ast.ImportFrom(str(module)):
                modules = [module]
            case _:
                continue
        yield from (name for name in modules if _is_message_module(name))


def _is_message_module(name: str) -> bool:
    package = name.partition('.')[0]
    is_of_messages = package.endswith(('_msgs', '_interfaces'))
    return is_of_messages or name.startswith('bt_orchestrator.ros.link')


@pytest.mark.parametrize(
    ('text', 'inside'),
    [
        ('from rclpy.impl.rcutils_logger import RcutilsLogger', 'rclpy.impl.rcutils_logger'),
        ('import rclpy.impl', 'rclpy.impl'),
        ('from rclpy import impl', 'rclpy.impl'),
        ('from rclpy.node import _hidden', 'rclpy.node._hidden'),
        ('import rclpy\nrclpy.node.Node._x', '_x'),
        ('from rclpy.node import Node\ndef f(node: Node):\n    node._clients.clear()', '_clients'),
        (
            'from rclpy.node import Node\nclass A(Node):\n    def f(self): self._clients',
            '_clients',
        ),
        ('from rclpy.node import Node\ngetattr(Node, "_clients")', '_clients'),
    ],
)
def test_the_inside_of_rclpy_is_seen(text: str, inside: str) -> None:
    assert list(used_of_the_inside(text)) == [inside]


@pytest.mark.parametrize(
    'text',
    [
        'from rclpy.node import Node\nNode.__init__',
        'from rclpy.node import Node\nclass A(Node):\n    def f(self): self._own = self._own',
        'from rclpy.node import Node\nclass A:\n    def __init__(self, a): self._a = a._asdict()',
        'class A:\n    def f(self, other): return other._own',
    ],
)
def test_what_is_not_of_rclpy_is_no_concern(text: str) -> None:
    assert list(used_of_the_inside(text)) == []


def used_of_the_inside(text: str) -> Iterator[str]:
    """Yield what a module takes from `rclpy.impl`, and the private names it uses of others.

    Only of modules that import rclpy.
    """
    tree = ast.parse(text)
    imported = list(_imported(tree))
    yield from (name for name in imported if '.impl' in name or '._' in name)
    if not imported:
        return
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(ast.Name('self' | 'cls'), _):
                pass
            case ast.Attribute(_, name) if _is_private(name):
                yield name
            case ast.Call(ast.Name('getattr' | 'setattr'), [_, ast.Constant(str(name)), *_]):
                if _is_private(name):
                    yield name
            case ast.ClassDef():
                yield from _inherited(node, {name.rpartition('.')[2] for name in imported})


def _imported(tree: ast.Module) -> Iterator[str]:
    """Yield what is imported of rclpy; of a hidden module its name."""
    for node in ast.walk(tree):
        match node:
            case ast.Import(names):
                modules = [alias.name for alias in names]
            case ast.ImportFrom(str(module), names):
                modules = [module if '.impl.' in module else f'{module}.{a.name}' for a in names]
            case _:
                continue
        yield from (name for name in modules if name.split('.')[0] == 'rclpy')


def _inherited(kind: ast.ClassDef, imported: set[str]) -> Iterator[str]:
    """Yield the private names that a class uses of a class of rclpy that it is made from."""
    if not any(isinstance(base, ast.Name) and base.id in imported for base in kind.bases):
        return
    functions = ast.FunctionDef | ast.AsyncFunctionDef
    own = {part.name for part in kind.body if isinstance(part, functions)}
    names = [
        node
        for node in ast.walk(kind)
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) == 'self'
    ]
    own |= {node.attr for node in names if isinstance(node.ctx, ast.Store)}
    yield from (node.attr for node in names if _is_private(node.attr) and node.attr not in own)


def _is_private(name: str) -> bool:
    of_tuples = ('_asdict', '_replace', '_fields')  # public names of named tuples
    return name.startswith('_') and not name.startswith('__') and name not in of_tuples


def test_few_entries_stand_at_the_top() -> None:
    entries = {path.name for path in PACKAGE.iterdir()} - {'__pycache__'}
    assert len(entries) <= MOST_ENTRIES, sorted(entries)


def test_rooms_know_few_others() -> None:
    """Also those that may be imported: each edge is one more thing to know of both."""
    places = {'.'.join(place(file)): place(file) for file in FILES if file not in TOP}
    users = [file for top in USERS for file in sorted((ROOT / top).rglob('*.py'))]
    edges = {
        (room_of(place(file)), room_of(places[module]))
        for file in {*FILES, *users} - TOP
        for module in imported_modules(file)
        if module in places and room_of(places[module]) != room_of(place(file))
    }
    assert len(edges) <= MOST_EDGES, sorted(edges)


def place(file: Path) -> tuple[str, ...]:
    """Return where a module is: its packages, and its name if it is no package itself."""
    parts = file.relative_to(ROOT).with_suffix('').parts
    return parts[:-1] if parts[-1] == '__init__' else parts


def room_of(parts: tuple[str, ...]) -> str:
    """Return the room of a module, as they were cut when the package had 35 entries at its top."""
    if parts[0] != PACKAGE.name:
        return parts[0]
    name = '/'.join(parts[1:])
    for now, before in BEFORE.items():
        if f'{name}/'.startswith(f'{now}/'):
            return before
    return parts[2] if parts[1] in ('base', 'engine', 'view') and len(parts) > 2 else parts[1]


def imported_modules(file: Path) -> Iterator[str]:
    """Yield the names that a module imports, both as a module and as a member of one."""
    for node in ast.walk(ast.parse(file.read_text())):
        match node:
            case ast.Import(names):
                yield from (alias.name for alias in names)
            case ast.ImportFrom(str(module), names):
                yield module
                yield from (f'{module}.{alias.name}' for alias in names)


def test_few_modules_name_a_single_request() -> None:
    """All others read what the table declares."""
    naming = {file for file in FILES if any(named_requests(file)) and not is_table(file)}
    assert len(naming) <= MOST_NAMING_REQUESTS, sorted(map(str, naming))


def test_no_module_imports_itself_over_others() -> None:
    """Imports for types alone count as well: who reads one module of a circle has to read all."""
    modules = {'.'.join(place(file)): file for file in FILES}
    graph = {
        name: {*imported_modules(file)} & modules.keys() - {name} for name, file in modules.items()
    }
    graphlib.TopologicalSorter(graph).prepare()


def is_table(file: Path) -> bool:
    return file.is_relative_to(PACKAGE / 'model' / 'requests')


def named_requests(file: Path) -> Iterator[str]:
    """Yield the constants of requests and the classes of commands that a file imports."""
    for node in ast.walk(ast.parse(file.read_text())):
        module = f'{node.module}.' if isinstance(node, ast.ImportFrom) else ''
        if not isinstance(node, ast.ImportFrom) or not any(part in module for part in REQUESTS):
            continue
        names = [alias.name for alias in node.names if alias.name not in NO_REQUESTS]
        is_table = '.model.requests.' in module
        yield from (name for name in names if (name if is_table else name[0]).isupper())
