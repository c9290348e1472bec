"""What the tests of the command share."""

from fitting.shell.cli import main


def refusal(capsys, *arguments, status: int = 2) -> str:
    """The one line on stderr with which the command refuses wrong usage, or data that do not tell (3)."""
    capsys.readouterr()
    assert main([str(argument) for argument in arguments]) == status
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("newtonjax: ")
    assert printed.err.count("\n") == 1
    return printed.err
