"""Files in, and results out: TOML, CSV, MJCF, URDF, NetCDF, Parquet.

The only package that opens the user's files. Input is bounded and checked before it is used, and
errors name the file, the place, what was found and what was expected. Output is written whole or
not at all. Solves nothing.
"""
