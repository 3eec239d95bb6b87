"""What a page is given to play a morph by itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import henkei as hk
from henkei.errors import InvalidInput
from henkei.recipes.morph import Morph
from henkei.shapes import random_disk
from henkei.studio.blobs import Blobs
from henkei.studio.morphs import MOST_TURNED, delay, require_turnable, time_of
from henkei.studio.services import Services
from henkei.workflows.morph_by_recipe import way_of

MORPH = Morph(sweep="left")


@pytest.fixture(scope="module")
def result() -> hk.CombinedMesh:
    return hk.combine(random_disk(0, 20), random_disk(1, 25), pairs="auto")


def test_vertices_start_when_they_do_in_what_is_exported(
    tmp_path: Path, result: hk.CombinedMesh
) -> None:
    services = Services(Blobs(tmp_path))
    blob = services.blobs.put_result(result)
    made = delay(MORPH, blob, services)
    assert made is not None
    values = services.blobs.get_message(made).arrays["values"]
    assert np.array_equal(values, way_of(MORPH, result)["delay"].astype(np.float32))
    assert delay(MORPH, blob, services) == made
    assert delay(Morph(sweep="top"), blob, services) != made
    assert delay(Morph(), blob, services) is None


def test_a_page_is_not_sent_more_than_it_can_turn() -> None:
    require_turnable(MOST_TURNED)
    with pytest.raises(InvalidInput, match=f"{MOST_TURNED + 1:,} vertices are too many to turn"):
        require_turnable(MOST_TURNED + 1)


def test_shapes_are_named_by_times() -> None:
    assert time_of("0.25") == 0.25
    with pytest.raises(InvalidInput, match="a time from 0 to 1 names a shape, not 'half'"):
        time_of("half")
