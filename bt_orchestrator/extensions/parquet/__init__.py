"""Export as Parquet, for BI tools: typed tables, in constant memory. pyarrow is used here only."""
