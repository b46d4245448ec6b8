"""A bench and its results as one folder or zip to keep and to publish, with the hash of
every file, the versions that made it, and nothing of the machine."""

MANIFEST, ABOUT = "pack.json", "README.md"
FORMAT = 1  # of the manifest; to be raised when older programs cannot read it
