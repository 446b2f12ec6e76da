"""The pytest plugin: options, cases as items, a run with its results, and worker processes."""
