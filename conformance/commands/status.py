"""The exit statuses of the commands."""

DONE, BROKEN_BENCH, WRONG_USE, NOT_ALLOWED = 0, 1, 2, 3
# As a run of the suite says it.
SILENT_NODE = 10
# As a shell says it of a program that Ctrl-C has ended.
INTERRUPTED = 130
