"""The command line. Nothing here but typer and rich is imported before a command runs, so that help comes at once."""

from testbed.cli.app import main

__all__ = ["main"]
