"""A mill of three toy stages, for tests of the runner: cheap, and able to fail in every way that a stage can."""
