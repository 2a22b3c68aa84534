"""The program `bt-orchestrator`: one verb, one file of this folder."""

from __future__ import annotations

import argparse
import atexit
import gc
import io
import os
import sys
import textwrap
from collections.abc import Iterator, Sequence
from typing import Any

from bt_orchestrator.base.diagnosis.ros_environment import (
    keep_to_this_computer,
    name_ros_wheels,
    ros_says,
)
from bt_orchestrator.base.errors import JournalAway, OrchestratorError, Refused
from bt_orchestrator.base.extending import ExtensionMissing
from bt_orchestrator.cli.command_parser import CommandParser
from bt_orchestrator.cli.output import WrongUse, print_mistakes
from bt_orchestrator.cli.verbs import (
    GROUPS,
    PROGRAM,
    VERBS,
    action_of,
    actions_of,
    command_of,
    declare_actions,
    help_line,
    is_verb,
)
from bt_orchestrator.ros.fast_dds import keep_off_shared_memory

_NO_TEXT = (
    'the argument {!r} is not UTF-8, which ROS 2, journals and files of this project have; set '
    'the locale to UTF-8, or rename the file'
)

TAKE_ROS_ARGUMENTS = ('run', 'sim-cell', 'demo', 'page', 'opcua')
"""Verbs that are ROS 2 nodes: --ros-args is for them, up to -- or the end."""

_MORE = f'{PROGRAM} VERB --help says more about a verb, and docs/glossary.md about the words'

INTERRUPTED = 130
PIPE_CLOSED = 141
"""Exit statuses of shells for SIGINT and SIGPIPE."""


# At its end Python would look for garbage among all objects, though the system takes all memory.
atexit.register(gc.freeze)


def main(argv: Sequence[str] | None = None) -> int:
    """Carry out a command line and return the exit status.

    0: done, 1: something is refused or did not work out, 2: wrong use.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    if '_ARGCOMPLETE' in os.environ:
        _complete(os.environ.get('COMP_LINE', ''))
    _open_standard_files()
    _print_anything()
    if (no_text := next(filter(_is_no_text, words), None)) is not None:
        return _complain(None, _NO_TEXT.format(no_text), 2)
    name_ros_wheels(os.environ, sys.prefix)
    keep_off_shared_memory(os.environ)
    keep_to_this_computer(os.environ)
    try:
        status = _carry_out(words)
        sys.stdout.flush()
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        _silence_output()
        return PIPE_CLOSED
    except OSError as error:  # a full disk, a folder that went away
        _silence_output()
        where = f'{error.filename}: ' if error.filename else ''
        return _complain(_verb(words), f'{where}{error.strerror or error}', 1)
    return status


def _carry_out(words: Sequence[str]) -> int:
    verb = _verb(words)
    try:
        args = parsed(words)
        verb = args.verb
        return int(args.carry_out(args))
    except Refused as refused:
        print_mistakes(refused)
        return 1
    except JournalAway as error:
        return _complain(verb, str(error), os.EX_TEMPFAIL)
    except OrchestratorError as error:
        return _complain(
            verb, str(error), 2 if isinstance(error, WrongUse | ExtensionMissing) else 1
        )
    except RuntimeError as error:
        if not type(error).__module__.startswith('rclpy'):
            raise  # a defect
        return _complain(
            verb, f'{ros_says(error, os.environ)}; bt-orchestrator doctor looks at all of it', 1
        )
    except ModuleNotFoundError as error:
        if (error.name or PROGRAM).startswith('bt_orchestrator.'):
            raise  # a defect, nothing that a user can install
        what = f'the Python package {error.name} is not installed'
        return _complain(verb, f'{what}; install it, or source the ROS 2 workspace it is in', 1)


def parsed(words: Sequence[str]) -> argparse.Namespace:
    """Read a command line.

    :raises SystemExit: it is wrong, which has been said, or it only asked for help
    """
    verb = _verb(words)
    own_words = without_ros_arguments(words) if verb in TAKE_ROS_ARGUMENTS else list(words)
    if not words:
        _parser_of_verbs().print_help()
        raise SystemExit(2)
    if is_verb(verb) and own_words[0] == verb:
        command = command_of(own_words)
        if command.typed != command.words:
            old = ' '.join(command.typed)
            print(f'{PROGRAM}: `{old}` is now `{command.name}`', file=sys.stderr)
        # Options may stand anywhere, as in `queue add --held ORDER`.
        args = command.parser().parse_intermixed_args(command.rest)
        args.verb, args.carry_out = command.name, command.action.run
    else:
        args = _parser_of_verbs().parse_args(own_words)
    args.ros_args = words
    return args


def _is_no_text(word: str) -> bool:
    return any('\ud800' <= char <= '\udfff' for char in word)


def _verb(words: Sequence[str]) -> str | None:
    return next((word for word in words if not word.startswith('-')), None)


def without_ros_arguments(words: Sequence[str]) -> list[str]:
    """Return a command line without what stands between --ros-args and --."""
    own: list[str] = []
    is_ros = False
    for word in words:
        if word == '--ros-args':
            is_ros = True
        elif is_ros and word == '--':
            is_ros = False
        elif not is_ros:
            own.append(word)
    return own


def _complete(line: str) -> None:
    """Tell the shell how a command line may go on, and end."""
    import argcomplete

    parser = _parser_of_verbs(with_options_of=_verb(line.split()[1:]), has_help_lines=True)
    argcomplete.autocomplete(parser)


def _parser_of_verbs(
    with_options_of: str | None = None, *, has_help_lines: bool = False
) -> argparse.ArgumentParser:
    """Declare the verbs without their options, for help and for mistakes.

    :param with_options_of: a verb that is declared as a whole; the others would take their time
    :param has_help_lines: shells show them beside the verbs; the help has them in groups instead
    """
    parser = CommandParser(
        prog=PROGRAM,
        description='Behaviour trees of ROS 2 action clients for a cell along a conveyor.',
        epilog='\n'.join((*_groups(), _MORE)),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument('--version', action=_Version, help='print the version and exit')
    verbs = parser.add_subparsers(
        dest='verb', metavar='VERB', required=True, help='one of the verbs below'
    )
    for name in VERBS:
        options: dict[str, Any] = {'help': help_line(name)} if has_help_lines else {}
        verb = verbs.add_parser(name, **options)
        if name == with_options_of and actions_of(name):
            declare_actions(verb, name, with_options=True)
        elif name == with_options_of:
            action_of(name).add_arguments(verb)
    return parser


def _groups() -> Iterator[str]:
    """Yield the verbs by what a person wants to do."""
    width = max(map(len, VERBS)) + 4
    for wanted, group in GROUPS.items():
        yield f'{wanted}:'
        for verb in group:
            begin, rest = f'  {verb}'.ljust(width), ' ' * width
            yield textwrap.fill(help_line(verb), 79, initial_indent=begin, subsequent_indent=rest)
        yield ''


class _Version(argparse.Action):
    """Looks the version up when it is asked for, and not at every start."""

    def __init__(self, option_strings: Sequence[str], dest: str, **options: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, **options)

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib.metadata import PackageNotFoundError, version

        try:
            release = version('bt_orchestrator')
        except PackageNotFoundError:
            release = 'not installed'
        print(f'{PROGRAM} {release}')
        parser.exit()


def _complain(verb: str | None, what: str, status: int) -> int:
    program = PROGRAM if verb is None else f'{PROGRAM} {verb}'
    for line in what.splitlines():
        print(f'{program}: error: {line}', file=sys.stderr)
    return status


def _open_standard_files() -> None:
    """Open nothing as what is closed of input, output and errors (`>&-`).

    Otherwise the next file that is opened takes its number, and gets what libraries print.
    """
    for number, name, mode in ((0, 'stdin', 'r'), (1, 'stdout', 'w'), (2, 'stderr', 'w')):
        if getattr(sys, name) is None:
            nowhere = os.open(os.devnull, os.O_RDWR)
            if nowhere != number:
                os.dup2(nowhere, number)
                os.close(nowhere)
            setattr(sys, name, os.fdopen(number, mode))


def _print_anything() -> None:
    """Escape characters that the output cannot encode, as the standard error does anyway."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors='backslashreplace')


def _silence_output() -> None:
    """Prevent further writes to the closed pipe, also by Python at its exit."""
    try:
        output = sys.stdout.fileno()
    except io.UnsupportedOperation:  # no file: whoever put that there reads it
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, output)
    os.close(nowhere)
