"""Bends a surface while its form features keep their shape: H. Masuda, Y. Yoshioka, Y. Furukawa,
"Feature-preserving interactive mesh deformation" (2006)."""

from henkei.deform.constraints import Feature, Fixed, Handle, Pin
from henkei.deform.deformer import Deformer
from henkei.deform.quality import DeformQuality
from henkei.deform.settings import Settings

__all__ = ["DeformQuality", "Deformer", "Feature", "Fixed", "Handle", "Pin", "Settings"]
