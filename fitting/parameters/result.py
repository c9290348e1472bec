"""What every verb returns: the same words for status, report, files, pictures and comparison."""

import abc
import base64
import functools
import hashlib
import html
import inspect
import io
import json
import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple, ParamSpec, TypeVar, cast

import numpy as np

from fitting.parameters import output
from newtonjax.numerics import Statement, path_of, shown

# What two results may differ in and still say the same.
_OF_THE_RUN = ("seconds", "origin")
# Arguments that change nothing of an answer.
_OF_THE_CALL = ("progress", "so_far", "path")
# Arrays of more numbers than this are named by their type in an origin.
_SHORT = 100
# Two-sided 95 % of a normal distribution.
_COVERAGE = 1.959963984540054


Result = TypeVar("Result", bound="AbstractResult")
Arguments = ParamSpec("Arguments")


class Origin(NamedTuple):
    """What a result was made from.

    - `file`: its name, None for an array or a scene; `sha256`: of the file's bytes, of the array's in rows, or of the
      TOML of scene and camera.
    - `given`: the arguments that were given, by name; what JSON cannot hold is named by its type.
    - `version`: of newtonjax; `date`: of the call, ISO 8601 with its offset from UTC.
    """

    file: str | None
    sha256: str
    given: dict[str, Any]
    version: str
    date: str


def says_its_origin(verb: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """A verb whose result says what it was made from: its first argument, and the others that were given."""
    first = next(iter(inspect.signature(verb).parameters))

    @functools.wraps(verb)
    def with_origin(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        source = args[0] if args else kwargs.get(first)
        # A text with line breaks is a table that was pasted.
        file = Path(source) if isinstance(source, str | Path) and "\n" not in str(source) else None
        # What is not there, or cannot be read, the verb itself refuses.
        data = (file.read_bytes() if file.is_file() else b"") if file else _bytes_of(source)
        origin = origin_of(data, {name: value for name, value in kwargs.items() if name != first}, file)
        return replace(verb(*args, **kwargs), origin=origin)  # pyright: ignore[reportArgumentType]  # a dataclass

    return with_origin


def origin_of(data: Any, arguments: Mapping[str, Any], file: Path | None = None) -> Origin:
    """The origin of a result that was made of these bytes with these arguments, just now."""
    return Origin(
        file.name if file else None,
        hashlib.sha256(data).hexdigest(),
        {name: _as_json(value) for name, value in arguments.items() if value is not None and name not in _OF_THE_CALL},
        version("newtonjax"),
        datetime.now(UTC).isoformat(timespec="seconds"),
    )


def _bytes_of(source: Any) -> Any:
    """What is hashed of an array or a table; the pixels of an array without a copy of them."""
    if isinstance(source, str):
        return source.encode(errors="replace")
    if isinstance(source, Mapping):
        return repr({str(key): np.asarray(column, dtype=object).tolist() for key, column in source.items()}).encode()
    try:
        with warnings.catch_warnings():
            # A masked number in a list becomes no number, with a warning; the verb itself says what is wrong.
            warnings.simplefilter("ignore", UserWarning)
            array = np.asarray(source)
    except ValueError:  # a ragged list, which the verb itself refuses
        return repr(source).encode()
    if array.dtype.hasobject:
        return repr(array.tolist()).encode()
    return np.ascontiguousarray(array).view(np.uint8) if array.ndim else array.tobytes()


def _as_json(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _as_json(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_as_json(item) for item in value]
    if isinstance(value, str | bool | int | float | None):
        return value
    if hasattr(value, "tolist") and np.size(value) <= _SHORT:
        return np.asarray(value).tolist()
    return str(value) if isinstance(value, Path) else type(value).__name__


class AbstractResult(abc.ABC):
    """What a verb of `fitting` returns.

    - `status`: "ok" where there is an answer; `message`: the reason where there is none; `warnings`: what to look at.
      Programs tell them apart by `reason` and `warning_codes`, names of `fitting.Reason` that stay.
    - `str(result)` is the report, `repr(result)` its first lines; in a notebook the picture stands beside it.
    - Results are equal where they say the same, whenever they were made. They can be pickled.
    """

    status: str
    message: str
    warnings: list[str]
    origin: Origin | None

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        for name, guard in (("figure", _takes_axes), ("from_dict", _takes_saved)):
            if name in vars(cls):
                setattr(cls, name, guard(vars(cls)[name]))

    @property
    def reason(self) -> str | None:
        """The name of `message` in `fitting.Reason`, None where there is no message."""
        return getattr(self.message, "code", None)

    @property
    def warning_codes(self) -> list[str]:
        """The names of the warnings in `fitting.Reason`, in their order."""
        return [getattr(text, "code", "") for text in self.warnings]

    @abc.abstractmethod
    def report(self) -> str:
        """The result as text."""

    @abc.abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """The result for JSON: units in the keys, None for what is not determined; its `kind`, and its `origin`."""

    @classmethod
    @abc.abstractmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "AbstractResult":
        """The result that `to_dict` was called of. Raises ValueError for another dictionary."""

    def _common(self) -> dict[str, Any]:
        """What ends every `to_dict`."""
        return {
            "reason": self.reason,
            "warnings": [str(text) for text in self.warnings],
            "warning_codes": self.warning_codes,
            "kind": type(self).__name__,
            "origin": self.origin and self.origin._asdict(),
        }

    def figure(self, ax=None) -> Any:
        """The result as a matplotlib figure; drawn into the axes `ax` where they are given.

        Raises ValueError for a result that has no picture.
        """
        del ax
        raise ValueError(f"a {type(self).__name__} has no picture; print its report()")

    def _reason_figure(self) -> Any:
        """A figure that says why there is no answer, where there is nothing to draw."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(6, 2.2), layout="constrained")
        figure.text(0.5, 0.5, f"{self.status}: {self.message}", ha="center", va="center", wrap=True)
        return figure

    def save(self, path: str | Path, *, force: bool = False) -> None:
        """Write the result as JSON, from which `load` makes it again; pixels are not in it.

        Raises FileExistsError for a file that is there already, unless `force`.
        """
        output.write(path_of(path), output.json_text(self.to_dict()), force)

    @classmethod
    def load(cls: type[Result], path: str | Path) -> Result:
        """The result in a file that `save` or the shell wrote.

        Raises FileNotFoundError, and ValueError for a file that does not hold such a result.
        """
        path = path_of(path)
        if not path.is_file():
            raise FileNotFoundError(f"{path} is not a file; give a result that was saved")
        try:
            return cast("Result", cls.from_dict(json.loads(path.read_text(encoding="utf-8"))))
        except ValueError as error:
            raise ValueError(f"{path} does not hold a saved {cls.__name__}: {error}") from error

    def __str__(self) -> str:
        return self.report()

    def __repr__(self) -> str:
        first = self.report().splitlines()[:4]
        return "\n".join([f"<{type(self).__name__}>", *first])

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return self._says() == cast("AbstractResult", other)._says()

    def _says(self) -> str:
        return output.json_text({key: value for key, value in self.to_dict().items() if key not in _OF_THE_RUN})

    __hash__ = None  # pyright: ignore[reportAssignmentType]  # what can be compared by value and holds lists has none

    def _repr_html_(self) -> str:
        text = f"<pre>{html.escape(self.report())}</pre>"
        try:
            figure = self.figure()
        except ValueError:
            return text
        file = io.BytesIO()
        figure.savefig(file, format="png", dpi=80)
        return text + f'<img src="data:image/png;base64,{base64.b64encode(file.getvalue()).decode()}">'


def _takes_axes(figure: Callable[..., Any]) -> Callable[..., Any]:
    """A method `figure(self, ax=None)` that refuses what are no axes."""

    @functools.wraps(figure)
    def with_axes(self: "AbstractResult", ax: Any = None) -> Any:
        from matplotlib.axes import Axes

        if ax is not None and not isinstance(ax, Axes):
            raise ValueError(f"ax is {shown(ax)}; allowed: axes of matplotlib, or None for a figure of its own")
        return figure(self, ax)

    return with_axes


def _takes_saved(from_dict: Any) -> Any:
    """A class method `from_dict` that refuses in one line what `to_dict` did not give."""
    function = from_dict.__func__

    @functools.wraps(function)
    def with_check(cls: type["AbstractResult"], saved: Mapping[str, Any]) -> "AbstractResult":
        kind = cls.__name__
        if not isinstance(saved, Mapping):
            raise ValueError(f"saved is {shown(saved)}; allowed: the dictionary that {kind}.to_dict gave")
        if saved.get("kind", kind) != kind:
            raise ValueError(
                f"it is a {' '.join(str(saved['kind']).split())[:40]}; allowed: the dictionary that {kind}.to_dict gave"
            )
        try:
            result = function(cls, saved)
            result.report()  # it shows every number
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            name = f"{error} is missing" if isinstance(error, KeyError) else shown(error)
            raise ValueError(f"saved is no dictionary that {kind}.to_dict gave: {name}") from error
        return result

    return classmethod(with_check)


def common_from(saved: Mapping[str, Any]) -> tuple[str, str, list[str], Origin | None]:
    """Status, message, warnings and origin of a saved result; the texts with their names, where these were saved."""
    message, reason, warnings = saved["message"], saved.get("reason"), list(saved["warnings"])
    codes = saved.get("warning_codes") or [""] * len(warnings)
    texts: list[str] = [Statement(text, code) if code else text for text, code in zip(warnings, codes, strict=True)]
    origin = Origin(**saved["origin"]) if saved.get("origin") else None
    return saved["status"], Statement(message, reason) if reason else message, texts, origin


def interval(value: float, sd: float) -> tuple[float, float]:
    """95 %, normal in the logarithm: a length cannot be negative, and s²/(k λ) is a product."""
    factor = float(np.exp(_COVERAGE * sd / value))
    return value / factor, value * factor
