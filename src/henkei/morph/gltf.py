"""Morphs as glTF 2.0: one mesh with morph targets, and an animation of their weights."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from henkei.io._glb import ARRAY_BUFFER, TRIANGLES, Builder
from henkei.io.unique import first_appearances
from henkei.mesh import Floats
from henkei.morph.film import Film, centre_of, unit_normals
from henkei.topology import Ints


def encode(film: Film, text: bool) -> bytes:
    """The bytes of a .gltf (``text``) or .glb file.

    The base is a; targets hold differences of positions and normals to it. Between two targets the
    weights cross-fade, so the surface runs through all of them. Positions count from the node's
    translation where the coordinates are far from the origin.
    """
    document = Builder()
    stations, shapes = film.key_shapes()
    centre = centre_of([film.correspondence.vertices_a, *shapes])
    names = [f"{station:.0%}" for station in stations[:-1]] + ["b"]
    document.content |= {
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [_node(centre)],
        "meshes": [
            {
                "name": "morph",
                "primitives": [_primitive(document, film, shapes, centre)],
                "weights": [0] * len(stations),
                "extras": {"targetNames": names},
            }
        ],
        "materials": [
            {
                "doubleSided": True,
                "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.7},
            }
        ],
        "animations": [_animation(document, film, len(stations))],
    }
    return document.gltf() if text else document.glb()


def _node(centre: Floats) -> dict[str, Any]:
    node: dict[str, Any] = {"name": "morph", "mesh": 0}
    if centre.any():
        node["translation"] = centre.tolist()
    return node


def _primitive(
    document: Builder, film: Film, shapes: list[Floats], centre: Floats
) -> dict[str, Any]:
    faces, vertex, corner = _split(film)
    base = (film.correspondence.vertices_a - centre).astype(np.float32)
    normals = unit_normals(film.correspondence.vertices_a, film.correspondence.faces)
    attributes = {
        "POSITION": document.add(base[vertex], ARRAY_BUFFER, bounds=True),
        "NORMAL": document.add(normals[vertex].astype(np.float32), ARRAY_BUFFER),
    }
    if film.texture is not None:
        flipped = film.texture[corner] * [1, -1] + [0, 1]
        attributes["TEXCOORD_0"] = document.add(flipped.astype(np.float32), ARRAY_BUFFER)
    if film.color is not None:
        attributes["COLOR_0"] = document.add(film.color[corner].astype(np.float32), ARRAY_BUFFER)
    targets = []
    for shape in shapes:
        moved = (shape - centre - base).astype(np.float32)
        turned = unit_normals(shape, film.correspondence.faces) - normals
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


def _split(film: Film) -> tuple[Ints, NDArray[np.int64], NDArray[np.int64]]:
    """Faces over vertices that are split at seams; of each its vertex and one of its corners."""
    faces, count = film.correspondence.faces, len(film.correspondence.vertices_a)
    corners = faces.ravel()
    first = np.zeros(count, dtype=np.int64)
    first[corners[::-1]] = np.arange(len(corners))[::-1]
    vertex = np.arange(count)
    values = [v for v in (film.texture, film.color) if v is not None]
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


def _animation(document: Builder, film: Film, count: int) -> dict[str, Any]:
    seconds, station = film.key_times()
    place = np.clip(np.floor(station * count), 0, count - 1).astype(int)
    part = station * count - place
    weights = np.zeros((len(station), count + 1))
    rows = np.arange(len(station))
    weights[rows, place] = 1 - part
    weights[rows, place + 1] += part
    return {
        "name": "morph",
        "samplers": [
            {
                "input": document.add(seconds.astype(np.float32), bounds=True),
                "interpolation": "LINEAR",
                "output": document.add(weights[:, 1:].ravel().astype(np.float32)),
            }
        ],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
    }
