"""Runs a notebook as a user does, cell by cell, and looks for errors and for pictures: `run_notebook.py NOTEBOOK`."""

import json
import sys

import nbformat
from nbclient import NotebookClient

notebook = nbformat.read(sys.argv[1], as_version=4)
assert not any(cell.get("outputs") for cell in notebook.cells), "a notebook is kept without outputs"
NotebookClient(notebook, timeout=600, kernel_name="python3").execute()
kinds = [kind for cell in notebook.cells for output in cell.get("outputs", []) for kind in output.get("data", {})]
print(json.dumps({"svg": kinds.count("image/svg+xml"), "png": kinds.count("image/png")}))
