"""axistwin in the tests of host software: `serve()` and the pytest plug-in."""
