"""The topology of faces of any size by plain counting, with dictionaries instead of tables."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable


def topology_of(faces: Iterable[Iterable[int]]) -> list[tuple[int, int]]:
    """Euler number and number of boundary loops of each component, sorted; two oriented manifolds
    are homeomorphic just if these agree.

    Fails where a face repeats a vertex, an edge is used twice in one direction, or the faces of a
    vertex do not form one fan.
    """
    faces = [tuple(map(int, face)) for face in faces]
    owner: dict[tuple[int, int], int] = {}
    after: dict[int, dict[int, int]] = defaultdict(dict)
    for number, face in enumerate(faces):
        assert len(set(face)) == len(face), f"face {number} repeats a vertex: {face}"
        for before, vertex, behind in zip(face[-1:] + face, face, face[1:] + face, strict=False):
            assert (vertex, behind) not in owner, f"edge {vertex, behind} runs twice one way"
            owner[vertex, behind] = number
            after[vertex][behind] = before
    for vertex, link in after.items():
        starts = set(link) - set(link.values()) or {next(iter(link))}
        at, steps = starts.pop(), 0
        while at in link and steps < len(link):
            at, steps = link[at], steps + 1
        assert steps == len(link), f"vertex {vertex} has several fans"
    return sorted(_signature(part, owner) for part in _components(faces, owner))


def _components(
    faces: list[tuple[int, ...]], owner: dict[tuple[int, int], int]
) -> list[list[tuple[int, ...]]]:
    seen: set[int] = set()
    parts = []
    for first in range(len(faces)):
        if first in seen:
            continue
        seen.add(first)
        part, pending = [], [first]
        while pending:
            number = pending.pop()
            face = faces[number]
            part.append(face)
            for edge in zip(face, face[1:] + face, strict=False):
                beside = owner.get(edge[::-1])
                if beside is not None and beside not in seen:
                    seen.add(beside)
                    pending.append(beside)
        parts.append(part)
    return parts


def _signature(faces: list[tuple[int, ...]], owner: dict[tuple[int, int], int]) -> tuple[int, int]:
    half_edges = [edge for face in faces for edge in zip(face, face[1:] + face, strict=False)]
    following = {a: b for a, b in half_edges if (b, a) not in owner}
    loops = 0
    while following:
        start, at = following.popitem()
        while at != start:
            at = following.pop(at)
        loops += 1
    vertices = {vertex for face in faces for vertex in face}
    edges = {frozenset(edge) for edge in half_edges}
    return len(vertices) - len(edges) + len(faces), loops
