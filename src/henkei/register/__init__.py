"""One mesh onto any other: S. Matsui, K. Morooka, H. Nagahashi, "3-D morphing by direct mapping
between mesh models using Self-organizing Deformable Model"."""

from henkei.register.pipeline import register
from henkei.register.quality import RegisterQuality
from henkei.register.registration import Registration
from henkei.register.settings import Settings

__all__ = ["RegisterQuality", "Registration", "Settings", "register"]
