"""JSON as people write and read it: where things stand in the file, and a layout that is short."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from json.decoder import JSONDecoder
from pathlib import Path
from typing import Any

from henkei.errors import InvalidFile

Place = Sequence[str | int]

WIDTH = 100
SPACE = re.compile(r"[ \t\r\n]*")
EXACT_INTEGERS = 2.0**53  # up to here, every whole float is written without a point


def parsed(path: Path) -> tuple[str, Any]:
    """The text of a JSON file, and the data in it.

    Raises
    ------
    InvalidFile : the file is missing or no JSON, or an object has a key twice; says the line.
    """
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        raise InvalidFile(f"{path}: there is no such file") from None
    except (OSError, ValueError) as error:
        reason = "a folder, not a file" if path.is_dir() else f"cannot be read as text ({error})"
        raise InvalidFile(f"{path}: {reason}") from None
    try:
        data = json.loads(text, object_pairs_hook=_without_repeats)
    except json.JSONDecodeError as error:
        line, column, fault = _fault(error)
        raise InvalidFile(f"{path}, line {line}, column {column}: not JSON: {fault}") from None
    except _Repeated as error:
        lines = [number for number, line in enumerate(text.splitlines(), 1) if error.key in line]
        raise InvalidFile(
            f"{path}: an object has the key {error.key!r} twice (see lines {lines}); keep one"
        ) from None
    except (RecursionError, ValueError) as error:
        raise InvalidFile(f"{path}: not usable as JSON ({error})") from None
    return text, data


def line_of(text: str, place: Place) -> int:
    """The line, counted from 1, where the value at a place stands, or its key in an object.

    Parameters
    ----------
    text : valid JSON.
    place : keys and indices from the outermost value inwards. The first that is not there ends the
        search: the line is that of the innermost value that is.
    """
    position = _skip(text, 0)
    for depth, step in enumerate(place, 1):
        inside = dict(_members(text, position))
        if step not in inside:
            break
        key, position = inside[step]
        if depth == len(place):
            position = key
    return text.count("\n", 0, position) + 1


def pretty(data: Any) -> str:
    """JSON text in which what fits a line is on one line, and numbers fill lines.

    The same data give the same text, and the text gives the same data: floats are written as the
    shortest text that reads back the same, whole ones without a point.
    """
    return _laid_out(_plain(data), "", WIDTH) + "\n"


class _Repeated(Exception):
    def __init__(self, key: str) -> None:
        self.key = key


def _without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        raise _Repeated(next(key for key in keys if keys.count(key) > 1))
    return found


def _members(text: str, position: int) -> Iterable[tuple[str | int, tuple[int, int]]]:
    """Key or index of each member of the value here; where key and value stand (an item: twice)."""
    if text[position] not in "{[":
        return
    decode = JSONDecoder().raw_decode
    in_object = text[position] == "{"
    position = _skip(text, position + 1)
    index = 0
    while text[position] not in "}]":
        start, name = position, index
        if in_object:
            name, position = decode(text, position)
            position = _skip(text, _skip(text, position) + 1)
        yield name, (start, position)
        position = _skip(text, decode(text, position)[1])
        if text[position] == ",":
            position = _skip(text, position + 1)
        index += 1


def _skip(text: str, position: int) -> int:
    """The next position that holds no white space."""
    found = SPACE.match(text, position)
    return found.end() if found else position


def _plain(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_plain(value) for value in data]
    if isinstance(data, float) and data.is_integer() and abs(data) < EXACT_INTEGERS:
        return data if data == 0 and str(data).startswith("-") else int(data)
    return data


def _laid_out(data: Any, indent: str, taken: int) -> str:
    """The value after ``taken`` characters of its line, its further lines indented."""
    short = json.dumps(data, ensure_ascii=False)
    if taken + len(short) < WIDTH or not isinstance(data, dict | list) or not data:
        return short
    deeper = indent + "  "
    if isinstance(data, dict):
        heads = [json.dumps(key, ensure_ascii=False) + ": " for key in data]
        values = [
            _laid_out(value, deeper, len(deeper) + len(head))
            for head, value in zip(heads, data.values(), strict=True)
        ]
        items = [head + value for head, value in zip(heads, values, strict=True)]
        return _enclosed("{}", items, indent)
    if all(isinstance(value, int | float) for value in data):
        return _enclosed("[]", _filled(data, WIDTH - len(deeper)), indent)
    return _enclosed("[]", [_laid_out(value, deeper, len(deeper)) for value in data], indent)


def _enclosed(brackets: str, items: Sequence[str], indent: str) -> str:
    inner = f",\n{indent}  ".join(items)
    return f"{brackets[0]}\n{indent}  {inner}\n{indent}{brackets[1]}"


def _filled(numbers: Sequence[float], width: int) -> list[str]:
    """Lines of numbers with commas between them, none at their ends."""
    lines: list[str] = []
    for number in map(json.dumps, numbers):
        if lines and len(lines[-1]) + len(number) + 3 <= width:
            lines[-1] += f", {number}"
        else:
            lines.append(number)
    return lines


def _fault(error: json.JSONDecodeError) -> tuple[int, int, str]:
    """Line and column, from 1, and what is wrong there."""
    text, position = error.doc, error.pos
    before = text[:position].rstrip().removesuffix(",").rstrip()
    comma = text.find(",", len(before), position + 1)
    if comma >= 0 and text[_skip(text, comma + 1) :][:1] in ("]", "}"):
        line, column = text.count("\n", 0, comma) + 1, comma - text.rfind("\n", 0, comma)
        return line, column, "a trailing comma; nothing follows it, so take it out"
    return error.lineno, error.colno, error.msg[:1].lower() + error.msg[1:]
