"""Tests of the suite beside other plugins of pytest; a package, as it has a conftest of its own."""
