"""The package's own names, which are loaded at first use."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import henkei as hk


def test_every_name_is_there():
    assert set(hk.__all__) <= set(dir(hk))
    for name in hk.__all__:
        assert getattr(hk, name) is not None
    with pytest.raises(AttributeError, match="nothing"):
        hk.nothing  # noqa: B018


def test_type_checkers_see_the_same_names():
    tree = ast.parse(Path(hk.__file__).read_text())
    block = next(node for node in tree.body if isinstance(node, ast.If))
    seen = {alias.name for node in block.body for alias in node.names}  # type: ignore[attr-defined]
    assert seen == set(hk.__all__)


def run(code: str) -> str:
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_import_alone_loads_no_numpy():
    assert run("import sys, henkei; print('numpy' in sys.modules)") == "False"


def test_the_function_is_not_hidden_by_the_package_of_its_name():
    code = "import henkei, henkei.combine.pipeline; print(henkei.combine.__name__, end=' ');"
    code += "from henkei import combine; print(callable(combine))"
    assert run(code) == "combine True"


def test_star_import():
    assert run("from henkei import *; print(combine.__name__, Mesh.__name__)") == "combine Mesh"
