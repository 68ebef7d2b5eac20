"""Stages: one folder, one independent program, one key each. No stage imports another."""
