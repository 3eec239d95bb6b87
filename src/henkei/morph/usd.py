"""Morphs as OpenUSD: a mesh with two variants, time samples and a blend shape.

Formats: https://openusd.org/release/api/usd_skel_page_front.html (UsdGeomMesh, UsdSkelBlendShape).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

from henkei.errors import InvalidInput
from henkei.mesh import Floats
from henkei.morph.film import Film, centre_of

FRAMES_PER_SECOND = 24.0
SAMPLES, BLEND_SHAPE = "timeSamples", "blendShape"


def export(path: str, film: Film) -> None:
    """Write a .usda, .usdc or .usd file (text, binary, binary).

    ``/morph`` is a SkelRoot with the variant set ``morph``. Variant ``timeSamples``, which is
    selected, holds points over time; variant ``blendShape`` holds one blend shape, with in-betweens
    where the path is not straight, and the animation of its weight. Points count from the prim's
    translation where the coordinates are far from the origin. Frames are 1/24 s.

    Raises
    ------
    InvalidInput : the file cannot be written.
    """
    stations, shapes = film.key_shapes()
    centre = centre_of([film.correspondence.vertices_a, *shapes])
    stage = Usd.Stage.CreateInMemory()
    root = UsdSkel.Root.Define(stage, "/morph")
    stage.SetDefaultPrim(root.GetPrim())
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    if centre.any():
        UsdGeom.XformCommonAPI(root).SetTranslate(Gf.Vec3d(*centre.tolist()))
    mesh = _mesh(stage, film)
    seconds, station = film.key_times()
    codes = seconds * FRAMES_PER_SECOND
    stage.SetTimeCodesPerSecond(FRAMES_PER_SECOND)
    stage.SetFramesPerSecond(FRAMES_PER_SECOND)
    stage.SetStartTimeCode(0.0)
    stage.SetEndTimeCode(float(codes[-1]))
    ways = root.GetPrim().GetVariantSets().AddVariantSet("morph")
    for name in (BLEND_SHAPE, SAMPLES):
        ways.AddVariant(name)
        ways.SetVariantSelection(name)
        with ways.GetVariantEditContext():
            # Opinions outside the variants would be stronger, so the points must be in here.
            _set_points(mesh, film.correspondence.vertices_a - centre)
            if name == SAMPLES:
                _add_samples(mesh, film, centre)
            else:
                offsets = [_float3(shape - film.correspondence.vertices_a) for shape in shapes]
                _add_blend_shape(stage, mesh, offsets, stations)
                _add_weights(stage, codes, station)
    if not stage.GetRootLayer().Export(path):
        raise InvalidInput(f"USD could not write {path}")


def _mesh(stage: Any, film: Film) -> Any:
    faces = film.correspondence.faces
    mesh = UsdGeom.Mesh.Define(stage, "/morph/mesh")
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(faces), 3, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(faces.ravel().astype(np.int32)))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(True)
    primvars = UsdGeom.PrimvarsAPI(mesh)
    if film.texture is not None:
        st = Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(film.texture, np.float32))
        kind = Sdf.ValueTypeNames.TexCoord2fArray
        primvars.CreatePrimvar("st", kind, UsdGeom.Tokens.faceVarying).Set(st)
    if film.color is not None:
        color = mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.faceVarying)
        color.Set(_float3(film.color[:, :3]))
    return mesh


def _add_samples(mesh: Any, film: Film, centre: Floats) -> None:
    last = film.frames - 1
    shown = film.meshes()
    if film.is_straight and film.time == "linear":
        last = 1
        shown = iter([film.correspondence.mesh_a, film.correspondence.mesh_b])
    for k, shape in enumerate(shown):
        for place in {k, 2 * last - k} if film.ping_pong else {k}:
            code = place / last * film.seconds * FRAMES_PER_SECOND
            _set_points(mesh, shape.vertices - centre, Usd.TimeCode(code))


def _add_blend_shape(stage: Any, mesh: Any, offsets: Sequence[Any], stations: Floats) -> None:
    shape = UsdSkel.BlendShape.Define(stage, "/morph/mesh/b")
    shape.CreateOffsetsAttr(offsets[-1])
    for station, between in zip(stations[:-1].tolist(), offsets[:-1], strict=True):
        step = shape.CreateInbetween(f"at_{station:.0%}".rstrip("%"))
        step.SetWeight(station)
        step.SetOffsets(between)
    skeleton = UsdSkel.Skeleton.Define(stage, "/morph/skeleton")
    identity = Vt.Matrix4dArray([Gf.Matrix4d(1.0)])
    skeleton.CreateJointsAttr(["root"])
    skeleton.CreateBindTransformsAttr(identity)
    skeleton.CreateRestTransformsAttr(identity)
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateBlendShapesAttr(["b"])
    binding.CreateBlendShapeTargetsRel().SetTargets([shape.GetPath()])
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    to_animation = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    to_animation.CreateAnimationSourceRel().SetTargets(["/morph/skeleton/animation"])


def _add_weights(stage: Any, codes: Floats, station: Floats) -> None:
    animation = UsdSkel.Animation.Define(stage, "/morph/skeleton/animation")
    animation.CreateBlendShapesAttr(["b"])
    weights = animation.CreateBlendShapeWeightsAttr()
    for code, weight in zip(codes.tolist(), station.tolist(), strict=True):
        weights.Set([weight], code)


def _set_points(mesh: Any, vertices: Floats, code: Any = None) -> None:
    at = Usd.TimeCode.Default() if code is None else code
    points = _float3(vertices)
    mesh.CreatePointsAttr().Set(points, at)
    mesh.CreateExtentAttr().Set(UsdGeom.PointBased.ComputeExtent(points), at)


def _float3(rows: NDArray[Any]) -> Any:
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(rows, np.float32))
