"""Servers that are wrong, each in one thing: a case has to fail for each of them."""
