"""The plugin manager behind one typed facade."""
import pluggy
from collections.abc import Iterable
hookimpl = pluggy.HookimplMarker("testbed")

def modules_in(package: str) -> Iterable[str]:
    return []
