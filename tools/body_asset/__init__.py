"""Derives the embedded free body from the CC0 MakeHuman data: `source` reads, the others compute, `assemble` joins."""
