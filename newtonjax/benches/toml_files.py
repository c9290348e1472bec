"""Scenes and cameras in TOML files: SI floats, every field checked, nothing rounded."""

import re
import sys
import tomllib
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import tomli_w

from newtonjax.benches import lens_on_plate
from newtonjax.benches.arguments import BENCHES, Argument, arguments_of, refuse_old_names
from newtonjax.benches.camera_tables import LENS, lens_of, table_of_lens, words_of_response
from newtonjax.benches.figure_tables import FIGURE, figure_of, table_of
from newtonjax.benches.light_tables import ALL_ORDERS, EXTENT, extent_of, orders_of, table_of_extent, table_of_orders
from newtonjax.numerics import Scalar, Vector2, Vector3, path_of, require_concrete, shown
from newtonjax.scene import (
    PROFILES,
    AbstractFigure,
    Camera,
    CameraLens,
    CollectingLens,
    Extent,
    Light,
    Response,
    Scene,
    Shield,
    Spectrum,
    Surface,
    Terms,
    camera_response,
    lamp,
    word_of,
)

Three = tuple[float, float, float]
Two = tuple[float, float]
Numbers = tuple[float, ...]
# Words that `lamp` takes, or the numbers of a spectrum.
_SPECTRUM = msgspec.defstruct(
    "Spectrum",
    [
        ("wavelengths", Numbers),
        ("weights", Numbers),
        *((name, Numbers | None, None) for name in PROFILES),
    ],
    forbid_unknown_fields=True,
    omit_defaults=True,
)

# The tables of a file beside ready benches, [[surfaces]] among them, by what is made of them. A table has the fields of
# its class, which checks their values.
_PARTS = {
    "surfaces": Surface,
    "light": Light,
    "screen": Surface,
    "shield": Shield,
    "collecting_lens": CollectingLens,
    "camera": Camera,
}
_IN_TOML = {
    Scalar: float,
    Scalar | None: float | None,
    Vector2: Two,
    Vector2 | None: Two | None,
    Vector3: Three,
    Spectrum | None: str | _SPECTRUM | None,
    Response | None: str | None,
    Terms | None: Numbers | None,
    AbstractFigure | None: FIGURE | None,
    Extent | None: EXTENT | None,
    CameraLens | None: LENS | None,
}


def _struct_of(kind: type) -> type[msgspec.Struct]:
    """What TOML may hold for a part of a bench, or for the camera."""
    return msgspec.defstruct(
        kind.__name__,
        [
            (field.name, _IN_TOML.get(field.type, field.type), *([] if field.default is MISSING else [field.default]))
            for field in fields(kind)
        ],
        forbid_unknown_fields=True,
        omit_defaults=True,
    )


_STRUCTS = {name: _struct_of(kind) for name, kind in _PARTS.items()}


def _type_of(argument: Argument) -> Any:
    """What TOML may hold for an argument of a bench."""
    by_kind = {"screen": float | str, "angles": Two, "names": str | tuple[str, ...], "index": float | str}
    by_kind |= dict.fromkeys(("view", "light", "coating"), str) | dict.fromkeys(("terms", "heights"), Numbers)
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
    [
        *((bench, table | None, None) for bench, table in _READY.items()),
        *(
            (name, (tuple[struct, ...] if name == "surfaces" else struct) | None, None)
            for name, struct in _STRUCTS.items()
        ),
        ("media", tuple[float, ...] | None, None),
        ("beams", tuple[str, ...] | None, None),
        ("all_orders", ALL_ORDERS | None, None),
    ],
    forbid_unknown_fields=True,
    omit_defaults=True,
)
_FIELDS = {name: struct.__struct_fields__ for name, struct in {**_READY, **_STRUCTS}.items()}
# Of what msgspec speaks: the place at the end of its text, as a field that it quotes may hold anything.
_PLACE = re.compile(r" - at `\$([.\w\[\]]*)`\Z")
_BY_HAND = ("surfaces", "media", "beams", "light", "screen")
_OF_TABLES = {"figure": figure_of, "lens": lens_of, "extent": extent_of}
_BESIDE = ("shield", "collecting_lens")  # what a scene by hand may have as well


def load_scene(path: str | Path) -> tuple[Scene, Camera | None]:
    """The scene in a TOML file, and the camera if it has one.

    Raises FileNotFoundError, and ValueError with the file, the field, the value and what is allowed.
    """
    path = path_of(path)
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
    if table.camera is not None and table.camera.response is not None:
        table.camera.response = camera_response(table.camera.response)
    return _scene(table), _made("camera", table.camera)


def _convert(content: dict) -> Any:
    """The file's tables, checked; what msgspec says of a bad one, with the value and the fields that it leaves out."""
    for bench in BENCHES:
        if isinstance(content.get(bench), dict):
            refuse_old_names(bench, content[bench])
    try:
        return msgspec.convert(content, _File)
    except msgspec.ValidationError as error:
        at = _PLACE.search(str(error))
        problem, place = (str(error)[: at.start()], at[1]) if at else (str(error), "")
        value, takes = content, _File.__struct_fields__
        for name in re.findall(r"\w+", place):
            value = value[int(name)] if isinstance(value, list | tuple) else value[name]
            takes = takes if name.isdecimal() else _FIELDS.get(name, ())
        where = place.strip(".") or "file"
        if isinstance(value, dict):
            advice = f"; it takes {', '.join(takes)}" if takes else ""
            raise ValueError(f"{_heading(where)} {_in_one_line(problem)}{advice}") from None
        raise ValueError(f"{where} is {shown(value)}; allowed: {problem.removeprefix('Expected ')}") from None


def _heading(where: str) -> str:
    """How a message names a table: [camera], surfaces[1]."""
    return where if where.endswith("]") else f"[{where}]"


def _in_one_line(problem: str) -> str:
    """What msgspec says, which quotes a field that it does not know as long as that is."""
    text = " ".join(problem.split())
    return text if len(text) <= 120 else f"{text[:117]}..."


def _scene(table: Any) -> Scene:
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
    if missing := [name for name in _BY_HAND if getattr(table, name) is None]:
        raise ValueError(f"{', '.join(missing)} missing; a scene by hand takes {', '.join(_BY_HAND)}")
    if table.light.spectrum is not None:
        table.light.spectrum = _spectrum(table.light.spectrum, table.media[0])
    return Scene(
        surfaces=tuple(_made("surfaces", surface, f"surfaces[{k}]") for k, surface in enumerate(table.surfaces)),
        media=table.media,
        beams=tuple(word_of(beam, len(table.surfaces)) for beam in table.beams),
        all_orders=orders_of(table.all_orders),
        **{name: _made(name, getattr(table, name)) for name in ("light", "screen", *_BESIDE)},
    )


def _spectrum(content: str | msgspec.Struct, ambient_index: float) -> Spectrum:
    """What [light] says of the spectrum: words, or numbers."""
    if isinstance(content, str):
        return lamp(content, ambient_index)
    return Spectrum(**msgspec.structs.asdict(content))


def _made(name: str, table: msgspec.Struct | None, where: str | None = None) -> Any:
    """A part of a bench, or the camera, of its table. Raises ValueError with the table's name."""
    try:
        if table is None:
            return None
        words = msgspec.structs.asdict(table)
        for part, of_table in _OF_TABLES.items():
            if part in words:
                words[part] = of_table(words[part])
        return _PARTS[name](**words)
    except ValueError as error:
        raise ValueError(f"{_heading(where or name)} {str(error).removeprefix(f'{name}.')}") from None


def save_scene(path: str | Path, scene: Scene, camera: Camera | None = None, *, force: bool = False) -> None:
    """Write a scene, surface by surface, and a camera to a TOML file; `load_scene` gives back the same numbers.

    Raises FileExistsError for an existing file unless `force`, ValueError for what is no scene or no camera, for
    traced numbers and for a batch of scenes.
    """
    for name, value, kind in (("scene", scene, Scene), ("camera", camera, Camera | None)):
        if not isinstance(value, kind):
            raise ValueError(f"{name} is {shown(value)}; allowed: a {name.capitalize()}")
    text = scene_text(scene, camera)
    with path_of(path).open("w" if force else "x", encoding="utf-8") as file:
        file.write(text)


def scene_text(scene: Scene, camera: Camera | None = None) -> str:
    """What `save_scene` writes. Raises ValueError for traced numbers and for a batch of scenes."""
    require_concrete("a file of a scene", scene, camera)
    table = _File(
        surfaces=tuple(_table("surfaces", surface) for surface in scene.surfaces),
        media=_plain(scene.media),
        beams=scene.beams,
        all_orders=table_of_orders(scene.all_orders),
        **{name: _table(name, getattr(scene, name)) for name in ("light", "screen", *_BESIDE)},
        camera=_table("camera", camera),
    )
    content = _without_none(msgspec.to_builtins(table))
    try:
        _convert(content)
    except ValueError as error:
        raise ValueError(f"{error} (a file holds one scene, not a batch)") from None
    return tomli_w.dumps(content)


def _table(name: str, part: Any) -> msgspec.Struct | None:
    """A part of a bench, or the camera, as a table of the file; `_made` is the way back."""
    return None if part is None else _STRUCTS[name](**{at: _plain(getattr(part, at)) for at in _FIELDS[name]})


def _plain(value: Any) -> Any:
    """A number or a vector as Python's own."""
    if value is None or isinstance(value, int | tuple):
        return value
    if isinstance(value, str):
        return sys.intern(value)  # msgspec leaves out a default where it is the same object
    if isinstance(value, Response):
        return words_of_response(value)
    if isinstance(value, Spectrum):
        return _SPECTRUM(**{name: _plain(getattr(value, name)) for name in _SPECTRUM.__struct_fields__})
    if isinstance(value, CameraLens):
        return table_of_lens(value, _plain)
    if isinstance(value, Extent):
        return table_of_extent(value)
    if isinstance(value, AbstractFigure):
        return table_of(value)
    numbers = np.asarray(value, dtype=float).tolist()
    return tuple(numbers) if isinstance(numbers, list) else numbers


def _without_none(tree):
    if isinstance(tree, dict):
        return {key: _without_none(value) for key, value in tree.items() if value is not None}
    return tree
