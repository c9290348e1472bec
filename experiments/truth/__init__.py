"""Whether answers are true: scatter, coverage, refusals, real photographs."""
