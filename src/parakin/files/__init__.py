"""Files in: TOML, CSV, MJCF, URDF, and YAML for its loops. Results out: CSV, NetCDF, Parquet.

`reading` chooses by name and suffix: `mechanism_toml`, `motion_toml`, `motion_csv`, or `mjcf` (and
its `mjcf_skeleton`) and `urdf` (and its `loop_table`), whose words are in a `vocabulary` and whose
`links` become a mechanism in `from_links`. `parsing` bounds and checks input, and
errors name the file, the place, what was found and what was expected. `datasets` writes results;
`writing`, which other packages use for their files too, writes a file whole or not at all. The only
package that opens the user's files. Solves nothing.
"""
