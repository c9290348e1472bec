"""Scenes and cameras in TOML files: SI floats, every field checked, nothing rounded."""

import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, TypeVar, cast

import msgspec
import numpy as np
import tomli_w

from newtonjax.benches import lens_on_plate
from newtonjax.benches.arguments import BENCHES, Argument, arguments_of, refuse_old_names
from newtonjax.numerics import shown
from newtonjax.scene import Camera, CollectingLens, Light, Scene, Shield, Surface, word_of

Three = tuple[float, float, float]
Two = tuple[float, float]
Positive = Annotated[float, msgspec.Meta(gt=0)]
Made = TypeVar("Made")
Pixels = Annotated[int, msgspec.Meta(ge=1)]


class SurfaceTable(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """One surface, or the screen: curvature [1/m], vertex [m], tilt [rad]."""

    curvature: float = 0.0
    vertex: Three = (0.0, 0.0, 0.0)
    tilt: Two = (0.0, 0.0)


class LightTable(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """The source: vacuum wavelength [m], tilt [rad], polarization and ellipticity [rad] or absent, degree or absent."""

    wavelength: Positive
    tilt: Two = (0.0, 0.0)
    polarization: float | None = None
    ellipticity: float | None = None
    degree: float | None = None


class ShieldTable(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """An opaque plane with a round hole: its radius [m], vertex [m], tilt [rad]."""

    radius: Positive
    vertex: Three = (0.0, 0.0, 0.0)
    tilt: Two = (0.0, 0.0)


class CollectingLensTable(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """An ideal lens before the screen: focal length [m], vertex [m]."""

    focal_length: Positive
    vertex: Three


class CameraTable(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """The camera: shape [rows, columns], pixel_size [m], and the rest of `Camera`."""

    shape: tuple[Pixels, Pixels]
    pixel_size: Positive
    centre_px: Two | None = None
    exposure: Positive = 10_000.0
    full_well: Positive = 12_000.0
    read_noise: Annotated[float, msgspec.Meta(ge=0)] = 5.0
    bits: Annotated[int, msgspec.Meta(ge=8, le=16)] = 8


class SceneFields(msgspec.Struct):
    """What a file holds beside ready benches: surfaces with media, light, screen and beams (and perhaps a shield and a
    collecting lens); and a camera.
    """

    surfaces: tuple[SurfaceTable, ...] | None = None
    media: tuple[Positive, ...] | None = None
    beams: tuple[str, ...] | None = None
    light: LightTable | None = None
    screen: SurfaceTable | None = None
    shield: ShieldTable | None = None
    collecting_lens: CollectingLensTable | None = None
    camera: CameraTable | None = None


def _type_of(argument: Argument) -> Any:
    """What TOML may hold for an argument of a bench."""
    by_kind = {"view": str, "screen": float | str, "angles": Two, "names": tuple[str, ...]}
    kind = by_kind.get(argument.kind, float)
    return kind | None if argument.default is None else kind


# A table for each ready bench, with the arguments of its call; and the file, which may hold any of them.
_READY = {
    bench: msgspec.defstruct(
        bench,
        [(argument.name, _type_of(argument), argument.default) for argument in arguments_of(bench)],
        forbid_unknown_fields=True,
    )
    for bench in BENCHES
}
_File = msgspec.defstruct(
    "SceneFile",
    [(bench, table | None, None) for bench, table in _READY.items()],
    bases=(SceneFields,),
    forbid_unknown_fields=True,
    omit_defaults=True,
)
_TABLES = {
    name: table.__struct_fields__
    for name, table in {
        **_READY,
        "surfaces": SurfaceTable,
        "screen": SurfaceTable,
        "light": LightTable,
        "shield": ShieldTable,
        "collecting_lens": CollectingLensTable,
        "camera": CameraTable,
    }.items()
}
_BY_HAND = ("surfaces", "media", "beams", "light", "screen")
_BESIDE = ("shield", "collecting_lens")  # what a scene by hand may have as well


def load_scene(path: str | Path) -> tuple[Scene, Camera | None]:
    """The scene in a TOML file, and the camera if it has one.

    Raises FileNotFoundError, and ValueError with the file, the field, the value and what is allowed.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"{path} is not a file; give the path of a scene in TOML (see docs/scene.toml)")
    try:
        # Editors on Windows begin a file with a byte-order mark.
        return scene_from_text(path.read_text(encoding="utf-8-sig"))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def scene_from_text(text: str) -> tuple[Scene, Camera | None]:
    """The scene in the text of a TOML file, and the camera if it has one.

    Raises ValueError with the field, the value and what is allowed.
    """
    table = _convert(tomllib.loads(text))
    return _scene(table), _made(Camera, table.camera)


def _convert(content: dict) -> SceneFields:
    """The file's tables, checked; what msgspec says of a bad one, with the value and the fields that it leaves out."""
    for bench in BENCHES:
        if isinstance(content.get(bench), dict):
            refuse_old_names(bench, content[bench])
    try:
        return cast("SceneFields", msgspec.convert(content, _File))
    except msgspec.ValidationError as error:
        problem, _, place = str(error).partition(" - at `$")
        names, value, fields = re.findall(r"\w+", place), content, (*BENCHES, *SceneFields.__struct_fields__)
        for name in names:
            value = value[int(name)] if isinstance(value, list) else value[name]
            fields = _TABLES.get(name, fields) if name == names[0] else ()
        where = place.strip(".`") or "file"
        if isinstance(value, dict):
            takes = f"; it takes {', '.join(fields)}" if fields else ""
            raise ValueError(f"[{where}] {problem}{takes}") from None
        raise ValueError(f"{where} is {value!r}; allowed: {problem.removeprefix('Expected ')}") from None


def _scene(table: SceneFields) -> Scene:
    by_hand = [name for name in (*_BY_HAND, *_BESIDE) if getattr(table, name) is not None]
    ready = [name for name in BENCHES if getattr(table, name) is not None]
    if len(ready) + bool(by_hand) != 1:
        holds = ", ".join(ready + by_hand) or "neither"
        raise ValueError(
            f"the file holds {holds}; allowed: one of [newton_rings], [air_wedge], or {', '.join(_BY_HAND)} together"
        )
    if ready:
        arguments = msgspec.structs.asdict(getattr(table, ready[0]))
        return getattr(lens_on_plate, ready[0])(**arguments)
    surfaces, media, beams, light, screen = table.surfaces, table.media, table.beams, table.light, table.screen
    if surfaces is None or media is None or beams is None or light is None or screen is None:
        raise ValueError(
            f"{', '.join(set(_BY_HAND) - set(by_hand))} missing; a scene by hand takes {', '.join(_BY_HAND)}"
        )
    return Scene(
        surfaces=tuple(Surface(**msgspec.structs.asdict(surface)) for surface in surfaces),
        media=media,
        light=Light(**msgspec.structs.asdict(light)),
        screen=Surface(**msgspec.structs.asdict(screen)),
        beams=tuple(word_of(beam, len(surfaces)) for beam in beams),
        shield=_made(Shield, table.shield),
        collecting_lens=_made(CollectingLens, table.collecting_lens),
    )


def _made(kind: Callable[..., Made], table: msgspec.Struct | None) -> Made | None:
    return None if table is None else kind(**msgspec.structs.asdict(table))


def save_scene(path: str | Path, scene: Scene, camera: Camera | None = None) -> None:
    """Write a scene, surface by surface, and a camera to a TOML file; `load_scene` gives back the same numbers.

    Raises FileExistsError where the file is there already, ValueError for what is no scene or no camera.
    """
    for name, value, kind in (("scene", scene, Scene), ("camera", camera, Camera | None)):
        if not isinstance(value, kind):
            raise ValueError(f"{name} is {shown(value)}; allowed: a {name.capitalize()}")
    text = scene_text(scene, camera)
    with Path(path).open("x", encoding="utf-8") as file:
        file.write(text)


def scene_text(scene: Scene, camera: Camera | None = None) -> str:
    """What `save_scene` writes."""
    table = _File(
        surfaces=tuple(_table(SurfaceTable, surface) for surface in scene.surfaces),
        media=_plain(scene.media),
        beams=scene.beams,
        light=_table(LightTable, scene.light),
        screen=_table(SurfaceTable, scene.screen),
        shield=_table(ShieldTable, scene.shield),
        collecting_lens=_table(CollectingLensTable, scene.collecting_lens),
        camera=_table(CameraTable, camera),
    )
    return tomli_w.dumps(_without_none(msgspec.to_builtins(table)))


def _table(kind: type[Made], part: Any) -> Made | None:
    """A part of a bench, or the camera, as a table of the file; `_made` is the way back."""
    return (
        None
        if part is None
        else kind(**{name: _plain(getattr(part, name)) for name in cast("Any", kind).__struct_fields__})
    )


def _plain(value: Any) -> Any:
    """A number or a vector as Python's own."""
    if value is None or isinstance(value, int | tuple):
        return value
    numbers = np.asarray(value, dtype=float).tolist()
    return tuple(numbers) if isinstance(numbers, list) else numbers


def _without_none(tree):
    if isinstance(tree, dict):
        return {key: _without_none(value) for key, value in tree.items() if value is not None}
    return tree
