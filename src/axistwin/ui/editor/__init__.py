"""Language support for editors: meaning of a word, completions at a place, structure of a text.

There is one module per kind of text.  Only `axistwin.ui.editor.server` depends on the Language Server Protocol.
"""
