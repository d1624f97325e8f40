"""Python in the documents runs as it stands."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import nbformat
import pytest
from nbclient import NotebookClient

from conftest import ROOT

DOCUMENTS = ["README.md", "docs/src/python.md", "docs/src/fmu.md", "runner/python/README.md"]


@pytest.mark.parametrize("name", DOCUMENTS)
def test_python_of_a_document(name: str, program: Path, tmp_path: Path) -> None:
    text = (ROOT / name).read_text()
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    # The units that a document writes before.
    (tmp_path / "machine.toml").write_text((ROOT / "runner/demo/healthy.toml").read_text())
    for line in re.findall(r"^ballrace (fmu .*)$", text, re.MULTILINE):
        subprocess.run([program, *shlex.split(line)], check=True, capture_output=True)
    if name != "README.md":
        assert blocks
    # The workers of a cluster import the main program, which a text has not.
    exec(compile("\n".join(blocks), name, "exec"), {"__name__": "document"})


def test_the_picture_of_the_fleet_in_the_gallery(tmp_path: Path) -> None:
    """The overview page that the gallery's Python writes, as a picture."""
    text = (ROOT / "docs/src/gallery.md").read_text()
    (code,) = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    (page, name) = re.findall(r"<!-- page: (\S+) -->\n!\[.*\]\((\S+)\)", text)[0]
    exec(compile(code, "gallery", "exec"), {"__name__": "document"})
    fresh = _drawn((tmp_path / page).read_text())
    path = ROOT / "docs/src" / name
    if os.environ.get("BALLRACE_WRITE"):
        path.write_text(fresh)
    texts = ["".join(ElementTree.fromstring(picture).itertext()).split() for picture in (path.read_text(), fresh)]
    assert texts[0] == texts[1], "BALLRACE_WRITE=1 draws it anew"


def _drawn(page: str) -> str:
    """Return a page as an SVG picture, which browsers lay out as the page itself."""
    (style,) = re.findall(r"<style>(.*?)</style>", page, re.DOTALL)
    (body,) = re.findall(r"<body>(.*?)</body>", page, re.DOTALL)
    width, height = 1100, 570
    style = style.replace("body {", ".page {").replace(" svg", " .page svg")
    content = f'<div xmlns="http://www.w3.org/1999/xhtml" class="page"><style>{style}</style>{body}</div>'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}">\n'
        f'<rect width="{width}" height="{height}" fill="#FFFFFF"/>\n'
        f'<foreignObject width="{width}" height="{height}">{content}</foreignObject>\n</svg>\n'
    )


def test_notebook(tmp_path: Path) -> None:
    path = ROOT / "docs/notebooks/first-machine.ipynb"
    stored = nbformat.read(path, as_version=4)
    run = NotebookClient(
        nbformat.from_dict(stored), timeout=300, kernel_name="python3", resources={"metadata": {"path": tmp_path}}
    ).execute()
    if os.environ.get("BALLRACE_WRITE"):
        nbformat.write(_plain(run), path)
        return
    texts = [_texts(notebook) for notebook in (stored, run)]
    assert texts[0] == texts[1], "stored outputs are those of another version: BALLRACE_WRITE=1 writes them"


def _plain(notebook: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """Return a notebook without times and without HTML, which differ from run to run."""
    for cell in notebook.cells:
        cell.metadata = nbformat.NotebookNode()
        for output in cell.get("outputs", []):
            output.get("data", {}).pop("text/html", None)
    return notebook


def _texts(notebook: nbformat.NotebookNode) -> list[str]:
    """Return the text that each cell prints. The kernel sends it in pieces whose borders differ from run to run."""
    return [
        "".join(output.text for output in cell.outputs if output.output_type == "stream" and output.name == "stdout")
        for cell in notebook.cells
        if cell.cell_type == "code"
    ]
