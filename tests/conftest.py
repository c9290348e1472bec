"""Strictness for every test: float64, no silent promotion, shapes and types checked at run time."""

import os
import tempfile

# Before JAX is imported, and inherited by worker processes and by programs under test: compiled code is shared within
# one run of the suite and never between two.
if "JAX_COMPILATION_CACHE_DIR" not in os.environ:
    _CACHE = tempfile.TemporaryDirectory(prefix="newtonjax-tests-")
    os.environ["JAX_COMPILATION_CACHE_DIR"] = _CACHE.name
    os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0.1"

import jax
from hypothesis import settings
from jaxtyping import install_import_hook

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_numpy_dtype_promotion", "strict")

# The same examples in every run; no deadline, since a first example may compile.
settings.register_profile("suite", deadline=None, derandomize=True, database=None)
settings.load_profile("suite")

_HOOK = install_import_hook(("newtonjax", "fitting"), "beartype.beartype")
