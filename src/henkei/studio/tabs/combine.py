"""The tab of combine."""

from __future__ import annotations

from typing import ClassVar

from henkei.studio.tabs.base import MeshId, Tab, TabState


class CombineState(TabState):
    """What is chosen."""

    slots: ClassVar[tuple[str, ...]] = ("a", "b")

    a: MeshId | None = None
    b: MeshId | None = None


TAB = Tab("combine", CombineState)
