"""The steps from an empty folder to an installed package."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

from commands import base_interpreter, run_logged
from report import timed
from sources import copy_tree, digest, find_sources

SCRIPTS = Path(__file__).resolve().parents[1]
PACKAGE = 'bt_orchestrator'
# All that setup.py packs, and itself.
PACKED = (
    *(PACKAGE, 'config', 'launch', 'resource', 'schemas', 'trees'),
    *('package.xml', 'pyproject.toml', 'setup.cfg', 'setup.py'),
)
VARIABLES = Path(__file__).with_name('ros_variables.py')


class Environment:
    """`folder` is .venv/<distro>; its ``bootstrap/`` holds stamps, logs and copies to build."""

    def __init__(self, root: Path, distro: str) -> None:
        self.folder = root / '.venv' / distro
        self._root = root
        self._distro = distro
        self._state = self.folder / 'bootstrap'
        self._python = self.folder / 'bin' / 'python'

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
        requirements = self._requirements()
        foundation = digest(requirements, sys.version, os.path.realpath(sys.executable))
        variables = digest([VARIABLES], foundation)
        done = [
            self._step('environment', foundation, lambda: self._create(requirements)),
            self._step('variables', variables, self._install_variables),
        ]
        interfaces = self._root / 'interfaces'
        builder = find_sources(interfaces / 'rosidl_pip')
        for project in sorted(path.parent for path in interfaces.glob('*/setup.py')):
            sources = [*builder, *find_sources(project)]
            done.append(self._install_step(project.name, foundation, sources, project, interfaces))
        sources = find_sources(*(self._root / name for name in PACKED))
        done.append(self._install_step(PACKAGE, foundation, sources, self._root, self._root))
        return any(done)

    def _requirements(self) -> list[Path]:
        folder = SCRIPTS / 'requirements'
        return [folder / f'{name}.txt' for name in ('dev', 'runtime', self._distro)]

    def _step(self, name: str, stamp: str, action: Callable[[], None]) -> bool:
        """Run `action`, unless it ended well before with the same `stamp`."""
        file = self._state / f'{name}.stamp'
        if file.exists() and file.read_text() == stamp:
            return False
        file.unlink(missing_ok=True)
        with timed(name):
            action()
        file.write_text(stamp)
        return True

    def _create(self, requirements: list[Path]) -> None:
        """Start from nothing: what an older list had installed must not hide a missing pin."""
        if self.folder.exists():
            shutil.rmtree(self.folder)
        self._state.mkdir(parents=True)
        run_logged(self._state / 'venv.log', sys.executable, '-m', 'venv', str(self.folder))
        for path in requirements:
            # The lists are complete, so a package that they lack is to be noticed, not fetched.
            # One of them (empy) comes as source only; dev.txt, the first, brings what builds it.
            self._pip(path.stem, '--no-deps', '--no-build-isolation', '-r', path)
        (self._state / 'interpreter').write_text(sys.executable)

    def _install_variables(self) -> None:
        """See `ros_variables`. Files named .pth run in the order of their names: ours is early."""
        version = f'python{sys.version_info.major}.{sys.version_info.minor}'
        site_packages = self.folder / 'lib' / version / 'site-packages'
        shutil.copy(VARIABLES, site_packages / '_ros_variables.py')
        line = f"import _ros_variables; _ros_variables.set_up('{self._distro}')\n"
        (site_packages / '_ros_variables.pth').write_text(line)
        (self.folder / 'log').mkdir(exist_ok=True)

    def _install_step(
        self, name: str, foundation: str, sources: list[Path], project: Path, base: Path
    ) -> bool:
        """Install `project` from a copy of its `sources`, all of which lie under `base`."""

        def install() -> None:
            copy = self._state / 'build'
            copy_tree(sources, base, copy)
            project_copy = copy / project.relative_to(base)
            # Built against what is installed here, by the setuptools that is installed here.
            self._pip(name, '--no-deps', '--no-build-isolation', '--force-reinstall', project_copy)
            shutil.rmtree(copy)

        return self._step(name, digest(sources, foundation), install)

    def _pip(self, log: str, *arguments: str | Path) -> None:
        command = [self._python, '-m', 'pip', 'install', '--disable-pip-version-check', *arguments]
        run_logged(self._state / f'{log}.log', *map(str, command))
