"""What all tabs share."""

from __future__ import annotations

import pytest

from henkei.recipes.combine import CombineRecipe
from henkei.recipes.quad import QuadRecipe
from henkei.studio.tabs.base import digest


@pytest.mark.parametrize(
    ("other", "same"),
    [
        (CombineRecipe.of({"pairs": [[1, 2]], "about": "ears", "$schema": "combine.json"}), True),
        (CombineRecipe.of({"pairs": [[1, 2]], "morph": {"path": "rotation"}}), True),
        (CombineRecipe.of({"pairs": [[1, 3]]}), False),
        (CombineRecipe.of({"pairs": [[1, 2]], "align": True}), False),
    ],
)
def test_a_result_belongs_to_what_its_recipe_makes(other: CombineRecipe, same: bool) -> None:
    one = digest(CombineRecipe.of({"pairs": [[1, 2]]}))
    assert (digest(other) == one) is same
    assert digest(CombineRecipe.of({"pairs": [[1, 2]]}), "m3") != one


def test_a_recipe_without_a_morph_has_a_digest_too() -> None:
    assert digest(QuadRecipe(about="a part")) == digest(QuadRecipe()) != digest(QuadRecipe(seed=1))
