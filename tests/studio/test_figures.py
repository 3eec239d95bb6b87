"""Figures of quality are kept as they are told."""

from __future__ import annotations

import numpy as np

from henkei.studio.figures import Figure, figure


def test_figures_are_kept_as_they_are_told() -> None:
    row = figure("Growth", 1.5, "in the mean", True, "%")
    assert Figure.model_validate(row).model_dump() == row
    assert Figure.model_validate(figure("Faces", 3)) == Figure(label="Faces", value=3)
    assert Figure.model_validate(figure("Off", 0.5, bad=np.float64(1.0) > 0)).bad
