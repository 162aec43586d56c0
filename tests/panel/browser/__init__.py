"""Tests of the panel in a real browser, which use every control at least once on the example machines.

Playwright keeps an event loop running until its browser is closed; therefore only this folder has browser tests.
"""
