"""Triangle meshes: connectivity, geometry, operators, remeshing; arrays in, arrays out."""
