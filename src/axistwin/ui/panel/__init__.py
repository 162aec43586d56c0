"""The panel: a web page that shows a bench and controls it.

No other package imports NiceGUI, which the extra `[panel]` installs.
"""
