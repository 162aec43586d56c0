"""Diagnostics: check programs and scenes, for `axistwin check` and the language server."""
