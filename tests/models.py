"""Models of simulation codes made by code: elements of all kinds, and decks of them as text."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from henkei.io.cae import model_of
from henkei.io.cells import KINDS
from henkei.io.model import Model

ABAQUS = {
    "triangle": "S3R", "quad": "S4R", "triangle6": "STRI65", "quad8": "S8R", "tetra": "C3D4",
    "tetra10": "C3D10M", "pyramid": "C3D5", "wedge": "C3D6", "wedge15": "C3D15",
    "hexahedron": "C3D8R", "hexahedron20": "C3D20R",
}  # fmt: skip
NASTRAN = {
    "triangle": "CTRIA3", "quad": "CQUAD4", "triangle6": "CTRIA6", "quad8": "CQUAD8",
    "tetra": "CTETRA", "tetra10": "CTETRA", "pyramid": "CPYRAM", "wedge": "CPENTA",
    "wedge15": "CPENTA", "hexahedron": "CHEXA", "hexahedron20": "CHEXA",
}  # fmt: skip
SECOND = {
    "triangle": "triangle6", "quad": "quad8", "tetra": "tetra10", "wedge": "wedge15",
    "hexahedron": "hexahedron20", "pyramid": "pyramid13",
}  # fmt: skip
SPLIT = {  # of a hexahedron
    "tetra": [(0, 1, 3, 4), (1, 2, 3, 6), (1, 4, 5, 6), (3, 4, 6, 7), (1, 3, 4, 6)],
    "wedge": [(0, 1, 3, 4, 5, 7), (1, 2, 3, 5, 6, 7)],
    "hexahedron": [tuple(range(8))],
}
VERTICAL_EDGES_FIRST = {
    "hexahedron20": [*range(12), *range(16, 20), *range(12, 16)],
    "wedge15": [*range(9), *range(12, 15), *range(9, 12)],
}
FORMS = ["inp", "small", "large", "free"]
Blocks = list[tuple[str, np.ndarray]]


def lattice(nx: int, ny: int, nz: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of a box and its cubes ``(k, 8)``."""
    axes = [np.arange(n + 1.0) for n in (nx, ny, nz)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape(nx + 1, ny + 1, nz + 1)
    corners = [
        (0, 0, 0),
        (1, 0, 0),
        (1, 1, 0),
        (0, 1, 0),
        (0, 0, 1),
        (1, 0, 1),
        (1, 1, 1),
        (0, 1, 1),
    ]
    cubes = [number[i : i + nx, j : j + ny, k : k + nz].ravel() for i, j, k in corners]
    return points, np.stack(cubes, axis=1)


def box(kind: str, nx: int = 4, ny: int = 3, nz: int = 3, noise: float = 0.05, seed: int = 0):
    """Points and blocks of a box of solids; tetrahedra that meet mirror each other in turn."""
    points, cubes = lattice(nx, ny, nz)
    points += noise * np.random.default_rng(seed).uniform(-1, 1, points.shape)
    if kind == "pyramid":
        middle = len(points) + np.arange(len(cubes))
        points = np.concatenate([points, points[cubes].mean(axis=1)])
        cells = [np.column_stack([cubes[:, f[::-1]], middle]) for f in KINDS["hexahedron"].faces]
        return points, [(kind, np.concatenate(cells))]
    if kind != "tetra":
        return points, [(kind, np.concatenate([cubes[:, split] for split in SPLIT[kind]]))]
    odd = (np.indices((nx, ny, nz)).sum(axis=0) % 2).ravel() == 1
    turned = cubes.copy()
    turned[odd] = cubes[odd][:, [1, 2, 3, 0, 5, 6, 7, 4]]
    return points, [(kind, np.concatenate([turned[:, split] for split in SPLIT[kind]]))]


def sheet(nx: int = 4, ny: int = 3):
    """A bent sheet of quads, with triangles in its last row."""
    points, cubes = lattice(nx, ny, 1)
    quads = cubes[:, [0, 1, 2, 3]]
    points = points[points[:, 2] == 0]
    place = np.cumsum(lattice(nx, ny, 1)[0][:, 2] == 0) - 1
    quads = place[quads]
    points[:, 2] = 0.1 * points[:, 0] ** 2
    last = quads[-ny:]
    triangles = np.concatenate([last[:, [0, 1, 2]], last[:, [0, 2, 3]]])
    return points, [("quad", quads[:-ny]), ("triangle", triangles)]


def second_order(points: np.ndarray, blocks: Blocks, offset: float = 0.03):
    """The same with mid-side nodes, each a little beside the middle of its edge."""
    edges: dict[tuple[int, ...], int] = {}
    raised = []
    for kind, table in blocks:
        between = KINDS[SECOND[kind]].between
        rows = [
            [
                *row,
                *(
                    edges.setdefault(tuple(sorted((row[a], row[b]))), len(points) + len(edges))
                    for a, b in between
                ),
            ]
            for row in table.tolist()
        ]
        raised.append((SECOND[kind], np.array(rows)))
    middle = points[np.array(list(edges))].mean(axis=1)
    middle += offset * np.random.default_rng(1).uniform(-1, 1, middle.shape)
    return np.concatenate([points, middle]), raised


def abaqus(points: np.ndarray, blocks: Blocks, first: int = 1) -> str:
    """An input file; numbers of nodes and elements count from ``first``."""
    lines = ["*HEADING", " a model", "** comment, 1, 2", "*NODE, NSET=every"]
    lines += [f"{i}, {x!r}, {y!r}, {z!r}" for i, (x, y, z) in enumerate(points.tolist(), first)]
    element = first
    for kind, table in blocks:
        lines.append(f"*ELEMENT, TYPE={ABAQUS[kind]}, ELSET=set_{kind}")
        for row in table.tolist():
            words = [str(element), *(str(node + first) for node in row)]
            lines += [", ".join(words[i : i + 16]) for i in range(0, len(words), 16)]
            lines[-2:] = [lines[-2] + ",", lines[-1]] if len(words) > 16 else lines[-2:]
            element += 1
    lines += [
        "*SOLID SECTION, ELSET=set_" + blocks[-1][0] + ", MATERIAL=steel",
        "*STEP",
        "*END STEP",
    ]
    return "\n".join(lines) + "\n"


def real_number(value: float, width: int) -> str:
    """A number as Nastran's fields hold it."""
    for digits in range(16, -1, -1):
        text = f"{value:.{digits}f}"
        text = text if "." in text else f"{text}."
        if len(text) <= width:
            return text
    return "0."


def nastran(points: np.ndarray, blocks: Blocks, form: str = "small", first: int = 1) -> str:
    """A deck in ``small``, ``large`` or ``free`` field."""
    lines = ["SOL 101", "CEND", "BEGIN BULK", "$ comment, 1, 2"]
    for number, point in enumerate(points.tolist(), first):
        lines += _grid(number, point, form)
    lines.append("MAT1    1       210000.         .3")
    element = first
    for property_id, (kind, table) in enumerate(blocks, 1):
        order = VERTICAL_EDGES_FIRST.get(kind, slice(None))
        for row in table[:, order].tolist():
            lines += _element(
                NASTRAN[kind], [element, property_id, *(n + first for n in row)], form
            )
            element += 1
    return "\n".join([*lines, "ENDDATA", ""])


def _grid(number: int, point: list[float], form: str) -> list[str]:
    if form == "free":
        return [f"GRID,{number},,{','.join(map(repr, point))}"]
    if form == "small":
        return [f"GRID    {number:<8}{'':8}" + "".join(f"{real_number(x, 8):>8}" for x in point)]
    x, y, z = (f"{real_number(value, 16):>16}" for value in point)
    return [f"GRID*   {number:<16}{'':16}{x}{y}", f"*       {z}"]


def _element(name: str, words: list[int], form: str) -> list[str]:
    each = 4 if form == "large" else 8
    rows = [words[i : i + each] for i in range(0, len(words), each)]
    if form == "free":
        return [",".join([name if i == 0 else "", *map(str, row)]) for i, row in enumerate(rows)]
    width, star = (16, "*") if form == "large" else (8, "")
    heads = [f"{name}{star}".ljust(8), *[star.ljust(8)] * (len(rows) - 1)]
    lines = [
        head + "".join(f"{word:>{width}}" for word in row)
        for head, row in zip(heads, rows, strict=True)
    ]
    return [line.ljust(80) for line in lines[:-1]] + lines[-1:]


def corners_of(model: Model) -> list[list[float]]:
    """Corner positions of all faces, in an order of their own, for comparing surfaces."""
    surface = model.surface
    rings = np.split(surface.indices, surface.offsets[1:-1])
    return sorted(sorted(map(tuple, surface.vertices[ring].tolist())) for ring in rings)


def parsed(text: str, name: str = "a.inp") -> Model:
    """The model in a text, as if it stood in a file of that name."""
    return model_of(Path(name), text.encode())


def text_of(form: str, points, blocks) -> tuple[str, str]:
    """A deck and its extension."""
    if form == "inp":
        return abaqus(points, blocks, first=101), "inp"
    return nastran(points, blocks, form, first=101), "bdf"
