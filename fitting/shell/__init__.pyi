"""The command `newtonjax`."""
