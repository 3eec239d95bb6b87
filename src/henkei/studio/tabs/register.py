"""The tab of register."""

from __future__ import annotations

from typing import ClassVar

from henkei.studio.tabs.base import MeshId, Tab, TabState


class RegisterState(TabState):
    """What is chosen."""

    slots: ClassVar[tuple[str, ...]] = ("source", "target")

    source: MeshId | None = None
    target: MeshId | None = None


TAB = Tab("register", RegisterState)
