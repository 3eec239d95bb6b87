"""Region labels: what has a label goes to where the target has it."""

from __future__ import annotations

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidInput
from henkei.register import Settings
from henkei.shapes import humanoid

SOURCE, TARGET = humanoid(), humanoid(arms_angle=80.0, leg_length=1.0)


def head(mesh):
    """1 for the tenth of the vertices that is highest, 0 for the others."""
    height = mesh.vertices[:, 1]
    return (height > np.quantile(height, 0.9)).astype(int)


LABELS = head(SOURCE), head(TARGET)


def agreement(result):
    return (result.pull(LABELS[1]) == LABELS[0]).mean()


def test_regions_go_to_regions():
    without = hk.register(SOURCE, TARGET)
    labelled = hk.register(SOURCE, TARGET, regions=LABELS)
    assert agreement(without) < 0.98  # else the labels have nothing to do
    assert agreement(labelled) > 0.995
    assert labelled.quality.inverted == 0


@pytest.mark.parametrize(
    ("regions", "told"),
    [
        ((LABELS[0], 0 * LABELS[1]), "label 1 is on the source but on no vertex of the target"),
        ((0 * LABELS[0], LABELS[1]), "label 1 is on the target but on no vertex of the source"),
        ((LABELS[0][:3], LABELS[1]), "regions of the source must be 3854 integers"),
        ((LABELS[0], LABELS[1] * 0.5), "regions of the target must be .* float64"),
        (LABELS[0], "regions are a pair"),
    ],
)
def test_unusable_labels(regions, told):
    with pytest.raises(InvalidInput, match=told):
        hk.register(SOURCE, TARGET, regions=regions)


def test_the_literal_form_has_no_regions():
    with pytest.raises(InvalidInput, match="regions"):
        hk.register(SOURCE, TARGET, regions=LABELS, settings=Settings(rule="literal"))
