"""Looking at surfaces and results: in notebooks, in a browser, in a file."""

from __future__ import annotations

import os
import sys
import tempfile
import webbrowser
from dataclasses import dataclass, replace
from html import escape
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

from henkei.errors import HenkeiError, InvalidInput
from henkei.io.html import figures, page, require_shown
from henkei.io.scene import Scene, lines_on, marks_on
from henkei.io.whole import whole
from henkei.mesh import Surface
from henkei.showing import Shown

HEIGHT = 480  # pixels
OF_ITSELF = 200_000  # faces up to which a surface shows itself at the end of a notebook's cell

# The picture lies over the figures, which are seen where a notebook leaves the picture out.
OUTPUT = (
    '<div style="display:grid">'
    '<div style="grid-area:1/1;padding:8px 12px">{figures}</div>'
    '<iframe style="grid-area:1/1;width:100%;height:{height}px;border:0;border-radius:8px" '
    'sandbox="allow-scripts" allowfullscreen title="{title}" srcdoc="{page}"></iframe></div>'
)


@dataclass(frozen=True, eq=False, repr=False)
class View:
    """What :func:`henkei.view` shows. In a notebook it shows itself.

    scene : all that is in the picture.
    height : pixels that it takes in a notebook.
    """

    scene: Scene
    height: int = HEIGHT

    @property
    def html(self) -> str:
        """The whole page, which loads nothing else.

        Raises
        ------
        MissingDependency : the viewer was not built; the message says what to do.
        """
        return b"".join(page(self.scene)).decode()

    def _repr_html_(self) -> str:
        return _output(self)

    def __repr__(self) -> str:
        surface = self.scene.surface
        sizes = f"{len(surface.vertices):,} vertices, {surface.face_count:,} faces"
        return f"View({sizes}; .show() opens it, .write('view.html') keeps it)"

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the page to a file, which appears whole or not at all.

        Raises
        ------
        InvalidInput : the file cannot be written, or has not the ending .html.
        MissingDependency : the viewer was not built; the message says what to do.
        """
        if not os.fsdecode(path).lower().endswith((".html", ".htm")):
            raise InvalidInput(f"{os.fsdecode(path)}: a view is a page; give it the ending .html")
        with whole(path) as stream:
            for block in page(self.scene):
                stream.write(block)

    def show(self) -> None:
        """Show it where one is: in the notebook, or in a browser; where there is no display, over
        ssh say, the file's name and what to do are printed.

        Raises
        ------
        MissingDependency : the viewer was not built; the message says what to do.
        """
        if _in_notebook():
            import_module("IPython.display").display(self)
            return
        path = Path(tempfile.mkdtemp(prefix="henkei-")) / "view.html"
        self.write(path)
        if not (_has_display() and webbrowser.open(path.as_uri())):
            print(f"{path}\nThere is no display here: copy this file to where there is one, or")
            print("serve it and forward the port: python -m http.server --bind 127.0.0.1")


def view(
    source: Any,
    scalars: Any = None,
    *,
    colormap: str | None = None,
    range: tuple[float, float] | None = None,
    title: str | None = None,
    height: int = HEIGHT,
    edges: bool | None = None,
    marks: Any = None,
    lines: Any = None,
    up: Literal["y", "z"] = "y",
) -> View:
    """A view of a surface or a result, to turn and to zoom: at the end of a notebook's cell it
    shows itself; ``.show()`` opens a browser, ``.write("view.html")`` keeps a file.

    Nothing is served and nothing is loaded, so it works over ssh, offline, and in a notebook that
    was exported to HTML.

    Parameters
    ----------
    source : a mesh, what :meth:`henkei.Mesh.from_any` takes, or a result: of :func:`henkei.combine`
        and :func:`henkei.register` with a slider from one shape to the other, of a shape model with
        one for each of the first modes.
    scalars : what the colours are: values (n,) of the vertices or (m,) of the faces, with NaN for
        none; colours (n, 3) or (m, 3) in [0, 1]; the name of an attribute; or a dict of such values
        by name, to choose from. Integers and booleans are told apart as labels.
    colormap : "viridis", "magma", "coolwarm", "quality" (red is low) or "categorical".
    range : the values at both ends of the colour map; the least and the largest by default.
    title : over the picture.
    height : pixels that it takes in a notebook.
    edges : whether the edges of faces are drawn at first.
    marks : vertices (k,) or points (k, 3) with dots, or a dict of places by label.
    lines : a line through vertices (k,) or points (k, 3), or a list of such lines.
    up : the axis that is upward.

    Raises
    ------
    InvalidInput : the source is nothing that can be shown, it has no faces or more than two
        million, or values, marks or lines do not fit it.
    """
    scene = scene_of(source)
    require_shown(scene.surface)
    if scalars is not None or colormap is not None or range is not None:
        scene = scene.coloured(_chosen(scene, scalars), colormap, range)
    if title is not None:
        scene = replace(scene, title=str(title))
    if edges is not None:
        scene = replace(scene, edges=bool(edges))
    if marks is not None:
        scene = replace(scene, marks=marks_on(marks, scene.surface))
    if lines is not None:
        scene = replace(scene, lines=lines_on(lines, scene.surface))
    if up not in ("y", "z"):
        raise InvalidInput(f"up is 'y' or 'z', not {up!r}")
    if isinstance(height, bool) or not isinstance(height, int) or not 100 <= height <= 10_000:
        raise InvalidInput(f"height is a number of pixels from 100 to 10000, not {height!r}")
    return View(replace(scene, up=up), height)


def scene_of(source: Any) -> Scene:
    """What there is to see of a surface or a result.

    Raises
    ------
    InvalidInput : the source is neither, nor what :meth:`henkei.Mesh.from_any` takes.
    """
    if isinstance(source, View):
        return source.scene
    if isinstance(source, Shown):
        return source._scene_()
    from henkei.interchange import surface_from

    return Scene.of(surface_from(source))


def represented(shown: Shown) -> str:
    """How a surface or result shows itself in a notebook. Never raises: where there is no picture,
    there are figures."""
    try:
        scene = shown._scene_()
        about = "" if isinstance(shown, Surface) else repr(shown)
        if scene.surface.face_count > OF_ITSELF:
            note = f"{about} Too large to be shown unasked; henkei.view(...) shows it."
            return figures(scene.surface, note.strip())
        return _output(View(scene), about)
    except Exception:  # a design that cannot be solved, say, which its own methods tell
        return escape(repr(shown))


def _output(view: View, about: str = "") -> str:
    """HTML for a notebook: the page in a frame of its own, where no name in it can do harm."""
    surface = view.scene.surface
    try:
        text = b"".join(page(view.scene)).decode()
    except HenkeiError as error:
        return figures(surface, f"{about} There is no picture: {error}".strip())
    return OUTPUT.format(
        figures=figures(surface, about),
        height=view.height,
        title=escape(view.scene.title or "Surface"),
        page=escape(text),
    )


def _chosen(scene: Scene, scalars: Any) -> Any:
    """The values to show; where only a colour map was chosen, those that are seen already."""
    if scalars is not None:
        return scalars
    if scene.shown is None:
        raise InvalidInput("a colormap or a range is for scalars; give some")
    return scene.colourings[scene.shown].name


def _in_notebook() -> bool:
    """Whether a notebook's kernel runs this, which shows HTML."""
    shell = sys.modules.get("IPython")
    running = shell.get_ipython() if shell is not None else None
    return type(running).__name__ == "ZMQInteractiveShell"


def _has_display() -> bool:
    """Whether a browser that is opened here is seen by whoever asks."""
    if sys.platform == "win32":
        return True
    if sys.platform == "darwin":
        return "SSH_CONNECTION" not in os.environ
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
