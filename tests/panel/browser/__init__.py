"""The panel in a real browser: every control used once, on each of the example machines.

Playwright keeps an event loop running as long as its browser is there, and others have theirs: so the browser belongs
to this folder.
"""
