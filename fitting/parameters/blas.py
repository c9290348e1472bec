"""One thread for matrix products, which are small in fits and studies."""

import sys
from functools import lru_cache


def one_blas_thread():
    """A context in which every BLAS that is loaded has one thread.

    One with threads of its own spins on the cores after each product, and the products here are small: a fit takes ten
    times as long. NumPy and SciPy bring one each, and SciPy's is loaded with the first of its modules that needs it.
    """
    return _libraries(sum(name.startswith("scipy.") for name in sys.modules)).limit(limits=1, user_api="blas")


@lru_cache(maxsize=1)
def _libraries(_modules: int):
    """Those that are loaded. To look for them takes as long as a frame of a stack: only when SciPy has new modules."""
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
