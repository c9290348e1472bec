"""One photograph of a batch: where it is, what is asked of it, and the key that identifies it."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

# The status of a row without a result: an unreadable file, or one whose worker process died. A photograph that shows no
# rings is "refused", which is a result.
FAILED = "failed"


@dataclass(frozen=True)
class Job:
    """A photograph to measure.

    - `path`: absolute; `page`: from 1 on, None where the number of pages is not known yet: then the first is measured.
    - `sha256`: of the file's bytes, empty where it cannot be read.
    - `arguments`: what the work is called with; `settings`: a description of them for JSON (`described`).
    """

    path: str
    page: int | None
    sha256: str
    arguments: Mapping[str, Any]
    settings: Mapping[str, Any]

    @cached_property
    def key(self) -> str:
        """SHA-256 of content, settings, path and page: the same for the same photograph in every run."""
        identity = [self.sha256, self.settings, self.path, self.page or 1]
        return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()

    def on_page(self, page: int) -> "Job":
        """The same for another page of the file."""
        return replace(self, page=page)

    def row(self, outcome: Mapping[str, Any]) -> dict[str, Any]:
        """The line of the results file: which photograph it is, and what came out."""
        return {
            "key": self.key,
            "path": self.path,
            "page": self.page or 1,
            "sha256": self.sha256,
            "settings": dict(self.settings),
            **outcome,
        }


def digest_of(path: str | Path) -> str:
    """SHA-256 of a file's bytes; empty where it cannot be read."""
    try:
        with Path(path).open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""


def described(value: Any) -> Any:
    """A value of a setting for JSON: files and arrays by their SHA-256, results by what they hold.

    Raises ValueError for what cannot be described, which no key could hold.
    """
    if value is None or isinstance(value, str | bool | int | float):
        return value
    if isinstance(value, Path):
        return {"file": value.name, "sha256": digest_of(value)}
    if isinstance(value, Mapping):
        return {str(name): described(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [described(item) for item in value]
    if hasattr(value, "to_dict"):
        return {"kind": type(value).__name__, "sha256": _digest(json.dumps(described(value.to_dict())).encode())}
    if hasattr(value, "tobytes") and value.ndim:
        return {"shape": list(value.shape), "sha256": _digest(value.tobytes())}
    if hasattr(value, "item"):
        return value.item()
    raise ValueError(f"a {type(value).__name__} is no setting of a batch; give a number, a text, a file or an array")


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
