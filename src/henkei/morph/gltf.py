"""Morphs as glTF 2.0: one mesh with morph targets, and an animation of their weights."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.io._glb import ARRAY_BUFFER, TRIANGLES, Builder
from henkei.io.unique import first_appearances
from henkei.mesh import Floats
from henkei.morph.film import Film, centre_of, unit_normals
from henkei.topology import Ints


@dataclass(frozen=True, eq=False)
class Targets:
    """A mesh with morph targets, and how their weights run over time.

    name : of the mesh, its node and the animation.
    faces : (m, 3).
    base : (n, 3) positions at weights 0.
    shapes : positions (n, 3) at weight 1 of each target alone.
    names : of the targets.
    seconds : (s,) of the key frames, from 0.
    weights : (s, number of targets) at each; linear in between.
    texture, color : (3 m, ...) of the corners, see :class:`henkei.morph.film.Film`.
    """

    name: str
    faces: Ints
    base: Floats
    shapes: Sequence[Floats]
    names: Sequence[str]
    seconds: Floats
    weights: Floats
    texture: NDArray[Any] | None
    color: NDArray[Any] | None


def encode(film: Film, text: bool) -> bytes:
    """The bytes of a .gltf (``text``) or .glb file.

    The base is a; targets hold differences of positions and normals to it. Between two targets the
    weights cross-fade, so the surface runs through all of them. Positions count from the node's
    translation where the coordinates are far from the origin.
    """
    stations, shapes = film.key_shapes()
    seconds, weights = _cross_fade(film, len(stations))
    targets = Targets(
        "morph",
        film.correspondence.faces,
        film.correspondence.vertices_a,
        shapes,
        [f"{station:.0%}" for station in stations[:-1]] + ["b"],
        seconds,
        weights,
        film.texture,
        film.color,
    )
    return encode_targets(targets, text)


def encode_targets(targets: Targets, text: bool) -> bytes:
    """The bytes of a .gltf (``text``) or .glb file with these targets."""
    document = Builder()
    centre = centre_of([targets.base, *targets.shapes])
    document.content |= {
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [_node(targets.name, centre)],
        "meshes": [
            {
                "name": targets.name,
                "primitives": [_primitive(document, targets, centre)],
                "weights": [0] * len(targets.shapes),
                "extras": {"targetNames": list(targets.names)},
            }
        ],
        "materials": [
            {
                "doubleSided": True,
                "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.7},
            }
        ],
        "animations": [_animation(document, targets)],
    }
    return document.gltf() if text else document.glb()


def _node(name: str, centre: Floats) -> dict[str, Any]:
    node: dict[str, Any] = {"name": name, "mesh": 0}
    if centre.any():
        node["translation"] = centre.tolist()
    return node


def _primitive(document: Builder, given: Targets, centre: Floats) -> dict[str, Any]:
    faces, vertex, corner = _split(given)
    base = (given.base - centre).astype(np.float32)
    normals = unit_normals(given.base, given.faces)
    attributes = {
        "POSITION": document.add(base[vertex], ARRAY_BUFFER, bounds=True),
        "NORMAL": document.add(normals[vertex].astype(np.float32), ARRAY_BUFFER),
    }
    if given.texture is not None:
        flipped = given.texture[corner] * [1, -1] + [0, 1]
        attributes["TEXCOORD_0"] = document.add(flipped.astype(np.float32), ARRAY_BUFFER)
    if given.color is not None:
        attributes["COLOR_0"] = document.add(given.color[corner].astype(np.float32), ARRAY_BUFFER)
    targets = []
    for shape in given.shapes:
        moved = (shape - centre - base).astype(np.float32)
        turned = unit_normals(shape, given.faces) - normals
        targets.append(
            {
                "POSITION": document.add(moved[vertex], ARRAY_BUFFER, bounds=True),
                "NORMAL": document.add(turned[vertex].astype(np.float32), ARRAY_BUFFER),
            }
        )
    return {
        "mode": TRIANGLES,
        "attributes": attributes,
        "indices": document.add_triangles(faces, len(vertex)),
        "material": 0,
        "targets": targets,
    }


def _split(given: Targets) -> tuple[Ints, NDArray[np.int64], NDArray[np.int64]]:
    """Faces over vertices that are split at seams; of each its vertex and one of its corners."""
    faces, count = given.faces, len(given.base)
    corners = faces.ravel()
    first = np.zeros(count, dtype=np.int64)
    first[corners[::-1]] = np.arange(len(corners))[::-1]
    vertex = np.arange(count)
    values = [v for v in (given.texture, given.color) if v is not None]
    if not values:
        return faces, vertex, first
    rows = np.concatenate(values, axis=1).astype(np.float32) + np.float32(0)  # no negative zero
    odd = np.flatnonzero((rows != rows[first[corners]]).any(axis=1))
    keys = np.column_stack([corners[odd], rows[odd].view(np.int32)])
    shown, number = first_appearances(keys)
    split = corners.astype(np.int32)
    split[odd] = count + number
    extra = odd[shown]
    return (
        split.reshape(-1, 3),
        np.concatenate([vertex, corners[extra]]),
        np.concatenate([first, extra]),
    )


def _cross_fade(film: Film, count: int) -> tuple[Floats, Floats]:
    """Seconds of the key frames, and the weights of ``count`` targets at each."""
    seconds, station = film.key_times()
    place = np.clip(np.floor(station * count), 0, count - 1).astype(int)
    part = station * count - place
    weights = np.zeros((len(station), count + 1))
    rows = np.arange(len(station))
    weights[rows, place] = 1 - part
    weights[rows, place + 1] += part
    return seconds, weights[:, 1:]


def _animation(document: Builder, given: Targets) -> dict[str, Any]:
    return {
        "name": given.name,
        "samplers": [
            {
                "input": document.add(given.seconds.astype(np.float32), bounds=True),
                "interpolation": "LINEAR",
                "output": document.add(given.weights.ravel().astype(np.float32)),
            }
        ],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
    }
