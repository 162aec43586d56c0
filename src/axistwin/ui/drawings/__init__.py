"""Drawings of machines with moving parts, as SVG and HTML, for the panel and the playground."""
