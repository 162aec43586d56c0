"""The panel in a real browser: every control is used once, on each example machine where the machine matters.

Playwright keeps an event loop running until its browser is closed; therefore the browser exists in this folder only.
"""
