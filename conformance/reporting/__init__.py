"""Writers: what a run found goes into files."""
