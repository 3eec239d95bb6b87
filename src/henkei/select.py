"""Regions of a surface for fixing, moving and keeping: by place, loop, crease, label or lasso.

All functions are those of :mod:`henkei.geometry.selection`.
"""

from henkei.geometry.selection import (
    Camera,
    Chain,
    boundary_loop,
    grown,
    in_box,
    in_lasso,
    in_sphere,
    labelled,
    near_line,
    sharp_chain,
    sharp_chains,
)

__all__ = [
    "Camera",
    "Chain",
    "boundary_loop",
    "grown",
    "in_box",
    "in_lasso",
    "in_sphere",
    "labelled",
    "near_line",
    "sharp_chain",
    "sharp_chains",
]
