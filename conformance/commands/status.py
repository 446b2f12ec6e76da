"""The exit statuses of the commands."""

DONE, BROKEN_BENCH, WRONG_USE, NOT_ALLOWED = 0, 1, 2, 3
# The checked files have errors.
FAULTY = 1
# As a run of the suite says it; the first as pytest says of a command line that it cannot follow.
NOT_THERE = 4
SILENT_NODE = 10
# As a shell says it of a program that Ctrl-C has ended.
INTERRUPTED = 130
