"""Many meshes at once: one after the other, on the cores of a machine, or on a Dask cluster."""

from henkei.batch.pipeline import register_many
from henkei.batch.report import Report, Row

__all__ = ["Report", "Row", "register_many"]
