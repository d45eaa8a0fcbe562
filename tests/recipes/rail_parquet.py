"""Makes tests/data/rail/*.parquet from profiles.csv beside them (python3, pyarrow; pyarrow 26.0 made the committed ones).

The folder's survey is models/scenarios/rail-thin.toml with 40 rays per profile instead of 150, simulated with seed 1:
  sed 's/^rays = 150/rays = 40/; s/^name = "rail-thin"/name = "rail-parquet"/' models/scenarios/rail-thin.toml > rail-parquet.toml
  boresight simulate rail-parquet.toml --out FOLDER     # keep survey.toml, rail.toml and the three tables
Then, from the repository's root: python3 tests/recipes/rail_parquet.py tests/data/rail

profiles.parquet is what pyarrow writes by default: Snappy, dictionaries, one row group, optional columns.
narrow.parquet has other types and order, Zstandard, row groups of 500, small pages of version 2, required and extra columns.
Of 20 rows: null.parquet has a null in the 7th row of the second row group, nan.parquet a NaN in row 5, gzip.parquet a compression
that is not read, and text, list, timestamp and decimal.parquet hold what is no plain number.
"""
import pathlib
import sys

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq

folder = pathlib.Path(sys.argv[1])
table = pa.csv.read_csv(folder / "profiles.csv", convert_options=pa.csv.ConvertOptions(
    column_types={"time_s": pa.float64(), "profiler": pa.int32(), "y_m": pa.float64(), "z_m": pa.float64()}))
pq.write_table(table, folder / "profiles.parquet")

columns = {name: table[name].combine_chunks() for name in table.column_names}
narrow = pa.table(
    [columns["z_m"].cast(pa.float32()), columns["profiler"].cast(pa.int64()), pa.array(["x"] * len(table)),
     columns["time_s"].cast(pa.int64()), columns["y_m"].cast(pa.float32())],
    schema=pa.schema([pa.field("Z_M", pa.float32(), nullable=False), pa.field("profiler", pa.int64()),
                      pa.field("note", pa.string()), pa.field("time_s", pa.int64(), nullable=False),
                      pa.field("y_m", pa.float32())]))
pq.write_table(narrow, folder / "narrow.parquet", compression="zstd", row_group_size=500, data_page_version="2.0",
               data_page_size=512, use_dictionary=["note", "profiler"],
               column_encoding={"time_s": "DELTA_BINARY_PACKED", "y_m": "BYTE_STREAM_SPLIT"})

few = table.slice(0, 20)
z = few["z_m"].to_pylist()
z[16] = None
pq.write_table(few.set_column(3, "z_m", pa.array(z, pa.float64())), folder / "null.parquet", row_group_size=10)
pq.write_table(few.set_column(2, "y_m", few["y_m"].cast(pa.string())), folder / "text.parquet")
pq.write_table(few.set_column(2, "y_m", pa.array([[v] for v in few["y_m"].to_pylist()])), folder / "list.parquet")
y = few["y_m"].to_pylist()
y[4] = float("nan")
pq.write_table(few.set_column(2, "y_m", pa.array(y, pa.float64())), folder / "nan.parquet")
pq.write_table(few, folder / "gzip.parquet", compression="gzip")
whole = few["time_s"].cast(pa.int64())
pq.write_table(few.set_column(0, "time_s", whole.cast(pa.timestamp("ns"))), folder / "timestamp.parquet")
decimal = whole.cast(pa.int32()).cast(pa.decimal128(12, 2))
pq.write_table(few.set_column(0, "time_s", decimal), folder / "decimal.parquet", store_decimal_as_integer=True)
