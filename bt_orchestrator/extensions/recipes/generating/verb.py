"""The verb `generate`: the script of a recipe for a cell, or why there is none."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.base.extending import RECIPES
from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.check import as_json, warn
from bt_orchestrator.cli.door import ask_and_print
from bt_orchestrator.cli.here import add_cell_option
from bt_orchestrator.cli.node_options import add_node_options, add_who_options
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.extensions.recipes.generating import explanation
from bt_orchestrator.extensions.recipes.generating.file import fault_of, replace_file, standing
from bt_orchestrator.extensions.recipes.generating.inputs import Inputs, read_inputs
from bt_orchestrator.extensions.recipes.generating.making import (
    Made,
    judge_of,
    make,
    moved,
    outage_lines,
    outages,
    plain_outages,
    plan,
    prices_of,
)
from bt_orchestrator.extensions.recipes.planning.outcome import NotMade
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.script import Script
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.checks.warnings import of_recipe, timeless
from bt_orchestrator.script.report import did_you_mean, listing
from bt_orchestrator.script.script_file import read_script

DESCRIPTION = """\
Generate the script of a recipe for a cell. It decides which component does each operation, in
which section, which tasks run side by side, and which wait for which. The script is an ordinary
one, complete, with a comment at every task that says why it is there. Before it is shown, it is
read again, proven not to get stuck, and run in virtual time. The same files give the same script,
byte for byte.

Without -o the script is printed."""

EPILOG = """\
Put your own decisions into overrides, which survive: `bind` an operation to a component, `set`
the keys of its task, `order` operations. A file that was edited by hand is not replaced.

exit status: 0 fine, 1 there is no script, or --check or --diff found a difference, 2 wrong use"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument('recipe', type=Path, metavar='RECIPE', help='recipe (YAML)')
    add_cell_option(parser)
    parser.add_argument(
        '--overrides', type=Path, metavar='FILE', help='what an engineer decided (YAML)'
    )
    _add_file_options(parser)
    parser.add_argument(
        '--keep',
        type=Path,
        metavar='OLD',
        help='do as little as possible elsewhere than this script does; -o and --explain say what '
        'that costs',
    )
    parser.add_argument(
        '--without',
        action='append',
        default=[],
        metavar='COMPONENT',
        help='as if this component were out of service; may be repeated',
    )
    parser.add_argument(
        '--explain',
        action='store_true',
        help='say where each operation is done, why, and what each other component would cost; '
        'without -o in place of the script',
    )
    parser.add_argument('--json', action='store_true', help='all that is known as one JSON object')
    add_release_options(parser)


def _add_file_options(parser: argparse.ArgumentParser) -> None:
    what = parser.add_mutually_exclusive_group()
    what.add_argument('-o', '--output', type=Path, metavar='FILE', help='write the script there')
    what.add_argument(
        '--check', type=Path, metavar='FILE', help='say whether this file is what would be written'
    )
    what.add_argument(
        '--diff', type=Path, metavar='FILE', help='print what would change in this file'
    )
    what.add_argument(
        '--without-each',
        action='store_true',
        help='what comes of it when each component in turn is out of service',
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    RECIPES.demand()
    return generate(args, bootstrap.installed_types())


def generate(args: argparse.Namespace, types: ActionTypes) -> int:
    """Generate what the options name, with the types that are known.

    :raises Refused: there are mistakes in a file, and they are not wanted as JSON
    :raises WrongUse: an option names a component that is not there, or lacks another one
    :raises NotReplaced: a file is left alone
    :raises NotVouchedFor: the script that was generated is not fit to be shown
    """
    check_release_options(args)
    try:
        inputs = read_inputs(args.recipe, args.cell, args.overrides, types)
        warn(timeless(args.cell, inputs.cell, of_recipe(inputs.recipe, inputs.cell)))
        keep = None if args.keep is None else read_script(args.keep, inputs.cell, types)
        without = _out_of_service(args.without, inputs)
        if args.without_each:
            return _without_each(args, inputs, without, keep)
        return _one(args, inputs, without, keep)
    except Refused as refused:
        if not args.json:
            raise
        print(json.dumps(as_json(refused.findings)))
    except NotMade as fault:
        if args.json:
            print(json.dumps(explanation.plain_reasons(fault)))
        for reason in () if args.json else fault.reasons:
            print(f'{args.recipe}: {reason}', file=sys.stderr)
    return 1


def _out_of_service(names: Sequence[str], inputs: Inputs) -> frozenset[str]:
    known = inputs.cell.components
    for name in names:
        if name not in known:
            hint = did_you_mean(name, known, f'it has {listing(known)}')
            raise WrongUse(
                f'--without: the cell {inputs.cell.name} has no component {name}; {hint}'
            )
    return frozenset(names)


def _one(
    args: argparse.Namespace, inputs: Inputs, without: frozenset[str], keep: Script | None
) -> int:
    made = make(inputs, without, keep)
    status = _shown(args, inputs, made, without, keep)
    return release(args, made, inputs) if args.release and not status else status


def _shown(
    args: argparse.Namespace,
    inputs: Inputs,
    made: Made,
    without: frozenset[str],
    keep: Script | None,
) -> int:
    if args.check is not None:
        return _check(args, made)
    if args.diff is not None:
        lines = standing(args.diff).diff(made)
        print('\n'.join(lines), end='\n' if lines else '')
        return int(bool(lines))
    if args.output is not None:
        replace_file(args.output, made)
    if args.output is None and not args.explain and not args.json:
        print(made.text, end='')
        return 0
    kept = _kept(args, inputs, made, keep, without)
    asked = args.explain and keep is None
    prices = prices_of(made, inputs, without) if asked else {}
    if args.json:
        file = None if args.output is None else str(args.output)
        print(json.dumps(explanation.plain(made, inputs, kept, file, prices)))
    else:
        _tell(args, inputs, made, kept, prices)
    return 0


def _tell(
    args: argparse.Namespace,
    inputs: Inputs,
    made: Made,
    kept: explanation.Kept | None,
    prices: explanation.Prices,
) -> None:
    if args.output is not None:
        print(f'{args.output} written')
    print('\n'.join(explanation.summary_lines(made, inputs, kept)))
    if args.explain:
        print('\n'.join(explanation.explanation(made, prices)))


def _check(args: argparse.Namespace, made: Made) -> int:
    fault = fault_of(standing(args.check), made)
    if args.json:
        print(json.dumps({'ok': fault is None, 'file': str(args.check), 'message': fault or ''}))
    elif fault is None:
        print(f'{args.check} is what {args.recipe} gives')
    else:
        print(fault, file=sys.stderr)
    return int(fault is not None)


def _kept(
    args: argparse.Namespace,
    inputs: Inputs,
    made: Made,
    old: Script | None,
    without: frozenset[str],
) -> explanation.Kept | None:
    if old is None:
        return None
    freely = plan(inputs, without, None, judge_of(inputs))
    here = moved(old, made.generated)
    return explanation.Kept(str(args.keep), here, freely, moved(old, freely))


def _without_each(
    args: argparse.Namespace, inputs: Inputs, without: frozenset[str], keep: Script | None
) -> int:
    whole = plan(inputs, without, keep, judge_of(inputs))
    all_outages = list(outages(inputs, whole, without, keep))
    if args.json:
        print(json.dumps(plain_outages(whole, all_outages)))
    else:
        print('\n'.join(outage_lines(whole, all_outages)))
    return 0


# The option `--release`: a running node may use the script that comes of it.


def add_release_options(parser: argparse.ArgumentParser) -> None:
    """Declare the option, and who asks which node."""
    parser.add_argument(
        '--release',
        action='store_true',
        help='then ask the running node to let its jobs start (engineer); with -o or --check, '
        'and --reason',
    )
    add_who_options(parser, required=False)
    add_node_options(parser)


def check_release_options(args: argparse.Namespace) -> None:
    """Refuse a release of what stands in no file, or for no reason.

    :raises WrongUse: says what is missing
    """
    if not args.release:
        return
    if (args.output is None and args.check is None) or args.json:
        raise WrongUse('--release goes with -o FILE or --check FILE, and without --json')
    if not args.reason:
        raise WrongUse('--release needs --reason: why, for the record')


def release(args: argparse.Namespace, made: Made, inputs: Inputs) -> int:
    """Ask the node; returns 1 if it refuses."""
    script, cell = digest(made.generated.script), digest(inputs.cell)
    return ask_and_print(args, 'script.release_script', script=script, cell_digest=cell)
