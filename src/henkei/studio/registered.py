"""What tells how a registration came out: heat maps, figures, warnings."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from henkei.geometry.distance import ClosestPoints
from henkei.mesh import Floats, Mesh
from henkei.register import Registration
from henkei.register.quality import RegisterQuality, stretch_ratios
from henkei.studio.figures import figure

if TYPE_CHECKING:
    from henkei.studio.blobs import Blobs

PERCENT = 100.0
DIAGONAL = "% of the diagonal"
LEAST_DISTANCE = 1e-3  # percent that the range of a heat map goes to
LEAST_GROWTH = 0.1  # powers of two, likewise
LEAST_STRETCH = 1.1
MOST_OF_IT = 0.99  # of faces or vertices, that a range covers: the worst would hide the rest
MISSED = 0.03  # of the diagonal: what is not reached so far is a part, not a detail
COARSE = 0.01  # the same, in the mean
FEW = 1e-3  # of the faces
OFF = 1e-6  # of the diagonal: more than rounding


def apart(result: Registration, target: Mesh) -> Floats:
    """Distance (n,) of the target's vertices from the model, as fractions of the target's diagonal;
    NaN for vertices that no face has."""
    away = ClosestPoints(result.mesh).query(target.vertices)[1] / target.diagonal
    away[target.topology.unused_vertices] = np.nan
    return np.asarray(away)


def colours(
    result: Registration, target: Mesh, unreached: Floats, blobs: Blobs
) -> list[dict[str, Any]]:
    """Heat maps of the model, and of the target.

    Parameters
    ----------
    unreached : (n,) as :func:`apart` gives it.
    """
    away = PERCENT * _off(result, target)
    grown = _growth(result)
    stretched = _stretch(result)
    most = max(_most_of(np.abs(grown)), LEAST_GROWTH)
    return [
        _colour("Distance from the target", "model", "face", away, blobs, unit=DIAGONAL),
        _colour(
            "Target not reached", "target", "vertex", PERCENT * unreached, blobs, unit=DIAGONAL
        ),
        {
            **_colour("Growth", "model", "face", grown, blobs, unit="doublings of area"),
            "colormap": "coolwarm",
            "limits": (-most, most),
        },
        {
            **_colour("Stretch", "model", "face", stretched, blobs, unit="longest by shortest"),
            "colormap": "viridis",
            "limits": (1.0, max(_most_of(stretched), LEAST_STRETCH)),
        },
    ]


def figures(result: Registration) -> list[dict[str, Any]]:
    """What tells whether to trust it: rows of label and value, with ``bad`` where one is not as it
    should be."""
    q = result.quality
    reached = "how far the target's vertices are from the model: what it does not reach"
    rows = [
        _length("Target off the model, mean", q.to_source_mean, reached, COARSE),
        _length(
            "Target off the model, largest",
            q.to_source_max,
            "large where a part is missed, such as a finger or an ear: set a landmark there",
            MISSED,
        ),
        _length(
            "Model off the target, mean",
            q.to_target_mean,
            "how far the model's vertices are from the target: rounding only",
            OFF,
        ),
        _length("Model off the target, largest", q.to_target_max, "", OFF),
    ]
    if len(result.landmarks):
        hint = "the farthest that one is from its counterpart: rounding only"
        rows.append(_length("Landmarks off their places", q.landmark_error, hint, OFF))
    rows += [
        figure(
            "Faces turned over",
            q.inverted,
            "on the sphere on which both meet: there are none",
            bad=q.inverted > 0,
        ),
        figure(
            "Faces the wrong way round",
            q.flipped,
            "they look against the target: none, or a few",
            bad=q.flipped_fraction > FEW,
        ),
        figure(
            "Faces that intersect others",
            q.self_intersecting,
            f"of the target it is {q.self_intersecting_target:.2%} of the faces",
            bad=_crossed(q),
        ),
    ]
    if q.bridged:
        hint = "the target has holes there; they continue the surface around smoothly"
        rows.append(figure("Vertices in holes of the target", q.bridged, hint))
    return [
        *rows,
        figure(
            "Change of area",
            _rounded(q.area_distortion),
            "spread of the logarithm of how faces grow: below 1 between shapes with the same parts",
        ),
        figure(
            "Stretch of faces",
            _rounded(q.angle_distortion),
            "longest by shortest, in the mean: near 1 between shapes that are alike, 2 to 4 "
            "between others",
        ),
    ]


def warnings(result: Registration) -> list[str]:
    """What a person should look at, and what helps."""
    q = result.quality
    told = []
    if q.to_source_max > MISSED:
        told.append(
            f"A part of the target is not reached: up to {q.to_source_max:.1%} of the diagonal is "
            "between it and the model. Colour by “Target not reached” to see where, and set a "
            "landmark there."
        )
    if q.to_target_mean > OFF:
        told.append(
            "The model is not on the target, as is usual with the literal rule, which is for "
            "study. Take the rule Nearest."
        )
    if q.flipped_fraction > FEW:
        told.append(
            f"{q.flipped:,} faces lie on the target the wrong way round. Landmarks near them help, "
            "and more weight on the form of faces."
        )
    if _crossed(q):
        told.append(
            f"{q.self_intersecting:,} faces intersect others. Landmarks near them help, and more "
            "weight on the form of faces."
        )
    if q.bridged:
        told.append(
            f"{q.bridged:,} vertices are in holes of the target. They continue the surface around "
            "smoothly, and are tinted on the model."
        )
    return told


def _crossed(q: RegisterQuality) -> bool:
    """Whether more faces intersect others than the target itself accounts for."""
    return q.self_intersecting_fraction > q.self_intersecting_target + FEW


def _off(result: Registration, target: Mesh) -> Floats:
    """Distance (m,) of the model's faces from the target, at the middles of face and edges, the
    largest of these; as fractions of the target's diagonal. NaN in holes of the target."""
    corners = result.mesh.vertices[result.faces]
    middles = (corners + np.roll(corners, -1, axis=1)) / 2
    places = np.concatenate([middles, corners.mean(axis=1, keepdims=True)], axis=1)
    away = ClosestPoints(target).query(places.reshape(-1, 3))[1]
    largest: Floats = away.reshape(len(places), -1).max(axis=1, initial=0.0) / target.diagonal
    bridged = (result.on_target.face[result.faces] < 0).any(axis=1)
    return np.where(bridged, np.nan, largest)


def _growth(result: Registration) -> Floats:
    """Powers of two (m,) by which each face's share of the area grew; NaN where it has none."""
    pair = result.correspondence
    shares = [Mesh(v, pair.faces).face_areas for v in (pair.vertices_a, pair.vertices_b)]
    before, after = (one / (one.sum() or 1.0) for one in shares)
    with np.errstate(divide="ignore", invalid="ignore"):
        grown = np.log2(after / before)
    return np.where(np.isfinite(grown), grown, np.nan)


def _stretch(result: Registration) -> Floats:
    """Longest by shortest stretch (m,) of each face."""
    pair = result.correspondence
    return stretch_ratios(pair.vertices_a[pair.faces], pair.vertices_b[pair.faces])


def _most_of(values: Floats) -> float:
    """What most values do not exceed, to two digits; 0 of none."""
    known = values[np.isfinite(values)]
    return float(f"{np.quantile(known, MOST_OF_IT):.2g}") if len(known) else 0.0


def _colour(
    title: str, on: str, per: str, values: Floats, blobs: Blobs, unit: str
) -> dict[str, Any]:
    data = blobs.put_message({"kind": "values"}, values=values.astype(np.float32))
    return {
        "title": title,
        "on": on,
        "per": per,
        "data": data,
        "colormap": "heat",
        "limits": (0.0, max(_most_of(values), LEAST_DISTANCE)),
        "unit": unit,
    }


def _length(label: str, fraction: float, hint: str, most: float) -> dict[str, Any]:
    """A length as a share of the target's diagonal."""
    value = _rounded(PERCENT * fraction) if fraction > 1e-9 else 0
    hint = f"of the diagonal of the target's box; {hint}" if hint else ""
    return figure(label, value, hint, fraction > most, "%")


def _rounded(value: float) -> float:
    """To three digits."""
    return float(f"{value:.3g}")
