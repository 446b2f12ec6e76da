"""report.html: a run as one page that needs no other file, for readers who were not there."""
