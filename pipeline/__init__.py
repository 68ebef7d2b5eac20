"""Decides what must run and runs it; knows keys, never arrays."""
