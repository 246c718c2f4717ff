"""Every run on record: Parquet files, asked by DuckDB."""
