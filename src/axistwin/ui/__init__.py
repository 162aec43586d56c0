"""What people look at and type into: panel, playground, drawings, terminal, lessons, editor and guide."""
