"""What the package says it needs, and what is installed of it: read without importing any of that."""

import re
from importlib import metadata
from typing import NamedTuple

_LINE = re.compile(r"([\w.-]+)[^;>=<!~]*(?:>=\s*([\d.]+))?[^;]*(?:;.*extra\s*==\s*['\"]([\w-]+)['\"])?")
# What each extra that users may miss gives; the others are for developers.
EXTRAS = {
    "app": "newtonjax app: the page for a browser",
    "cluster": "newtonjax batch --scheduler: photographs on a Dask cluster",
    "raw": "raw files of cameras",
    "nuts": 'fitting.sample(sampler="nuts"): chains by NUTS',
    "video": "videos: each frame a photograph",
    "sheets": "tables in .xlsx and .ods",
}


class Requirement(NamedTuple):
    """A package that is needed: its lowest version, the extra that needs it, and what is installed, "" if nothing."""

    package: str
    lowest: str
    extra: str
    installed: str

    def lack(self) -> str:
        """What is not as needed, empty if nothing."""
        if not self.installed:
            return "missing"
        if _numbers(self.installed) < _numbers(self.lowest):
            return f"{self.installed} is older than {self.lowest}"
        return ""


def requirements() -> list[Requirement]:
    """All that newtonjax needs, extras included; empty where it is not installed."""
    try:
        lines = metadata.requires("newtonjax") or []
    except metadata.PackageNotFoundError:
        return []
    parts = [match.groups(default="") for line in lines if (match := _LINE.match(line))]
    return [Requirement(package, lowest, extra, installed(package)) for package, lowest, extra in parts]


def installed(package: str) -> str:
    """The version of a package that is installed, empty if none is."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return ""


def _numbers(version: str) -> tuple[int, ...]:
    """The numbers that a version begins with: (2, 1) of 2.1rc3."""
    return tuple(int(part) for part in re.findall(r"\d+", re.split(r"[^\d.]", version)[0]))
