"""Settings from plain values: a strict, checked way from TOML or JSON into a stage's frozen dataclass."""

from __future__ import annotations

import ast
import dataclasses
import difflib
import inspect
import itertools
import math
import re
import textwrap
import types
import typing
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import cattrs

T = TypeVar("T")

_LIMITS: dict[str, tuple[str, Callable[[Any, Any], bool]]] = {
    "ge": (">=", lambda value, limit: value >= limit),
    "gt": (">", lambda value, limit: value > limit),
    "le": ("<=", lambda value, limit: value <= limit),
    "lt": ("<", lambda value, limit: value < limit),
}


class SettingsError(ValueError):
    """A setting that can't be used: its name, the limit, the value and a suggestion, in one line."""


def build(kind: type[T], given: Mapping[str, Any]) -> T:
    """Make a `kind` of `given`; fields left out take their defaults.

    Ranges stand in a field's metadata, as "ge", "gt", "le", "lt" and "choices", and hold for each element of a tuple.
    An int may stand for a float; nothing else is converted.

    Raises:
        SettingsError: An unknown name, a missing or ill-typed value, or one out of range.
    """
    if not isinstance(given, Mapping):
        raise SettingsError(f"must be a table, got {given!r}")
    fields = {field.name: field for field in dataclasses.fields(kind) if field.init}  # type: ignore[arg-type]
    for name in given:
        if name not in fields:
            raise SettingsError(f"unknown key {name!r}; {suggestion(name, fields)}")
    types_of = typing.get_type_hints(kind)
    values: dict[str, Any] = {}
    for name, field in fields.items():
        if name in given:
            values[name] = _value(kind, name, types_of[name], given[name])
            _check_range(kind, name, field.metadata, values[name])
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise SettingsError(f"{name} is missing{_meaning(kind, name)}")
    try:
        return kind(**values)
    except SettingsError:
        raise
    except ValueError as error:
        raise SettingsError(" ".join(str(error).split())) from None


def plain(settings: Any) -> dict[str, Any]:
    """The dataclass `settings` as plain JSON values; tuples become lists."""
    return {name: _plain(value) for name, value in dataclasses.asdict(settings).items()}


def suggestion(name: str, known: Any) -> str:
    """ "did you mean 'x'?", or the list of what is known."""
    close = difflib.get_close_matches(name, list(known), n=1, cutoff=0.6)
    if close:
        return f"did you mean {close[0]!r}?"
    return f"known: {', '.join(sorted(known))}" if known else "none is known here"


def _value(kind: type, name: str, wanted: Any, given: Any) -> Any:
    try:
        return _CONVERTER.structure(given, wanted)
    except SettingsError as error:
        raise SettingsError(f"{name}: {error}") from None
    except Exception:  # cattrs raises what the constructor of the wanted type raises
        problem = f"{name} must be {_type_name(wanted)}, got {given!r}"
        raise SettingsError(problem + _meaning(kind, name)) from None


def _check_range(kind: type, name: str, metadata: Mapping[str, Any], value: Any) -> None:
    choices = metadata.get("choices")
    for element in value if isinstance(value, tuple | list) else (value,):
        if element is None:
            continue
        if isinstance(element, float) and not math.isfinite(element):
            raise SettingsError(f"{name} must be finite, got {element}{_meaning(kind, name)}")
        if choices is not None and element not in choices:
            near = suggestion(element, [c for c in choices if isinstance(c, str)]) if isinstance(element, str) else ""
            hint = f"; {near}" if near.startswith("did") else ""
            raise SettingsError(f"{name} must be one of {', '.join(map(str, choices))}, got {element!r}{hint}")
        for label, (sign, holds) in _LIMITS.items():
            if label in metadata and not holds(element, metadata[label]):
                unit = _unit(kind, name)
                limit = f"{metadata[label]} {unit}".rstrip()
                raise SettingsError(f"{name} must be {sign} {limit}, got {element}{_meaning(kind, name)}")


def _strict(wanted: type, *accepted: type) -> Callable[[Any, Any], Any]:
    def structure(given: Any, _: Any) -> Any:
        if (isinstance(given, bool) and wanted is not bool) or not isinstance(given, accepted):
            raise TypeError
        return wanted(given)

    return structure


def _structure_tuple(given: Any, wanted: Any) -> Any:
    elements = typing.get_args(wanted)
    if not isinstance(given, list | tuple):
        raise TypeError
    if len(elements) == 2 and elements[1] is Ellipsis:
        return tuple(_CONVERTER.structure(element, elements[0]) for element in given)
    if len(given) != len(elements):
        raise TypeError
    return tuple(_CONVERTER.structure(value, element) for value, element in zip(given, elements))


def _type_name(wanted: Any) -> str:
    origin, elements = typing.get_origin(wanted), typing.get_args(wanted)
    if origin is typing.Literal:
        return "one of " + ", ".join(map(repr, elements))
    if origin in (typing.Union, types.UnionType):
        return " or ".join(_type_name(element) for element in elements if element is not type(None))
    if origin is tuple:
        if elements[-1] is Ellipsis:
            return f"a list of {_type_name(elements[0])}"
        return f"a list of {len(elements)} ({', '.join(map(_type_name, elements))})"
    names = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}
    return names.get(wanted, getattr(wanted, "__name__", str(wanted)))


def _meaning(kind: type, name: str) -> str:
    text = _docstrings(kind).get(name, "")
    return f" ({text.rstrip('.')})" if text else ""


def _unit(kind: type, name: str) -> str:
    found = re.search(r"\[([^\]]+)\]", _docstrings(kind).get(name, ""))
    return found.group(1) if found else ""


def _docstrings(kind: type) -> dict[str, str]:
    """First line of the docstring under each field; read from the source, since Python doesn't keep them."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(kind)))
    except (OSError, TypeError, SyntaxError):
        return {}
    body = tree.body[0].body if isinstance(tree.body[0], ast.ClassDef) else []
    found: dict[str, str] = {}
    for field, after in itertools.pairwise(body):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(after, ast.Expr):
            text = ast.literal_eval(after.value) if isinstance(after.value, ast.Constant) else ""
            found[field.target.id] = str(text).strip().split("\n")[0]
    return found


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _plain(element) for name, element in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(element) for element in value]
    return value


_CONVERTER = cattrs.Converter(detailed_validation=False)
for _wanted, _accepted in ((float, (int, float)), (int, (int,)), (bool, (bool,)), (str, (str,))):
    _CONVERTER.register_structure_hook(_wanted, _strict(_wanted, *_accepted))
_CONVERTER.register_structure_hook_func(lambda wanted: typing.get_origin(wanted) is tuple, _structure_tuple)
_CONVERTER.register_structure_hook_func(dataclasses.is_dataclass, lambda given, wanted: build(wanted, given))
