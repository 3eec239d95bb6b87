"""What tabs work with: surfaces, blobs, engines that were prepared, and progress."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from henkei.errors import InvalidInput
from henkei.mesh import Floats, Surface
from henkei.progress import Progress, silent
from henkei.studio.drawables import drawable

if TYPE_CHECKING:
    from henkei.studio.aside import Aside
    from henkei.studio.blobs import Blobs
    from henkei.studio.document import MeshEntry

Kept = TypeVar("Kept")
_MOST_KEPT = 64  # things remembered, beside engines


class Services:
    """Of one session; used on its engine thread only.

    blobs : where surfaces, results and arrays for the page are.
    meshes : those open now.
    progress : of what the engine does at present.
    tell : a notice to the person.
    aside : has long work done on another thread; None to wait for it.
    renew : makes the view of a tab anew and tells it.
    """

    def __init__(self, blobs: Blobs) -> None:
        self.blobs = blobs
        self.meshes: Sequence[MeshEntry] = ()
        self.progress: Progress = silent
        self.tell: Callable[[str], None] = lambda message: None
        self.aside: Aside | None = None
        self.renew: Callable[[str], None] = lambda tab: None
        self._engines: dict[str, tuple[object, Any]] = {}
        self._remembered: dict[Hashable, Any] = {}

    def entry(self, mesh: str | None) -> MeshEntry:
        """What is known of an open mesh.

        Raises
        ------
        InvalidInput : no mesh was chosen, or it is no longer open.
        """
        if mesh is None:
            raise InvalidInput("no mesh is chosen yet; open one, or choose one that is open")
        for one in self.meshes:
            if one.id == mesh:
                return one
        raise InvalidInput(f"mesh {mesh!r} is not open any more; choose another one")

    def surface(self, mesh: str | None) -> Surface:
        """The surface of an open mesh."""
        return self.blobs.surface(self.entry(mesh).surface)

    def drawn(self, surface: str) -> str:
        """The blob with what the page draws of a surface, by that surface's blob."""

        def make() -> str:
            header, arrays = drawable(self.blobs.surface(surface))
            return self.blobs.put_message(header, **arrays)

        return self.remembered(("drawn", surface), make)

    def frame(self, drawn: str) -> tuple[Floats, float]:
        """Centre (3,) and scale of what the page draws, by its blob."""

        def read() -> tuple[Floats, float]:
            header = self.blobs.get_message(drawn).header
            return np.array(header["centre"]), float(header["scale"])

        return self.remembered(("frame", drawn), read)

    def values(self, values: NDArray[Any], **header: Any) -> str:
        """A blob with a value for each vertex or face, for colours."""
        given = np.asarray(values, dtype=np.float32)
        return self.blobs.put_message({"kind": "values", **header}, values=given)

    def engine(self, tab: str, key: object, make: Callable[[], Kept]) -> Kept:
        """What a tab has prepared for ``key``; made anew when the key is another one."""
        known = self._engines.get(tab)
        if known is None or known[0] != key:
            self._engines.pop(tab, None)
            self._engines[tab] = known = (key, make())
        kept: Kept = known[1]
        return kept

    def has_engine(self, tab: str, engine: object) -> bool:
        """Whether a tab has prepared just this last; may be asked from any thread."""
        known = self._engines.get(tab)
        return known is not None and known[1] is engine

    def present(self, tab: str) -> Any:
        """What a tab has prepared last, whatever for; None if nothing."""
        return self._engines.get(tab, (None, None))[1]

    def remembered(self, key: Hashable, make: Callable[[], Kept]) -> Kept:
        """What was made for this key before, or now."""
        if key not in self._remembered:
            while len(self._remembered) >= _MOST_KEPT:
                self._remembered.pop(next(iter(self._remembered)))
            self._remembered[key] = make()
        kept: Kept = self._remembered[key]
        return kept

    def forget(self) -> None:
        """Drop all that was kept to be quick."""
        self._engines.clear()
        self._remembered.clear()
