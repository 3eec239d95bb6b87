"""The deform tab as a session uses it, for tests."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from henkei.mesh import Floats, Surface
from henkei.shapes import bumper_parts
from henkei.studio.deform_state import DeformState
from henkei.studio.tabs.deform import TAB
from henkei.workflows.deform_by_recipe import deform_by_recipe
from tab_desk import TabDesk

SIZE = 2000  # of the bumper


class Desk(TabDesk[DeformState]):
    """The tab with a mesh in it."""

    def __init__(self, folder: Path, surface: Surface) -> None:
        super().__init__(folder, TAB, DeformState(), "mesh", surface)
        self.told: list[str] = []
        self.services.tell = self.told.append

    def select(self, vertices: Any) -> None:
        self.do("select_vertices", vertices=np.asarray(vertices).tolist())

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
