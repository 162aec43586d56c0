"""Output to LinuxCNC HAL: the component `axistwin` passes positions on to stepgen, a servo loop or a fieldbus drive."""
