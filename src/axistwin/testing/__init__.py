"""Tests of host software against virtual controllers: `serve()` and the pytest plug-in."""
