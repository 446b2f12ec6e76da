"""The suite on real SocketCAN; ``run`` says where that comes from.

A package, unlike its neighbours, so that its conftest.py has a name of its own for mypy.
"""
