"""The verb `doctor`: what is installed here, what is amiss, and a line of advice for each of that.

It imports neither JAX nor NumPy: a broken one is what it is asked about.
"""

import os
import platform
import shutil
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from fitting.parameters import output
from fitting.shell import jax_probe, requirements
from fitting.shell.ownership import is_ours
from fitting.shell.progress import waiting
from fitting.shell.session import NAMED_BY, cache_folder
from newtonjax.numerics import available_memory

# Below this much memory, or room for compiled programs, work may fail [bytes].
_LEAST_MEMORY, _LEAST_ROOM = 1e9, 1e8
_REINSTALL = "pip install --upgrade --force-reinstall"
_SIGNALS = {
    "SIGILL": "this processor lacks an instruction of this jaxlib; install one that was built for it",
    "SIGKILL": "there may be too little memory; close other programs",
}
# Variables that change what JAX does.
_VARIABLES = ("JAX_", "XLA_", "NEWTONJAX_", "OMP_", "CUDA_VISIBLE")


class Fact(NamedTuple):
    """One line: where it belongs, what it is, its value, and what to do if it is not as it should be."""

    section: str
    name: str
    value: str
    advice: str = ""


def run(as_json: bool) -> int:
    """Print the facts as they come; 1 if any of them needs advice, else 0."""
    facts = []
    for fact in _facts():
        if not as_json:
            _print(fact, is_first=not facts or facts[-1].section != fact.section)
        facts.append(fact)
    advice = [f"{fact.name}: {fact.advice}" for fact in facts if fact.advice]
    if as_json:
        sys.stdout.write(output.json_text(_answer(facts, advice)))
    else:
        print("[[Advice]]")
        print(*(f"    {line}" for line in advice or ["nothing is amiss"]), sep="\n")
    return int(bool(advice))


def _print(fact: Fact, is_first: bool) -> None:
    if is_first:
        print(f"[[{fact.section}]]")
    mark = "  <- see below" if fact.advice else ""
    print(f"    {fact.name:<22} {fact.value}{mark}", flush=True)


def _answer(facts: list[Fact], advice: list[str]) -> dict:
    sections: dict[str, dict[str, str]] = {}
    for fact in facts:
        sections.setdefault(fact.section.lower(), {})[fact.name] = fact.value
    return {"ok": not advice, **sections, "advice": advice}


def _facts() -> Iterator[Fact]:
    needed = requirements.requirements()
    yield from _system()
    yield from _versions(needed)
    yield from _extras(needed)
    yield from _cache(cache_folder())
    packages = [item.package for item in needed if item.installed and item.extra in ("", *requirements.EXTRAS)]
    with waiting("starting JAX"):
        probe = jax_probe.probe(packages)
    yield from _jax(probe)


def _system() -> Iterator[Fact]:
    yield Fact("System", "system", f"{platform.platform()}, {platform.machine()}")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    yield Fact("System", "cores", f"{cores} for this process, of {os.cpu_count()}")
    free = available_memory()
    is_small = free is not None and free < _LEAST_MEMORY
    advice = "close other programs: a fit of a large photograph takes a gigabyte" if is_small else ""
    yield Fact("System", "memory", "unknown" if free is None else f"{free / 1e9:.1f} GB available", advice)
    for name, value in sorted(os.environ.items()):
        if name.startswith(_VARIABLES):
            yield Fact("System", name, _short(value))


def _versions(needed: list[requirements.Requirement]) -> Iterator[Fact]:
    yield Fact("Versions", "python", platform.python_version())
    ours = requirements.installed("newtonjax")
    yield Fact("Versions", "newtonjax", ours or "not installed", "" if ours else "pip install newtonjax")
    yield Fact("Versions", "jaxlib", requirements.installed("jaxlib") or "missing")
    for item in needed:
        if not item.extra:
            wanted = f"'{item.package}>={item.lowest}'" if item.lowest else item.package
            advice = f"pip install {wanted}" if item.lack() else ""
            yield Fact("Versions", item.package, item.lack() or item.installed, advice)


def _extras(needed: list[requirements.Requirement]) -> Iterator[Fact]:
    for extra, gives in requirements.EXTRAS.items():
        lacks = [f"{item.package} {item.lack()}" for item in needed if item.extra == extra and item.lack()]
        command = f"; {', '.join(lacks)}: pip install 'newtonjax[{extra}]'" if lacks else "; installed"
        yield Fact("Extras", extra, gives + command)


def _cache(folder: Path) -> Iterator[Fact]:
    where = f"{_short(str(folder))}{f' (by {NAMED_BY})' if NAMED_BY in os.environ else ''}"
    above = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    can_write = above.is_dir() and os.access(above, os.W_OK | os.X_OK)
    other = f"let {NAMED_BY} name a folder that can be written: without one every run compiles anew"
    yield Fact("Cache", "folder", where, "" if can_write else other)
    files = [path for path in (*_files(folder), *_files(folder / "programs")) if not path.name.startswith(".")]
    sizes = [size for path in files if (size := _size(path)) is not None]
    yield Fact("Cache", "programs", f"{len(sizes)} files, {sum(sizes) / 1e6:.0f} MB (may be deleted at any time)")
    programs = folder / "programs"
    is_safe = not programs.is_dir() or (is_ours(folder) and is_ours(programs))
    advice = "" if is_safe else f"chmod -R go-w {folder}: saved programs that others may have written are not run"
    yield Fact("Cache", "owner", "nobody else may write" if is_safe else "others may write", advice)
    room = shutil.disk_usage(above).free
    yield Fact("Cache", "room", f"{room / 1e9:.1f} GB", "free some of this disk" if room < _LEAST_ROOM else "")


def _files(folder: Path) -> list[Path]:
    try:
        return [path for path in folder.iterdir() if path.is_file()]
    except OSError:
        return []


def _size(path: Path) -> int | None:
    """None for a file that another process has just removed."""
    try:
        return path.stat().st_size
    except OSError:
        return None


def _jax(probe: jax_probe.Probe) -> Iterator[Fact]:
    facts = probe.facts
    if "devices" in facts:
        yield Fact("JAX", "devices", ", ".join(facts["devices"]))
        if _has_idle_gpu(facts["devices"]):
            yield Fact("JAX", "gpu", "not used: pip install 'jax[cuda12]' (or the extra of jax that its driver needs)")
    if "float64" in facts:
        advice = "JAX_PLATFORMS=cpu: the device computes in less than 64 bits, which fringes need"
        yield Fact("JAX", "float64", str(facts["float64"]), "" if facts["float64"] else advice)
    for package, error in facts.get("imports", {}).items():
        yield Fact("JAX", package, error, f"{_REINSTALL} {package}")
    step = probe.ended_in()
    if step:
        yield Fact("JAX", jax_probe.STEPS[step], _ending(probe), _advice(probe, step))
    else:
        yield Fact("JAX", "a program", "compiled and run")


def _ending(probe: jax_probe.Probe) -> str:
    if probe.status is None:
        return f"no answer within {jax_probe.LIMIT:.0f} s"
    return f"ended with {probe.status}: {probe.last_line or 'without a word'}"


def _advice(probe: jax_probe.Probe, step: str) -> str:
    if probe.status is not None and probe.status < 0:
        name = signal.Signals(-probe.status).name
        return f"{name} ended it: {_SIGNALS.get(name, 'install jaxlib again, or another version of it')}"
    if step == "devices" or probe.status is None:
        return "JAX_PLATFORMS=cpu leaves other devices out"
    return f"{_REINSTALL} jax jaxlib"


def _has_idle_gpu(devices: list[str]) -> bool:
    """Whether the system has a GPU that JAX does not use, and was not told to leave out."""
    has_gpu = Path("/dev/nvidia0").exists() and "JAX_PLATFORMS" not in os.environ
    return has_gpu and all(device.startswith("cpu") for device in devices)


def _short(text: str) -> str:
    """A path with ~ for the user's own folder, as it may be shown to others."""
    return text.replace(str(Path.home()), "~") if str(Path.home()) != "/" else text
