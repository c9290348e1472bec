"""What the tests of the command share."""

from fitting.cli import main


def refusal(capsys, *arguments) -> str:
    """The one line on stderr with which the command refuses wrong usage."""
    capsys.readouterr()
    assert main([str(argument) for argument in arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("newtonjax: ")
    assert printed.err.count("\n") == 1
    return printed.err
