# SPDX-License-Identifier: Apache-2.0
"""How a command presents itself: a line on what it does, its options, and examples."""

from __future__ import annotations

import argparse

__all__ = ["add_command"]


def add_command(
    commands: argparse._SubParsersAction[argparse.ArgumentParser], name: str, title: str, examples: str
) -> argparse.ArgumentParser:
    """A command's parser: `evcot NAME -h` shows title, options and examples, one command with a remark per line."""
    epilog = "examples:\n" + "\n".join(f"  {line}".rstrip() for line in examples.strip().splitlines())
    return commands.add_parser(
        name, help=title, description=title[:1].upper() + title[1:] + ".", epilog=epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
