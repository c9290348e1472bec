"""Sentences of results: one table of them, which programs tell apart by name and a translation may replace."""

import ast
import pickle
import string

import numpy as np
import pytest
from counting import Source
from test_architecture import ROOT

import fitting
from fitting.colour import ColourReason
from fitting.pieces import Piece
from fitting.plate_reasons import PlateReason
from fitting.reasons import Reason
from fitting.sheet_reasons import SheetReason
from newtonjax import PlanReason

TREES = Source(ROOT).trees
KINDS = (Reason, ColourReason, SheetReason, PlateReason, Piece, PlanReason)
MEMBERS = {f"{kind.__name__}.{name}": member for kind in KINDS for name, member in kind.__members__.items()}
# What makes a result of a status and a message.
RESULTS = ("FitResult", "FrameFit", "RingsResult", "Scale", "Form", "RefusedError", "LostError", "UndeterminedError")


def fields_of(template: str) -> set[str]:
    return {name for _, name, _, _ in string.Formatter().parse(template) if name}


def calls() -> list[tuple[str, ast.Call, str]]:
    """Module, node and called name of every call in the packages."""
    return [
        (module, node, ast.unparse(node.func))
        for module, tree in TREES.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
    ]


def test_every_sentence_of_the_table_is_stated_somewhere():
    stated = {
        ast.unparse(node) for tree in TREES.values() for node in ast.walk(tree) if isinstance(node, ast.Attribute)
    }
    assert not set(MEMBERS) - stated


def test_a_sentence_gets_the_values_of_its_template():
    wrong = [
        f"{module}:{node.lineno} {name}"
        for module, node, name in calls()
        if name in MEMBERS and {str(word.arg) for word in node.keywords} != fields_of(MEMBERS[name].value)
    ]
    assert not wrong


def test_no_sentence_of_a_result_is_put_together_in_place():
    in_place = [
        f"{module}:{node.lineno}"
        for module, node, name in calls()
        if name.endswith("warnings.append") or name in RESULTS
        for text in node.args[-1 if name.endswith("append") else 0 :]
        if isinstance(text, ast.JoinedStr) or (isinstance(text, ast.Constant) and " " in str(text.value))
    ]
    assert not in_place


@pytest.fixture(scope="module")
def refused():
    return fitting.fit(np.full((64, 64), 7, np.uint16), wavelength=589.3e-9, pixel_size=1e-5)


def test_a_result_names_its_reason_and_its_warnings(refused, tmp_path):
    assert refused.reason == Reason.UNIFORM.name
    assert refused.message == Reason.UNIFORM.value
    assert refused.warning_codes == ["VIEW_ASSUMED"]
    refused.save(tmp_path / "result.json")
    loaded = fitting.FitResult.load(tmp_path / "result.json")
    assert (loaded.reason, loaded.warning_codes) == (refused.reason, refused.warning_codes)
    assert loaded == refused


def test_a_saved_result_without_names_can_still_be_read(refused):
    saved = {key: value for key, value in refused.to_dict().items() if key not in ("reason", "warning_codes")}
    loaded = fitting.FitResult.from_dict(saved)
    assert (loaded.message, loaded.reason, loaded.warning_codes) == (str(refused.message), None, [""])


def test_a_sentence_keeps_its_values_and_pieces_when_pickled():
    table = {"order": [1, 2, 3, 4, 5, 6], "radius_mm": [1.0, 1.41, 1.73, 4.0, 4.47, 4.9]}
    message = fitting.rings(table, wavelength=589.3e-9).message
    copy = pickle.loads(pickle.dumps(message))  # noqa: S301  # its own bytes
    assert (copy, copy.code, copy.values) == (message, "MIXED_SIZES_SET_RIGHT", message.values)
    assert copy.values["mixture"].code == "READINGS_AT_SIZE"


def test_a_table_of_templates_translates_a_sentence_with_its_pieces():
    french = {
        Reason.BENT_LINE.value: "{bend} : la moitié est dans le budget",
        Piece.BEND.value: "r² en fonction de l'ordre n'est pas une droite ({change:+.0%})",
    }
    sentence = Reason.BENT_LINE(bend=Piece.BEND(deviations=4.0, change=0.12, law=""))
    assert sentence.translated(lambda template: french.get(template, template)) == (
        "r² en fonction de l'ordre n'est pas une droite (+12%) : la moitié est dans le budget"
    )
