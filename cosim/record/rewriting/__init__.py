"""A finished record written anew: without the room that it did not need, or compressed."""
