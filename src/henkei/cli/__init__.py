"""The program ``henkei``. A command's module is imported when the command runs."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from cyclopts import App, CycloptsError, Parameter

from henkei.cli.console import errors, tidy_warnings
from henkei.errors import HenkeiError

DONE, BROKEN_PIPE, REFUSED, INTERRUPTED = 0, 1, 2, 130  # exit status; 3 is some of many done

COMMANDS = {
    "info": "Say what meshes are, what is wrong with them, and which commands take them.",
    "features": "List the form features of a mesh: holes, rims, bosses, lines, planar pads.",
    "quad": "Make any triangle mesh into quads only, of the same topology.",
    "design": "Design a smooth surface from a coarse cage, with constraints at every level.",
    "deform": "Bend a mesh by a recipe; its holes, lines and pads keep their shape.",
    "combine": "Combine two disks into one mesh that carries both surfaces exactly.",
    "register": "Register a mesh onto any other, or many scans into one connectivity.",
    "stats": "Mean, modes and variance of shapes in one connectivity.",
    "morph": "Write the way from one shape to another: glTF, USD, meshes, pictures, films.",
    "studio": "Open all five methods in a browser, to work on meshes by hand.",
    "demo": "Combine and morph two built-in heads, and show the result on a page.",
}


def version() -> str:
    """Name and version."""
    import henkei

    return f"henkei {henkei.__version__}"


def program(arguments: Sequence[str] = ()) -> App:
    """The program with all its commands, none of them loaded.

    A command that the arguments name tells its own help; the others have their lines for the list.
    """
    app = App(
        name="henkei",
        help="Change the form of surfaces: combine or register two meshes, put many into one "
        "connectivity, morph between them, make them into quads, design smooth ones from cages.",
        help_format="markdown",
        version=version,
        default_parameter=Parameter(negative=()),
        error_console=errors(),
        suppress_keyboard_interrupt=False,
    )
    for name, help_text in COMMANDS.items():
        line = None if name in arguments else help_text
        app.command(f"henkei.cli.{name}:{name}", name=name, help=line)
    return app


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program with these arguments, or those it was started with; the exit status."""
    with tidy_warnings():
        try:
            status = _run(sys.argv[1:] if arguments is None else arguments)
            sys.stdout.flush()
        except BrokenPipeError:
            # The reader has gone; what is still buffered must not fail again at exit.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return BROKEN_PIPE
        return status


def _run(arguments: Sequence[str]) -> int:
    try:
        program(arguments)(list(arguments), exit_on_error=False, result_action="return_value")
    except CycloptsError:
        return REFUSED
    except HenkeiError as error:
        return _refused(str(error))
    except MemoryError:
        return _refused("there is not enough memory for this; try smaller meshes or fewer frames")
    except KeyboardInterrupt:
        errors().print("interrupted")
        return INTERRUPTED
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else DONE
    return DONE


def _refused(reason: str) -> int:
    from rich.text import Text

    console = errors()
    text = Text.assemble(("henkei: ", "bold red"), reason)
    console.print(text, soft_wrap=not console.is_terminal)
    return REFUSED
