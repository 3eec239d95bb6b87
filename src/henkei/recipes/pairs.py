"""Corresponding places of two surfaces, as a person writes them.

``[[12, 40], [77, 3]]`` are pairs of vertices, of the first surface and of the second;
``[[[0, 1, 2], [0, 1.1, 2]]]`` are pairs of points on or near them. A list has pairs of one kind.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Discriminator, Field, Strict, Tag

from henkei.recipes.recipe import Point, by_form, fault

Vertex = Annotated[int, Strict(), Field(ge=0, lt=2**31)]
VertexPair = tuple[Vertex, Vertex]
PointPair = tuple[Point, Point]


def _tag(data: Any) -> str | None:
    if not isinstance(data, list | tuple):
        return None
    of_points = any(isinstance(place, list | tuple) for place in data)
    return "(points)" if of_points else "(vertices)"


Pair = Annotated[
    Annotated[VertexPair, Tag("(vertices)")] | Annotated[PointPair, Tag("(points)")],
    Discriminator(
        _tag,
        custom_error_type="no_pair",
        custom_error_message="Input should be two vertices [i, j], or two points [[x, y, z], "
        "[x, y, z]]",
    ),
]


def _of_one_kind(pairs: tuple[Pair, ...]) -> tuple[Pair, ...]:
    for index, pair in enumerate(pairs):
        if isinstance(pair[0], int) != isinstance(pairs[0][0], int):
            kinds = "points", "vertices"
            this, before = kinds if isinstance(pairs[0][0], int) else kinds[::-1]
            raise fault(f"a pair of {this}, where those before are of {before}", index)
    return pairs


Pairs = Annotated[tuple[Pair, ...], AfterValidator(_of_one_kind)]
"""Pairs of vertices, or pairs of points."""

ProposedPairs = Annotated[
    Annotated[Literal["auto"], Tag("(plain)")] | Annotated[Pairs, Tag("(list)")],
    by_form('a list of pairs, or "auto"'),
]
"""The same, or ``"auto"``: proposed by shape."""
