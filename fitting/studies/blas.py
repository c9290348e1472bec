"""One thread for small matrix products."""

from functools import cache


@cache
def _controller():
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def one_thread():
    """A context in which matrix products keep to one thread: more of them spin, and take ten times as long."""
    return _controller().limit(limits=1, user_api="blas")
