"""Why a study of a bench ends without an answer."""


class UndeterminedError(ValueError):
    """The image does not determine the target; the shell exits with 3."""


class NotConvergedError(ValueError):
    """A fit of a study does not converge; the shell exits with 4."""


def exit_status(error: Exception) -> int:
    """Of the shell: 3, 4, or 2 for wrong usage and unreadable input."""
    return {UndeterminedError: 3, NotConvergedError: 4}.get(type(error), 2)
