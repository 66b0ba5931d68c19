"""Files in, and results out: TOML, CSV, MJCF, URDF, NetCDF, Parquet.

The only room that opens a file of the user's. What comes in is bounded and checked before it means
anything, and told by file, place, found and expected; what goes out is written whole or not at all.
Solves nothing.
"""
