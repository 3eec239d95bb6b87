"""The adaptation of a self-organizing deformable model, slowly: every vertex is looked at, and the
way over the edges is searched anew at each step."""

from __future__ import annotations

from math import ceil, exp

MASK = 2**64 - 1


def draws(seed: int, bound: int):
    """Numbers below a bound by SplitMix64, without end."""
    state = seed & MASK
    while True:
        state = (state + 0x9E3779B97F4A7C15) & MASK
        z = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
        yield int(((z ^ (z >> 31)) >> 11) * 2.0**-53 * bound)


def between(start: float, end: float, done: float) -> float:
    """Geometric from start to end (eq. 9, 10)."""
    return start * (end / start) ** done


def nearest(x, p) -> int:
    """The vertex nearest to p; of several, the first."""
    return min(range(len(x)), key=lambda v: squared(x[v], p))


def squared(q, p) -> float:
    dx, dy, dz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    return dx * dx + dy * dy + dz * dz


def in_front(x, p, normal) -> int | None:
    """The vertex in front of the plane through p that is nearest to the plane (eq. 6, 7)."""
    away = [
        normal[0] * (q[0] - p[0]) + normal[1] * (q[1] - p[1]) + normal[2] * (q[2] - p[2]) for q in x
    ]
    front = [v for v in range(len(x)) if away[v] > 0]
    return min(front, key=lambda v: away[v], default=None)


def hops_from(start: int, neighbours, most: int) -> dict[int, int]:
    """Vertices at most so many edges away, and how many."""
    found = {start: 0}
    for h in range(most):
        for v in [v for v, hops in found.items() if hops == h]:
            for w in neighbours[v]:
                found.setdefault(w, h + 1)
    return found


def adapt(
    vertices, neighbours, points, normals, winners, steps, rate, radius, literal, seed
) -> tuple[list[list[float]], int]:
    """The vertices afterwards, and how many draws had no winner.

    neighbours : list of vertices for each vertex.
    winners : the vertex that always wins a control point, or -1.
    rate, radius : start and end.
    """
    x = [list(map(float, v)) for v in vertices]
    random, without = draws(seed, len(points)), 0
    for step in range(steps):
        eps, sigma = (between(*ends, step / steps) for ends in (rate, radius))
        drawn = next(random)
        p, winner = points[drawn], winners[drawn]
        if winner < 0:
            winner = in_front(x, p, normals[drawn]) if literal else nearest(x, p)
        if winner is None:
            without += 1
            continue
        for v, h in hops_from(winner, neighbours, ceil(3.1 * sigma)).items():
            pull = eps * exp(-0.5 * (h / sigma) * (h / sigma))
            for k in range(3):
                x[v][k] += pull * (p[k] - x[v][k])
    return x, without
