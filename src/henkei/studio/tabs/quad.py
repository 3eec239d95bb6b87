"""The tab of quad."""

from __future__ import annotations

from typing import ClassVar

from henkei.studio.tabs.base import MeshId, Tab, TabState


class QuadState(TabState):
    """What is chosen."""

    slots: ClassVar[tuple[str, ...]] = ("mesh",)

    mesh: MeshId | None = None


TAB = Tab("quad", QuadState)
