"""What can be exported from each tab: all that the command line can write."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from henkei.errors import InvalidInput, some
from henkei.progress import Progress, part, silent
from henkei.studio.exported import COMBINE, DEFORM, DESIGN, QUAD, REGISTER
from henkei.studio.exporting import Export, Format, Material, joined, plain_stem

FORMATS: Mapping[str, tuple[Format, ...]] = {
    "combine": COMBINE,
    "register": REGISTER,
    "deform": DEFORM,
    "quad": QUAD,
    "design": DESIGN,
}
MOST_LISTED = 40  # formats in a message
STEMS = {
    "combine": ("_", ""),
    "register": ("_on_", ""),
    "deform": ("", "_deformed"),
    "quad": ("", "_quads"),
    "design": ("", "_designed"),
}
"""What stands between the names of a tab's meshes and after them, in those of files."""


def export(
    tab: str,
    key: str,
    options: Any,
    material: Material,
    folder: Path,
    progress: Progress = silent,
) -> Path:
    """Write a file.

    Parameters
    ----------
    tab, key : of the format.
    options : by name, see :attr:`Format.options`; those that are left out have their defaults.
    folder : where the file is put, under a name after the meshes; several files as one ``.zip``.
        What had this name is replaced.

    Raises
    ------
    InvalidInput : there is no such format or option, or nothing yet to write.
    MissingDependency : an optional library is needed.
    HenkeiError : as the functions that write.
    """
    form = format_of(tab, key)
    chosen = form.chosen(options)
    form.require(material)
    stem = _stem(tab, material)
    progress("writing", 0.0)
    with TemporaryDirectory(dir=folder) as place:
        form.write(Export(material, chosen, Path(place), stem, part(progress, 0.0, 0.95)))
        written = joined(sorted(Path(place).iterdir()), folder, stem, form.suffix)
    progress("written", 1.0)
    return written


def format_of(tab: str, key: str) -> Format:
    """A way of exporting from a tab.

    Raises
    ------
    InvalidInput : there is none.
    """
    if tab not in list(FORMATS):
        raise InvalidInput(f"there is no tab {str(tab)[:40]!r}; known are {some(FORMATS)}")
    known = {form.key: form for form in FORMATS[tab]}
    if key not in list(known):
        listed = some(known, MOST_LISTED)
        raise InvalidInput(f"{tab} has no format {str(key)[:40]!r}; known are {listed}")
    return known[key]


def listed(tab: str, *, done: bool) -> list[dict[str, Any]]:
    """What the page offers, see :meth:`Format.as_dict`.

    Parameters
    ----------
    done : whether there is a result.
    """
    return [form.as_dict() for form in FORMATS[tab] if done or form.needs == "input"]


def _stem(tab: str, material: Material) -> str:
    between, after = STEMS[tab]
    names = [Path(material.names.get(slot, slot)).stem for slot in material.surfaces]
    return plain_stem(between.join(names[:2])) + after
