"""The kernel in browsers: the sampled functions compiled to WebAssembly."""
