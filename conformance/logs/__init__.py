"""Recorded logs of a bus: read, listed in words, judged by the oracle."""
