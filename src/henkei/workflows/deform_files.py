"""A mesh to deform from any file, and the deformed one back into such a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from henkei.errors import InvalidInput
from henkei.geometry.model_motion import moved
from henkei.io import read, write
from henkei.io.cae import READERS, read_model, write_model
from henkei.io.files import BY_SUFFIX
from henkei.io.model import Model
from henkei.mesh import Floats, Surface

MESHES = tuple(dict.fromkeys((*BY_SUFFIX, *READERS)))


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A file and the surface in it.

    model : all that the file of a simulation code holds; None for other files.
    """

    path: Path
    surface: Surface
    model: Model | None = None

    @classmethod
    def read(cls, path: Path) -> MeshFile:
        """Read a file, told by its extension; see :func:`henkei.read` and
        :func:`henkei.io.cae.read_model`.

        Raises
        ------
        InvalidFile, MissingDependency : as these functions.
        """
        if path.suffix.lower() in READERS and not _is_surface(path):
            model = read_model(path)
            return cls(path, model.surface, model)
        return cls(path, read(path))

    def write(self, path: Path, surface: Surface, rotations: Floats | None = None) -> None:
        """Write the deformed surface; of a model, if the file can hold one, all of it with its
        numbers, sets and inner nodes.

        Parameters
        ----------
        rotations : (n, 3, 3) of the vertices, by which mid-side and hanging nodes turn; see
            :func:`henkei.geometry.model_motion.moved`.

        Raises
        ------
        InvalidInput, NotFinite, MissingDependency : as :func:`henkei.write` and
            :func:`henkei.io.cae.write_model`.
        """
        if self.model is not None and path.suffix.lower() in READERS:
            write_model(path, self.model, moved(self.model, surface.vertices, rotations=rotations))
        else:
            write(path, surface)


def require_mesh_name(path: Path) -> None:
    """Raise InvalidInput if the extension names no format that meshes are written in."""
    if path.suffix.lower() not in MESHES:
        raise InvalidInput(
            f"{path}: nothing is written under the ending {path.suffix!r}; known are "
            f"{', '.join(MESHES)}, and .png for a picture"
        )


def _is_surface(path: Path) -> bool:
    """Whether a .vtk file holds polygons alone, and no model."""
    if path.suffix.lower() != ".vtk" or not path.is_file():
        return False
    with path.open("rb") as stream:
        return b"DATASET POLYDATA" in stream.read(1000)
