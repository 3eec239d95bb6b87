"""What can go wrong, by cause.

    HenkeiError
      InvalidMesh           the surface itself is not what the method needs
        NotFinite           a coordinate is NaN or infinite
        NotManifold         an edge with more than two faces, a vertex with more than one fan
        NotOriented         neighbouring faces wind against each other, or the surface is one-sided
        NotADisk            not connected, closed, more than one boundary loop, or with handles
        NotASphere          not connected, or with handles, where a sphere is needed, closed or not
        NotClosed           has a boundary where a closed surface is needed
        DegenerateFaces     a face that repeats a vertex
      InvalidInput          an argument, apart from the mesh, is not usable
        InvalidFile         a file is missing, damaged, truncated, empty or of an unknown format
        MissingDependency   an optional library is needed and not installed
      Infeasible            valid input for which no result with the promised guarantees exists
      NotConverged          an iteration ended before it reached what was asked
      Cancelled             the caller's progress function asked to stop

A message says what is wrong, where (indices, line) and what to do about it.
"""

from __future__ import annotations

from collections.abc import Iterable


class HenkeiError(Exception):
    """Base of every error that henkei raises on purpose."""


class InvalidMesh(HenkeiError):
    """The surface is not what the method needs."""


class NotFinite(InvalidMesh):
    """A coordinate is NaN or infinite."""


class NotManifold(InvalidMesh):
    """An edge with more than two faces, or a vertex with more than one fan of faces."""


class NotOriented(InvalidMesh):
    """Neighbouring faces wind against each other, or the surface is one-sided."""


class NotADisk(InvalidMesh):
    """The surface is not connected with exactly one boundary loop and no handle."""


class NotASphere(InvalidMesh):
    """The surface is not connected, or has handles; boundary loops would be closed."""


class NotClosed(InvalidMesh):
    """The surface has a boundary where none is allowed."""


class DegenerateFaces(InvalidMesh):
    """A face repeats a vertex."""


class InvalidInput(HenkeiError):
    """An argument, apart from the mesh, is not usable."""


class InvalidFile(InvalidInput):
    """A file is missing, damaged, truncated, empty or of an unknown format."""


class MissingDependency(InvalidInput):
    """An optional library is needed and not installed."""


class Infeasible(HenkeiError):
    """The input is valid, but no result with the promised guarantees exists."""


class NotConverged(HenkeiError):
    """An iteration ended before it reached what was asked."""


class Cancelled(HenkeiError):
    """The caller's progress function asked to stop."""


def some(items: Iterable[object], limit: int = 6) -> str:
    """The first few items as text for a message: ``3, 17, 40 and 12 more``."""
    listed = list(items)
    shown = ", ".join(str(item) for item in listed[:limit])
    rest = len(listed) - limit
    return f"{shown} and {rest} more" if rest > 0 else shown
