"""The deform tab as a session uses it, for tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from henkei.mesh import Floats, Surface
from henkei.shapes import bumper_parts
from henkei.studio.blobs import Blobs
from henkei.studio.deform_state import DeformState
from henkei.studio.document import MeshEntry
from henkei.studio.services import Services
from henkei.studio.tabs.base import Basis
from henkei.studio.tabs.deform import TAB
from henkei.workflows.deform_by_recipe import deform_by_recipe

SIZE = 2000  # of the bumper


class Desk:
    """The tab with a mesh in it, as a session would use it."""

    def __init__(self, folder: Path, surface: Surface) -> None:
        self.surface = surface
        self.told: list[str] = []
        self.services = Services(Blobs(folder))
        self.services.tell = self.told.append
        blob = self.services.blobs.put_surface(surface)
        count, faces = len(surface.vertices), surface.face_count
        self.services.meshes = (
            MeshEntry(id="m1", name="part", surface=blob, vertices=count, faces=faces),
        )
        self.state = DeformState()
        self.do("use", slot="mesh", mesh="m1")

    def after(self, action: str, /, **arguments: Any) -> DeformState:
        after: DeformState = TAB.action(action, arguments).apply(self.state, self.services)
        assert DeformState.model_validate(after.model_dump(mode="json")) == after
        return after

    def do(self, action: str, /, **arguments: Any) -> None:
        TAB.settle(self.services)
        self.state = self.after(action, **arguments)

    def select(self, vertices: Any) -> None:
        self.do("select_vertices", vertices=np.asarray(vertices).tolist())

    def live(self, action: str, /, **arguments: Any) -> Floats:
        return TAB.frames(self.after(action, **arguments), self.services)["mesh"]

    def grab(self, **what: Any) -> Basis | None:
        return TAB.basis(self.state, what, self.services)

    @property
    def view(self) -> dict[str, Any]:
        return TAB.view(self.state, self.services)

    @property
    def positions(self) -> Floats:
        return TAB.frames(self.state, self.services)["mesh"]

    @property
    def by_recipe(self) -> Floats:
        return deform_by_recipe(self.surface, self.state.recipe).mesh.vertices

    def part(self, name: str) -> dict[str, Any]:
        """What the page is told of a part, with its vertices."""
        told = next(part for part in self.view["parts"] if part["name"] == name)
        if "ids" in told:
            told["ids"] = self.services.blobs.get_message(told["ids"]).arrays["values"]
        return told

    def bend(self) -> None:
        """The bumper with its sides fixed, and its middle as handle."""
        parts = bumper_parts(SIZE)
        self.select(parts["sides"])
        self.do("add", kind="fixed")
        self.select(parts["handle"])
        self.do("add", kind="handles")
