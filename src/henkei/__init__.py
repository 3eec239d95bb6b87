"""henkei: change the form of surfaces.

The names below are the public ones. Each is loaded at its first use, so that ``import henkei`` and
the program's ``--help`` cost next to nothing.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from henkei import errors, select, shapes
    from henkei.combine import CombinedMesh, combine
    from henkei.deform import Deformer
    from henkei.design import Designer, Pyramid
    from henkei.geometry.element_quality import element_quality
    from henkei.geometry.form_features import FormFeatures, find_features
    from henkei.geometry.model_motion import moved
    from henkei.geometry.repair import (
        largest_component,
        oriented,
        weld,
        without_degenerate_faces,
        without_unused_vertices,
    )
    from henkei.io import read, write
    from henkei.io.cae import read_model, write_model
    from henkei.io.view import view
    from henkei.mesh import Attributes, Mesh, PolygonMesh
    from henkei.morph import write_morph
    from henkei.morph.targets import blend, write_targets
    from henkei.quad import QuadResult, quadrangulate
    from henkei.recipes.combine import CombineRecipe
    from henkei.recipes.deform import DeformRecipe
    from henkei.recipes.design import DesignRecipe
    from henkei.recipes.quad import QuadRecipe
    from henkei.recipes.register import RegisterRecipe
    from henkei.register import Registration, register
    from henkei.statistics import ShapeModel, procrustes, shape_model
    from henkei.workflows.combine_by_recipe import combine_by_recipe
    from henkei.workflows.deform_by_recipe import deform_by_recipe
    from henkei.workflows.design_by_recipe import design_by_recipe
    from henkei.workflows.diagnose import diagnose
    from henkei.workflows.quad_by_recipe import quad_by_recipe
    from henkei.workflows.quad_files import write_layout, write_quads
    from henkei.workflows.register_by_recipe import register_by_recipe
    from henkei.workflows.results import load, save
    from henkei.workflows.taken_up import TakenUp, take_up

__all__ = [
    "Attributes",
    "CombineRecipe",
    "CombinedMesh",
    "DeformRecipe",
    "Deformer",
    "DesignRecipe",
    "Designer",
    "FormFeatures",
    "Mesh",
    "PolygonMesh",
    "Pyramid",
    "QuadRecipe",
    "QuadResult",
    "RegisterRecipe",
    "Registration",
    "ShapeModel",
    "TakenUp",
    "blend",
    "combine",
    "combine_by_recipe",
    "deform_by_recipe",
    "design_by_recipe",
    "diagnose",
    "element_quality",
    "errors",
    "find_features",
    "largest_component",
    "load",
    "moved",
    "oriented",
    "procrustes",
    "quad_by_recipe",
    "quadrangulate",
    "read",
    "read_model",
    "register",
    "register_by_recipe",
    "save",
    "select",
    "shape_model",
    "shapes",
    "take_up",
    "view",
    "weld",
    "without_degenerate_faces",
    "without_unused_vertices",
    "write",
    "write_layout",
    "write_model",
    "write_morph",
    "write_quads",
    "write_targets",
]

_HOMES = {
    "henkei.combine": ("CombinedMesh", "combine"),
    "henkei.deform": ("Deformer",),
    "henkei.design": ("Designer", "Pyramid"),
    "henkei.geometry.element_quality": ("element_quality",),
    "henkei.geometry.form_features": ("FormFeatures", "find_features"),
    "henkei.geometry.model_motion": ("moved",),
    "henkei.geometry.repair": (
        "largest_component",
        "oriented",
        "weld",
        "without_degenerate_faces",
        "without_unused_vertices",
    ),
    "henkei.io": ("read", "write"),
    "henkei.io.cae": ("read_model", "write_model"),
    "henkei.io.view": ("view",),
    "henkei.mesh": ("Attributes", "Mesh", "PolygonMesh"),
    "henkei.morph": ("write_morph",),
    "henkei.morph.targets": ("blend", "write_targets"),
    "henkei.quad": ("QuadResult", "quadrangulate"),
    "henkei.recipes.combine": ("CombineRecipe",),
    "henkei.recipes.deform": ("DeformRecipe",),
    "henkei.recipes.design": ("DesignRecipe",),
    "henkei.recipes.quad": ("QuadRecipe",),
    "henkei.recipes.register": ("RegisterRecipe",),
    "henkei.register": ("Registration", "register"),
    "henkei.statistics": ("ShapeModel", "procrustes", "shape_model"),
    "henkei.workflows.combine_by_recipe": ("combine_by_recipe",),
    "henkei.workflows.deform_by_recipe": ("deform_by_recipe",),
    "henkei.workflows.design_by_recipe": ("design_by_recipe",),
    "henkei.workflows.diagnose": ("diagnose",),
    "henkei.workflows.quad_by_recipe": ("quad_by_recipe",),
    "henkei.workflows.quad_files": ("write_layout", "write_quads"),
    "henkei.workflows.register_by_recipe": ("register_by_recipe",),
    "henkei.workflows.results": ("load", "save"),
    "henkei.workflows.taken_up": ("TakenUp", "take_up"),
}
_HOME_OF = {name: module for module, names in _HOMES.items() for name in names}
_MODULES = ("errors", "select", "shapes")


def __getattr__(name: str) -> Any:
    if name in _MODULES:
        return import_module(f"henkei.{name}")
    if name == "__version__":
        from importlib.metadata import version

        value: Any = version("henkei")
    elif name in _HOME_OF:
        value = getattr(import_module(_HOME_OF[name]), name)
    else:
        raise AttributeError(f"module 'henkei' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "__version__"})


class _Package(ModuleType):
    """Where a package and a function share a name (``combine``), the function has it."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in _HOME_OF and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
