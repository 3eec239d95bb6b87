"""A tab with one surface that moves, as a session would use it, for tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Generic, TypeVar

from henkei.mesh import Floats, Surface
from henkei.studio.blobs import Blobs
from henkei.studio.document import MeshEntry
from henkei.studio.services import Services
from henkei.studio.tabs.base import Basis, Tab, TabState

State = TypeVar("State", bound=TabState)


class TabDesk(Generic[State]):
    """A tab with a mesh in it.

    tab : and the key of its surface that moves.
    """

    def __init__(
        self, folder: Path, tab: Tab[State], state: State, moving: str, surface: Surface
    ) -> None:
        self.tab, self.state, self.moving, self.surface = tab, state, moving, surface
        self.services = Services(Blobs(folder))
        blob = self.services.blobs.put_surface(surface)
        count, faces = len(surface.vertices), surface.face_count
        self.services.meshes = (
            MeshEntry(id="m1", name="part", surface=blob, vertices=count, faces=faces),
        )
        (slot,) = state.slots
        self.do("use", slot=slot, mesh="m1")

    def after(self, action: str, /, **arguments: Any) -> State:
        after: State = self.tab.action(action, arguments).apply(self.state, self.services)
        assert type(after).model_validate(after.model_dump(mode="json")) == after
        return after

    def do(self, action: str, /, **arguments: Any) -> None:
        self.tab.settle(self.services)
        self.state = self.after(action, **arguments)

    def live(self, action: str, /, **arguments: Any) -> Floats:
        return self.tab.frames(self.after(action, **arguments), self.services)[self.moving]

    def grab(self, **what: Any) -> Basis | None:
        return self.tab.basis(self.state, what, self.services)

    @property
    def view(self) -> dict[str, Any]:
        return self.tab.view(self.state, self.services)

    @property
    def positions(self) -> Floats:
        return self.tab.frames(self.state, self.services)[self.moving]
