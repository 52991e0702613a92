"""What connections are made of: matched elements, conversions of values, bundles of packets."""
