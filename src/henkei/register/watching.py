"""The source on its way: where its vertices are while the method runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from henkei.geometry.alignment import Similarity
from henkei.geometry.distance import points_on
from henkei.mesh import Floats, Mesh
from henkei.register.spheres import OnSphere
from henkei.register.surfaces import Closed

Watch = Callable[[Floats], None]
"""Called with positions ``(n, 3)`` of all vertices of the source, in the target's space."""


@dataclass(frozen=True, eq=False)
class View:
    """A model over another surface, for those who watch.

    seen : shows it, given directions (k, 3) of its vertices; None if nobody watches.
    """

    seen: Watch | None = None

    def show(self, model: OnSphere) -> None:
        """Show it as it is."""
        if self.seen is not None:
            self.seen(model.directions)


UNSEEN = View()


@dataclass(frozen=True, eq=False)
class Watcher:
    """Who is shown the source.

    motion : from the source's space to the target's.
    watch : None if nobody watches; then nothing is computed.
    """

    source: Closed
    motion: Similarity
    watch: Watch | None

    def show(self, points: Floats) -> None:
        """Show the vertices of the source's closed mesh at points (k, 3) of the target's space; the
        vertices that no face uses move along."""
        if self.watch is not None:
            used = self.source.used
            shown = self.motion.apply(self.source.given.vertices)
            shown[used] = points[: len(used)]
            self.watch(shown)

    def over(self, surface: OnSphere, placed: Mesh) -> View:
        """The source over a surface on the sphere, which is ``placed`` in the target's space."""
        if self.watch is None:
            return UNSEEN
        return View(lambda directions: self.show(points_on(placed, surface.locate(directions))))
