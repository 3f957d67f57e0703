"""TOML files and what stands in them: reading with every mistake told, quantities with units, gain files."""
