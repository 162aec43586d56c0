"""Ring 2: commanded motions as data: profiles, ramps, pulse trains."""
