"""A quick stand-in for the method of registration, which worker processes can import too."""

from __future__ import annotations

import os
import warnings
from typing import Any

import numpy as np

import henkei as hk
from henkei.geometry.alignment import Similarity
from henkei.geometry.correspondence import Correspondence, SurfacePoints
from henkei.progress import Progress, silent
from henkei.register import Registration
from henkei.register.quality import RegisterQuality

REFUSED, FAULTY, DEADLY, WARNED = 31, 32, 33, 34  # vertices of targets that are trouble


def registered(
    source: hk.Mesh,
    target: hk.Mesh,
    *,
    mediator: str | hk.Mesh = "sphere",
    landmarks: Any = (),
    regions: Any = None,
    seed: int = 0,
    settings: Any = None,
    progress: Progress = silent,
    watch: Any = None,
) -> Registration:
    """Vertex i of the source at a corner of face i of the target, if there is one."""
    progress("placing", 0.5)
    size = len(target.vertices)
    if size == REFUSED:
        raise hk.errors.NotClosed("target: 7 boundary loops")
    if size == FAULTY:
        raise ZeroDivisionError("an oversight")
    if size == DEADLY:
        os._exit(1)
    if size == WARNED:
        warnings.warn("target: 3 vertices are not used", stacklevel=2)
    faces = np.arange(len(source.vertices), dtype=np.int32) % len(target.faces)
    weights = np.tile([1.0, 0.0, 0.0], (len(faces), 1))
    return Registration(
        Correspondence(
            source.faces,
            source.vertices,
            target.vertices[target.faces[faces, 0]],
            SurfacePoints(np.zeros_like(faces), weights),
            SurfacePoints(faces, weights),
        ),
        target.faces,
        size,
        np.asarray(landmarks, dtype=np.int32).reshape(-1, 2)[:, 0],
        Similarity(np.eye(3), 1.0, np.zeros(3)),
        quality(source, seed / 100),
    )


def quality(source: hk.Mesh, mean: float) -> RegisterQuality:
    """Figures that tell which seed was used."""
    nothing = dict.fromkeys(RegisterQuality.__dataclass_fields__, 0)
    own = {"vertices": len(source.vertices), "faces": len(source.faces), "to_source_mean": mean}
    return RegisterQuality(**{**nothing, **own})
