"""Quads: any triangle mesh becomes one of quadrilaterals only, with a guarantee.

After Okabe and Sugihara (2009). The steps, each in a file of its own, are named in ``pipeline``.
"""

from henkei.quad.cage import quad_cage
from henkei.quad.pipeline import quadrangulate
from henkei.quad.quality import QuadQuality
from henkei.quad.result import QuadResult

__all__ = ["QuadQuality", "QuadResult", "quad_cage", "quadrangulate"]
