"""What a way of exporting is: its options, what it needs, and how its files become one."""

from __future__ import annotations

import re
import shutil
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from henkei.errors import InvalidInput, MissingDependency, some
from henkei.io.whole import whole
from henkei.mesh import Surface
from henkei.progress import Progress
from henkei.recipes.recipe import Recipe, meant

Needs = Literal["input", "result"]
Value = bool | str | tuple[float, ...]

ZIP = ".zip"
LONGEST_STEM = 80  # bytes; systems take 255, of which others stand around it
MOST_NUMBERS = 20
_EPOCH = (1980, 1, 1, 0, 0, 0)  # the date of every entry, so that bytes depend on the files alone


@dataclass(frozen=True)
class Option:
    """Something that a person may choose about a file.

    default : by its type the option is a switch, one of ``choices``, or positive numbers.
    """

    name: str
    label: str
    default: Value
    choices: tuple[str, ...] = ()

    def checked(self, value: Any) -> Value:
        """A value that was chosen.

        Raises
        ------
        InvalidInput : it is none of this option.
        """
        if isinstance(self.default, bool):
            if isinstance(value, bool):
                return value
            raise InvalidInput(f"{self.name} is true or false, not {value!r}")
        if isinstance(self.default, str):
            if isinstance(value, str) and value in self.choices:
                return value
            raise InvalidInput(f"{self.name} is one of {some(self.choices, 20)}, not {value!r}")
        if isinstance(value, list | tuple) and 0 < len(value) <= MOST_NUMBERS:
            numbers = [number for number in value if type(number) in (int, float) and number > 0]
            if len(numbers) == len(value) and max(numbers) < float("inf"):
                return tuple(map(float, numbers))
        raise InvalidInput(f"{self.name} is a list of 1 to {MOST_NUMBERS} numbers above 0")


@dataclass(frozen=True, eq=False)
class Material:
    """What a file is made from.

    recipe : of the tab.
    surfaces : the meshes it is for, by their slots and in the order of these.
    names : of these meshes, likewise.
    result : what the recipe made of them, if it was made: of combine with b moved onto a if the
        recipe asks for that.
    """

    recipe: Any
    surfaces: Mapping[str, Surface]
    names: Mapping[str, str]
    result: Any = None


@dataclass(frozen=True, eq=False)
class Export:
    """A file, or some, in the making.

    folder : empty; what is left in it is what is exported.
    stem : of the files' names.
    """

    material: Material
    options: Mapping[str, Any]
    folder: Path
    stem: str
    progress: Progress

    @property
    def recipe(self) -> Any:
        """The recipe of the tab."""
        return self.material.recipe

    @property
    def surface(self) -> Surface:
        """The first mesh."""
        return next(iter(self.material.surfaces.values()))

    @property
    def result(self) -> Any:
        """What the recipe made."""
        return self.material.result

    def file(self, ending: str) -> Path:
        """A file with the common stem; ``ending`` is what follows it, as in ``_b.ply``."""
        return self.folder / f"{self.stem}{ending}"


def always() -> str | None:
    """Nothing is missing for this."""
    return None


@dataclass(frozen=True, eq=False)
class Format:
    """A way of exporting.

    key : its name in a tab.
    label : its name for people; group: a heading above it.
    suffix : of the file, if no option says it; several files become one ``.zip``.
    write : puts the files into the folder of an :class:`Export`.
    needs : the meshes and the recipe alone, or the result.
    library : why it cannot be written here, as a message; None if it can.
    """

    key: str
    label: str
    suffix: str
    write: Callable[[Export], object] = field(repr=False)
    group: str = ""
    needs: Needs = "input"
    options: tuple[Option, ...] = ()
    library: Callable[[], str | None] = field(default=always, repr=False)

    @property
    def missing(self) -> str | None:
        """Why it cannot be written here, and what to do."""
        return self.library()

    def chosen(self, options: Any) -> dict[str, Value]:
        """All options, with what was chosen in place of defaults.

        Raises
        ------
        InvalidInput : an option does not exist, or its value is none of it.
        """
        if not isinstance(options, Mapping):
            raise InvalidInput(f"options are an object of names and values, not {options!r}")
        known = {option.name: option for option in self.options}
        for name in options:
            if name not in known:
                listed = some(known) or "none"
                raise InvalidInput(
                    f"{self.key} has no option {name!r}{meant(name, [*known])}; known are {listed}"
                )
        return {
            name: option.checked(options[name]) if name in options else option.default
            for name, option in known.items()
        }

    def require(self, material: Material) -> None:
        """Raise InvalidInput where something is not there, MissingDependency for a library."""
        if not isinstance(material.recipe, Recipe):
            raise InvalidInput("there is no recipe to export")
        if not material.surfaces:
            raise InvalidInput("no mesh is chosen yet; open one, or choose one that is open")
        if self.needs == "result" and material.result is None:
            raise InvalidInput(f"there is no result yet for {self.label!r}; make it first")
        if self.missing is not None:
            raise MissingDependency(self.missing)

    def as_dict(self) -> dict[str, Any]:
        """For the page: what it is, its options with their defaults, and why it is missing."""
        missing = self.missing
        return {
            "format": self.key,
            "label": self.label,
            "group": self.group,
            "options": {option.name: option.default for option in self.options},
            "choices": [
                {"name": one.name, "label": one.label, "choices": list(one.choices)}
                for one in self.options
            ],
            **({} if missing is None else {"missing": missing, "detail": missing}),
        }


def plain_stem(text: str) -> str:
    """A name that every system takes as a part of a file's."""
    plain = re.sub(r"[^\w.-]+", "_", text).strip("._-")
    return plain.encode()[:LONGEST_STEM].decode(errors="ignore") or "henkei"


def joined(files: Sequence[Path], folder: Path, stem: str, suffix: str) -> Path:
    """Move a file into a folder under its own name, or several as ``stem.zip``.

    suffix : ``.zip``, if one file is to be packed too.
    """
    if len(files) == 1 and suffix != ZIP:
        return files[0].replace(folder / files[0].name)
    target = folder / f"{stem}{ZIP}"
    with whole(target) as stream, zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in files:
            entry = zipfile.ZipInfo(file.name, _EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            with file.open("rb") as source, archive.open(entry, "w", force_zip64=True) as copy:
                shutil.copyfileobj(source, copy)
    return target
