"""Many shapes over one connectivity: aligned, their mean, and how they vary about it."""

from henkei.statistics.curves import Curve
from henkei.statistics.pipeline import shape_model
from henkei.statistics.procrustes import Procrustes, procrustes
from henkei.statistics.shape_model import ShapeModel

__all__ = ["Curve", "Procrustes", "ShapeModel", "procrustes", "shape_model"]
