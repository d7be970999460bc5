"""A testbed that compares surface interpolation schemes.

The public names are imported when they are first used, so that ``import testbed`` and the command line start at once.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from testbed.errors import MeshError, PluginError, Refused, SpecError, TestbedError
    from testbed.geometry.mesh import HermiteMesh
    from testbed.geometry.mesh_arrays import save_mesh
    from testbed.geometry.mesh_files import load_mesh
    from testbed.geometry.surface import Surface
    from testbed.registry import boundary_curve, dataset, measure, scheme

__version__ = "0.1.0"

_HOME = {
    "HermiteMesh": "testbed.geometry.mesh",
    "MeshError": "testbed.errors",
    "PluginError": "testbed.errors",
    "Refused": "testbed.errors",
    "SpecError": "testbed.errors",
    "Surface": "testbed.geometry.surface",
    "TestbedError": "testbed.errors",
    "boundary_curve": "testbed.registry",
    "dataset": "testbed.registry",
    "export_surface": "testbed_reports.export.formats",  # above all else, so that nothing here may import it
    "load_mesh": "testbed.geometry.mesh_files",
    "measure": "testbed.registry",
    "save_mesh": "testbed.geometry.mesh_arrays",
    "scheme": "testbed.registry",
}

__all__ = [
    "HermiteMesh",
    "MeshError",
    "PluginError",
    "Refused",
    "SpecError",
    "Surface",
    "TestbedError",
    "boundary_curve",
    "dataset",
    "export_surface",
    "load_mesh",
    "measure",
    "save_mesh",
    "scheme",
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(importlib.import_module(_HOME[name]), name)
    raise AttributeError(f"module 'testbed' has no attribute {name!r}")
