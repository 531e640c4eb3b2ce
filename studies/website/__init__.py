"""A site and notebooks made from the documents: the tutorial, the shipped scenes and the library examples, executed.

``python -m studies.website OUT`` builds the pages of a site, with a name that ends in .ipynb it writes the tutorial
as a notebook.  Both need the extra ``docs``: ``pip install -e '.[docs]'``.
"""
