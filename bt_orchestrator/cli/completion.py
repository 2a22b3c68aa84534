"""The verb `completion`: what a shell needs to complete command lines of this program."""

from __future__ import annotations

import argparse
import sys

from bt_orchestrator.view.screen.advice import PROGRAM

SHELLS = ('bash', 'zsh', 'fish')

DESCRIPTION = """\
Print what makes a shell complete verbs, options and their values. For this shell only:

  bash, zsh   source <(bt-orchestrator completion bash)
  fish        bt-orchestrator completion fish | source

For every one to come, put that line into ~/.bashrc, ~/.zshrc or ~/.config/fish/config.fish."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument('shell', choices=SHELLS, help='which shell')


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    from argcomplete.shell_integration import shellcode

    # zsh runs what is made for bash, and asks for nothing else.
    kind = 'bash' if args.shell == 'zsh' else args.shell
    sys.stdout.write(shellcode([PROGRAM], shell=kind))
    return 0
