"""Figures of quality, as pages list them."""

from __future__ import annotations

from typing import Any

from henkei.recipes.recipe import Part
from henkei.studio.tabs.base import Flag


class Figure(Part):
    """A figure of quality, as a tab keeps it.

    bad : it is not as it should be.
    """

    label: str
    value: int | float | str
    unit: str = ""
    hint: str = ""
    bad: Flag = False


def figure(
    label: str, value: float | str, hint: str = "", bad: bool = False, unit: str = ""
) -> dict[str, Any]:
    """The data of a :class:`Figure`."""
    return {"label": label, "value": value, "unit": unit, "hint": hint, "bad": bool(bad)}
