"""The peers' ways to deform, each in a process of its own, which may run another Python.

A peer is a function of vertices, faces and the vertices that are held and moved; what it prepares
it keeps in the function that it returns, which makes positions of positions of the handle. Nothing
of henkei is imported here.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.fresh import installed, peak_memory, timed

Array = NDArray[Any]
Frame = Callable[[Array], Array]
Peer = Callable[[Array, Array, Array, Array], Frame]


def libigl_arap(
    vertices: Array, faces: Array, fixed: Array, handle: Array, *, iterations: int = 1
) -> Frame:
    """As-rigid-as-possible (Sorkine and Alexa 2007) with libigl's default energy, spokes and rims,
    which is its fastest; a frame goes on from the one before."""
    import igl

    data = igl.ARAPData()
    data.max_iter = iterations
    data.energy = igl.ARAP_ENERGY_TYPE_SPOKES_AND_RIMS
    held = np.concatenate([fixed, handle])
    igl.arap_precomputation(vertices, faces.astype(np.int64), 3, held.astype(np.int32), data)
    positions = [vertices]

    def frame(target: Array) -> Array:
        wanted = np.concatenate([vertices[fixed], target])
        positions[0] = igl.arap_solve(wanted, data, positions[0])
        return positions[0]

    return frame


def libigl_biharmonic(vertices: Array, faces: Array, fixed: Array, handle: Array) -> Frame:
    """Displacements that minimise the squared Laplacian (Botsch and Kobbelt 2004)."""
    import igl
    import scipy.sparse as sparse

    matrix = libigl_bilaplacian(vertices, faces)
    held, data = np.concatenate([fixed, handle]), igl.min_quad_with_fixed_data()
    none = sparse.csc_matrix((0, len(vertices)))
    igl.min_quad_with_fixed_precompute(matrix, held.astype(np.int64), none, True, data)
    zero, no_rows = np.zeros_like(vertices), np.zeros((0, 3))

    def frame(target: Array) -> Array:
        wanted = np.concatenate([np.zeros((len(fixed), 3)), target - vertices[handle]])
        moved: Array = vertices + igl.min_quad_with_fixed_solve(data, zero, wanted, no_rows)
        return moved

    return frame


def libigl_bilaplacian(vertices: Array, faces: Array) -> Any:
    """L M^-1 L of the cotangent Laplacian and the Voronoi areas."""
    import igl
    import scipy.sparse as sparse

    laplacian = igl.cotmatrix(vertices, faces.astype(np.int64))
    areas = igl.massmatrix(vertices, faces.astype(np.int64), igl.MASSMATRIX_TYPE_VORONOI)
    return (laplacian @ sparse.diags(1 / areas.diagonal()) @ laplacian).tocsc()


def open3d_arap(
    vertices: Array, faces: Array, fixed: Array, handle: Array, *, iterations: int = 1
) -> Frame:
    """As-rigid-as-possible in Open3D, which keeps no factorisation from call to call."""
    import open3d

    mesh = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(vertices), open3d.utility.Vector3iVector(faces)
    )
    held = open3d.utility.IntVector(np.concatenate([fixed, handle]).tolist())

    def frame(target: Array) -> Array:
        wanted = open3d.utility.Vector3dVector(np.concatenate([vertices[fixed], target]))
        moved = mesh.deform_as_rigid_as_possible(held, wanted, iterations)
        return np.asarray(moved.vertices).copy()

    return frame


def blender_laplacian(vertices: Array, faces: Array, fixed: Array, handle: Array) -> Frame:
    """Blender's Laplacian deform modifier, bound; its coordinates have single precision."""
    import bpy

    bpy.context.scene.render.threads_mode = "FIXED"
    bpy.context.scene.render.threads = 1
    mesh = bpy.data.meshes.new("surface")
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", vertices.astype(np.float32).ravel())
    mesh.loops.add(faces.size)
    mesh.loops.foreach_set("vertex_index", faces.astype(np.int32).ravel())
    mesh.polygons.add(len(faces))
    mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    thing = bpy.data.objects.new("surface", mesh)
    bpy.context.collection.objects.link(thing)
    group = thing.vertex_groups.new(name="held")
    group.add(np.concatenate([fixed, handle]).tolist(), 1.0, "REPLACE")
    modifier = thing.modifiers.new("deform", "LAPLACIANDEFORM")
    modifier.vertex_group = "held"
    bpy.context.view_layer.objects.active = thing
    bpy.ops.object.laplaciandeform_bind(modifier="deform")
    if not modifier.is_bind:
        raise RuntimeError("the modifier did not bind")
    moved = vertices.astype(np.float32)

    def frame(target: Array) -> Array:
        moved[handle] = target
        mesh.vertices.foreach_set("co", moved.ravel())
        mesh.update()
        graph = bpy.context.evaluated_depsgraph_get()
        graph.update()
        found = np.empty(vertices.size, dtype=np.float32)
        thing.evaluated_get(graph).data.vertices.foreach_get("co", found)
        return found.reshape(-1, 3).astype(np.float64)

    return frame


FAST: dict[str, Peer] = {
    "libigl biharmonic": libigl_biharmonic,
    "libigl ARAP": libigl_arap,
    "Open3D ARAP": open3d_arap,
    "Blender Laplacian": blender_laplacian,
}
CONVERGED = 50  # iterations
THOROUGH: dict[str, Peer] = {
    f"libigl ARAP, {CONVERGED} iterations": partial(libigl_arap, iterations=CONVERGED),
    f"Open3D ARAP, {CONVERGED} iterations": partial(open3d_arap, iterations=CONVERGED),
}
PACKAGES = {"libigl": "libigl", "Open3D": "open3d", "Blender": "bpy"}


def versions() -> dict[str, str]:
    """Of the peers that are installed for this Python."""
    return installed(PACKAGES)


def speed(name: str, path: str, repeat: int, frames: int) -> dict[str, Any]:
    """CPU seconds of a peer's preparation and of a frame, and its peak memory in MB."""
    arrays = dict(np.load(path))
    parts = [arrays[part] for part in ("vertices", "faces", "fixed", "handle")]
    prepared, frame = timed(lambda: FAST[name](*parts), repeat)
    costs = {"prepare": prepared["cpu"], "frame": _frame(frame, parts[0][parts[3]], frames)}
    if name == "libigl biharmonic":
        assembly, _ = timed(lambda: libigl_bilaplacian(*parts[:2]), repeat)
        costs["factor"] = costs["prepare"] - assembly["cpu"]
    return {**costs, "memory": peak_memory()}


def _frame(frame: Frame, rest: Array, frames: int) -> float:
    heights = iter(np.linspace(1, 20, frames))
    cost, _ = timed(lambda: frame(rest + np.array([0, 0, next(heights)])), frames)
    return float(cost["cpu"])


def shapes(name: str, path: str, output: str) -> dict[str, Any]:
    """Write the positions (k, n, 3) a peer gives for each of the poses in ``targets``.

    After the first, a new turn begins at each pose that is at rest, and the peer begins anew.
    """
    arrays = dict(np.load(path))
    parts = [arrays[part] for part in ("vertices", "faces", "fixed", "handle")]
    peer, found = {**FAST, **THOROUGH}[name], []
    for i, (target, angle) in enumerate(zip(arrays["targets"], arrays["angles"], strict=True)):
        if i == 0 or angle == 0:
            frame = peer(*parts)
        found.append(frame(target))
    np.savez(output, positions=np.array(found))
    return {}
