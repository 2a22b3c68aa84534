"""Look at what a release consists of: its dependencies, containers, manifests and wheels.

Steps, in this order (all but the last one are quick, and a part of continuous integration):

    audit         known holes in the Python and npm packages that the lists pin
    containers    the container file and the compose file, by hadolint and the compose schema
    manifests     package.xml, the changelog and the rosdep keys, by the tools of ROS
    licences      docs/licences.md against what is installed; --write makes it anew
    sbom          a CycloneDX list of the environment, in dist/
    install       sdist and wheel, in new environments of every Python that is here

A step that needs a network, and finds none, says NOT DONE and does not fail.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

import audit
import containers
import installing
import licences
import manifests
from outcome import Outcome, Place

sys.path.append(str(Path(__file__).parents[1] / 'environment'))

from installer import Installer

ROOT = Path(__file__).resolve().parents[2]
STEPS = {
    'audit': audit.look,
    'containers': containers.look,
    'manifests': manifests.look,
    'licences': licences.look,
    'sbom': licences.write_sbom,
    'install': installing.look,
}


def main() -> int:
    parser = argparse.ArgumentParser(
        prog='scripts/release-check',
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument('steps', nargs='*', metavar='STEP', help='(default: all)')
    parser.add_argument('--write', action='store_true', help='write docs/licences.md')
    options = parser.parse_args()
    if unknown := sorted(set(options.steps) - set(STEPS)):
        parser.error(f'no step is called {", ".join(unknown)}; there are {", ".join(STEPS)}')
    place = Place(ROOT, tools(), options.write)
    outcomes: list[Outcome] = []
    for name in options.steps or STEPS:
        print(f'\n== {name}', flush=True)
        for outcome in STEPS[name](place):
            print(f'  {outcome}', flush=True)
            outcomes.append(outcome)
    failed = sum(outcome.failed for outcome in outcomes)
    print(f'\n{len(outcomes) - failed} passed, {failed} failed')
    return int(failed > 0)


def tools() -> Path:
    """Return the folder of programs of .venv/release, made anew when its list has changed."""
    folder, pins = ROOT / '.venv' / 'release', ROOT / 'scripts' / 'requirements' / 'release.txt'
    stamp = folder / 'pins.txt'
    if not stamp.exists() or stamp.read_text() != pins.read_text():
        command = [sys.executable, '-m', 'venv', '--clear', '--without-pip', str(folder)]
        subprocess.run(command, check=True)
        installer = Installer(folder / 'bin' / 'python', folder)
        installer.prepare(pins.with_name('installers.txt'))
        installer.install_lists('tools', pins)
        stamp.write_text(pins.read_text())
    return folder / 'bin'


if __name__ == '__main__':
    sys.exit(main())
