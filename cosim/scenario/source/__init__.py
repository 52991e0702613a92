"""The document as it is written: files found, included, merged, overridden, before any meaning."""
