"""henkei: change the form of surfaces."""

from henkei.mesh import Attributes, Mesh, PolygonMesh

__all__ = ["Attributes", "Mesh", "PolygonMesh"]
