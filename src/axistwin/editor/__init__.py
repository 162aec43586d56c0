"""What an editor is told about a text: what a word means, what may be written at a place, what the text is made of.

One module per kind of text, and none of them knows of an editor's protocol: `axistwin.editor.server` speaks that.
"""
