"""Break one rule after the other, and see whether the tests of that rule notice.

`3_5_belt_waits_for_all_turns.patch` is applied to a copy of the package; the tests of TESTS whose
names begin with `test_3_5_` have to fail with it. A patch that they do not notice, or that does
not apply any more, is a finding.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
PACKAGE = 'bt_orchestrator'
TESTS = (
    'test/unit/rules',
    'test/unit/engine/runtime',
    'test/unit/extensions/postgres',
    'test/unit/extensions/recipes/planning',
    'test/unit/ros/services',
    'test/unit/sim',
    'test/unit/view/report/account',
)

TESTS_FAILED = 1
"""Exit code of pytest; every other one but 0 is a mistake of the caller."""


def main(arguments: list[str] | None = None) -> int:
    """Run all patches, or those of some rules; 1 if any is not noticed."""
    parser = argparse.ArgumentParser(prog='mutate', description=__doc__.splitlines()[0])
    parser.add_argument('rules', nargs='*', metavar='RULE', help='for example 3.5; default: all')
    rules = parser.parse_args(arguments).rules
    chosen = [patch for patch in patches() if not rules or rule_of(patch) in rules]
    survived = 0
    for patch in chosen:
        verdict = verdict_of(patch)
        survived += verdict != 'killed'
        sys.stdout.write(f'{rule_of(patch):5} {patch.stem:52} {verdict}\n')
        sys.stdout.flush()
    sys.stdout.write(f'{len(chosen)} mutations, {survived} not noticed\n')
    return 1 if survived or not chosen else 0


def patches() -> list[Path]:
    """Return every patch, in the order of the rules."""
    return sorted(HERE.glob('*.patch'))


def rule_of(patch: Path) -> str:
    """Return the rule that a patch breaks, as it is numbered in the semantics: 3.5."""
    return '.'.join(patch.stem.split('_')[:2])


def verdict_of(patch: Path) -> str:
    """Say `killed`, or what is wrong."""
    with tempfile.TemporaryDirectory(prefix='mutate-') as folder:
        copy = Path(folder)
        copy_package(copy)
        if not applies(patch, copy):
            return 'does not apply'
        code = _run_tests(rule_of(patch), copy)
    if code == 0:
        return 'survived'
    return 'killed' if code == TESTS_FAILED else f'no verdict: pytest ended with {code}'


def copy_package(to: Path) -> None:
    """Copy the package, without what Python compiled."""
    ignored = shutil.ignore_patterns('__pycache__')
    shutil.copytree(ROOT / PACKAGE, to / PACKAGE, ignore=ignored)


def applies(patch: Path, copy: Path, *, check: bool = False) -> bool:
    """Apply a patch to a copy of the package and tell whether it fitted.

    :param check: only look
    """
    command = ['git', 'apply', *(['--check'] if check else []), str(patch)]
    # Outside of any repository, wherever the temporary folder is.
    environment = {**os.environ, 'GIT_CEILING_DIRECTORIES': str(copy.parent)}
    run = subprocess.run(command, cwd=copy, env=environment, capture_output=True, check=False)
    return run.returncode == 0


def _run_tests(rule: str, copy: Path) -> int:
    command = [sys.executable, '-m', 'pytest', '-x', '-q', '-p', 'no:cacheprovider']
    command += ['-c', str(ROOT / 'pyproject.toml'), '--rootdir', str(ROOT)]
    command += ['-k', f'test_{rule.replace(".", "_")}_', *(str(ROOT / part) for part in TESTS)]
    path = os.pathsep.join(map(str, (copy, ROOT / 'test')))
    environment = {**os.environ, 'PYTHONPATH': path, 'PYTHONDONTWRITEBYTECODE': '1'}
    # In the folder of the copy: `-m` puts the working directory in front of every other path.
    run = subprocess.run(command, cwd=copy, env=environment, capture_output=True, check=False)
    return run.returncode


if __name__ == '__main__':
    sys.exit(main())
