"""The public interface: every name of both packages with its signature, docstring, units and errors.

The list stands in `public_api.txt`, so that a change of the interface shows in review; the same names stand on the
manual's pages in `docs/reference`. To write both anew:
`python tests/architecture/test_public_api.py`.
"""

import importlib
import inspect
import re
from enum import Enum
from pathlib import Path

import pytest

import fitting
import newtonjax as nj
from fitting.parameters import AbstractResult

PACKAGES = ("newtonjax", "fitting")
LIST = Path(__file__).with_name("public_api.txt")
# Arguments with a dimension: a docstring that has them says in which unit they are.
DIMENSIONAL = {
    "wavelength", "pixel_size", "radius", "gap", "wedge_angle", "view_angle", "screen", "division", "plate_radius",
    "lens_thickness", "plate_thickness", "light_tilt", "lens_tilt", "plate_tilt", "shield", "collecting_lens", "vertex",
    "tilt", "focal_length", "expected_radius", "curvature", "noise", "polarization", "epsilon", "exposure",
}  # fmt: skip
UNIT = re.compile(r"\[(m|rad|px|1/m|photoelectrons|units?|incident irradiance)\]|metres|radians|irradiance")


def public(package: str) -> dict[str, object]:
    """The public objects of a package by name, in order."""
    module = importlib.import_module(package)
    return {f"{package}.{name}": getattr(module, name) for name in sorted(module.__all__) if not name.startswith("__")}


OBJECTS = {name: value for package in PACKAGES for name, value in public(package).items()}
# Of results and of the camera: users call these. Methods of rendering are called by `render`.
CALLED = (AbstractResult, fitting.FrameFit, nj.Camera, nj.Scene)
METHODS = {
    f"{name}.{member}": value
    for name, kind in OBJECTS.items()
    if inspect.isclass(kind) and issubclass(kind, CALLED)
    for member, value in sorted(vars(kind).items())
    if not member.startswith("_") and (inspect.isfunction(value) or isinstance(value, classmethod | property))
}


def signature_of(value) -> str:
    """The signature as it stands in the source, without what a decorator or a type checker adds."""
    if isinstance(value, property) or (inspect.isclass(value) and issubclass(value, Enum)):
        return ""
    try:
        signature = inspect.signature(value.__func__ if isinstance(value, classmethod) else value)
    except ValueError:
        return "(...)"
    parameters = [parameter.replace(annotation=inspect.Parameter.empty) for parameter in signature.parameters.values()]
    text = str(signature.replace(parameters=parameters, return_annotation=inspect.Signature.empty))
    return re.sub(r"<factory>|<object object at 0x[0-9a-f]+>", "...", text)


def listing() -> str:
    members = {
        f"{name}.{member}": property() for name, kind in OBJECTS.items() for member in getattr(kind, "__members__", ())
    }
    lines = [f"{name}{signature_of(value)}" for name, value in sorted({**OBJECTS, **METHODS, **members}.items())]
    return "\n".join(lines) + "\n"


MANUAL = LIST.parents[2] / "docs" / "reference"


def reference(package: str) -> str:
    """A page of the manual: its title and first words as they stand, then every public name, functions first."""
    title = (MANUAL / f"{package}.md").read_text(encoding="utf-8").split("\n:::")[0]
    names = sorted(public(package), key=lambda name: (name.rpartition(".")[2][0].isupper(), name))
    return title + "".join(f"\n::: {name}\n" for name in names)


def test_the_public_interface_is_that_of_the_list():
    assert listing() == LIST.read_text(encoding="utf-8")


@pytest.mark.parametrize("package", PACKAGES)
def test_the_manual_has_every_public_name(package):
    assert reference(package) == (MANUAL / f"{package}.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", [*OBJECTS, *METHODS])
def test_a_public_name_has_a_docstring(name):
    value = {**OBJECTS, **METHODS}[name]
    text = inspect.getdoc(value)
    assert text
    assert len(text) > 15
    # Not the signature that a dataclass makes of itself.
    assert not text.startswith(f"{name.split('.')[-1]}(")


FUNCTIONS = {name: value for name, value in {**OBJECTS, **METHODS}.items() if inspect.isfunction(value)}


@pytest.mark.parametrize("name", [n for n, f in OBJECTS.items() if inspect.isfunction(f) or inspect.isclass(f)])
def test_a_docstring_gives_units_of_dimensional_arguments(name):
    value = OBJECTS[name]
    if inspect.isclass(value) and issubclass(value, Exception):
        return
    dimensional = set(inspect.signature(value).parameters) & DIMENSIONAL
    if dimensional:
        assert UNIT.search(inspect.getdoc(value) or ""), f"no unit for {', '.join(sorted(dimensional))}"


def raises(function) -> bool:
    """Whether the function itself, or a check that it calls by its name, raises."""
    source = inspect.getsource(inspect.unwrap(function))
    return bool(re.search(r"\braise \w|\b_?(require|check)\w*\(", source))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_docstring_says_which_errors_are_raised(name):
    function = FUNCTIONS[name]
    if raises(function):
        assert re.search(r"Raises|Error", inspect.getdoc(function) or "")


if __name__ == "__main__":
    LIST.write_text(listing(), encoding="utf-8")
    for package in PACKAGES:
        (MANUAL / f"{package}.md").write_text(reference(package), encoding="utf-8")
