"""Measures the solver: against its peers, along the curve of error against time, at the extremes."""
