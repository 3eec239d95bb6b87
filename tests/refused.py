"""A recipe with one wrong value is refused by name, and in a file by its line too."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from henkei.errors import InvalidFile, InvalidInput
from henkei.recipes.recipe import Recipe


def assert_refused(
    kind: type[Recipe], good: dict, place: tuple[str | int, ...], value: Any, told: str, path: Path
) -> None:
    """The message says what is ``told`` if the good recipe has another value at the place."""
    data = deepcopy(good)
    here: Any = data
    for step in place[:-1]:
        here = here[step]
    here[place[-1]] = value
    with pytest.raises(InvalidInput) as caught:
        kind.of(data)
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)
    path.write_text(json.dumps(data, indent=1))
    with pytest.raises(InvalidFile) as refused:
        kind.read(path)
    start, _, rest = str(refused.value).partition(": ")
    assert start.startswith(f"{path}, line ")
    assert rest == str(caught.value)
