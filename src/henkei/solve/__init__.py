"""Sparse linear systems: factor once, solve often."""

from henkei.solve.factor import Factor, factor_general, factor_spd

__all__ = ["Factor", "factor_general", "factor_spd"]
