"""The page about the demonstration."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from henkei.combine import CombinedMesh

STYLE = """
:root { color-scheme: light dark; --ink: #23211e; --soft: #6b665e; --line: #dcd8cf;
  --paper: #f6f5f2; --link: #1d55b0; }
@media (prefers-color-scheme: dark) { :root { --ink: #e9e6e0; --soft: #a19b91; --line: #3b3833;
  --paper: #1d1b19; --link: #8db4f2; } }
body { margin: 0 auto; max-width: 62rem; padding: 2rem 1.25rem 4rem; background: var(--paper);
  color: var(--ink); font: 16px/1.55 system-ui, sans-serif; }
h1 { font-size: 1.7rem; margin: 0 0 .5rem; } h2 { font-size: 1.15rem; margin: 2.5rem 0 .5rem; }
p { max-width: 44rem; } figure { margin: 1rem 0; } a { color: var(--link); }
img { max-width: 100%; height: auto; border-radius: 6px; background: #f6f5f2; display: block; }
figcaption { color: var(--soft); font-size: .9rem; margin-top: .4rem; max-width: 50rem; }
.blue { color: #4a86e8; } .orange { color: #e0762f; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
td, th { padding: .3rem 1.2rem .3rem 0; border-bottom: 1px solid var(--line); text-align: left;
  font-weight: normal; vertical-align: top; }
td + td { text-align: right; } td + td + td, .words td + td { text-align: left; }
.words td + td + td { display: none; }
.wide, pre { overflow-x: auto; } code, pre { font-size: .92em; }
"""

Row = tuple[str, str, str]


def page(combined: CombinedMesh, files: Mapping[str, str], missing: str) -> str:
    """HTML about the combined heads, with links to files beside it.

    Parameters
    ----------
    combined : the result.
    files : what each file in the folder is, by name.
    missing : why there are no pictures, or "".
    """
    a, b = len(combined.vertex_of_a), len(combined.vertex_of_b)
    parts = [
        "<h1>Two heads, one mesh</h1>",
        f"<p>The two heads are separate models: {a:,} and {b:,} vertices, connected differently. "
        f"{len(combined.pairs)} pairs of vertices on the boundaries (the necks) and "
        f"{len(combined.landmarks)} inside (eyes, brows, nose, mouth, chin, ears) say what "
        "corresponds. Both were flattened into one polygon and overlaid there. The combined mesh "
        "has all vertices of both and one wherever their edges cross, so it takes the shape of "
        "either head, and of everything between.</p>",
    ]
    if missing:
        parts.append(f"<p><strong>No pictures:</strong> {escape(missing)}.</p>")
    for name, alternative, caption in _FIGURES:
        if name in files:
            parts.append(
                f'<figure><img src="{name}" alt="{escape(alternative)}">'
                f"<figcaption>{caption}</figcaption></figure>"
            )
    parts += [
        "<h2>How good it is</h2>",
        _table("", [(label, value, why) for label, value, why in _quality(combined)]),
        "<h2>Files</h2>",
        _table(
            ' class="words"',
            [
                (f'<a href="{escape(name)}">{escape(name)}</a>', escape(what), "")
                for name, what in files.items()
            ],
        ),
        "<h2>The same by hand</h2>",
        "<pre>henkei combine woman.ply goblin.ply --pairs pairs.json --landmarks pairs.json "
        "-o combined.npz\n"
        "henkei morph combined.npz --no-align --time smoothstep -o morph.glb</pre>",
    ]
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>henkei: two heads, one mesh</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body>\n</html>\n"
    )


_FIGURES: tuple[Row, ...] = (
    (
        "strip.png",
        "Five heads from the first to the second",
        "From head a to head b. Each vertex moves on a straight line; the mesh is the same in all.",
    ),
    ("morph.gif", "The morph as a film", "The morph. In <code>morph.glb</code> it can be turned."),
    (
        "plane.png",
        "Both flattened heads and a part of their overlay",
        'The common plane: <span class="blue">a</span>, <span class="orange">b</span>, and the '
        "overlay around the tip of a's nose, enlarged. A dot marks each place where an edge of a "
        "crosses an edge of b; grey edges split faces with more than three corners.",
    ),
)


def _quality(combined: CombinedMesh) -> list[Row]:
    q = combined.quality
    return [
        ("vertices", f"{q.vertices:,}", f"{q.crossings:,} of them where edges cross"),
        ("edges", f"{q.edges:,}", ""),
        ("faces", f"{q.faces:,}", ""),
        ("V &minus; E + F", str(q.euler), "1 for a disk"),
        ("inverted faces", str(q.inverted), "in the common plane, decided in exact arithmetic"),
        ("area error, a", f"{q.area_error_a:.1e}", "combined mesh against head a, relative"),
        ("area error, b", f"{q.area_error_b:.1e}", "combined mesh against head b, relative"),
        ("vertex error, a", f"{q.vertex_error_a:.1e}", "largest, as a fraction of the diagonal"),
        ("vertex error, b", f"{q.vertex_error_b:.1e}", "largest, as a fraction of the diagonal"),
        ("flattened with", escape(q.weights_a), f"weights; b: {escape(q.weights_b)}"),
    ]


def _table(attributes: str, rows: list[Row]) -> str:
    lines = ["<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows]
    return f'<div class="wide"><table{attributes}>\n' + "\n".join(lines) + "\n</table></div>"
