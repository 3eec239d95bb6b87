"""henkei: change the form of surfaces."""

from henkei.combine import CombinedMesh, combine
from henkei.geometry.repair import (
    largest_component,
    oriented,
    weld,
    without_degenerate_faces,
    without_unused_vertices,
)
from henkei.io import read, write
from henkei.mesh import Attributes, Mesh, PolygonMesh
from henkei.morph import write_morph
from henkei.workflows.diagnose import diagnose

__all__ = [
    "Attributes",
    "CombinedMesh",
    "Mesh",
    "PolygonMesh",
    "combine",
    "diagnose",
    "largest_component",
    "oriented",
    "read",
    "weld",
    "without_degenerate_faces",
    "without_unused_vertices",
    "write",
    "write_morph",
]
