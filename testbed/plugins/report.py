"""Reports: from results on disk to something people read."""

from abc import abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from testbed.plugins.base import Plugin


@dataclass(frozen=True)
class Report(Plugin):
    """A report; reads a results directory and writes files beside the results.

    Attributes
    ----------
    on_request
        Whether it is written only where it is asked for.
    """

    on_request: ClassVar[bool] = False

    @abstractmethod
    def write(self, directory: Path) -> tuple[Path, ...]:
        """Read the results in ``directory``, write the report there, and return the files written."""
