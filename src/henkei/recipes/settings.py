"""Settings of a method in a recipe: any fields of its dataclass, by their names."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import fields
from typing import Any, get_type_hints

from pydantic import ConfigDict, ValidationError, create_model

from henkei.errors import InvalidInput
from henkei.recipes.recipe import Part, fault, reason


class _Strict(Part):
    model_config = ConfigDict(strict=True)


class SettingsOf:
    """What a recipe may say of a method's settings.

    Parameters
    ----------
    kind : the dataclass; it raises InvalidInput where a value is out of its range.
    method : how readers know it.
    without : fields that the recipe has elsewhere.
    """

    def __init__(
        self, kind: Callable[..., Any], method: str, without: Collection[str] = ()
    ) -> None:
        self._kind = kind
        hints = get_type_hints(kind)
        known: dict[str, Any] = {
            f.name: (hints[f.name], f.default)
            for f in fields(kind)  # type: ignore[arg-type]
            if f.name not in without
        }
        about = f"Of the method, see {method}."
        self._model = create_model("Settings", __base__=_Strict, __doc__=about, **known)

    @property
    def schema(self) -> dict[str, Any]:
        """JSON schema of them."""
        return self._model.model_json_schema()

    def checked(self, given: dict[str, Any]) -> dict[str, Any]:
        """The same settings, for a validator; a fault names the field."""
        try:
            self._model.model_validate(given)
            self._kind(**given)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            place = first.get("ctx", {}).get("place", ())
            raise fault(reason(first), *first["loc"], *place) from None
        except InvalidInput as error:
            raise fault(str(error)) from None
        return given
