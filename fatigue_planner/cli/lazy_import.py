"""Commands whose modules are loaded when they are called, so that help, version and mistakes are told at once."""

from collections.abc import Sequence
from importlib import import_module
from typing import Any, ClassVar

import typer
from typer.core import TyperCommand, TyperGroup

from fatigue_planner.cli.options import EXIT_CODES


class LazyCommand(TyperCommand):
    """A command by name, its summary for the list of commands, and where its function or its group is.

    It turns into the real one as soon as there are arguments for it.
    """

    def __init__(self, name: str, summary: str, place: str) -> None:
        super().__init__(name, help=summary)
        self._place = place

    def load(self) -> Any:
        """The real command."""
        module, attribute = self._place.split(":")
        found = getattr(import_module(module), attribute)
        if isinstance(found, typer.Typer):
            app = found
        else:
            app = typer.Typer(add_completion=False)
            app.command()(found)
        command = typer.main.get_command(app)
        command.name, command.epilog = self.name, EXIT_CODES
        return command

    def make_context(self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any) -> Any:
        """The context of the real command."""
        return self.load().make_context(info_name, args, parent, **extra)


class LazyGroup(TyperGroup):
    """A group of such commands, in this order."""

    lazy: ClassVar[Sequence[LazyCommand]] = ()

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes)
        for command in self.lazy:
            self.add_command(command)
