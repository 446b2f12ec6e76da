"""Servers that are right in another way than the reference server: no case may fail for them."""
