"""Fixtures of the tests of devices: the models that a test adds end with it."""

import sys

import pytest

from axistwin.controllers import registry

STAGE = '''\
"""A stage, as somebody writes it."""

from axistwin.devices import Device, Lines, Positioner, command, query


class Stage(Device):
    """A stage with one axis."""

    model, title, framing = "stage", "Example stage controller", Lines(b"\\r")
    axes = {"1": Positioner(velocity=20_000)}

    @command("{axis}PA{position:int}", section="Absolute move")
    def move_absolute(self, axis: str, position: int) -> None:
        self.axes[axis].move_to(position)

    @query("{axis}TP", section="Tell position")
    def tell_position(self, axis: str) -> str:
        return str(self.axes[axis].position)
'''


@pytest.fixture
def names(monkeypatch):
    """Forget all models that the test adds, and the folders of their files."""
    monkeypatch.setattr(sys, "path", list(sys.path))
    registry.installed.cache_clear()
    yield
    registry.LOADED.clear()
    registry.FILES.clear()
    registry.installed.cache_clear()


@pytest.fixture
def stage(names, tmp_path):
    """Return the file of a device."""
    file = tmp_path / "stage.py"
    file.write_text(STAGE)
    return file


@pytest.fixture
def install(names, tmp_path):
    """Return a function that installs a package with the given models: a module, and its entry points."""
    site = tmp_path / "site-packages"
    site.mkdir()
    sys.path.append(str(site))

    def install(package: str, text: str, /, **models: str) -> None:
        module = package.replace("-", "_")
        sys.modules.pop(module, None)
        (site / f"{module}.py").write_text(text)
        metadata = site / f"{module}-1.0.dist-info"
        metadata.mkdir()
        lines = "".join(f"{name} = {module}:{place}\n" for name, place in models.items())
        (metadata / "entry_points.txt").write_text(f"[console_scripts]\nx = y:z\n\n[axistwin.devices]\n{lines}")
        registry.installed.cache_clear()

    return install
