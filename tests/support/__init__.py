"""Helpers of tests in more than one folder; those of one folder stand in it."""
