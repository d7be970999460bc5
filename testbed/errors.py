"""What can go wrong, as one sentence each: what, where, and what to do."""


class TestbedError(Exception):
    """An error whose message is meant for the user; the command line prints it without a traceback."""

    __test__ = False  # not a test class, whatever pytest thinks of the name


class MeshError(TestbedError, ValueError):
    """A mesh that cannot be a surface's data; the message names the face or vertex."""


class SpecError(TestbedError, ValueError):
    """A ``name[field=value]`` that names nothing registered, or a parameter that is not one."""


class PluginError(TestbedError):
    """A plugin that breaks the rules: a misspelt hook, a duplicate name, a missing declaration."""


class Refused(TestbedError):
    """A scheme's answer to data it cannot take; a result like any other, never a wrong surface.

    Parameters
    ----------
    reason
        One sentence: what is wrong with the data, and at which face, edge or vertex.
    """

    def __init__(self, reason: str) -> None:
        super().__init__(reason)
        self.reason = reason
