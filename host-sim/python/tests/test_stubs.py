"""The type stubs say what the module has, with the same words."""

import ast
import inspect
import pathlib
import subprocess
import sys

import cohold
import cohold._native


def test_stubs_are_the_modules_own():
    check = [sys.executable, "-m", "mypy.stubtest", "cohold._native", "--ignore-disjoint-bases"]
    done = subprocess.run(check, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_pages_law_passes_mypy(tmp_path):
    """What a reader copies from docs/guides/python.md, each method given its types or none."""
    page = (pathlib.Path(__file__).parents[3] / "docs/guides/python.md").read_text()
    (law,) = [block for block in page.split("```python\n") if "cohold.add_law(" in block.split("```")[0]]
    file = tmp_path / "law.py"
    file.write_text("import cohold\n\n" + law.split("```")[0])
    done = subprocess.run([sys.executable, "-m", "mypy", str(file)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_examples_pass_mypy_as_strict_as_it_is():
    examples = pathlib.Path(__file__).parents[1] / "examples"
    check = [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", *sorted(examples.glob("*.py"))]
    done = subprocess.run(check, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_docstrings_of_the_stubs_are_the_modules():
    stub = ast.parse((pathlib.Path(cohold.__file__).parent / "_native.pyi").read_text())
    told = 0
    for node in ast.walk(stub):
        if not isinstance(node, (ast.ClassDef, ast.FunctionDef)) or node.name.startswith("_"):
            continue
        owners = [cohold._native, *(getattr(cohold, name) for name in cohold.__all__)]
        known = {inspect.getdoc(getattr(owner, node.name, None)) for owner in owners}
        assert ast.get_docstring(node) in known, node.name
        told += 1
    assert told > 40
