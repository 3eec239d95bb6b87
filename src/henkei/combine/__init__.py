"""Two disks in one mesh, by overlaying their harmonic maps (Kanai, Suzuki, Kimura 1999)."""

from henkei.combine.combined import CombinedMesh, CombineQuality
from henkei.combine.pipeline import combine

__all__ = ["CombineQuality", "CombinedMesh", "combine"]
