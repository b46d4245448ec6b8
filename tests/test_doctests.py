"""Every example in a docstring gives what stands below it."""

import doctest
from importlib import import_module
from pathlib import Path

import pytest
from packages import FOLDERS, ROOT, module_name

FILES = [file for name in FOLDERS for file in sorted((ROOT / name).rglob("*.py"))]
WITH_EXAMPLES = [f for f in FILES if ">>> " in f.read_text(encoding="utf8")]


@pytest.mark.parametrize("file", WITH_EXAMPLES, ids=module_name)
def test_examples_in_docstrings(file: Path):
    result = doctest.testmod(import_module(module_name(file)))
    assert result.attempted and not result.failed
