"""These tests take plugins that change all runs, so an environment of their own: see Makefile."""

import os

collect_ignore_glob = [] if "CONFORMANCE_BESIDE" in os.environ else ["test_*.py"]
