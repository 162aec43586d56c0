"""The panel: a bench in a browser, to be seen and touched.  An application on the public face, as all others.

NiceGUI, the extra `[panel]`, is imported by what is in here and by nobody else.
"""
