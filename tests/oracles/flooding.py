"""Flooding of patches, slowly: all claims are looked at each time a face is to be taken."""

from __future__ import annotations


def flood(neighbours, normals, centres, seeds, patch_normals, patch_centres, compactness):
    """Patch of each face: again and again the claim of least error is granted, of equal ones that
    on the lower face, then that of the lower patch."""
    label = [-1] * len(neighbours)
    for patch, seed in enumerate(seeds):
        label[seed] = patch
    while True:
        claims = [
            (
                squared(normals[face], patch_normals[patch])
                + compactness * squared(centres[face], patch_centres[patch]),
                face,
                patch,
            )
            for taken, patch in enumerate(label)
            if patch >= 0
            for face in neighbours[taken]
            if face >= 0 and label[face] < 0
        ]
        if not claims:
            return label
        _, face, patch = min(claims)
        label[face] = patch


def squared(a, b) -> float:
    x, y, z = (float(p) - float(q) for p, q in zip(a, b, strict=True))
    return x * x + y * y + z * z
