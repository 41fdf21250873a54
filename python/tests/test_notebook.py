"""The notebook of the examples, executed."""

from __future__ import annotations

import pytest
from conftest import ROOT

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")


def test_the_notebook_runs(tmp_path):
    notebook = nbformat.read(ROOT / "examples/design.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": tmp_path}}).execute()
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(cell.outputs for cell in cells if not cell.source.startswith("turn"))
    kinds = [set(output["data"]) for output in cells[-1].outputs if "data" in output]
    assert any("text/html" in kind for kind in kinds)
    assert any("image/svg+xml" in output.get("data", {}) for cell in cells for output in cell.outputs)
