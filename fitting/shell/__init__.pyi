"""The command `newtonjax`."""

from fitting.shell.photographs import batch as batch
