"""The peers' refinement, smoothing and factorisation, each in a process of its own, which may run
another Python.

A peer is a function that takes what it works on in its own form and returns one that works, which
alone is timed. Nothing of henkei is imported here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from bench.fresh import installed, timed

Array = NDArray[Any]
Counts = tuple[int, int]
Refiner = Callable[[Array, Array, int], Callable[[], tuple[Array, Array]]]
Smoother = Callable[[dict[str, Array], int], Callable[[], Array]]
Solver = Callable[[Any], Callable[[], Any]]

STEP = 0.33  # p of Taubin's filter
INFLATE = 1 / (0.1 - 1 / STEP)  # q


def libigl_upsample(vertices: Array, faces: Array, levels: int) -> Callable[[], Any]:
    """``igl.upsample``, all levels in one call."""
    import igl

    corners = faces.astype(np.int64)
    return lambda: igl.upsample(vertices, corners, levels)


def trimesh_subdivide(vertices: Array, faces: Array, levels: int) -> Callable[[], Any]:
    """``trimesh.remesh.subdivide``, level by level."""
    import trimesh

    def made() -> tuple[Array, Array]:
        points, corners = vertices, faces
        for _ in range(levels):
            points, corners = trimesh.remesh.subdivide(points, corners)
        return points, corners

    return made


def open3d_midpoint(vertices: Array, faces: Array, levels: int) -> Callable[[], Any]:
    """``subdivide_midpoint``, all levels in one call."""
    mesh = _open3d_mesh(vertices, faces)

    def made() -> tuple[Array, Array]:
        found = mesh.subdivide_midpoint(levels)
        return np.asarray(found.vertices), np.asarray(found.triangles)

    return made


def meshlab_midpoint(vertices: Array, faces: Array, levels: int) -> Callable[[], Any]:
    """``meshing_surface_subdivision_midpoint`` of every edge."""
    import pymeshlab

    def made() -> tuple[Array, Array]:
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
        every = pymeshlab.PercentageValue(0)
        meshes.meshing_surface_subdivision_midpoint(iterations=levels, threshold=every)
        found = meshes.current_mesh()
        return found.vertex_matrix(), found.face_matrix()

    return made


def gpytoolbox_upsample(vertices: Array, faces: Array, levels: int) -> Callable[[], Any]:
    """``gpytoolbox.subdivide`` by ``upsample``."""
    import gpytoolbox

    return lambda: gpytoolbox.subdivide(vertices, faces, method="upsample", iters=levels)


def blender_simple(vertices: Array, faces: Array, levels: int) -> Callable[[], Any]:
    """Blender's subdivision modifier, simple; its coordinates have single precision."""
    import bpy

    bpy.context.scene.render.threads_mode = "FIXED"
    bpy.context.scene.render.threads = 1
    mesh = bpy.data.meshes.new("cage")
    mesh.from_pydata(vertices.tolist(), [], faces.tolist())
    thing = bpy.data.objects.new("cage", mesh)
    bpy.context.collection.objects.link(thing)
    modifier = thing.modifiers.new("subdivision", "SUBSURF")
    modifier.subdivision_type, modifier.levels = "SIMPLE", 0
    bpy.context.evaluated_depsgraph_get().update()

    def made() -> tuple[Array, Array]:
        modifier.levels = 0
        bpy.context.evaluated_depsgraph_get().update()
        modifier.levels = levels
        graph = bpy.context.evaluated_depsgraph_get()
        graph.update()
        found = thing.evaluated_get(graph).data
        points = np.empty((len(found.vertices), 3), dtype=np.float32)
        corners = np.empty(len(found.loops), dtype=np.int32)
        found.vertices.foreach_get("co", points.ravel())
        found.loops.foreach_get("vertex_index", corners)
        return points, corners.reshape(-1, 4)

    return made


REFINERS: dict[str, Refiner] = {
    "libigl": libigl_upsample,
    "trimesh": trimesh_subdivide,
    "Open3D": open3d_midpoint,
    "MeshLab": meshlab_midpoint,
    "gpytoolbox": gpytoolbox_upsample,
}
QUAD_REFINERS: dict[str, Refiner] = {"Blender": blender_simple}


def scipy_means(level: dict[str, Array], steps: int) -> Callable[[], Array]:
    """x + p (W x - x), with W by rows."""
    points, means = level["vertices"], _means(level)

    def filtered() -> Array:
        now = points
        for _ in range(steps):
            now = now + STEP * (means @ now - now)
            now = now + INFLATE * (means @ now - now)
        return now

    return filtered


def scipy_product(level: dict[str, Array], steps: int) -> Callable[[], Array]:
    """The same with 1 + p (W - 1) as one matrix: a product, and nothing else, for each half."""
    points, means = level["vertices"], _means(level)
    one = sparse.eye_array(len(points), format="csr")
    halves = [sparse.csr_array(one + factor * (means - one)) for factor in (STEP, INFLATE)]

    def filtered() -> Array:
        now = points
        for _ in range(steps):
            for half in halves:
                now = half @ now
        return now

    return filtered


def trimesh_taubin(level: dict[str, Array], steps: int) -> Callable[[], Array]:
    """``filter_taubin`` by the mean of neighbours; it counts each half as a step."""
    import trimesh

    def filtered() -> Array:
        mesh = trimesh.Trimesh(level["vertices"], level["faces"], process=False)
        trimesh.smoothing.filter_taubin(mesh, lamb=STEP, nu=-INFLATE, iterations=2 * steps)
        return np.asarray(mesh.vertices)

    return filtered


def open3d_taubin(level: dict[str, Array], steps: int) -> Callable[[], Array]:
    """``filter_smooth_taubin``; it weighs neighbours by their inverse distance."""
    mesh = _open3d_mesh(level["vertices"], level["faces"])
    return lambda: np.asarray(mesh.filter_smooth_taubin(steps, STEP, INFLATE).vertices)


def meshlab_taubin(level: dict[str, Array], steps: int) -> Callable[[], Array]:
    """``apply_coord_taubin_smoothing``."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(level["vertices"], level["faces"]))

    def filtered() -> Array:
        meshes.apply_coord_taubin_smoothing(lambda_=STEP, mu=INFLATE, stepsmoothnum=steps)
        found: Array = meshes.current_mesh().vertex_matrix()
        return found

    return filtered


STEPPERS: dict[str, Smoother] = {
    "SciPy, one product": scipy_product,
    "SciPy, x + p (W x - x)": scipy_means,
}
SMOOTHERS: dict[str, Smoother] = {
    "trimesh": trimesh_taubin,
    "Open3D": open3d_taubin,
    "MeshLab": meshlab_taubin,
}


def cvxopt_cholmod(matrix: Any) -> Callable[[], Any]:
    """CHOLMOD with BLAS, supernodal, in approximate minimum degree."""
    from cvxopt import cholmod, spmatrix

    lower = sparse.tril(matrix).tocoo()
    given = spmatrix(lower.data, lower.row.tolist(), lower.col.tolist(), matrix.shape)
    cholmod.options["supernodal"] = 2

    def factored() -> Any:
        factor = cholmod.symbolic(given)
        cholmod.numeric(given, factor)
        return factor

    return factored


def cholespy_cholmod(matrix: Any) -> Callable[[], Any]:
    """CHOLMOD as the wheel of cholespy has it, without BLAS."""
    import cholespy

    parts = (matrix.indptr, matrix.indices, matrix.data)
    return lambda: cholespy.CholeskySolverD(matrix.shape[0], *parts, cholespy.MatrixType.CSC)


def pardiso(matrix: Any) -> Callable[[], Any]:
    """Intel's PARDISO for positive definite matrices."""
    from pypardiso import PyPardisoSolver

    upper = sparse.csr_matrix(sparse.triu(matrix))

    def factored() -> Any:
        solver = PyPardisoSolver(mtype=2)
        solver.factorize(upper)
        return solver

    return factored


def superlu(matrix: Any) -> Callable[[], Any]:
    """SciPy's ``splu`` in its symmetric mode, minimum degree."""
    from scipy.sparse.linalg import splu

    symmetric = {"SymmetricMode": True}
    return lambda: splu(
        matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=symmetric
    )


SOLVERS: dict[str, Solver] = {
    "CHOLMOD (cvxopt)": cvxopt_cholmod,
    "PARDISO": pardiso,
    "CHOLMOD (cholespy)": cholespy_cholmod,
    "SuperLU (SciPy)": superlu,
}
PACKAGES = {
    "libigl": "libigl",
    "trimesh": "trimesh",
    "Open3D": "open3d",
    "MeshLab": "pymeshlab",
    "gpytoolbox": "gpytoolbox",
    "Blender": "bpy",
    "SciPy": "scipy",
    "cvxopt": "cvxopt",
    "cholespy": "cholespy",
    "PARDISO": "pypardiso",
}


def versions() -> dict[str, str]:
    """Of the peers that are installed for this Python."""
    return installed(PACKAGES)


def refinement(name: str, path: str, levels: int, repeat: int) -> dict[str, Any]:
    """CPU seconds from a cage to the faces and vertices of its last level, and their numbers."""
    arrays = dict(np.load(path))
    refiner = {**REFINERS, **QUAD_REFINERS}[name]
    made = refiner(arrays["vertices"], arrays["faces"], levels)
    cost, (vertices, faces) = timed(made, repeat)
    counts = [len(vertices), len(faces)]
    return {"cpu": cost["cpu"], "memory": cost["memory"], "counts": counts}


def smoothing(name: str, path: str, steps: int, repeat: int) -> dict[str, Any]:
    """CPU seconds of a number of Taubin's steps, and how far off vertices are."""
    level = dict(np.load(path))
    cost, found = timed({**STEPPERS, **SMOOTHERS}[name](level, steps), repeat)
    return {"cpu": cost["cpu"], "difference": float(np.abs(found - level["wanted"]).max())}


def factor(name: str, path: str, repeat: int) -> dict[str, Any]:
    """CPU seconds of one factorisation of a matrix, ordering included."""
    matrix = sparse.csc_matrix(sparse.load_npz(path))
    cost, _ = timed(SOLVERS[name](matrix), repeat)
    return {"cpu": cost["cpu"], "memory": cost["memory"]}


def _means(level: dict[str, Array]) -> Any:
    parts = (level["values"], level["indices"], level["start"])
    return sparse.csr_array(parts, shape=(len(level["vertices"]),) * 2)


def _open3d_mesh(vertices: Array, faces: Array) -> Any:
    import open3d

    points = open3d.utility.Vector3dVector(vertices)
    return open3d.geometry.TriangleMesh(points, open3d.utility.Vector3iVector(faces))
