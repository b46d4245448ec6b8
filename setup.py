"""Which folders are which packages: `vision/` is installed as `benchtwin.vision`, so
that a user's own `vision.py` stands in nobody's way. All else is in pyproject.toml."""

from setuptools import find_packages, setup

NAMES = [
    "bench",
    "infer",
    "rigs",
    "vision",
    "measure",
    "sim",
    "twin",
    "calibrate",
    "diagnose",
    "report",
    "page",
    "prove",
]
FOLDERS = {f"benchtwin.{name}": name for name in NAMES}

setup(
    package_dir={"benchtwin": "benchtwin", **FOLDERS},
    packages=[
        "benchtwin",
        *FOLDERS,
        *(
            f"{package}.{inner}"
            for package, folder in FOLDERS.items()
            for inner in find_packages(folder)
        ),
    ],
)
