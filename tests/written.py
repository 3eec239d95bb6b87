"""Surfaces to write, and how a file of theirs is made and read back in memory."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
from hypothesis import strategies as st

from henkei.io.files import BY_SUFFIX
from henkei.mesh import Attributes, Mesh, PolygonMesh, Surface, simplest

EXACT = ["obj", "ply", "ply:text", "off", "vtk", "vtp", "stl:text"]
ROUNDED = ["stl", "glb", "gltf"]
POLYGONS = ["obj", "ply", "ply:text", "off", "vtk", "vtp"]

finite = st.floats(allow_nan=False, allow_infinity=False)
float32 = st.floats(allow_nan=False, allow_infinity=False, width=32)


def encoded(kind: str, surface: Surface) -> bytes:
    """The bytes of a file; ``kind`` is an extension, with ``:text`` for the ascii form."""
    suffix, _, form = kind.partition(":")
    path = Path(f"surface.{suffix}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        blocks = BY_SUFFIX[path.suffix].encode(path, surface, form == "text")
        return b"".join(blocks)


def decoded(kind: str, data: bytes) -> Surface:
    path = Path(f"surface.{kind.partition(':')[0]}")
    return BY_SUFFIX[path.suffix].decode(path, data)


def again(kind: str, surface: Surface) -> Surface:
    return decoded(kind, encoded(kind, surface))


@st.composite
def surfaces(draw, coordinates=finite, largest=6, attributes=False) -> Surface:
    """Any surface that a file can hold: also with repeated, flipped and degenerate faces."""
    count = draw(st.integers(1, 8))
    vertices = draw(
        st.lists(st.tuples(*[coordinates] * 3), min_size=count, max_size=count).map(np.array)
    )
    face = st.lists(st.integers(0, count - 1), min_size=3, max_size=largest)
    faces = draw(st.lists(face, min_size=1, max_size=6))
    surface = PolygonMesh.from_faces(vertices, faces)
    if attributes:
        surface = PolygonMesh(
            surface.vertices, surface.faces, attributes=_attributes(draw, surface)
        )
    return simplest(surface)


def _attributes(draw, surface: PolygonMesh) -> Attributes:
    rng = np.random.default_rng(draw(st.integers(0, 1000)))
    vertices, corners, faces = len(surface.vertices), len(surface.indices), surface.face_count
    return Attributes(
        vertex={
            "normal": rng.standard_normal((vertices, 3)),
            "color": rng.integers(0, 256, (vertices, draw(st.integers(3, 4)))) / 255,
            "label": rng.integers(-9, 9, vertices).astype(np.int32),
            "height": rng.standard_normal(vertices),
        },
        corner={"uv": rng.integers(0, 4, (corners, 2)) / 7},
        face={"material": rng.integers(0, 3, faces).astype(np.int32)},
    )


def same_shape(a: Surface, b: Surface) -> bool:
    """Equal vertices (-0.0 and 0.0 are one) and equal faces."""
    return (
        np.array_equal(a.vertices, b.vertices)
        and np.array_equal(a.indices, b.indices)
        and np.array_equal(a.offsets, b.offsets)
        and type(a) is type(b)
    )


def ordered_for_stl(surface: Surface) -> bool:
    """Whether welding equal corners by first appearance gives these very vertices."""
    first = list(dict.fromkeys(surface.indices.tolist()))
    return first == list(range(len(surface.vertices))) and len(
        np.unique(surface.vertices + 0.0, axis=0)
    ) == len(surface.vertices)


def sheet() -> Mesh:
    """Nine vertices, eight triangles, float32 coordinates, in order of first appearance."""
    x, y = np.meshgrid(np.arange(3.0), np.arange(3.0))
    vertices = np.stack([x, y, 0.25 * x * y], axis=-1).reshape(-1, 3)
    squares = np.array([[i, i + 1, i + 4, i + 3] for i in (0, 1, 3, 4)])
    faces = np.concatenate([squares[:, [0, 1, 2]], squares[:, [0, 2, 3]]])
    used = np.array(list(dict.fromkeys(faces.ravel().tolist())))
    return Mesh(vertices[used], np.argsort(used)[faces])


def patchwork() -> PolygonMesh:
    """A triangle, a quad and a pentagon with every kind of attribute."""
    rng = np.random.default_rng(1)
    return PolygonMesh.from_faces(
        rng.standard_normal((7, 3)).astype(np.float32),
        [[0, 1, 2], [2, 1, 3, 4], [2, 4, 5, 6, 0]],
        Attributes(
            vertex={"color": rng.integers(0, 256, (7, 3)) / 255, "label": np.arange(7)},
            corner={"uv": rng.random((12, 2)).astype(np.float32)},
            face={"material": np.array([1, 0, 1])},
        ),
    )
