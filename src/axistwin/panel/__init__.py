"""The panel: a bench in a browser, to watch and to operate.

Only this package imports NiceGUI, the extra `[panel]`.
"""
