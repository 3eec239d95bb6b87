"""Which peers are installed."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = {"GEOS": "shapely", "CGAL": "cgal", "libigl": "libigl"}
CGAL_CHECKED = (
    "No Python wheel offers CGAL's 2-D arrangements, their overlay, or Nef polygons. Looked "
    "through: `cgal` 6.0.1 (SWIG; 2-D triangulations, meshes, hulls, Voronoi diagrams, polyline "
    "simplification), `compas_cgal` 0.10.0 (3-D Booleans, straight skeletons, triangulations) and "
    "`libigl` 2.6 (`igl.copyleft.cgal`: 3-D Booleans and `remesh_self_intersections`); "
    "`scikit-geometry`, which has arrangements, has no wheel on PyPI. What comes nearest is "
    "`cgal`'s `Constrained_Delaunay_triangulation_2` with all edges of both as constraints: it "
    "splits them where they cross (exact predicates, rounded crossings) and triangulates, but "
    "tells for no vertex or face where it lies on the inputs. It is called once per edge, since "
    "the wheel has no call for many. `remesh_self_intersections` (exact constructions) took "
    "97 CPU-s for 5k + 5k faces, and is not in the table."
)


def installed(peer: str) -> str | None:
    """Name and version of a peer, or None where it is not installed."""
    try:
        found = f"{peer} ({PACKAGES[peer]} {version(PACKAGES[peer])})"
    except PackageNotFoundError:
        return None
    if peer == "GEOS":
        import shapely

        found = f"GEOS {shapely.geos_version_string} (shapely {shapely.__version__})"
    return found


def missing(peer: str) -> str:
    """What the report says of a peer that is not installed."""
    return f"not available ({PACKAGES[peer]} is not installed)"


def machine() -> str:
    """Processor, system and the libraries below henkei, in words."""
    names = ("henkei", "numpy", "scipy", "cholespy")
    libraries = []
    for name in names:
        try:
            libraries.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            libraries.append(f"without {name}")
    python = f"Python {platform.python_version()}"
    return f"{_processor()}, {platform.system()}; {', '.join([python, *libraries])}; one thread"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
