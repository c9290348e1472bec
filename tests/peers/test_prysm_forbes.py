"""Prysm's polynomials of Forbes."""

import numpy as np
import pytest

import newtonjax as nj


@pytest.mark.parametrize(("kind", "name"), [("con", "Qcon"), ("bfs", "Qbfs")])
def test_prysm_has_the_same_heights(kind, name):
    polynomials = pytest.importorskip("prysm.polynomials", reason="prysm is not installed (extra 'peers')")
    u = np.linspace(0.01, 0.99, 50)
    for m, row in enumerate(np.eye(20)):
        ours = nj.Forbes(row, 1.0, kind).sag(u, np.zeros(50))
        np.testing.assert_allclose(ours, getattr(polynomials, name)(m, u), atol=1e-14)
