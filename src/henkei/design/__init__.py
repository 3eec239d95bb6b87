"""Smooth surfaces from a coarse cage, with constraints at every level.

S. Takahashi: Designing subdivision surfaces via multiresolution-based local filtering (2000).
"""

from henkei.design.compression import (
    CompressionCurve,
    compressed,
    compression_curve,
    level_errors,
)
from henkei.design.conflicts import Conflict
from henkei.design.constraints import Constraint, Curve, Derivative, Pin
from henkei.design.designer import Designer
from henkei.design.drag import Drag
from henkei.design.pyramid import Pyramid
from henkei.design.quality import DesignQuality
from henkei.design.subdivision_connectivity import Unrefined, unrefined

__all__ = [
    "CompressionCurve",
    "Conflict",
    "Constraint",
    "Curve",
    "Derivative",
    "DesignQuality",
    "Designer",
    "Drag",
    "Pin",
    "Pyramid",
    "Unrefined",
    "compressed",
    "compression_curve",
    "level_errors",
    "unrefined",
]
