"""Documents that users write: YAML with places, forms for it, problems as sentences."""
