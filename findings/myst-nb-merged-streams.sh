#!/usr/bin/env bash
# myst-nb 1.4.0: what a program prints, on a page of documents that are executed.
# Guess:     with `nb_merge_streams = True` the pieces in which a program's output arrives are joined as they are.
# Behaviour: each piece ends with a new line: a pipe is read at any moment, within a number too. The page shows two
#            numbers where the program printed one. nbclient's own `coalesce_streams` joins the same pieces rightly.
# Output seen: merged '1.\n5 mm/s\n', nbclient '1.5 mm/s\n'
# Source:    myst_nb/core/utils.py, coalesce_streams; nbclient/client.py, the option of that name.
# Here:      pages are executed by nbclient with `coalesce_streams` first, and myst-nb executes nothing.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/v" && "$folder/v/bin/pip" install --quiet myst-nb==1.4.0 nbclient==0.11.0 ipykernel==7.4.0
cd "$folder" && v/bin/python - <<'PYTHON'
import copy

import nbformat
from myst_nb.core.utils import coalesce_streams
from nbclient import NotebookClient

SOURCE = "import time\nfor text in ('1.', '5 mm/s\\n'):\n    print(text, end='', flush=True)\n    time.sleep(0.5)"
notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(SOURCE)])
apart = NotebookClient(copy.deepcopy(notebook)).execute().cells[0].outputs
joined = NotebookClient(copy.deepcopy(notebook), coalesce_streams=True).execute().cells[0].outputs
merged = coalesce_streams(copy.deepcopy(apart))[0].text
print("merged", repr(merged), "nbclient", repr(joined[0].text))
assert len(apart) == 2
assert merged == "1.\n5 mm/s\n"
assert joined[0].text == "1.5 mm/s\n"
PYTHON
